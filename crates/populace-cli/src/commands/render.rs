//! `populace render`

use std::path::{Path, PathBuf};

use crate::cli::{RenderArgs, Size};
use crate::draw::DrawJob;
use crate::failure::Failure;
use crate::given::Given;
use crate::replay::ReplayJob;
use crate::scene::{self, SceneJob, SceneSource};
use crate::trajectory;

/// Members of a crowd unless set.
const MEMBERS: u32 = 1000;

pub(crate) fn run(args: RenderArgs) -> Result<(), Failure> {
    if let Some(file) = args.inputs.iter().find(|input| scene::is_scene(input)) {
        let file = file.clone();
        return scene(args, &file);
    }
    let is_trajectory = |input: &&PathBuf| trajectory::is_trajectory(input);
    if let Some(file) = args.inputs.iter().find(is_trajectory) {
        return replay(&args, file);
    }
    given(&args).check_without_recording()?;
    let out = out(&args)?;
    let inputs: Vec<_> = args.inputs.iter().chain(&args.cast).cloned().collect();
    let job = DrawJob {
        inputs: &inputs,
        members: args.members.unwrap_or(MEMBERS),
        out,
        args: &args.picture,
    };
    job.run()
}

fn scene(mut args: RenderArgs, file: &Path) -> Result<(), Failure> {
    given(&args).check_for_scene(file)?;
    let plan = scene::read(file)?;
    args.picture.size.get_or_insert(Size(plan.output.size));
    let source = SceneSource { plan, file: Some(file), cast: &[], picture: &args.picture };
    SceneJob { source, out: out(&args)? }.run()
}

fn replay(args: &RenderArgs, file: &PathBuf) -> Result<(), Failure> {
    refuse_outputs_without_drawing(args)?;
    let mut cast = given(args).cast_for_recording(file)?;
    cast.extend(args.cast.iter().cloned());
    let job = ReplayJob {
        file,
        cast: &cast,
        out: args.out.as_deref(),
        read: &args.trajectory.read,
        overlay: &args.trajectory.overlay,
        picture: &args.picture,
    };
    job.run()
}

/// Refuses outputs that --no-draw would not write.
fn refuse_outputs_without_drawing(args: &RenderArgs) -> Result<(), Failure> {
    let outputs =
        [("--out", args.out.is_some()), ("--images", !args.picture.film.images.is_empty())];
    match outputs.into_iter().find(|(_, is_given)| *is_given && args.trajectory.no_draw) {
        Some((flag, _)) => {
            Err(Failure::usage(format!("--no-draw draws nothing, so leave out {flag}")))
        }
        None => Ok(()),
    }
}

fn given(args: &RenderArgs) -> Given<'_> {
    let RenderArgs { inputs, cast, members, trajectory, picture, .. } = args;
    Given { inputs, cast, members: *members, trajectory, picture }
}

/// Returns the path of what is drawn, which only recordings may lack.
fn out(args: &RenderArgs) -> Result<&Path, Failure> {
    let out = args.out.as_deref().filter(|_| !args.trajectory.no_draw);
    out.ok_or_else(|| Failure::usage("--no-draw needs a trajectory file"))
}
