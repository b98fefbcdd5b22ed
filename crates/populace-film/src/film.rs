//! A film, written on a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use crate::Error;
use crate::animation::GifWriter;
use crate::ffmpeg::FfmpegWriter;
use crate::output::Part;
use crate::settings::{Encoder, FilmSettings, Format};
use crate::writer::FrameWriter;

/// Frames that wait for the encoder at most.
const WAITING: usize = 4;

enum Message {
    Frame(Vec<u8>),
    Finish,
}

/// How many frames of a film its encoder has taken. A clone on another thread sees the number grow.
#[derive(Clone, Debug, Default)]
pub struct FilmProgress(Arc<AtomicU32>);

impl FilmProgress {
    /// Returns the number of frames. Those that wait in the queue of [`Film::push`] do not count.
    #[must_use]
    pub fn frame_count(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    fn count_frame(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// A film that grows frame by frame.
///
/// Frames are encoded on another thread, so that the caller can draw the next ones. A few wait in a
/// queue; [`push`](Self::push) blocks while it is full. Until it is complete, the film is a file
/// beside its own name, such as `film.part.mp4`, which plays up to its last whole second.
/// [`finish`](Self::finish) gives it its name. Dropping it leaves the part.
#[derive(Debug)]
pub struct Film {
    path: PathBuf,
    part: PathBuf,
    draft: PathBuf,
    settings: FilmSettings,
    frames: u32,
    progress: FilmProgress,
    queue: Option<SyncSender<Message>>,
    thread: Option<JoinHandle<Result<Option<PathBuf>, Error>>>,
}

impl Film {
    /// Begins a film of the [`Format`] that the extension of `path` names. An existing file of this
    /// name stays until the film is complete; an older part is replaced.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownFormat`] for another extension, [`Error::BadValue`] for settings out of
    /// range, [`Error::WithoutOpenH264`] or [`Error::NoFfmpeg`] for a missing encoder, and
    /// [`Error::Output`] if the part cannot be created.
    pub fn create(path: impl AsRef<Path>, settings: &FilmSettings) -> Result<Self, Error> {
        let path = path.as_ref();
        let unknown = || Error::UnknownFormat { path: path.to_owned() };
        let format = Format::of(path).ok_or_else(unknown)?;
        settings.check()?;
        let part = Part::of(path);
        let [part_path, draft] = [part.path(), part.draft()].map(Path::to_owned);
        let writer: Box<dyn FrameWriter> = match (format, settings.encoder) {
            (Format::Gif, _) => Box::new(GifWriter::new(part, settings)?),
            (Format::Mp4, Encoder::Ffmpeg) => Box::new(FfmpegWriter::new(part, settings)?),
            (Format::Mp4, Encoder::OpenH264) => built_in(part, settings)?,
        };
        let (queue, messages) = sync_channel(WAITING);
        let progress = FilmProgress::default();
        let counted = progress.clone();
        let thread = std::thread::Builder::new()
            .name("film".into())
            .spawn(move || write_all(writer, &messages, &counted))
            .map_err(|source| Error::Output { path: part_path.clone(), source })?;
        Ok(Self {
            path: path.to_owned(),
            part: part_path,
            draft,
            settings: *settings,
            frames: 0,
            progress,
            queue: Some(queue),
            thread: Some(thread),
        })
    }

    /// Returns the file that holds the film until it is complete.
    #[must_use]
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Returns the file in which [`finish`](Self::finish) rewrites an MP4. A process that ends
    /// during that call leaves it behind; it is of no use.
    #[must_use]
    pub fn draft(&self) -> &Path {
        &self.draft
    }

    /// Returns the number of frames that were pushed.
    #[must_use]
    pub fn frame_count(&self) -> u32 {
        self.frames
    }

    /// Returns how many frames the encoder has taken, now and later.
    #[must_use]
    pub fn progress(&self) -> FilmProgress {
        self.progress.clone()
    }

    /// Appends a frame: RGBA in sRGB, 8 bits each, top row first. Alpha is ignored.
    ///
    /// # Errors
    ///
    /// [`Error::FrameSize`] for another number of bytes, and the first error of writing the frames
    /// before. After an error of writing, the film has ended, and its part stays.
    pub fn push(&mut self, rgba: Vec<u8>) -> Result<(), Error> {
        if rgba.len() as u64 != self.settings.frame_bytes() {
            let ([width, height], found) = (self.settings.size, rgba.len());
            let expected = self.settings.frame_bytes();
            return Err(Error::FrameSize { width, height, found, expected });
        }
        let sent = self.queue.as_ref().map(|queue| queue.send(Message::Frame(rgba)));
        if let Some(Ok(())) = sent {
            self.frames += 1;
            return Ok(());
        }
        self.end()?;
        Err(ended())
    }

    /// Completes the film, and returns its path. Waits until all frames are written.
    ///
    /// # Errors
    ///
    /// [`Error::NoFrames`] without a frame, and the first error of writing. The part stays then.
    pub fn finish(mut self) -> Result<PathBuf, Error> {
        if self.frames == 0 {
            return Err(Error::NoFrames { path: self.path.clone() });
        }
        if let Some(queue) = &self.queue {
            // An error shows that the thread has ended, which `end` reports.
            let _ = queue.send(Message::Finish);
        }
        self.end()?.ok_or_else(ended)
    }

    /// Waits for the thread, and returns the path of a complete film.
    fn end(&mut self) -> Result<Option<PathBuf>, Error> {
        drop(self.queue.take());
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) | None => Err(ended()),
        }
    }
}

fn ended() -> Error {
    Error::Encoder { encoder: "the film", cause: "it ended with an earlier error".into() }
}

impl Drop for Film {
    /// Writes the frames that were pushed into the part, and leaves it; removes a part without any.
    fn drop(&mut self) {
        let _ = self.end();
        if self.frames == 0 {
            let _ = std::fs::remove_file(&self.part);
        }
    }
}

/// Writes frames until there are no more. Returns the path of a complete film.
fn write_all(
    mut writer: Box<dyn FrameWriter>,
    messages: &Receiver<Message>,
    progress: &FilmProgress,
) -> Result<Option<PathBuf>, Error> {
    for message in messages {
        match message {
            Message::Frame(rgba) => {
                writer.write(&rgba)?;
                progress.count_frame();
            }
            Message::Finish => return writer.finish().map(Some),
        }
    }
    writer.stop().map(|()| None)
}

#[cfg(feature = "openh264")]
fn built_in(part: Part, settings: &FilmSettings) -> Result<Box<dyn FrameWriter>, Error> {
    use crate::h264::OpenH264;
    use crate::mp4::{Mp4Writer, Track};
    let encoder = OpenH264::new(settings)?;
    let even = |side: u32| u16::try_from(side.next_multiple_of(2)).unwrap_or(u16::MAX);
    let track = Track::new(settings.size.map(even), settings.rate);
    Ok(Box::new(Mp4Writer::new(part, track, encoder)?))
}

#[cfg(not(feature = "openh264"))]
fn built_in(_part: Part, _settings: &FilmSettings) -> Result<Box<dyn FrameWriter>, Error> {
    Err(Error::WithoutOpenH264)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes two frames, and fails at the third.
    struct FailsAtThird(u32);

    impl FrameWriter for FailsAtThird {
        fn write(&mut self, _rgba: &[u8]) -> Result<(), Error> {
            self.0 += 1;
            if self.0 < 3 { Ok(()) } else { Err(ended()) }
        }

        fn stop(&mut self) -> Result<(), Error> {
            Ok(())
        }

        fn finish(self: Box<Self>) -> Result<PathBuf, Error> {
            Err(ended())
        }
    }

    #[test]
    fn progress_counts_the_frames_that_the_encoder_took() {
        let (queue, messages) = sync_channel(WAITING);
        for _ in 0..WAITING {
            queue.send(Message::Frame(Vec::new())).expect("room");
        }
        let progress = FilmProgress::default();
        let seen_elsewhere = progress.clone();
        write_all(Box::new(FailsAtThird(0)), &messages, &progress).expect_err("the third frame");
        assert_eq!(seen_elsewhere.frame_count(), 2);
    }
}
