//! MP4 files (ISO/IEC 14496-12) with one track of H.264 (14496-15), without reordered frames.
//!
//! A growing film is fragmented: a header without frames, then a `moof` and an `mdat` for each group
//! of frames that begins with a key frame. A complete one has all tables in front of the frames.

mod boxes;
mod tables;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::Error;
use crate::output::{Part, output_error};
use crate::writer::FrameWriter;
pub(crate) use tables::{Sample, Track};

/// An encoder of frames.
pub(crate) trait FrameEncoder: Send {
    /// Encodes a frame of RGBA and appends it to `bytes`, each unit of H.264 after its length in
    /// four bytes. Returns true for a key frame.
    fn encode(&mut self, rgba: &[u8], bytes: &mut Vec<u8>) -> Result<bool, Error>;

    /// Returns the sequence and picture parameter sets, which are known after the first frame.
    fn parameter_sets(&self) -> [&[u8]; 2];
}

/// An MP4 film that grows.
pub(crate) struct Mp4Writer<E> {
    encoder: E,
    part: Part,
    file: File,
    track: Track,
    /// Bytes of the frames since the last key frame, which are not in the file yet.
    pending: Vec<u8>,
    /// Length of the file in bytes, up to the last whole fragment.
    written: u64,
}

impl<E: FrameEncoder> Mp4Writer<E> {
    /// Creates the part of the film.
    pub(crate) fn new(part: Part, track: Track, encoder: E) -> Result<Self, Error> {
        let file = part.create()?;
        Ok(Self { encoder, part, file, track, pending: Vec::new(), written: 0 })
    }

    /// Writes the pending frames as a fragment, after the header if it is the first.
    fn write_fragment(&mut self) -> Result<(), Error> {
        let header = match self.written {
            0 => self.track.fragmented_header(self.encoder.parameter_sets()),
            _ => Vec::new(),
        };
        let frames = std::mem::take(&mut self.pending);
        let begin = self.written + header.len() as u64;
        let fragment = self.track.fragment(begin, &frames);
        let bytes = [header, fragment].concat();
        if let Err(source) = self.file.write_all(&bytes) {
            // Only whole fragments stay.
            let _ = self.file.set_len(self.written);
            return Err(output_error(self.part.path(), source));
        }
        self.written += bytes.len() as u64;
        Ok(())
    }

    /// Writes the whole film in its ordinary form, from the frames of the part.
    fn write_whole(&mut self, draft: &Path) -> Result<(), Error> {
        let header = self.track.whole_header(self.encoder.parameter_sets());
        let fail = |source| output_error(draft, source);
        let mut whole = File::create(draft).map_err(fail)?;
        whole.write_all(&header).map_err(fail)?;
        for range in self.track.chunks() {
            copy(&mut self.file, range, &mut whole).map_err(fail)?;
        }
        whole.sync_all().map_err(fail)
    }
}

/// Copies a range of bytes of a file.
fn copy(from: &mut File, [begin, length]: [u64; 2], to: &mut File) -> io::Result<()> {
    from.seek(SeekFrom::Start(begin))?;
    match io::copy(&mut from.take(length), to)? {
        copied if copied == length => Ok(()),
        _ => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

impl<E: FrameEncoder> FrameWriter for Mp4Writer<E> {
    fn write(&mut self, rgba: &[u8]) -> Result<(), Error> {
        let mut frame = Vec::new();
        let is_key = self.encoder.encode(rgba, &mut frame)?;
        if is_key && !self.pending.is_empty() {
            self.write_fragment()?;
        }
        let bytes = u32::try_from(frame.len()).map_err(|_| Error::Encoder {
            encoder: "the writer of MP4",
            cause: "a frame has more than 4 GiB".into(),
        })?;
        self.track.push(Sample { bytes, is_key });
        self.pending.extend(frame);
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Error> {
        if self.pending.is_empty() { Ok(()) } else { self.write_fragment() }
    }

    fn finish(mut self: Box<Self>) -> Result<PathBuf, Error> {
        self.stop()?;
        let draft = self.part.draft().to_owned();
        let written = self.write_whole(&draft);
        self.part.complete(written)
    }
}
