//! `populace demo`

use populace_scene::{StreetSettings, street};

use crate::cli::DemoArgs;
use crate::failure::Failure;
use crate::output;
use crate::report;
use crate::scene::{SceneJob, SceneSource};

/// Seconds before the first picture: people have met, sat down and begun to cross by then.
const LEAD_IN_SECS: f32 = 20.0;

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let settings = StreetSettings { members: args.members as usize, seed: args.picture.seed };
    let mut plan = street(settings);
    plan.output.lead_in_s = LEAD_IN_SECS;
    if let Some(file) = &args.write_scene {
        let text = plan.to_toml().map_err(|error| Failure::Run(error.into()))?;
        output::write(file, text.as_bytes())?;
        return report::path(file);
    }
    let source = SceneSource { plan, file: None, cast: &args.cast, picture: &args.picture };
    SceneJob { source, out: &args.out }.run()
}
