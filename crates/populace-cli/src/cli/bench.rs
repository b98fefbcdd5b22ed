//! The arguments of `populace bench`.

use std::path::PathBuf;

use clap::Args;
use populace::{Devices, Split};
use populace_bench::{Load, Method};

use crate::input::InputArgs;

#[derive(Args, Debug)]
pub(crate) struct BenchArgs {
    /// Characters to measure, with their own clips: files, `@people`, or one of these by name, such
    /// as `@child` [default: random skeletons and clips]. With --skate, also with the clips of
    /// `@people` and of files without meshes [default: @people]. --joints, --load and --retarget
    /// are for random skeletons, not for these
    #[arg(value_name = "FILE", conflicts_with_all = ["joints", "retarget", "load", "from"])]
    pub(crate) files: Vec<PathBuf>,
    /// Measure foot skate instead of times: how fast planted soles move over the ground, on a
    /// standard course, with and without planting
    #[arg(
        long,
        conflicts_with_all = [
            "members", "joints", "slots", "frames", "device", "split", "schedule", "load",
            "retarget", "changing", "seed", "chart", "from", "against",
        ]
    )]
    pub(crate) skate: bool,
    /// Members of the crowd; a list of sizes, or repeated
    #[arg(
        long,
        value_name = "N,...",
        default_value = "10000",
        value_delimiter = ',',
        allow_hyphen_values = true,
        value_parser = clap::value_parser!(u32).range(1..=10_000_000)
    )]
    pub(crate) members: Vec<u32>,
    /// Give all members one skeleton with this many joints [default: four skeletons of 24 to 128
    /// joints]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) joints: Option<u32>,
    /// Clips that each member blends
    #[arg(
        long,
        value_name = "N",
        default_value_t = 2,
        value_parser = clap::value_parser!(u32).range(1..=8)
    )]
    pub(crate) slots: u32,
    /// Frames to measure
    #[arg(
        long,
        value_name = "N",
        default_value_t = 25,
        value_parser = clap::value_parser!(u32).range(1..=10_000)
    )]
    pub(crate) frames: u32,
    /// Device to measure, or several joined by + that share the crowd; can be repeated [default:
    /// native and every OpenCL device]
    #[arg(long, value_name = "DEVICE[+DEVICE]")]
    pub(crate) device: Vec<Devices>,
    /// Distribution of members over several devices: measured balances them by their times; shares
    /// such as 60,40 are fixed
    #[arg(
        long,
        value_name = "measured|SHARE,SHARE",
        default_value_t = Split::Measured,
        allow_hyphen_values = true
    )]
    pub(crate) split: Split,
    /// Schedule to measure; can be repeated. `baked` looks up precomputed palettes of one clip, on
    /// the native device only [default: staged, fused and baked]
    #[arg(long, value_name = "staged|fused|fused-wide|fused-grouped|baked")]
    pub(crate) schedule: Vec<Method>,
    /// Additional load to measure besides plain: with constraints, every member looks at a target
    /// and plants both feet; full adds a masked and an additive layer with a slot in each. A list,
    /// or repeated; not with FILE
    #[arg(long, value_name = "plain|constraints|full", value_delimiter = ',')]
    pub(crate) load: Vec<Load>,
    /// Also measure with clips of other skeletons, whose joints have the same names in another
    /// order and additional joints between them
    #[arg(long)]
    pub(crate) retarget: bool,
    /// Also measure while this percentage of the members, in turn, crossfades to another clip in
    /// each frame
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub(crate) changing: Option<f32>,
    /// Also let another program evaluate the plain crowd, with the same clips, frame by frame in
    /// turn, and print how times and errors compare: one built by
    /// crates/populace-bench/against/build.sh from ozz-animation
    #[arg(long, value_name = "PROGRAM")]
    pub(crate) against: Option<PathBuf>,
    /// Also write a chart of nanoseconds per joint over members as an SVG
    #[arg(long, value_name = "FILE")]
    pub(crate) chart: Option<PathBuf>,
    /// Show the results of an earlier run with --json instead of measuring
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = [
            "members", "joints", "slots", "frames", "device", "split", "schedule", "load",
            "retarget", "changing", "seed", "against",
        ]
    )]
    pub(crate) from: Option<PathBuf>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) input: InputArgs,
}

/// Parses a percentage above 0.
fn percent(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(percent) if percent > 0.0 && percent <= 100.0 => Ok(percent),
        _ => Err("write a number above 0 and up to 100".into()),
    }
}
