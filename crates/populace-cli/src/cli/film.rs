//! Arguments for films: which frames are drawn, and how they are written.

use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::Args;
use populace_film::{Encoder, FrameRate};

/// Options for films and other series of frames.
#[derive(Args, Debug)]
pub(crate) struct FilmArgs {
    /// Frames to draw: N frames from frame 0 on, or those from A to B, both included. Frame k shows
    /// the time k / fps, whichever frames are drawn [default: one picture; for .mp4 and .gif, all
    /// frames of a trajectory file or a scene]
    #[arg(long, value_name = "N|A..B")]
    pub(crate) frames: Option<FrameRange>,
    /// Frames per second, from 0.001 to 1000, or a fraction such as 30000/1001 [default: 30; 25 for
    /// a trajectory file; that of a scene file]
    #[arg(long, value_name = "N")]
    pub(crate) fps: Option<FrameRate>,
    /// Draw one picture, of this time in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds, conflicts_with = "frames")]
    pub(crate) at: Option<f64>,
    /// Leave out the numbered PNG files that exist
    #[arg(long)]
    pub(crate) skip_existing: bool,
    /// Encoder of MP4: the built-in one, or ffmpeg where it is installed
    #[arg(long, value_name = "openh264|ffmpeg", default_value_t = Encoder::OpenH264)]
    pub(crate) encoder: Encoder,
    /// Motion blur: degrees of 360 that the shutter is open from one frame to the next. One picture
    /// for each 22.5 degrees, and at least two, are averaged
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, value_parser = degrees)]
    pub(crate) shutter: f64,
    /// Images beside each picture, as PNG: depth, id or alpha. In FILE.depth.png, a unit is a
    /// centimetre along the view, 0 nothing and 65535 the farthest; in FILE.id.png, red, green and
    /// blue are the digits of 1 plus a person's number, to the base of 256; in FILE.alpha.png, 255
    /// is a pixel that people cover
    #[arg(long, value_name = "depth,id,alpha", value_delimiter = ',')]
    pub(crate) images: Vec<ImageKind>,
}

/// The frames of a film, by their numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange(pub(crate) RangeInclusive<u32>);

/// Largest number of frames.
pub(crate) const MOST_FRAMES: u32 = 1_000_000;

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            Err(format!(
                "write a number of frames in 1..={MOST_FRAMES}, or the first and the last frame, \
                 for example 50..99"
            ))
        };
        let bounds = match text.split_once("..") {
            Some((first, last)) => [first.trim().parse::<u32>(), last.trim().parse::<u32>()],
            None => [Ok(0), text.parse::<u32>().map(|count| count.wrapping_sub(1))],
        };
        match bounds {
            [Ok(first), Ok(last)] if first <= last && last < MOST_FRAMES => Ok(Self(first..=last)),
            _ => wrong(),
        }
    }
}

/// An image beside a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ImageKind {
    /// Depth in centimetres.
    Depth,
    /// The person in each pixel.
    Id,
    /// How much of each pixel members cover.
    Alpha,
}

impl ImageKind {
    /// The word in the argument and in file names.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Id => "id",
            Self::Alpha => "alpha",
        }
    }
}

impl FromStr for ImageKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = [Self::Depth, Self::Id, Self::Alpha];
        let found = all.into_iter().find(|kind| kind.name() == text);
        found.ok_or_else(|| "write depth, id or alpha, or several with commas between".into())
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(secs) if (0.0..=1e6).contains(&secs) => Ok(secs),
        _ => Err("write seconds from 0 to 1000000".into()),
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if (0.0..=360.0).contains(&degrees) => Ok(degrees),
        _ => Err("write degrees from 0 to 360".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_counted_or_named_by_first_and_last() {
        assert_eq!("3".parse(), Ok(FrameRange(0..=2)));
        assert_eq!("50..99".parse(), Ok(FrameRange(50..=99)));
        assert_eq!("7..7".parse(), Ok(FrameRange(7..=7)));
        for bad in ["", "0", "-3", "9..8", "1..", "..5", "1..1000000", "1000001", "a..b", "1.5"] {
            let message = bad.parse::<FrameRange>().expect_err(bad);
            assert!(message.contains("50..99"), "{message}");
        }
    }
}
