//! `populace demo`

use std::path::Path;

use crate::cli::DemoArgs;
use crate::failure::Failure;
use crate::output;
use crate::report;
use crate::scene::{self, SceneJob, SceneSource};

/// People of a picture unless set.
const MEMBERS: u32 = 500;
/// The picture, unless another path is given.
const OUT: &str = "populace-demo.png";

pub(crate) fn run(args: DemoArgs) -> Result<(), Failure> {
    let plan = scene::street(args.members.unwrap_or(MEMBERS), args.picture.seed);
    if let Some(file) = &args.write_scene {
        let text = plan.to_toml().map_err(|error| Failure::Run(error.into()))?;
        output::write(file, text.as_bytes())?;
        return report::path(file);
    }
    #[cfg(feature = "viewer")]
    if args.out.is_none() && (args.script.is_some() || args.picture.is_still()) && has_display() {
        let DemoArgs { picture, cast, members, script, .. } = args;
        return super::view::run(&crate::cli::ViewArgs::of_street(picture, cast, members, script)?);
    }
    let source = SceneSource { plan, file: None, cast: &args.cast, picture: &args.picture };
    SceneJob { source, out: args.out.as_deref().unwrap_or(Path::new(OUT)) }.run()
}

/// Returns true if there seems to be a display.
#[cfg(feature = "viewer")]
fn has_display() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    ["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(is_set)
}
