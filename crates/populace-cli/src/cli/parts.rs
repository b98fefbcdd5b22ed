//! Arguments for films in parts: chunks of frames, and numbered pictures that become a film.

use std::path::PathBuf;

use clap::Args;
use populace_film::{Encoder, FrameRate};

use super::film::{FrameRange, MOST_FRAMES};
use crate::trajectory::ReadArgs;

#[derive(Args, Debug)]
pub(crate) struct PlanArgs {
    /// Inputs of `populace render`: a trajectory file or a scene, and characters
    #[arg(required = true, value_name = "FILE")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Frames of the film: N frames from frame 0 on, or those from A to B, both included [default:
    /// the whole trajectory file, or the `seconds` of a scene file]
    #[arg(long, value_name = "N|A..B")]
    pub(crate) frames: Option<FrameRange>,
    /// Frames per second, from 0.001 to 1000, or a fraction such as 30000/1001 [default: 25 for a
    /// trajectory file; that of a scene file]
    #[arg(long, value_name = "N")]
    pub(crate) fps: Option<FrameRate>,
    /// Number of frames of each chunk; the last may have fewer
    #[arg(
        long,
        value_name = "N",
        default_value_t = 50,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_FRAMES))
    )]
    pub(crate) chunk: u32,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

#[derive(Args, Debug)]
pub(crate) struct JoinArgs {
    /// The pictures: the name that `populace render --out` was given, such as frames/crowd.png for
    /// frames/crowd_0000.png and so on, or a folder that holds one such series
    #[arg(value_name = "FILE.png|FOLDER")]
    pub(crate) pictures: PathBuf,
    /// Frames of the film: N frames from frame 0 on, or those from A to B, both included [default:
    /// from the first to the last that there is]
    #[arg(long, value_name = "N|A..B")]
    pub(crate) frames: Option<FrameRange>,
    /// Frames per second, from 0.001 to 1000, or a fraction such as 30000/1001
    #[arg(long, value_name = "N")]
    pub(crate) fps: FrameRate,
    /// Film to write: .mp4 or .gif
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Encoder of MP4: the built-in one, or ffmpeg where it is installed
    #[arg(long, value_name = "openh264|ffmpeg", default_value_t = Encoder::OpenH264)]
    pub(crate) encoder: Encoder,
}
