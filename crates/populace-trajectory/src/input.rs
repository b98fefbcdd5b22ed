//! The bytes of a file: on disk or in memory.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use crate::{Error, Location};

/// Bytes from the start of a file by which its format is recognised.
const HEAD_BYTES: u64 = 16 * 1024;
/// Bytes of the longest line. Longer ones are no rows, and would fill the memory.
const LINE_BYTES: u64 = 1 << 20;

/// First bytes of text of some programs.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();
/// First bytes of files that gzip compressed.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// A file to read.
pub(crate) struct Input {
    path: PathBuf,
    bytes: Option<Vec<u8>>,
}

impl Input {
    /// A file on disk.
    pub(crate) fn of_file(path: &Path) -> Self {
        Self { path: path.to_owned(), bytes: None }
    }

    /// Bytes in memory, under a name for messages. Nothing lies beside them.
    pub(crate) fn of_bytes(name: &Path, bytes: Vec<u8>) -> Self {
        Self { path: name.to_owned(), bytes: Some(bytes) }
    }

    /// The path, or the name in messages.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path if the file is on disk.
    pub(crate) fn on_disk(&self) -> Option<&Path> {
        self.bytes.is_none().then_some(&*self.path)
    }

    /// Returns the path if the file is on disk and not compressed.
    #[cfg(any(feature = "hdf5", feature = "sqlite"))]
    pub(crate) fn plain_on_disk(&self) -> Result<Option<&Path>, Error> {
        let Some(path) = self.on_disk() else { return Ok(None) };
        let mut start = Vec::new();
        let file = File::open(path).map_err(self.unreadable())?;
        file.take(GZIP.len() as u64).read_to_end(&mut start).map_err(self.unreadable())?;
        Ok((start != GZIP).then_some(path))
    }

    /// Returns the path of a file beside this one: with the same name up to the extension, if it is
    /// on disk.
    pub(crate) fn beside(&self, extension: &str) -> Option<PathBuf> {
        let path = self.on_disk()?;
        let is_gzip = path.extension().is_some_and(|end| end == "gz");
        let path = if is_gzip { path.with_extension("") } else { path.to_owned() };
        let path = path.with_extension(extension);
        (path != self.path && path.is_file()).then_some(path)
    }

    /// Opens the bytes; compressed files (gzip) are decompressed on the way.
    pub(crate) fn open(&self) -> Result<Box<dyn BufRead + '_>, Error> {
        let mut raw: Box<dyn BufRead> = match &self.bytes {
            Some(bytes) => Box::new(Cursor::new(bytes)),
            None => Box::new(BufReader::new(File::open(&self.path).map_err(self.unreadable())?)),
        };
        let is_gzip = raw.fill_buf().map_err(self.unreadable())?.starts_with(&GZIP);
        if is_gzip {
            return Ok(Box::new(BufReader::new(flate2::bufread::MultiGzDecoder::new(raw))));
        }
        Ok(raw)
    }

    /// Opens the bytes of text, without a byte order mark.
    pub(crate) fn open_text(&self) -> Result<Box<dyn BufRead + '_>, Error> {
        let mut from = self.open()?;
        if from.fill_buf().map_err(self.unreadable())?.starts_with(BYTE_ORDER_MARK) {
            from.consume(BYTE_ORDER_MARK.len());
        }
        Ok(from)
    }

    /// Returns the first bytes.
    pub(crate) fn head(&self) -> Result<Vec<u8>, Error> {
        let mut head = Vec::new();
        self.open()?.take(HEAD_BYTES).read_to_end(&mut head).map_err(self.unreadable())?;
        Ok(head)
    }

    /// Returns the error for a failed read.
    pub(crate) fn unreadable(&self) -> impl Fn(std::io::Error) -> Error + '_ {
        |reason| Error::Unreadable { path: self.path.clone(), reason }
    }

    /// Returns the error for content that breaks the format's rules.
    pub(crate) fn malformed(&self, at: Option<Location>, problem: impl Into<String>) -> Error {
        Error::Malformed { path: self.path.clone(), at, problem: problem.into() }
    }

    /// Calls a function with each line and its number from 1. Line ends and a byte order mark are
    /// removed, and bytes that are no UTF-8 are replaced.
    pub(crate) fn for_each_line(
        &self,
        mut take: impl FnMut(&str, u64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut from = self.open()?;
        let mut line = Vec::new();
        for number in 1.. {
            line.clear();
            let mut limited = (&mut from).take(LINE_BYTES);
            if limited.read_until(b'\n', &mut line).map_err(self.unreadable())? == 0 {
                break;
            }
            if limited.limit() == 0 {
                let problem = "the line is longer than any row; is this a text file?";
                return Err(self.malformed(Some(Location::Line(number)), problem));
            }
            let text = String::from_utf8_lossy(&line);
            take(text.trim_start_matches('\u{feff}').trim_end_matches(['\n', '\r']), number)?;
        }
        Ok(())
    }
}
