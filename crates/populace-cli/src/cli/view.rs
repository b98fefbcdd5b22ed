//! The arguments of `populace view`.

use std::path::PathBuf;

use clap::{Args, FromArgMatches};

use super::film::FilmArgs;
use super::picture::PictureArgs;
use super::trajectories::TrajectoryArgs;
use crate::failure::Failure;
use populace_film::Encoder;

/// Options of films and pictures, which mean nothing in a window.
const FILM_OPTIONS: [&str; 6] =
    ["frames", "skip_existing", "encoder", "shutter", "images", "no_draw"];

#[derive(Args, Debug)]
pub(crate) struct ViewArgs {
    /// Characters, built-in people, a trajectory file or a scene file, as for `populace render`, or
    /// @street for the street of `populace demo` [default: @people]
    #[arg(value_name = "FILE")]
    pub(crate) inputs: Vec<PathBuf>,
    /// More characters: files, folders with glTF files, or built-in people. A scene names its own
    #[arg(long, value_name = "PATH", num_args = 1..)]
    pub(crate) cast: Vec<PathBuf>,
    /// Number of members of a crowd of characters [default: 200]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=10_000_000)
    )]
    pub(crate) members: Option<u32>,
    /// File with lines such as "at 0.5 click 300 200" that drive the window
    #[arg(long, value_name = "FILE")]
    pub(crate) script: Option<PathBuf>,
    /// File that remembers the size and the panels of the window [default: viewer.toml in your
    /// folder of settings; none with --script]
    #[arg(long, value_name = "FILE")]
    pub(crate) layout: Option<PathBuf>,
    /// Path of films that are recorded; a number is added to the name
    #[arg(long, value_name = "FILE", default_value = "populace.mp4")]
    pub(crate) film: PathBuf,
    #[command(flatten)]
    pub(crate) trajectory: TrajectoryArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

impl ViewArgs {
    /// The arguments that open the street of `populace demo`.
    pub(crate) fn of_street(
        picture: PictureArgs,
        cast: Vec<PathBuf>,
        members: Option<u32>,
        script: Option<PathBuf>,
    ) -> Result<Self, Failure> {
        let command = Self::augment_args(clap::Command::new("view"));
        let matches = command.try_get_matches_from(["view", "@street"]);
        let defaults = matches.and_then(|matches| Self::from_arg_matches(&matches));
        let defaults = defaults.map_err(|error| Failure::Run(error.into()))?;
        Ok(Self { picture, cast, members, script, ..defaults })
    }

    /// Refuses options that mean nothing in a window.
    pub(crate) fn refuse_films(&self) -> Result<(), Failure> {
        let FilmArgs { frames, skip_existing, encoder, shutter, images, .. } = &self.picture.film;
        let is_given = frames.is_some()
            || *skip_existing
            || *encoder != Encoder::OpenH264
            || *shutter != 0.0
            || !images.is_empty()
            || self.trajectory.no_draw;
        if is_given {
            return Err(Failure::usage(
                "--frames, --skip-existing, --encoder, --shutter, --images and --no-draw have no \
                 meaning in a window; `populace render` takes them",
            ));
        }
        Ok(())
    }
}

/// Hides the options of films from the help, and says what others mean in a window.
pub(super) fn without_films(command: clap::Command) -> clap::Command {
    FILM_OPTIONS
        .into_iter()
        .fold(command, |command, name| command.mut_arg(name, |arg| arg.hide(true)))
        .mut_arg("size", |arg| {
            arg.help("Width and height of the window in pixels [default: those of the layout]")
        })
        .mut_arg("at", |arg| arg.help("Time at which the window begins, in seconds"))
        .mut_arg("json", |arg| arg.help("Print one JSON document once the window is closed"))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_help_says_what_options_mean_in_a_window() {
        let mut command = super::super::command();
        let mut help = |name: &str| {
            let command = command.find_subcommand_mut(name).expect("a command");
            command.render_long_help().to_string().split_whitespace().collect::<Vec<_>>().join(" ")
        };
        let view = help("view");
        for text in ["Time at which the window begins", "document once the window is closed"] {
            assert!(view.contains(text), "{text}: {view}");
        }
        for name in ["demo", "view"] {
            assert!(help(name).contains("such as \"at 0.5 click 300 200\" that"), "{name}");
        }
    }
}
