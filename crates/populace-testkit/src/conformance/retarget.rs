//! Checks of retargeted clips.

use populace_device::{Backend, LayerMode};
use populace_model::convert::single;

use super::plans;
use super::sampling::{compare_probes, promised_m};
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

/// Checks points around every joint for every clip on every other body, at times between keys. They
/// may deviate by half of what is promised for a clip; with rows at key times alone they deviate by
/// more.
///
/// # Panics
///
/// If the backend is wrong, or a conversion deviates too far.
pub fn check_retarget_between_keys(backend: &mut dyn Backend) {
    let scene = Scene::of_humanoids();
    let mut judge = Judge::new("retargeted clips between keys");
    let mut rng = Rng::new(52);
    let mut crowd = plans::crowd(&scene, 1, None);
    for body in 0..scene.bodies.len() {
        for (index, of) in scene.clips.iter().enumerate().filter(|(_, clip)| clip.body != body) {
            let (start, duration) = (of.clip.start_secs(), of.clip.duration_secs());
            for _ in 0..12 {
                let time = start + single(rng.between(0.0, 1.0)) * duration;
                crowd.add(MemberPlan::plain(body, vec![Play::held(index, time)]));
            }
        }
    }
    crowd.run_stages(backend, 0);
    for (member, _, plan) in crowd.members() {
        let of = &scene.clips[plan.plays[0].clip];
        let tolerance_m = 0.5 * promised_m(&scene, plan.body);
        let got = crowd.read(backend, member);
        let wanted = crowd.expected_within(member, 0, of.at_keys);
        compare_probes(&mut judge, &crowd, member, |_| tolerance_m, &got, &wanted);
    }
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
