//! Ring geometry that arms and hands share, so that their borders match at the wrist.

use glam::DVec3;

use crate::anatomy::{Body, Limb, Side};

/// Points around an arm; point 2 is on the outside, 5 behind, 8 inside, 11 in front.
pub(super) const AROUND: usize = 12;

/// Half width of the blend between forearm and hand weights, as a fraction of the body's height.
pub(super) const BLEND: f64 = 0.018;

/// Returns the point at the distance `at` from the shoulder along the left arm, `back` behind its
/// axis and `outward` to its outside. All three are fractions of the body's height.
pub(super) fn on_arm(body: &Body, at: f64, back: f64, outward: f64) -> DVec3 {
    let shoulder = body.joint(Limb::UpperArm, Side::Left);
    shoulder + (body.along * at - DVec3::Z * back + body.outward * outward) * body.height
}
