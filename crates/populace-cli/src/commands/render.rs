//! `populace render`

use crate::cli::RenderArgs;
use crate::failure::Failure;
use crate::film::Film;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let film = Film {
        inputs: &args.inputs,
        members: args.members,
        out: &args.out,
        away_percent: 0,
        lead_in: 0,
        args: &args.picture,
    };
    film.make()
}
