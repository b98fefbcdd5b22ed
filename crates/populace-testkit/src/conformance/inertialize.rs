//! Checks of inertialization.

use populace_clip::ticks_from_secs;
use populace_device::{Backend, LayerMode};
use populace_model::convert::single;

use super::plans;
use crate::compare::Judge;
use crate::scenes::Scene;
use crate::{Inertialization, MemberPlan, Play, Rng};

/// The clock when the last transitions start.
const START_SECS: f64 = 6.0;

/// Checks transitions in layers of all kinds, single ones and several that interrupt each other: at
/// the start, in the middle, and when some and all of them are over. Inertialization magnifies
/// sampling errors, so the caps of this check are wide.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_inertialization(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::coarse("inertialization");
    let clips = scene.tight_clips();
    let tick = ticks_from_secs(START_SECS);
    let mut crowd = plans::crowd(&scene, 8, plans(&mut Rng::new(44), &scene, &clips, tick));
    for secs in [0.0, 0.05, 0.21, 0.4, 1.0] {
        judge.frame(backend, &mut crowd, tick + ticks_from_secs(secs));
    }
    judge.done();
}

/// Creates members of all bodies with transitions that started at or before `tick`.
pub(super) fn plans(rng: &mut Rng, scene: &Scene, clips: &[usize], tick: u64) -> Vec<MemberPlan> {
    (0..60).map(|n| plan(rng, scene, clips, (n, tick))).collect()
}

fn plan(rng: &mut Rng, scene: &Scene, clips: &[usize], (n, tick): (usize, u64)) -> MemberPlan {
    let body = n % scene.bodies.len();
    let mut plan = plans::member(rng, scene, body, clips, 3);
    let starts = 1 + n as u64 % 2;
    for nth in 0..4 {
        let layer = u32::try_from(rng.below(plan.layers.len())).expect("few layers");
        let [outgoing, incoming] = [(); 2].map(|()| Play { layer, ..plans::play(rng, clips) });
        plan.inertialization.push(Inertialization {
            outgoing,
            incoming,
            tick: tick - ticks_from_secs(0.1) * (nth % (1 + starts)),
            ticks: ticks_from_secs(rng.between(0.1, 0.8)),
            share: single(rng.between(0.1, 0.6)),
            share_per_sec: single(rng.between(-0.5, 0.5)),
        });
    }
    plan.inertialization.truncate(1 + n % 4);
    if n % 3 == 0 {
        plan.layers.iter_mut().for_each(|layer| layer.mode = LayerMode::Additive);
    }
    plan
}
