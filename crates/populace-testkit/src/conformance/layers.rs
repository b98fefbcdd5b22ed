//! Checks of Pose: layers over each other.

use populace_clip::ticks_from_secs;
use populace_device::{Backend, LayerMode};
use populace_model::convert::single;

use super::plans;
use crate::compare::Judge;
use crate::scenes::{Scene, body, clip};
use crate::{LayerPlan, MemberPlan, Play, Rng};

/// Checks override layers: weights, masks, totals below and above 1, and layers without slots. The
/// settings of layer 0 are ignored.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_override_layers(backend: &mut dyn Backend) {
    check_layers("override layers", backend, 41, LayerMode::Override);
}

/// Checks additive layers: differences from each clip's first pose, scaled by weight and mask and
/// never normalised.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_additive_layers(backend: &mut dyn Backend) {
    check_layers("additive layers", backend, 42, LayerMode::Additive);
}

fn check_layers(name: &'static str, backend: &mut dyn Backend, seed: u64, mode: LayerMode) {
    let scene = Scene::new();
    let mut judge = Judge::new(name);
    let clips = scene.tight_clips();
    let mut rng = Rng::new(seed);
    let mut plans = Vec::new();
    // The first 60 play up to eight clips. The errors of their rows add up, so some joints are
    // skipped.
    for n in 0..96 {
        let body = n % scene.bodies.len();
        let joints = scene.bodies[body].joints.len();
        let mut layers: Vec<LayerPlan> =
            (0..1 + n % 4).map(|_| plans::layer(&mut rng, joints)).collect();
        layers.iter_mut().for_each(|layer| layer.mode = mode);
        if n % 5 == 0 {
            // Extreme settings; those of layer 0 are ignored.
            layers.iter_mut().for_each(|layer| layer.weight = 1.0);
            layers[0] =
                LayerPlan { mode: LayerMode::Additive, weight: 0.0, mask: Some(vec![0.0; joints]) };
        }
        let count = rng.below(if n < 60 { 9 } else { 4 });
        let plays = (0..count).map(|_| {
            let layer = u32::try_from(rng.below(layers.len())).expect("few layers");
            let weight = single([0.02, 0.3, 0.9, 1.0][rng.below(4)]);
            plans::play(&mut rng, &clips).on_layer(layer).with_weight(weight)
        });
        let plays = plays.collect();
        plans.push(MemberPlan { body, plays, inertialization: Vec::new(), layers });
    }
    let mut crowd = plans::crowd(&scene, 8, plans);
    for secs in [6.0, 6.7, 9.1] {
        judge.frame(backend, &mut crowd, ticks_from_secs(secs));
    }
    judge.done();
}

/// Checks rotations of all angles, which leave the hemisphere of the rest rotation, in additive and
/// override layers below another override layer. They magnify errors, so the caps of this check are
/// wide.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_far_rotations(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::coarse("far rotations");
    let mut rng = Rng::new(43);
    let plans = (0..60).map(|n| far(&mut rng, &scene, n));
    let mut crowd = plans::crowd(&scene, 4, plans);
    judge.frame(backend, &mut crowd, 0);
    judge.done();
}

/// Creates a member with wide rotations between a base and an override layer.
fn far(rng: &mut Rng, scene: &Scene, n: usize) -> MemberPlan {
    let (body, wide) = [(body::SMALL, clip::WIDE), (body::SCALED, clip::WIDE_UNEVEN)][n % 2];
    let mut layers = vec![LayerPlan::default(); 3];
    layers[1].mode = [LayerMode::Additive, LayerMode::Additive, LayerMode::Override][n % 3];
    layers[1].weight = [1.0, 0.6][n % 2];
    layers[2].weight = single(rng.between(0.2, 0.8));
    let clips = [clip::LEAVES, wide, clip::EVEN, wide];
    let mut plays: Vec<Play> = clips.map(|clip| plans::held_exactly(rng, scene, clip)).into();
    for (play, layer) in plays.iter_mut().zip([0, 1, 2, 1]) {
        play.layer = layer;
    }
    plays.truncate(3 + n % 3 / 2);
    MemberPlan { body, plays, inertialization: Vec::new(), layers }
}
