//! Arguments as they are typed.

mod values;

use std::path::PathBuf;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use populace::{Crowd, CrowdBuilder, Devices, Schedule, Split};

use crate::aim::{Point, ReachArg};
use crate::bench::{Load, Way};
use crate::failure::Failure;
use crate::input::InputArgs;
use crate::mix::{LayerArg, SlotArg};
pub(crate) use values::{Size, VertexId, View};
use values::{frame_rate, height, percent};

/// Animates and draws crowds in which every member has the full character pipeline.
#[derive(Debug, Parser)]
#[command(name = "populace", version, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The arguments of this run. Wrong usage, `--help` and `--version` end it here.
pub(crate) fn parse() -> Cli {
    let matches = command().get_matches();
    Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command()).exit())
}

/// The command line. What looks like a negative number after a flag is that flag's value, so that
/// the flag can say what it takes.
fn command() -> clap::Command {
    let negative = |arg: clap::Arg| match arg.get_action() {
        clap::ArgAction::Set | clap::ArgAction::Append if !arg.is_positional() => {
            arg.allow_negative_numbers(true)
        }
        _ => arg,
    };
    Cli::command().mut_subcommands(|subcommand| subcommand.mut_args(negative))
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Draw a crowd of the built-in people, without any file.
    ///
    /// Evaluates 20 frames of 1/60 s first, to time them. All else is as for `populace render`.
    Demo(DemoArgs),
    /// Draw a crowd of the characters in FILE... as a PNG or as numbered PNGs, without a window.
    ///
    /// A humanoid character that has no clips, and is lent none, plays the walk and the idle of the
    /// built-in people.
    ///
    /// The path of the picture, or of the first frame, is the last line on stdout. The JSON
    /// document gives in its place `frames`, the number of pictures, and medians over them:
    /// `animate` is from the call that evaluates a frame to its end on the device, `draw` until the
    /// picture is read back, and `total` until it is written too. `drawn_members` and `triangles`
    /// are those of the last picture.
    ///
    /// SIGINT and SIGTERM end the program at once. No file is ever half written: each appears under
    /// its name when it is complete.
    Render(RenderArgs),
    /// Show what is in character files.
    Inspect(InspectArgs),
    /// Evaluate one member through the real pipeline: joints, palettes, skinned vertices.
    Pose(PoseArgs),
    /// List the devices that can be used, and why not what cannot.
    ///
    /// --device takes these names: native is the CPU without a driver, on all cores; native:2 the
    /// same on two threads; opencl:N an OpenCL device by its number, opencl the first of them;
    /// opencl:N:1/2 the first of two equal parts of one, which CPU drivers offer, each with compute
    /// units of its own. Several names joined by + share a crowd, as in native:1+opencl:0:1/2; the
    /// first of them is the one that hands palettes to OpenGL.
    Devices(DevicesArgs),
    /// Measure the pipeline on this machine, and check its results against the oracle.
    ///
    /// Schedules, devices and loads take turns frame by frame, after three frames to warm up; the
    /// last frame is held against the oracle.
    ///
    /// In the JSON document `joints` are those of all members together. `ms_median` and `ms_min`
    /// are the device's own time, from profiling events where it has them (the native device's is
    /// that of the host). `wall_ms_median` is the host's from the call to the end, `host_ms_median`
    /// its part in the call alone, `change_ms_median` that of the calls that change clips, before
    /// it. `bytes_per_joint` counts what is a member's own, once for each stage that reads or
    /// writes it, without the tables that all share. `memory_bytes` are the device's;
    /// `bytes_per_member_beyond_palettes` is how many more it takes for each further member, found
    /// from crowds of 2,000 and 4,000. `baked` tells what tables of palettes take, and the rows of
    /// the same clips. The schedule floor writes palettes and computes nothing.
    Bench(BenchArgs),
}

/// Where to evaluate.
#[derive(Args, Clone, Debug)]
pub(crate) struct DeviceArgs {
    /// Device to evaluate on: native, opencl or opencl:N, or several joined by + [default: the best
    /// there is]. `populace devices --help` tells more
    #[arg(long, value_name = "DEVICE[+DEVICE]")]
    pub(crate) device: Option<Devices>,
    /// How several devices share the members: measured, or a share for each as in 60,40
    #[arg(long, value_name = "measured|SHARE,SHARE", default_value_t = Split::Measured, allow_hyphen_values = true)]
    pub(crate) split: Split,
    /// How stages are mapped to work-items
    #[arg(long, value_name = "staged|fused|fused-wide|fused-grouped", default_value_t = Schedule::Fused)]
    pub(crate) schedule: Schedule,
}

impl DeviceArgs {
    /// A crowd to be built there, or on the best device where none is named.
    pub(crate) fn crowd(&self) -> CrowdBuilder {
        let builder = Crowd::builder().split(self.split.clone()).schedule(self.schedule);
        self.device.iter().cloned().fold(builder, CrowdBuilder::devices)
    }
}

/// Builds a crowd, and says so where it is on the native device although none was named.
pub(crate) fn build(builder: CrowdBuilder) -> Result<Crowd, Failure> {
    let crowd = builder.build()?;
    if let Some(reason) = crowd.fallback() {
        crate::report::talk!("on the native device: {reason}");
    }
    Ok(crowd)
}

#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    /// glTF 2.0 files (.gltf, .glb) with characters; files that hold only clips lend them to the
    /// others. @people are the built-in people, @woman, @child and so on one of them; - is standard
    /// input
    #[arg(required = true, value_name = "FILE")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Members of the crowd
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) members: u32,
    /// The PNG to write; with --frames the name that the frames' numbers are added to
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

#[derive(Args, Debug)]
pub(crate) struct DemoArgs {
    /// Members of the crowd
    #[arg(long, value_name = "N", default_value_t = 250, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) members: u32,
    /// The PNG to write; with --frames the name that the frames' numbers are added to
    #[arg(long, value_name = "FILE", default_value = "populace-demo.png")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

/// How a crowd is drawn.
#[derive(Args, Debug)]
pub(crate) struct PictureArgs {
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", allow_hyphen_values = true)]
    pub(crate) size: Size,
    /// Frames of a film to write, as numbered PNGs [default: one picture]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) frames: Option<u32>,
    /// Frames per second, from 0.001 to 1000
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = frame_rate, requires = "frames")]
    pub(crate) fps: f32,
    /// From where: crowd shows all members, close one of them, six numbers are the eye and what it
    /// looks at, in metres
    #[arg(
        long,
        value_name = "crowd|close|X,Y,Z,X,Y,Z",
        default_value = "crowd",
        allow_hyphen_values = true
    )]
    pub(crate) camera: View,
    /// Height of every character in metres [default: its own; sensible ones where characters are
    /// mixed]
    #[arg(long, value_name = "METRES", value_parser = height)]
    pub(crate) height: Option<f32>,
    /// A file that lends its clips and is not drawn, whatever else it holds; can be repeated. They
    /// are retargeted where skeletons differ. @people lends those of the built-in people, @child
    /// and so on those of one of them
    #[arg(long, value_name = "FILE")]
    pub(crate) clips: Vec<PathBuf>,
    /// Clip that all members play [default: a walk or an idle, whichever are found by name, else
    /// any]
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// Let the motion of a clip's root carry members on, cycle after cycle. Clips that walk in
    /// place do so without it
    #[arg(long)]
    pub(crate) root_motion: bool,
    /// Leave out the parts of a node, by its name; can be repeated
    #[arg(long, value_name = "NODE")]
    pub(crate) hide: Vec<String>,
    /// Seed of everything random; the same seed gives the same picture
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Print one JSON document in place of the path
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Args, Debug)]
pub(crate) struct InspectArgs {
    /// glTF 2.0 files (.gltf, .glb); - is standard input
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Show only what clips take: rows, their bytes, and those of the files' keys
    #[arg(long)]
    pub(crate) rows: bool,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) input: InputArgs,
}

#[derive(Args, Debug)]
pub(crate) struct PoseArgs {
    /// A glTF 2.0 file (.gltf, .glb); - is standard input
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Clip to play, by name or by index [default: none, the rest pose]
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<String>,
    /// Also find clips of this file, after the file's own; they are retargeted where the skeletons
    /// differ. @people lends those of the built-in people
    #[arg(long, value_name = "FILE")]
    pub(crate) clips: Option<PathBuf>,
    /// Time on the clip's own axis in seconds, not wrapped
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    pub(crate) time: f32,
    /// Mix this clip, by name or by index, standing at a time on its own axis; can be repeated, up
    /// to 8 times [weight 1 among the clips of its layer, layer 0]. With "partial" also one that
    /// hardly fits: names alone bind less than 30 % of the joints that it moves. A backslash quotes
    /// a comma, an equals sign or a backslash in a name
    #[arg(long, value_name = "clip=C,time=S,weight=W,layer=L,partial", conflicts_with_all = ["clip", "time"])]
    pub(crate) slot: Vec<SlotArg>,
    /// Lay layer 1, 2 or 3 over those below it, for this joint and what hangs on it, with its
    /// weight, replacing them or adding to them; can be repeated [all joints, weight 1]
    #[arg(long, value_name = "L,mask=JOINT,additive,weight=W", allow_hyphen_values = true)]
    pub(crate) layer: Vec<LayerArg>,
    /// Look at a point of model space, in metres: spine, neck, head and eyes share the turn, within
    /// their limits
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) look_at: Option<Point>,
    /// Reach for a point of model space, in metres, with the limb of two bones that ends in a
    /// joint; can be repeated. A backslash quotes a comma, an equals sign or a backslash in the
    /// name
    #[arg(long, value_name = "JOINT=X,Y,Z")]
    pub(crate) reach: Vec<ReachArg>,
    /// Also give skinned vertices, in scene space
    #[arg(long)]
    pub(crate) vertices: bool,
    /// Give this vertex alone, as the file counts them; can be repeated
    #[arg(
        long,
        value_name = "NODE,PRIMITIVE,VERTEX",
        requires = "vertices",
        allow_hyphen_values = true
    )]
    pub(crate) vertex: Vec<VertexId>,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Args, Debug)]
pub(crate) struct DevicesArgs {
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct BenchArgs {
    /// Members of the crowd; several sizes as a list or by repeating it
    #[arg(long, value_name = "N,...", default_value = "10000", value_delimiter = ',', allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) members: Vec<u32>,
    /// Joints of the one skeleton that all members share [default: four skeletons of 24 to 128
    /// joints]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) joints: Option<u32>,
    /// Clips that each member blends
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub(crate) slots: u32,
    /// Frames measured of each
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) frames: u32,
    /// Device to measure, or several that share the crowd, joined by +; can be repeated [default:
    /// native and every OpenCL device]
    #[arg(long, value_name = "DEVICE[+DEVICE]")]
    pub(crate) device: Vec<Devices>,
    /// How several devices share the members: measured, or a share for each as in 60,40
    #[arg(long, value_name = "measured|SHARE,SHARE", default_value_t = Split::Measured, allow_hyphen_values = true)]
    pub(crate) split: Split,
    /// Schedule to measure; can be repeated. baked looks palettes of one clip up, natively, and can
    /// do nothing else [default: staged, fused and baked]
    #[arg(long, value_name = "staged|fused|fused-wide|fused-grouped|baked")]
    pub(crate) schedule: Vec<Way>,
    /// Load to measure beside the plain one: constraints lets every member look at something and
    /// keep both feet to the ground; full adds two layers, one through a mask and one additive,
    /// with a slot in each. A list, or repeated
    #[arg(long, value_name = "plain|constraints|full", value_delimiter = ',')]
    pub(crate) load: Vec<Load>,
    /// Also measure with clips from other skeletons: their joints have the same names, another
    /// order, and more between
    #[arg(long)]
    pub(crate) retarget: bool,
    /// Also measure while this share of the members, in turn, crossfades to another clip each frame
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub(crate) changing: Option<f32>,
    /// Also draw nanoseconds per joint over members, of whole frames, as an SVG
    #[arg(long, value_name = "FILE")]
    pub(crate) chart: Option<PathBuf>,
    /// Measure nothing, and show what an earlier run gave with --json
    #[arg(long, value_name = "FILE", conflicts_with_all = ["members", "joints", "slots", "frames", "device", "split", "schedule", "load", "retarget", "changing", "seed"])]
    pub(crate) from: Option<PathBuf>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        command().debug_assert();
    }
}
