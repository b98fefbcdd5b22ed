//! Checks of Evaluate: clip times and weights from the clock.

use populace_clip::ticks_from_secs;
use populace_device::layout::Float4;
use populace_device::{Backend, StageBuffer};

use super::plans;
use crate::compare::Judge;
use crate::oracle::{Timing, Weighting};
use crate::scenes::{Scene, clip};
use crate::tolerance::{LOCAL_CAP, WEIGHT_ERROR};
use crate::{MemberPlan, Play, Rng};

/// Clips that have a tight bound at any time.
const CLOCKS: [usize; 6] =
    [clip::EVEN, clip::UNEVEN, clip::SCALED, clip::STEPS, clip::LINEAR_AND_STEPS, clip::STILL];

/// Checks looping, single and held playback at several speeds, forwards and backwards, at many
/// ticks.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_clock(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("clock");
    let mut members = Vec::new();
    for clip in CLOCKS {
        for speed in [1.0, -1.0, 0.37, -2.3, 4.0, 0.0] {
            let start_tick = ticks_from_secs(0.25);
            let phase = if speed < 0.0 { 0.8 } else { 0.15 };
            let timings =
                [Timing::Loop { start_tick, phase, speed }, Timing::Once { start_tick, speed }];
            members.extend(timings.map(|timing| (clip, timing)));
        }
        members.push((clip, Timing::Held { secs: 0.6 }));
    }
    let plan = |(clip, timing): (usize, Timing)| {
        let play = Play { timing, ..Play::held(clip, 0.0) };
        MemberPlan::plain(scene.clips[clip].body, vec![play])
    };
    let mut crowd = plans::crowd(&scene, 3, members.into_iter().map(plan));
    let mut rng = Rng::new(11);
    let mut secs = 0.25;
    for _ in 0..24 {
        judge.frame(backend, &mut crowd, ticks_from_secs(secs));
        secs += rng.between(0.01, 0.7);
    }
    judge.done();
}

/// Checks constant weights, and ramps that rise, fall and are over; the weight 0 of empty slots;
/// and the poses of clips that fade into each other.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_weights(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("weights");
    let ramp = |secs_from: f64, from, to, secs| Weighting::Ramp {
        tick: ticks_from_secs(secs_from),
        from,
        to,
        secs,
    };
    let fades = [
        [ramp(0.0, 0.0, 1.0, 0.5), ramp(0.0, 1.0, 0.0, 0.5)],
        [ramp(0.1, 0.2, 0.9, 3.0), Weighting::Constant(0.5)],
        [ramp(0.0, 1.0, 0.3, 0.0), ramp(0.1, 0.4, 0.4, 1.0)],
        [Weighting::Constant(0.35), ramp(0.1, 1.0, 0.25, 7.3)],
    ];
    let plan = |weightings: [Weighting; 2]| {
        let held = [Play::held(clip::EVEN, 0.5), Play::held(clip::LINEAR_AND_STEPS, 1.2)];
        let plays =
            held.into_iter().zip(weightings).map(|(play, weighting)| Play { weighting, ..play });
        MemberPlan::plain(scene.clips[clip::EVEN].body, plays.collect())
    };
    let mut crowd = plans::crowd(&scene, 4, fades.map(plan));
    let mut secs = 0.1;
    while secs < 20.0 {
        let tick = ticks_from_secs(secs);
        judge.frame(backend, &mut crowd, tick);
        for (member, index, plan) in crowd.members() {
            let mut samples = [Float4::default(); 4];
            backend
                .read(&crowd.tables, StageBuffer::Samples, index as usize * 4, &mut samples)
                .expect("samples can be read");
            for (slot, sample) in samples.iter().enumerate() {
                let (wanted, bound) = match plan.plays.get(slot) {
                    Some(play) => (play.weighting.weight(tick), WEIGHT_ERROR),
                    None => (0.0, 0.0),
                };
                let name = || format!("member {member} slot {slot} weight at {secs} s");
                judge.number(sample.0[3], wanted, bound, LOCAL_CAP, name);
            }
        }
        secs *= 1.3;
    }
    judge.done();
}
