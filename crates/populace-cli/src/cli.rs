//! Arguments as they are typed.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand};
use populace::{Crowd, CrowdBuilder, Device, Devices, Schedule, Split};

use crate::aim::{Point, ReachArg};
use crate::bench::{Load, Way};
use crate::mix::{LayerArg, SlotArg};

/// Animates and draws crowds in which every member has the full character pipeline.
#[derive(Debug, Parser)]
#[command(name = "populace", version, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Draw a crowd of the built-in people, without any file.
    Demo(DemoArgs),
    /// Draw a crowd of the characters in FILE... as a PNG or as numbered PNGs, without a window.
    Render(RenderArgs),
    /// Show what is in character files.
    Inspect(InspectArgs),
    /// Evaluate one member through the real pipeline: joints, palettes, skinned vertices.
    Pose(PoseArgs),
    /// List the devices that can be used, and why not what cannot.
    ///
    /// --device takes these names: native is the CPU without a driver, on all cores; native:2 the same on two threads;
    /// opencl:N an OpenCL device by its number, opencl the first of them; opencl:N:1/2 the first of two equal parts of
    /// one, which CPU drivers offer, each with compute units of its own. Several names joined by + share a crowd, as in
    /// native:1+opencl:0:1/2; the first of them is the one that hands palettes to OpenGL.
    Devices(DevicesArgs),
    /// Measure the pipeline on this machine, and check its results against the oracle.
    ///
    /// Schedules, devices and loads take turns frame by frame, after three frames to warm up; the last frame is held
    /// against the oracle.
    ///
    /// In the JSON document `joints` are those of all members together. `ms_median` and `ms_min` are the device's own time,
    /// from profiling events where it has them (the native device's is that of the host). `wall_ms_median` is the host's
    /// from the call to the end, `host_ms_median` its part in the call alone, `change_ms_median` that of the calls that
    /// change clips, before it. `bytes_per_joint` counts what is a member's own, once for each stage that reads or writes
    /// it, without the tables that all share. `memory_bytes` are the device's; `bytes_per_member_beyond_palettes` is how
    /// many more it takes for each further member, found from crowds of 2,000 and 4,000. `baked` tells what tables of
    /// palettes take, and the rows of the same clips. The schedule floor writes palettes and computes nothing.
    Bench(BenchArgs),
}

/// Where to evaluate.
#[derive(Args, Clone, Debug)]
pub(crate) struct DeviceArgs {
    /// Device to evaluate on: native, opencl or opencl:N, or several joined by + [default: the best there is].
    /// `populace devices --help` tells more
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
    /// What is named, or the best device there is.
    pub(crate) fn devices(&self) -> Devices {
        self.device.clone().unwrap_or_else(|| Device::best().into())
    }

    /// A crowd to be built there.
    pub(crate) fn crowd(&self) -> CrowdBuilder {
        Crowd::builder().devices(self.devices()).split(self.split.clone()).schedule(self.schedule)
    }
}

#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    /// glTF 2.0 files (.gltf, .glb) with characters; files that hold only clips lend them to the others. @people are the
    /// built-in people, @woman, @child and so on one of them
    #[arg(required = true, value_name = "FILE")]
    pub(crate) inputs: Vec<String>,
    /// Members of the crowd
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) members: u32,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub(crate) size: Size,
    /// The PNG to write; with --frames the name that the frames' numbers are added to
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Frames of a film to write, as numbered PNGs [default: one picture]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) frames: Option<u32>,
    /// Frames per second, from 0.001 to 1000
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = frame_rate, requires = "frames")]
    pub(crate) fps: f32,
    /// From where: crowd shows all members, close one of them, six numbers are the eye and what it looks at, in metres
    #[arg(long, value_name = "crowd|close|X,Y,Z,X,Y,Z", default_value = "crowd", allow_hyphen_values = true)]
    pub(crate) camera: View,
    /// Height of every character in metres [default: its own; sensible ones where characters are mixed]
    #[arg(long, value_name = "METRES", value_parser = height)]
    pub(crate) height: Option<f32>,
    /// A file that lends its clips and is not drawn, whatever else it holds; can be repeated. They are retargeted where
    /// skeletons differ
    #[arg(long, value_name = "FILE")]
    pub(crate) clips: Vec<PathBuf>,
    /// Clip that all members play [default: a walk or an idle, whichever are found by name, else any]
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// Let the motion of a clip's root carry members on, cycle after cycle. Clips that walk in place do so without it
    #[arg(long)]
    pub(crate) root_motion: bool,
    /// Leave out the parts of a node, by its name; can be repeated
    #[arg(long, value_name = "NODE")]
    pub(crate) hide: Vec<String>,
    /// Seed of everything random; the same seed gives the same picture
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Args, Debug)]
pub(crate) struct DemoArgs {
    /// Members of the crowd
    #[arg(long, value_name = "N", default_value_t = 250, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) members: u32,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub(crate) size: Size,
    /// The PNG to write
    #[arg(long, value_name = "FILE", default_value = "populace-demo.png")]
    pub(crate) out: PathBuf,
    /// Seed of everything random; the same seed gives the same picture
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Args, Debug)]
pub(crate) struct InspectArgs {
    /// glTF 2.0 files (.gltf, .glb)
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Show only what clips take: rows, their bytes, and those of the files' keys
    #[arg(long)]
    pub(crate) rows: bool,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct PoseArgs {
    /// A glTF 2.0 file (.gltf, .glb)
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Clip to play, by name or by index [default: none, the rest pose]
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<String>,
    /// Also find clips of this file, after the file's own; they are retargeted where the skeletons differ
    #[arg(long, value_name = "FILE")]
    pub(crate) clips: Option<PathBuf>,
    /// Time on the clip's own axis in seconds, not wrapped
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) time: f32,
    /// Mix this clip, by name or by index, standing at a time on its own axis; can be repeated, up to 8 times [weight 1
    /// among the clips of its layer, layer 0]. With "partial" also one that hardly fits: names
    /// alone bind less than 30 % of the joints that it moves. A backslash quotes a comma, an equals
    /// sign or a backslash in a name
    #[arg(long, value_name = "clip=C,time=S,weight=W,layer=L,partial", conflicts_with_all = ["clip", "time"])]
    pub(crate) slot: Vec<SlotArg>,
    /// Lay layer 1, 2 or 3 over those below it, for this joint and what hangs on it, with its weight, replacing them or
    /// adding to them; can be repeated [all joints, weight 1]
    #[arg(long, value_name = "L,mask=JOINT,additive,weight=W")]
    pub(crate) layer: Vec<LayerArg>,
    /// Look at a point of model space, in metres: spine, neck, head and eyes share the turn, within their limits
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) look_at: Option<Point>,
    /// Reach for a point of model space, in metres, with the limb of two bones that ends in a joint; can be repeated. A
    /// backslash quotes a comma, an equals sign or a backslash in the name
    #[arg(long, value_name = "JOINT=X,Y,Z")]
    pub(crate) reach: Vec<ReachArg>,
    /// Also give skinned vertices, in scene space
    #[arg(long)]
    pub(crate) vertices: bool,
    /// Give this vertex alone, as the file counts them; can be repeated
    #[arg(long, value_name = "NODE,PRIMITIVE,VERTEX", requires = "vertices")]
    pub(crate) vertex: Vec<VertexId>,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
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
    #[arg(long, value_name = "N,...", default_value = "10000", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) members: Vec<u32>,
    /// Joints of the one skeleton that all members share [default: four skeletons of 24 to 128 joints]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) joints: Option<u32>,
    /// Clips that each member blends
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub(crate) slots: u32,
    /// Frames measured of each
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) frames: u32,
    /// Device to measure, or several that share the crowd, joined by +; can be repeated [default: native and every OpenCL
    /// device]
    #[arg(long, value_name = "DEVICE[+DEVICE]")]
    pub(crate) device: Vec<Devices>,
    /// How several devices share the members: measured, or a share for each as in 60,40
    #[arg(long, value_name = "measured|SHARE,SHARE", default_value_t = Split::Measured, allow_hyphen_values = true)]
    pub(crate) split: Split,
    /// Schedule to measure; can be repeated. baked looks palettes of one clip up, natively, and can do nothing else
    /// [default: staged, fused and baked]
    #[arg(long, value_name = "staged|fused|fused-wide|fused-grouped|baked")]
    pub(crate) schedule: Vec<Way>,
    /// Load to measure beside the plain one: constraints lets every member look at something and keep both feet to the
    /// ground; full adds two layers, one through a mask and one additive, with a slot in each. A list, or repeated
    #[arg(long, value_name = "plain|constraints|full", value_delimiter = ',')]
    pub(crate) load: Vec<Load>,
    /// Also measure with clips from other skeletons: their joints have the same names, another order, and more between
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

/// Pixels across and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size(pub(crate) [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        match sides {
            Some(sides) if !sides.contains(&0) => Ok(Self(sides)),
            _ => Err("write width and height in pixels as 1280x720".into()),
        }
    }
}

fn frame_rate(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(rate) if (0.001..=1000.0).contains(&rate) => Ok(rate),
        _ => Err("write a number from 0.001 to 1000".into()),
    }
}

/// A length in metres that a body could have.
fn height(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(metres) if (1e-3..=1e4).contains(&metres) => Ok(metres),
        _ => Err("write metres from 0.001 to 10000".into()),
    }
}

/// A share that is not nothing.
fn percent(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(percent) if percent > 0.0 && percent <= 100.0 => Ok(percent),
        _ => Err("write a number above 0 and up to 100".into()),
    }
}

/// From where a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum View {
    /// So that all members are in the picture.
    Crowd,
    /// One member, large.
    Close,
    /// From a place to a place, in metres.
    At { eye: [f32; 3], target: [f32; 3] },
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "crowd" => return Ok(Self::Crowd),
            "close" => return Ok(Self::Close),
            _ => {}
        }
        let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[a, b, c, x, y, z]) if [a, b, c, x, y, z].iter().all(|v| v.is_finite()) => {
                Ok(Self::At { eye: [a, b, c], target: [x, y, z] })
            }
            _ => Err("write crowd, close, or the eye and what it looks at as 0,1.6,5,0,1,0".into()),
        }
    }
}

/// A vertex as the file counts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct VertexId {
    pub(crate) node: usize,
    pub(crate) primitive: usize,
    pub(crate) vertex: usize,
}

impl FromStr for VertexId {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<usize>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[node, primitive, vertex]) => Ok(Self { node, primitive, vertex }),
            _ => Err("write the node, primitive and vertex index as 5,0,17".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn sizes_and_vertices_are_read_or_refused() {
        assert_eq!("640x360".parse(), Ok(Size([640, 360])));
        for bad in ["", "640", "0x3", "-1x5", "axb", "5x"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        assert_eq!("close".parse(), Ok(View::Close));
        let wanted = View::At { eye: [0.0, 1.5, -5.0], target: [0.0; 3] };
        assert_eq!("0,1.5,-5,0,0,0".parse(), Ok(wanted));
        for bad in ["", "near", "1,2,3", "1,2,3,4,5,nan"] {
            assert!(bad.parse::<View>().is_err(), "{bad}");
        }
        for bad in ["0", "-1", "inf", "1e-30", "x"] {
            assert!(frame_rate(bad).is_err() && height(bad).is_err(), "{bad}");
        }
        assert_eq!("5,0,17".parse(), Ok(VertexId { node: 5, primitive: 0, vertex: 17 }));
        for bad in ["", "5,0", "5,0,1,2", "a,b,c", "5,-1,0"] {
            assert!(bad.parse::<VertexId>().is_err(), "{bad}");
        }
    }
}
