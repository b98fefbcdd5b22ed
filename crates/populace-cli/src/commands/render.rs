//! `populace render`

use crate::cli::RenderArgs;
use crate::draw::DrawJob;
use crate::failure::Failure;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let job = DrawJob {
        inputs: &args.inputs,
        members: args.members,
        out: &args.out,
        away_percent: 0,
        lead_in: 0,
        args: &args.picture,
    };
    job.run()
}
