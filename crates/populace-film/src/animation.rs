//! Animated GIF.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use gif::{DisposalMethod, EncodingError, Frame, Repeat};

use crate::Error;
use crate::colors::{Color, FewColors};
use crate::output::{Part, output_error};
use crate::settings::{FilmSettings, FrameRate};
use crate::writer::FrameWriter;

/// The place of pixels that stay, before those of the colours.
const STAYS: u8 = 0;
/// Most colours of a frame besides.
const COLORS: usize = 255;
/// Greatest difference in a channel, of 255, between a frame and a pixel that stays as it is shown.
const NEAR: u8 = 3;
/// Least and greatest frames per second. A frame lasts at most 65535 hundredths of a second, and
/// browsers show frames of less than 2 for longer.
const SLOWEST: f64 = 1.0 / 655.0;
const FASTEST: f64 = 50.0;

/// A GIF that grows.
pub(crate) struct GifWriter {
    part: Part,
    encoder: gif::Encoder<BufWriter<File>>,
    size: [u16; 2],
    rate: FrameRate,
    frames: u32,
    /// The pixels as the GIF shows them, to find what changes.
    shown: Vec<Color>,
}

impl GifWriter {
    pub(crate) fn new(part: Part, settings: &FilmSettings) -> Result<Self, Error> {
        if !(SLOWEST..=FASTEST).contains(&settings.rate.per_sec()) {
            return Err(Error::BadValue {
                what: "the frame rate of a GIF",
                value: settings.rate.to_string(),
                rule: "1/655 to 50, since frames of GIF last no longer, and browsers slow down \
                       faster ones",
            });
        }
        let size = settings.size.map(|side| u16::try_from(side).unwrap_or(u16::MAX));
        let file = BufWriter::new(part.create()?);
        let fail = |error| failed(&part, error);
        let mut encoder = gif::Encoder::new(file, size[0], size[1], &[]).map_err(fail)?;
        encoder.set_repeat(Repeat::Infinite).map_err(fail)?;
        let rate = settings.rate;
        Ok(Self { part, encoder, size, rate, frames: 0, shown: Vec::new() })
    }

    /// Returns the next frame, and shows it: pixels that stay are transparent, which takes less
    /// room and leaves the colours to the others.
    fn next_frame(&mut self, rgba: &[u8]) -> Frame<'static> {
        let pixels = || rgba.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]);
        let near = |a: Color, b: Color| (0..3).all(|at| a[at].abs_diff(b[at]) <= NEAR);
        let changed = |(at, pixel)| self.shown.get(at).is_none_or(|shown| !near(*shown, pixel));
        let changed: Vec<bool> = pixels().enumerate().map(changed).collect();
        let new = pixels().zip(&changed).filter(|(_, changed)| **changed);
        let few = FewColors::choose(new.map(|(pixel, _)| pixel), COLORS);
        self.shown.resize(changed.len(), [0; 3]);
        let show = |((pixel, changed), shown): ((Color, bool), &mut Color)| {
            if !changed {
                return STAYS;
            }
            let place = few.place(pixel);
            *shown = few.colors[usize::from(place)];
            place + 1
        };
        let places: Vec<u8> = pixels().zip(changed).zip(&mut self.shown).map(show).collect();
        let [width, height] = self.size;
        let palette = [&[[0; 3]], &few.colors[..]].concat().into_flattened();
        Frame::from_palette_pixels(width, height, places, palette, Some(STAYS))
    }

    /// Returns how long the next frame lasts in hundredths of a second. Rounded times add up to
    /// those of the film.
    fn delay(&self) -> u16 {
        let [now, then] = [self.frames, self.frames + 1].map(|frame| self.rate.secs(frame) * 100.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "floats saturate, and the longest delay is what GIF has"
        )]
        let delay = (then.round() - now.round()) as u16;
        delay
    }
}

fn failed(part: &Part, error: EncodingError) -> Error {
    match error {
        EncodingError::Io(source) => output_error(part.path(), source),
        other => Error::Encoder { encoder: "the encoder of GIF", cause: other.to_string() },
    }
}

impl FrameWriter for GifWriter {
    fn write(&mut self, rgba: &[u8]) -> Result<(), Error> {
        let mut frame = self.next_frame(rgba);
        frame.delay = self.delay();
        frame.dispose = DisposalMethod::Keep;
        self.encoder.write_frame(&frame).map_err(|error| failed(&self.part, error))?;
        self.frames += 1;
        self.encoder.get_mut().flush().map_err(|source| output_error(self.part.path(), source))
    }

    fn stop(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<PathBuf, Error> {
        let Self { part, encoder, .. } = *self;
        let mut file = encoder.into_inner().map_err(|error| failed(&part, error))?;
        let synced = file.flush().and_then(|()| file.get_ref().sync_all());
        synced.map_err(|source| output_error(part.path(), source))?;
        part.complete_as_is()
    }
}
