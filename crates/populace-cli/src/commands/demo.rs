//! `populace demo`

use std::path::PathBuf;

use crate::cli::DemoArgs;
use crate::draw::DrawJob;
use crate::failure::Failure;

/// Frames timed before the first picture.
const TIMED_FRAMES: u32 = 20;

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let job = DrawJob {
        inputs: &[PathBuf::from("@people")],
        members: args.members,
        out: &args.out,
        away_percent: 15,
        lead_in: TIMED_FRAMES,
        args: &args.picture,
    };
    job.run()
}
