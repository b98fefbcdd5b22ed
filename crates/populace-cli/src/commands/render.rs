//! `populace render`

use crate::cli::RenderArgs;
use crate::draw::DrawJob;
use crate::failure::Failure;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let inputs: Vec<_> = args.inputs.iter().chain(&args.cast).cloned().collect();
    let job = DrawJob {
        inputs: &inputs,
        members: args.members,
        out: &args.out,
        lead_in: 0,
        args: &args.picture,
    };
    job.run()
}
