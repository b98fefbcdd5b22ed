//! Arguments for trajectory files.

use clap::Args;

use super::values::{trail_secs, wall_height};
use crate::failure::Failure;
use crate::trajectory::ReadArgs;

/// Options for trajectory files.
#[derive(Args, Clone, Debug)]
pub(crate) struct TrajectoryArgs {
    #[command(flatten)]
    pub(crate) read: ReadArgs,
    /// Evaluate all frames and print measures as JSON, without drawing
    #[arg(long, help_heading = "Trajectory files")]
    pub(crate) no_draw: bool,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
}

/// Options for what is drawn over pictures of trajectories.
#[derive(Args, Clone, Debug)]
pub(crate) struct OverlayArgs {
    /// Colour clothes by speed, density (people within 1.5 m, by area), id, z (elevation) or a
    /// column of the file, with a legend
    #[arg(long, value_name = "NAME", alias = "color-by", help_heading = "Trajectory files")]
    pub(crate) colour_by: Option<String>,
    /// Draw the way that people came in the last seconds
    #[arg(
        long,
        value_name = "SECONDS",
        num_args = 0..=1,
        default_missing_value = "3",
        value_parser = trail_secs,
        help_heading = "Trajectory files"
    )]
    pub(crate) trails: Option<f64>,
    /// Write ids above heads
    #[arg(long, help_heading = "Trajectory files")]
    pub(crate) ids: bool,
    /// Show the time since the beginning of the file
    #[arg(long, help_heading = "Trajectory files")]
    pub(crate) clock: bool,
    /// Height of walls and obstacles in metres, from 0.01 to 100 [default: 0.6]
    #[arg(
        long,
        value_name = "METRES",
        value_parser = wall_height,
        help_heading = "Trajectory files"
    )]
    pub(crate) walls: Option<f64>,
}

impl OverlayArgs {
    /// Returns the height of walls and obstacles in metres.
    pub(crate) fn walls_m(&self) -> f64 {
        self.walls.unwrap_or(0.6)
    }

    /// Refuses these options if one was given. For commands without a trajectory file.
    pub(crate) fn refuse_unused(&self) -> Result<(), Failure> {
        let given = [
            ("--colour-by", self.colour_by.is_some()),
            ("--trails", self.trails.is_some()),
            ("--ids", self.ids),
            ("--clock", self.clock),
            ("--walls", self.walls.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(Failure::usage(format!("{flag} needs a trajectory file"))),
            None => Ok(()),
        }
    }
}
