//! Reads files from a ZIP archive, such as a Python wheel: stored or deflated, not encrypted, below
//! 4 GiB (PKWARE, "APPNOTE.TXT", sections 4.3 and 4.4).

use std::collections::HashMap;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Seek, SeekFrom};
use std::path::Path;

use flate2::Crc;
use flate2::read::DeflateDecoder;

const END: u32 = 0x0605_4b50;
const ENTRY: u32 = 0x0201_4b50;
const LOCAL: u32 = 0x0403_4b50;
/// Bytes of those records without names and comments, which follow.
const END_BYTES: usize = 22;
const ENTRY_BYTES: usize = 46;
const LOCAL_BYTES: usize = 30;
/// The comment after the last record has at most this many bytes.
const MAX_COMMENT: u64 = 0xffff;
const STORED: u16 = 0;
const DEFLATED: u16 = 8;

/// Where a file lies in the archive.
struct Entry {
    method: u16,
    crc: u32,
    packed_bytes: u64,
    bytes: u64,
    at: u64,
}

/// An open archive.
pub(crate) struct Archive {
    file: File,
    entries: HashMap<String, Entry>,
}

fn wrong(what: &str) -> Error {
    Error::new(ErrorKind::InvalidData, what.to_owned())
}

fn u16_at(bytes: &[u8], at: usize) -> Result<u16> {
    let bytes = bytes.get(at..at + 2).and_then(|b| b.try_into().ok());
    bytes.map(u16::from_le_bytes).ok_or_else(|| wrong("the archive is cut off"))
}

fn u32_at(bytes: &[u8], at: usize) -> Result<u32> {
    let bytes = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
    bytes.map(u32::from_le_bytes).ok_or_else(|| wrong("the archive is cut off"))
}

impl Archive {
    /// Opens an archive and reads the list of its files.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let mut file = File::open(path)?;
        let length = file.seek(SeekFrom::End(0))?;
        let tail = read_at(&mut file, length.saturating_sub(END_BYTES as u64 + MAX_COMMENT), None)?;
        let end = (0..tail.len().saturating_sub(END_BYTES - 1))
            .rev()
            .find(|at| u32_at(&tail, *at).is_ok_and(|word| word == END))
            .ok_or_else(|| wrong("it is not a ZIP archive"))?;
        let bytes = u64::from(u32_at(&tail, end + 12)?);
        let directory = read_at(&mut file, u32_at(&tail, end + 16)?.into(), Some(bytes))?;
        let (mut entries, mut at) = (HashMap::new(), 0);
        for _ in 0..u16_at(&tail, end + 10)? {
            if u32_at(&directory, at)? != ENTRY {
                return Err(wrong("the list of the archive's files is damaged"));
            }
            let [name, extra, comment] =
                [28, 30, 32].map(|field| u16_at(&directory, at + field).map(usize::from));
            let (name, next) = (name?, extra? + comment?);
            let entry = Entry {
                method: u16_at(&directory, at + 10)?,
                crc: u32_at(&directory, at + 16)?,
                packed_bytes: u32_at(&directory, at + 20)?.into(),
                bytes: u32_at(&directory, at + 24)?.into(),
                at: u32_at(&directory, at + 42)?.into(),
            };
            let text = directory.get(at + ENTRY_BYTES..at + ENTRY_BYTES + name);
            let text = text.ok_or_else(|| wrong("the archive is cut off"))?;
            entries.insert(String::from_utf8_lossy(text).into_owned(), entry);
            at += ENTRY_BYTES + name + next;
        }
        Ok(Self { file, entries })
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.entries.contains_key(name)
    }

    /// The names of all files, sorted.
    pub(crate) fn names(&self) -> Vec<&str> {
        let mut names: Vec<_> = self.entries.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    /// Reads a file of at most `limit` bytes.
    pub(crate) fn read(&mut self, name: &str, limit: u64) -> Result<Vec<u8>> {
        let entry = self.entries.get(name).ok_or_else(|| wrong("it is not in the archive"))?;
        if entry.bytes > limit || entry.packed_bytes > limit {
            return Err(wrong("it is too large"));
        }
        let header = read_at(&mut self.file, entry.at, Some(LOCAL_BYTES as u64))?;
        if u32_at(&header, 0)? != LOCAL {
            return Err(wrong("its place in the archive is damaged"));
        }
        let skipped = u64::from(u16_at(&header, 26)?) + u64::from(u16_at(&header, 28)?);
        let start = entry.at + LOCAL_BYTES as u64 + skipped;
        let packed = read_at(&mut self.file, start, Some(entry.packed_bytes))?;
        let bytes = match entry.method {
            STORED => packed,
            DEFLATED => {
                let mut bytes = Vec::new();
                DeflateDecoder::new(&packed[..]).take(limit).read_to_end(&mut bytes)?;
                bytes
            }
            _ => return Err(wrong("it is packed by a method other than deflate")),
        };
        let mut crc = Crc::new();
        crc.update(&bytes);
        if crc.sum() == entry.crc { Ok(bytes) } else { Err(wrong("its checksum differs")) }
    }
}

/// Reads bytes from a place in a file: as many as given, or all up to the end.
fn read_at(file: &mut File, at: u64, count: Option<u64>) -> Result<Vec<u8>> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    let read = file.take(count.unwrap_or(u64::MAX)).read_to_end(&mut bytes)?;
    match count {
        Some(count) if (read as u64) < count => Err(wrong("the archive is cut off")),
        _ => Ok(bytes),
    }
}
