//! Random plans of members.

use populace_clip::ticks_from_secs;
use populace_device::LayerMode;
use populace_model::convert::single;

use crate::oracle::{Timing, Weighting};
use crate::scenes::Scene;
use crate::{LayerPlan, MemberPlan, Play, Rng, TestCrowd};

/// Plays a random clip of `clips`, started before 5 s.
pub(super) fn play(rng: &mut Rng, clips: &[usize]) -> Play {
    let start_tick = ticks_from_secs(rng.between(0.0, 5.0));
    let speed = single(rng.between(-1.5, 2.0));
    let timing = match rng.below(4) {
        0 => Timing::Once { start_tick, speed },
        1 => Timing::Held { secs: single(rng.between(-0.5, 2.5)) },
        _ => Timing::Loop { start_tick, phase: rng.between(0.0, 1.0), speed },
    };
    Play {
        clip: clips[rng.below(clips.len())],
        timing,
        weighting: Weighting::Constant(single(rng.between(0.05, 1.0))),
        layer: 0,
    }
}

/// Holds a clip at a time at which its rows are exact, so that the bound of even wide rotations is
/// rounding alone.
pub(super) fn held_exactly(rng: &mut Rng, scene: &Scene, clip: usize) -> Play {
    let times = &scene.clips[clip].exact_times;
    let weight = single(rng.between(0.2, 1.0));
    Play::held(clip, times[rng.below(times.len())]).with_weight(weight)
}

/// Creates a random layer for use above layer 0.
pub(super) fn layer(rng: &mut Rng, joints: usize) -> LayerPlan {
    let mode = if rng.chance(0.5) { LayerMode::Override } else { LayerMode::Additive };
    LayerPlan {
        mode,
        weight: single(rng.between(0.1, 1.0)),
        mask: rng.chance(0.6).then(|| mask(rng, joints)),
    }
}

/// Creates random weights; some are exactly 0 or 1.
pub(super) fn mask(rng: &mut Rng, joints: usize) -> Vec<f32> {
    (0..joints).map(|_| single(rng.between(-0.3, 1.3).clamp(0.0, 1.0))).collect()
}

/// Creates a random member with up to `most` slots target up to four layers.
pub(super) fn member(
    rng: &mut Rng,
    scene: &Scene,
    body: usize,
    clips: &[usize],
    most: usize,
) -> MemberPlan {
    let joints = scene.bodies[body].joints.len();
    let mut layers = vec![LayerPlan::default()];
    for _ in 0..rng.below(4) {
        layers.push(layer(rng, joints));
    }
    let plays = (0..rng.below(most + 1))
        .map(|_| {
            let target = rng.below(layers.len());
            play(rng, clips).on_layer(u32::try_from(target).expect("few layers"))
        })
        .collect();
    MemberPlan { body, plays, inertialization: Vec::new(), layers }
}

/// Creates random members, cycling through all bodies.
pub(super) fn members(
    seed: u64,
    scene: &Scene,
    clips: &[usize],
    count: usize,
    most: usize,
) -> Vec<MemberPlan> {
    let mut rng = Rng::new(seed);
    (0..count).map(|n| member(&mut rng, scene, n % scene.bodies.len(), clips, most)).collect()
}

/// Creates a crowd with the given members.
pub(super) fn crowd(
    scene: &Scene,
    slots: usize,
    plans: impl IntoIterator<Item = MemberPlan>,
) -> TestCrowd<'_> {
    let mut crowd = TestCrowd::new(scene, slots);
    for plan in plans {
        crowd.add(plan);
    }
    crowd
}
