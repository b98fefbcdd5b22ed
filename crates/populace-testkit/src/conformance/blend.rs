//! Checks of Pose: slots mixed within a layer.

use populace_clip::ticks_from_secs;
use populace_device::Backend;
use populace_model::convert::single;

use super::plans;
use crate::compare::Judge;
use crate::scenes::{Scene, body, clip};
use crate::tolerance::LOCAL_CAP;
use crate::{MemberPlan, Play, Rng};

/// A time at which all random plays have started.
const LATER_SECS: f64 = 6.125;

/// Checks mixes of one to eight clips on every body. Includes clips between rows far apart, where
/// an interpolated rotation is shorter than 1 and must not lose weight because of that.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_blends(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("blends");
    let clips = scene.tight_clips();
    let mut rng = Rng::new(31);
    let mut crowd = plans::crowd(&scene, 8, None);
    for n in 0..48 {
        let plays = (0..1 + n % 8).map(|_| plans::play(&mut rng, &clips)).collect();
        crowd.add(MemberPlan::plain((n / 8) % scene.bodies.len(), plays));
    }
    for n in 0..16 {
        let clips = [clip::LEAVES, clip::LEAVES, clip::EVEN, clip::LINEAR_AND_STEPS];
        let plays =
            clips[..2 + n % 3].iter().map(|&clip| plans::held_exactly(&mut rng, &scene, clip));
        crowd.add(MemberPlan::plain(body::SMALL, plays.collect()));
    }
    for step in 0..5 {
        judge.frame(backend, &mut crowd, ticks_from_secs(LATER_SECS + 0.31 * f64::from(step)));
    }
    judge.done();
}

/// Checks that the same slots in another order give the same pose within twice the oracle's bound.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_slot_order(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("slot order");
    let clips = scene.tight_clips();
    let mut rng = Rng::new(32);
    let mut crowd = plans::crowd(&scene, 8, None);
    for n in 0..24 {
        let mut plan = plans::member(&mut rng, &scene, 1 + n % 3, &clips, 8);
        crowd.add(plan.clone());
        plan.plays.reverse();
        crowd.add(plan);
    }
    let tick = ticks_from_secs(LATER_SECS);
    crowd.run_stages(backend, tick);
    for member in (0..48).step_by(2) {
        let (one, other) = (crowd.read(backend, member), crowd.read(backend, member + 1));
        let Some(wanted) = crowd.expected(member, tick) else {
            judge.skip(10 * one.rotations.len());
            continue;
        };
        for (joint, bound) in wanted.locals.iter().enumerate() {
            let mut pair = |got: &[f32], with: &[f32], bound: f64| {
                for (c, (got, with)) in got.iter().zip(with).enumerate() {
                    let name = || {
                        format!("member {} joint {joint} number {c} in reversed order", member + 1)
                    };
                    judge.number(*got, f64::from(*with), 2.0 * bound, 2.0 * LOCAL_CAP, name);
                }
            };
            pair(&other.rotations[joint], &one.rotations[joint], bound.rotation);
            pair(&other.translations[joint], &one.translations[joint], bound.translation);
            pair(&other.scales[joint], &one.scales[joint], bound.scale);
        }
    }
    judge.done();
}

/// Checks that slots of weight 0 or below, at any index and in any layer, leave the result equal
/// bit for bit.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_zero_weights(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("zero weights");
    let clips: Vec<usize> = (0..scene.clips.len()).collect();
    let mut rng = Rng::new(33);
    let mut crowd = plans::crowd(&scene, 8, None);
    for n in 0..24 {
        let plan = plans::member(&mut rng, &scene, 1 + n % 4, &clips, 5);
        let mut with = plan.clone();
        for weight in [0.0, -0.0, -0.5] {
            let layer = u32::try_from(rng.below(with.layers.len())).expect("few layers");
            let weightless = plans::play(&mut rng, &clips).with_weight(weight).on_layer(layer);
            with.plays.insert(rng.below(with.plays.len() + 1), weightless);
        }
        crowd.add(plan);
        crowd.add(with);
    }
    for step in 0..3 {
        crowd.run(backend, ticks_from_secs(LATER_SECS + 0.4 * f64::from(step)));
        for member in (0..48).step_by(2) {
            let without = crowd.read_palette(backend, member);
            let with = crowd.read_palette(backend, member + 1);
            judge.same_matrices(&format!("member {} palette entry", member + 1), &with, &without);
        }
    }
    judge.done();
}

/// Checks that layer 0 is divided by its total weight down to 1e-3, and that below that, or with no
/// slot, the rest pose shows.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_small_totals(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("small totals");
    let mut plans = vec![MemberPlan::plain(body::SMALL, vec![])];
    for weight in [1.0, 0.3, 0.01, 0.001_1, 0.000_9, 0.000_01, 0.0] {
        let play = Play::held(clip::EVEN, 0.4).with_weight(weight);
        plans.push(MemberPlan::plain(body::SMALL, vec![play]));
        // Two slots, each of half the weight.
        let half = single(f64::from(weight) * 0.5);
        let two = [play.with_weight(half), Play::held(clip::STILL, 0.0).with_weight(half)];
        plans.push(MemberPlan::plain(body::SMALL, two.to_vec()));
    }
    plans.push(MemberPlan::plain(
        body::SMALL,
        vec![Play::held(clip::LINEAR_AND_STEPS, 0.8).with_weight(0.01)],
    ));
    let mut crowd = plans::crowd(&scene, 2, plans);
    judge.frame(backend, &mut crowd, 0);
    judge.done();
}
