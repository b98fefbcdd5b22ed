//! Settings of a film.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use crate::Error;

/// A number of frames per second, as an exact fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    frames: u32,
    secs: u32,
}

/// The largest number of frames per second.
const MOST: f64 = 1000.0;
/// The smallest.
const LEAST: f64 = 0.001;

impl FrameRate {
    /// Returns the rate of `frames` in `secs` seconds, such as 30000 in 1001.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] for rates out of 0.001 to 1000 and numbers above 1,000,000.
    pub fn new(frames: u32, secs: u32) -> Result<Self, Error> {
        let rate = f64::from(frames) / f64::from(secs);
        if frames > 1_000_000 || secs > 1_000_000 || !(LEAST..=MOST).contains(&rate) {
            return Err(Self::refused(&format!("{frames}/{secs}")));
        }
        let divisor = greatest_divisor(frames, secs);
        Ok(Self { frames: frames / divisor, secs: secs / divisor })
    }

    /// Returns the rate nearest to `rate`: of whole numbers, those of television such as
    /// 23.976, 29.97 and 59.94 (whole numbers by 1.001), and thousandths.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] for rates out of 0.001 to 1000.
    pub fn nearest(rate: f64) -> Result<Self, Error> {
        if !(LEAST..=MOST).contains(&rate) {
            return Err(Self::refused(&rate.to_string()));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most a million, checked above"
        )]
        let whole = |value: f64| value.round() as u32;
        let television = (rate * 1.001).round();
        if rate.fract() != 0.0 && television >= 1.0 && (rate * 1.001 - television).abs() < 5e-4 {
            return Self::new(whole(television) * 1000, 1001);
        }
        Self::new(whole(rate * 1000.0), 1000)
    }

    fn refused(value: &str) -> Error {
        let rule = "a number from 0.001 to 1000, or a fraction such as 30000/1001";
        Error::BadValue { what: "the frame rate", value: value.to_owned(), rule }
    }

    /// Numerator and denominator in lowest terms: frames, and the seconds that they take.
    #[must_use]
    pub fn fraction(self) -> [u32; 2] {
        [self.frames, self.secs]
    }

    /// Frames per second.
    #[must_use]
    pub fn per_sec(self) -> f64 {
        f64::from(self.frames) / f64::from(self.secs)
    }

    /// Returns the time of frame `frame` in seconds.
    #[must_use]
    pub fn secs(self, frame: u32) -> f64 {
        f64::from(frame) * f64::from(self.secs) / f64::from(self.frames)
    }
}

impl FromStr for FrameRate {
    type Err = Error;

    /// Reads a number such as 29.97, or a fraction such as 30000/1001.
    fn from_str(text: &str) -> Result<Self, Error> {
        let refused = || Self::refused(text);
        match text.split_once('/') {
            Some((frames, secs)) => match (frames.trim().parse(), secs.trim().parse()) {
                (Ok(frames), Ok(secs)) => Self::new(frames, secs).map_err(|_| refused()),
                _ => Err(refused()),
            },
            None => Self::nearest(text.trim().parse().map_err(|_| refused())?),
        }
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.secs {
            1 => write!(f, "{}", self.frames),
            secs => write!(f, "{}/{secs}", self.frames),
        }
    }
}

fn greatest_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a.max(1) } else { greatest_divisor(b, a % b) }
}

/// The form of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MP4 with H.264.
    Mp4,
    /// An animated GIF that plays in a loop.
    Gif,
}

impl Format {
    /// Returns the format that the extension of a file name stands for, in lower or upper case.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mp4" => Some(Self::Mp4),
            "gif" => Some(Self::Gif),
            _ => None,
        }
    }
}

/// The encoder of MP4 films.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoder {
    /// The built-in one, of the feature `openh264`.
    #[default]
    OpenH264,
    /// The program `ffmpeg` with libx264, which must be installed.
    Ffmpeg,
}

impl FromStr for Encoder {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "openh264" => Ok(Self::OpenH264),
            "ffmpeg" => Ok(Self::Ffmpeg),
            _ => Err(Error::BadValue {
                what: "the encoder",
                value: text.to_owned(),
                rule: "openh264 or ffmpeg",
            }),
        }
    }
}

impl fmt::Display for Encoder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OpenH264 => "openh264",
            Self::Ffmpeg => "ffmpeg",
        })
    }
}

/// Settings of a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSettings {
    /// Width and height in pixels, of frames and film. MP4 adds a column or row to odd ones.
    pub size: [u32; 2],
    /// Frames per second.
    pub rate: FrameRate,
    /// Encoder of MP4 films. GIF has one of its own.
    pub encoder: Encoder,
    /// Quantizer of H.264, the same for all frames, from 0 to 51. Smaller numbers give better
    /// pictures and larger files.
    pub quantizer: u8,
}

impl FilmSettings {
    /// Returns settings for frames of `size` pixels (width, height), with the built-in encoder and
    /// a quantizer at which losses are hard to see.
    #[must_use]
    pub fn new(size: [u32; 2], rate: FrameRate) -> Self {
        Self { size, rate, encoder: Encoder::default(), quantizer: 22 }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let [width, height] = self.size;
        if !(1..=LARGEST_SIDE).contains(&width) || !(1..=LARGEST_SIDE).contains(&height) {
            let rule = "from 1x1 to 65534x65534";
            let value = format!("{width}x{height}");
            return Err(Error::BadValue { what: "the size of the film", value, rule });
        }
        if self.quantizer > MOST_QUANTIZER {
            let value = self.quantizer.to_string();
            return Err(Error::BadValue { what: "the quantizer", value, rule: "from 0 to 51" });
        }
        Ok(())
    }

    /// Returns the number of bytes of a frame.
    pub(crate) fn frame_bytes(&self) -> u64 {
        4 * u64::from(self.size[0]) * u64::from(self.size[1])
    }
}

/// Sides in a file have 16 bits, and an odd one grows by one.
const LARGEST_SIDE: u32 = 65534;
/// Largest quantizer of H.264.
const MOST_QUANTIZER: u8 = 51;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_exact_fractions() {
        for (text, fraction) in [
            ("25", [25, 1]),
            ("29.97", [30000, 1001]),
            ("23.976", [24000, 1001]),
            ("59.94", [60000, 1001]),
            ("30000/1001", [30000, 1001]),
            ("12.5", [25, 2]),
            ("0.001", [1, 1000]),
            ("1000", [1000, 1]),
        ] {
            assert_eq!(text.parse::<FrameRate>().unwrap().fraction(), fraction, "{text}");
        }
        for bad in ["", "0", "-1", "nan", "inf", "1001", "1/0", "0/1", "x/2", "1e-9"] {
            let message = bad.parse::<FrameRate>().unwrap_err().to_string();
            assert!(message.contains("30000/1001"), "{bad}: {message}");
        }
        assert_eq!("30000/1001".parse::<FrameRate>().unwrap().to_string(), "30000/1001");
    }

    #[test]
    fn formats_follow_the_extension() {
        assert_eq!(Format::of(Path::new("a.b/film.MP4")), Some(Format::Mp4));
        assert_eq!(Format::of(Path::new("film.gif")), Some(Format::Gif));
        assert_eq!(Format::of(Path::new("film")), None);
    }
}
