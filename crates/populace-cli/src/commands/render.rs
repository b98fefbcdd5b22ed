//! `populace render`

use std::path::PathBuf;

use crate::cli::{RenderArgs, Size};
use crate::draw::DrawJob;
use crate::failure::Failure;
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
    let mut trajectories = args.inputs.iter().filter(is_trajectory);
    if let Some(file) = trajectories.next() {
        return match trajectories.next() {
            None => replay(&args, file),
            Some(other) => Err(Failure::usage(format!(
                "{} and {} are both trajectory files; give one",
                file.display(),
                other.display()
            ))),
        };
    }
    args.trajectory.read.refuse_unused()?;
    args.trajectory.overlay.refuse_unused()?;
    let Some(out) = args.out.as_deref().filter(|_| !args.trajectory.no_draw) else {
        return Err(Failure::usage("--no-draw needs a trajectory file"));
    };
    let inputs: Vec<_> = args.inputs.iter().chain(&args.cast).cloned().collect();
    let job = DrawJob {
        inputs: &inputs,
        members: args.members.unwrap_or(MEMBERS),
        out,
        lead_in: 0,
        args: &args.picture,
    };
    job.run()
}

fn scene(mut args: RenderArgs, file: &PathBuf) -> Result<(), Failure> {
    if args.members.is_some() {
        return Err(Failure::usage(
            "--members has no meaning here: the scene file says how many people there are",
        ));
    }
    if let Some(other) = args.inputs.iter().find(|input| *input != file) {
        let (file, other) = (file.display(), other.display());
        return Err(Failure::usage(format!(
            "{file} is a scene, which names its own characters; give {other} by --cast"
        )));
    }
    args.trajectory.read.refuse_unused()?;
    args.trajectory.overlay.refuse_unused()?;
    let Some(out) = args.out.as_deref().filter(|_| !args.trajectory.no_draw) else {
        return Err(Failure::usage("--no-draw needs a trajectory file"));
    };
    let plan = scene::read(file)?;
    args.picture.size.get_or_insert(Size(plan.output.size));
    let source = SceneSource { plan, file: Some(file), cast: &args.cast, picture: &args.picture };
    SceneJob { source, out }.run()
}

fn replay(args: &RenderArgs, file: &PathBuf) -> Result<(), Failure> {
    if args.members.is_some() {
        return Err(Failure::usage(
            "--members has no meaning here: the file says how many people there are",
        ));
    }
    let others = args.inputs.iter().filter(|input| *input != file);
    let cast: Vec<_> = others.chain(&args.cast).cloned().collect();
    let job = ReplayJob {
        file,
        cast: &cast,
        out: args.out.as_deref().filter(|_| !args.trajectory.no_draw),
        read: &args.trajectory.read,
        overlay: &args.trajectory.overlay,
        picture: &args.picture,
    };
    job.run()
}
