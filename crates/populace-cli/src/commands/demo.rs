//! `populace demo`

use std::path::Path;

use crate::built_in;
use crate::cli::DemoArgs;
use crate::failure::Failure;
use crate::given::check_for_street;
use crate::output;
use crate::report;
use crate::scene::{self, SceneJob, SceneSource};

/// People of a picture unless set.
const MEMBERS: u32 = 500;
/// The picture, unless another path is given.
const OUT: &str = "populace-demo.png";

pub(crate) fn run(args: DemoArgs) -> Result<(), Failure> {
    check_for_street(&args.picture)?;
    let mut plan = scene::street(args.members.unwrap_or(MEMBERS), args.picture.seed);
    if let Some(file) = &args.write_scene {
        if !args.cast.is_empty() {
            let from =
                args.cast.iter().map(|path| scene_path(path)).collect::<Result<Vec<_>, _>>()?;
            plan.casts.iter_mut().for_each(|cast| cast.from.clone_from(&from));
        }
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

/// Returns a path of a cast as a scene file has it: paths there are relative to that file.
fn scene_path(path: &Path) -> Result<String, Failure> {
    if built_in::name_of(path).is_some() {
        return Ok(path.display().to_string());
    }
    let named = |reason: &dyn std::fmt::Display| {
        Failure::Input(anyhow::anyhow!("{}: {reason}", path.display()))
    };
    let whole = std::path::absolute(path).map_err(|error| named(&error))?;
    let text = whole.into_os_string().into_string();
    text.map_err(|_| named(&"a scene file has names in UTF-8 alone; rename it"))
}

/// Returns true if there seems to be a display.
#[cfg(feature = "viewer")]
fn has_display() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    ["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(is_set)
}
