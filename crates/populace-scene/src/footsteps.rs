//! Steps of people whose footsteps the file has.

use populace_locomotion::LedStep;
use populace_trajectory::Footstep;

use crate::motion::Motion;

/// Shortest and longest time of a step in seconds that people take.
const STEP_SECS: [f64; 2] = [0.2, 2.0];
/// Longest wait in seconds from one step to the next.
const JOINT_SECS: f64 = 0.01;

/// Returns the step that an agent takes at a time. A foot touches down `from_touch_down` of a step
/// before the body is over it. `None` between steps, and for steps that nobody takes.
pub(crate) fn led_step(motion: &Motion, secs: f64, from_touch_down: f32) -> Option<LedStep> {
    let steps = motion.steps();
    let now = steps.partition_point(|step| step.secs[0] <= secs).checked_sub(1)?;
    let [from, until] = steps[now].secs;
    let takes =
        |step: &Footstep| (STEP_SECS[0]..=STEP_SECS[1]).contains(&(step.secs[1] - step.secs[0]));
    if secs > until || !takes(&steps[now]) {
        return None;
    }
    let next = steps.get(now + 1).filter(|next| takes(next) && next.secs[0] - until < JOINT_SECS);
    let foothold = |step: &Footstep| foothold(motion, step, f64::from(from_touch_down));
    Some(LedStep {
        part: single((secs - from) / (until - from)).clamp(0.0, 1.0),
        secs: single(until - from),
        footholds: [foothold(&steps[now]), next.and_then(foothold)],
    })
}

/// Returns where a step ends, in metres to the left and ahead of where the body is when the foot
/// touches down.
fn foothold(motion: &Motion, step: &Footstep, from_touch_down: f64) -> Option<[f32; 2]> {
    let [from, until] = step.secs;
    let body = motion.at(until - from_touch_down * (until - from))?;
    let [x, y] = [0, 1].map(|axis: usize| step.at[1][axis] - body.position[axis]);
    let (sin, cos) = body.heading_rad.sin_cos();
    Some([y * cos - x * sin, x * cos + y * sin])
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
fn single(value: f64) -> f32 {
    value as f32
}
