//! Pose: layers laid over each other.

use populace_core::{Backend, LayerMode, ticks_from_secs};

use super::plans;
use crate::compare::Judge;
use crate::scenes::Scene;
use crate::{LayerPlan, MemberPlan, Rng, single};

/// Override layers: weights, masks, totals below and above 1, layers without slots; what layer 0 says of itself is not
/// looked at.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_override_layers(backend: &mut dyn Backend) {
    check_layers("override layers", backend, 41, LayerMode::Override);
}

/// Additive layers: differences from each clip's first pose, by weight and mask, never normalised.
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
    for n in 0..60 {
        let body = n % scene.bodies.len();
        let joints = scene.bodies[body].joints.len();
        let mut layers: Vec<LayerPlan> = (0..1 + n % 4).map(|_| plans::layer(&mut rng, joints)).collect();
        layers.iter_mut().for_each(|layer| layer.mode = mode);
        if n % 5 == 0 {
            // At the ends of their ranges; layer 0's are not looked at.
            layers.iter_mut().for_each(|layer| layer.weight = 1.0);
            layers[0] = LayerPlan { mode: LayerMode::Additive, weight: 0.0, mask: Some(vec![0.0; joints]) };
        }
        let count = rng.below(9);
        let plays = (0..count).map(|_| {
            let layer = u32::try_from(rng.below(layers.len())).expect("few layers");
            let weight = single([0.02, 0.3, 0.9, 1.0][rng.below(4)]);
            plans::play(&mut rng, &clips).on_layer(layer).weighing(weight)
        });
        let plays = plays.collect();
        plans.push(MemberPlan { body, plays, layers });
    }
    let mut crowd = plans::crowd(&scene, 8, plans);
    for secs in [6.0, 6.7, 9.1] {
        judge.frame(backend, &mut crowd, ticks_from_secs(secs));
    }
    judge.done();
}
