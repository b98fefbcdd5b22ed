//! Checks of retargeted clips.

use populace_device::{Backend, LayerMode};

use super::plans;
use crate::compare::Judge;
use crate::scenes::Scene;
use crate::{LayerPlan, MemberPlan, Play, Rng};

/// Checks every clip on every other body at key times: alone, mixed with the body's own clip, and
/// in an additive layer above it.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_retarget(backend: &mut dyn Backend) {
    let scene = Scene::of_humanoids();
    let mut judge = Judge::coarse("retargeted clips");
    let mut rng = Rng::new(51);
    let mut crowd = plans::crowd(&scene, 2, plans(&mut rng, &scene));
    judge.frame(backend, &mut crowd, 0);
    judge.done();
}

/// Creates members of all bodies, each with a clip of another body.
pub(super) fn plans(rng: &mut Rng, scene: &Scene) -> Vec<MemberPlan> {
    let mut plans = Vec::new();
    for body in 0..scene.bodies.len() {
        for clip in (0..scene.clips.len()).filter(|&clip| scene.clips[clip].body != body) {
            let own =
                scene.clips.iter().position(|c| c.body == body).expect("each body has a clip");
            for n in 0..4 {
                let other = plans::held_exactly(rng, scene, clip);
                let mut layers = vec![LayerPlan::default()];
                let plays: Vec<Play> = match n {
                    0 | 1 => vec![other],
                    2 => vec![other, plans::held_exactly(rng, scene, own)],
                    _ => {
                        layers
                            .push(LayerPlan { mode: LayerMode::Additive, ..LayerPlan::default() });
                        vec![plans::held_exactly(rng, scene, own), other.on_layer(1)]
                    }
                };
                plans.push(MemberPlan { body, plays, inertialization: Vec::new(), layers });
            }
        }
    }
    plans
}
