//! `populace demo`

use std::path::PathBuf;

use crate::cli::DemoArgs;
use crate::draw::DrawJob;
use crate::failure::Failure;

/// Frames timed before the first picture.
const TIMED_FRAMES: u32 = 20;

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let people = [PathBuf::from("@people")];
    let job = DrawJob {
        inputs: if args.cast.is_empty() { &people } else { &args.cast },
        members: args.members,
        out: &args.out,
        lead_in: TIMED_FRAMES,
        args: &args.picture,
    };
    job.run()
}
