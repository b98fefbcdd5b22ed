//! `populace demo`

use std::path::PathBuf;

use crate::cli::DemoArgs;
use crate::failure::Failure;
use crate::film::Film;

/// Frames that are timed before the first picture.
const FRAMES: u32 = 20;

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let film = Film {
        inputs: &[PathBuf::from("@people")],
        members: args.members,
        out: &args.out,
        away_percent: 15,
        lead_in: FRAMES,
        args: &args.picture,
    };
    film.make()
}
