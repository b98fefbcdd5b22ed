//! Checks of crowds over many frames.

use populace_clip::ticks_from_secs;
use populace_device::Backend;

use super::plans;
use crate::compare::Judge;
use crate::plan::FRAME_TICKS;
use crate::scenes::{Scene, body};
use crate::{LayerPlan, MemberPlan, Play, Rng};

/// Checks crowds that get clips, members and masks between frames, so that every table grows.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_growth(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("growth");
    let mut rng = Rng::new(71);
    let mut crowd = plans::crowd(&scene, 4, [MemberPlan::plain(body::SMALL, vec![])]);
    for (step, clip) in scene.tight_clips().into_iter().enumerate() {
        let tick = ticks_from_secs(6.0) + step as u64 * FRAME_TICKS;
        let body = scene.clips[clip].body;
        let joints = scene.bodies[body].joints.len();
        let play = plans::play(&mut rng, &[clip]);
        let mut plan = MemberPlan::plain(body, vec![play, Play { layer: 1, ..play }]);
        plan.layers
            .push(LayerPlan { mask: Some(plans::mask(&mut rng, joints)), ..LayerPlan::default() });
        crowd.add(plan);
        // The first member changes to the new clip.
        crowd.set_plan(0, MemberPlan::plain(body::SMALL, vec![plans::play(&mut rng, &[clip])]));
        judge.frame(backend, &mut crowd, tick);
    }
    judge.done();
}

/// Checks 600 frames at 60 Hz: every member agrees with the oracle, without drift.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_long_run(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("long run");
    let clips = scene.tight_clips();
    let mut crowd = plans::crowd(&scene, 6, plans::members(72, &scene, &clips, 30, 6));
    let start = ticks_from_secs(5.0);
    for frame in 0..=600 {
        let tick = start + frame * FRAME_TICKS;
        if [0, 299, 599, 600].contains(&frame) {
            judge.frame(backend, &mut crowd, tick);
        } else {
            crowd.run(backend, tick);
        }
    }
    judge.done();
}
