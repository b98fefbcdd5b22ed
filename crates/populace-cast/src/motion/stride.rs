//! Path of a foot through one cycle in place. In stance it rolls from heel to toe on ground that
//! moves at constant speed. In swing it follows published thigh and knee angles.

use super::curve::{self, Knots};
use crate::anatomy::{Body, HEEL_BACK, Limb, Side, TOE_JOINT, TOE_TIP};
use crate::surface::smooth;

/// Parameters of a gait's legs. Phases are fractions of the cycle since the foot's own strike.
/// Angles are in degrees. Lengths are in metres for an adult's foot (scale 1).
pub(super) struct Legs {
    /// Phase at which the toes leave the ground.
    pub(super) toe_off: f64,
    /// Weight of the heel strike when the hip height is fitted, relative to the rest of the stance.
    pub(super) strike_weight: f64,
    /// Phase at which the ankle passes under the hip.
    pub(super) mid_stance: f64,
    /// Pitch of the foot, positive if the toes point up.
    pub(super) foot_pitch: &'static Knots,
    /// Angle of the thigh from the vertical, positive forward.
    pub(super) thigh: &'static Knots,
    /// Flexion of the knee.
    pub(super) knee: &'static Knots,
    /// Clearance of the sole above the ground in mid-swing.
    pub(super) clearance: f64,
    /// Fraction of the ground's speed that the foot has reached when it strikes.
    pub(super) speed_match: f64,
    /// Additional height of the ankle in early swing, which the correction at both ends of the
    /// swing removes.
    pub(super) lift: f64,
}

/// Position of an ankle, and pitch of foot and toes in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Height in metres.
    pub(super) y: f64,
    /// Distance before the hip joint at rest in metres.
    pub(super) z: f64,
    pub(super) pitch: f64,
    pub(super) toe_pitch: f64,
    /// Part of `z` in metres that comes from the foot's rolling.
    pub(super) roll: f64,
}

/// The legs of one body in one gait.
pub(super) struct Stride<'a> {
    pub(super) legs: &'a Legs,
    /// Distance travelled per cycle in metres.
    pub(super) length: f64,
    /// Scale of the feet.
    foot: f64,
    /// Height of the ankle at rest in metres.
    ankle_y: f64,
    /// Length of the thigh in metres.
    upper: f64,
    /// Length of the shin in metres.
    lower: f64,
}

impl<'a> Stride<'a> {
    pub(super) fn new(body: &Body, legs: &'a Legs, length: f64) -> Self {
        let [hip, knee, ankle] =
            [Limb::Thigh, Limb::Shin, Limb::Foot].map(|limb| body.joint(limb, Side::Left));
        Self {
            legs,
            length,
            foot: body.foot,
            ankle_y: ankle.y,
            upper: (knee - hip).length(),
            lower: (ankle - knee).length(),
        }
    }

    /// Returns the pitch of the foot in radians.
    fn pitch(&self, phase: f64) -> f64 {
        curve::at(self.legs.foot_pitch, phase).to_radians()
    }

    /// Returns height and z of the ankle of a foot on the ground. The foot rotates about its heel
    /// while the toes are up, and about the toe joint while the heel is up.
    pub(super) fn planted(&self, phase: f64) -> [f64; 2] {
        let (sin, cos) = self.pitch(phase).sin_cos();
        let flat = self.length * (self.legs.mid_stance - phase);
        let [toe_y, toe_z] = TOE_JOINT.map(|v| v * self.foot);
        let heel = HEEL_BACK * self.foot;
        let (pivot_y, pivot_z) = if sin > 0.0 { (0.0, -heel) } else { (toe_y, toe_z) };
        let (y, z) = (self.ankle_y - pivot_y, -pivot_z);
        [pivot_y + z * sin + y * cos, flat + pivot_z + z * cos - y * sin]
    }

    /// Returns the offset in z of a planted foot's ankle that comes from rolling.
    fn roll(&self, phase: f64) -> f64 {
        self.planted(phase)[1] - self.length * (self.legs.mid_stance - phase)
    }

    /// Returns the roll in swing, from its value at toe-off (t = 0) to that at the strike (t = 1).
    fn roll_back(&self, t: f64) -> f64 {
        let (off, step) = (self.legs.toe_off, 1e-4);
        let scale = (1.0 - off) / step;
        let (last, first) = (self.roll(off), self.roll(0.0));
        let slopes = [(last - self.roll(off - step)) * scale, (self.roll(step) - first) * scale];
        curve::hermite(t, [last, first], slopes)
    }

    /// Returns height and z of the ankle at the published angles, for a hip at height `hip_y`.
    fn free(&self, phase: f64, hip_y: f64) -> [f64; 2] {
        let thigh = curve::at(self.legs.thigh, phase).to_radians();
        let shin = thigh - curve::at(self.legs.knee, phase).to_radians();
        [
            hip_y - self.upper * thigh.cos() - self.lower * shin.cos(),
            self.upper * thigh.sin() + self.lower * shin.sin(),
        ]
    }

    /// Returns the height of the hip above a planted foot at the published flexion of the knee.
    pub(super) fn hip_target(&self, phase: f64) -> f64 {
        let knee = curve::at(self.legs.knee, phase).to_radians();
        self.hip_height(phase, self.leg_length(knee))
    }

    /// Returns the height of the hip above a planted foot with the leg nearly straight.
    pub(super) fn hip_limit(&self, phase: f64) -> f64 {
        self.hip_height(phase, self.leg_length(0.07))
    }

    /// Returns the distance from hip to ankle at a flexion of the knee in radians.
    fn leg_length(&self, knee: f64) -> f64 {
        let (a, b) = (self.upper, self.lower);
        (a * a + b * b + 2.0 * a * b * knee.cos()).sqrt()
    }

    /// Returns the height of the hip above a planted foot at a distance `length` from the ankle.
    fn hip_height(&self, phase: f64, length: f64) -> f64 {
        let [y, z] = self.planted(phase);
        y + (length * length - z * z).max(0.0).sqrt()
    }

    /// Returns the foot's state at a phase of its own cycle, from 0 to 1. `hip_y` returns the
    /// height of the hip at a phase of the same cycle.
    pub(super) fn step(&self, phase: f64, hip_y: &dyn Fn(f64) -> f64) -> Step {
        let off = self.legs.toe_off;
        let pitch = self.pitch(phase);
        if phase <= off {
            let [y, z] = self.planted(phase);
            return Step { y, z, pitch, toe_pitch: pitch.max(0.0), roll: self.roll(phase) };
        }
        let t = (phase - off) / (1.0 - off);
        let [mut y, z] = self.swing(phase, t, hip_y);
        // The polynomial t^2 (1 - t)^4 has its maximum, 1 / 45.56, at t = 1/3.
        y += self.legs.lift * self.foot * 45.56 * t * t * (1.0 - t).powi(4);
        let toe_pitch = if pitch > 0.0 { pitch } else { pitch * smooth(0.0, 0.55, t) };
        let lift = (std::f64::consts::PI * t).sin().powi(2);
        let min_y = self.legs.clearance * self.foot * lift - self.lowest(pitch, toe_pitch);
        // Smooth maximum of `y` and `min_y`.
        let eps = 1e-6 + 0.01 * lift;
        let short = min_y - y;
        y += 0.5 * (short + (short * short + eps * eps).sqrt());
        Step { y, z, pitch, toe_pitch, roll: self.roll_back(t) }
    }

    /// Returns height and z of the ankle in swing: the path of published angles, plus a Hermite
    /// correction that matches position and velocity of the planted foot at both ends.
    fn swing(&self, phase: f64, t: f64, hip_y: &dyn Fn(f64) -> f64) -> [f64; 2] {
        let off = self.legs.toe_off;
        let step = 1e-4;
        let gap = |from: f64, phase: f64| {
            let (planted, free) = (self.planted(from), self.free(phase, hip_y(phase)));
            [0, 1].map(|axis| planted[axis] - free[axis])
        };
        let (leave, before) = (gap(off, off), gap(off - step, off - step));
        let (strike, after) = (gap(0.0, 1.0), gap(step, 1.0 + step));
        let free = self.free(phase, hip_y(phase));
        let scale = (1.0 - off) / step;
        [0, 1].map(|axis| {
            let slopes = [
                (leave[axis] - before[axis]) * scale,
                self.legs.speed_match * (after[axis] - strike[axis]) * scale,
            ];
            free[axis] + curve::hermite(t, [leave[axis], strike[axis]], slopes)
        })
    }

    /// Returns the height of the sole's lowest corner relative to the ankle, a negative number.
    fn lowest(&self, pitch: f64, toe_pitch: f64) -> f64 {
        let below = |y: f64, z: f64, pitch: f64| z * pitch.sin() + y * pitch.cos();
        let [toe_y, toe_z] = TOE_JOINT.map(|v| v * self.foot);
        let heel = below(-self.ankle_y, -HEEL_BACK * self.foot, pitch);
        let toes = below(toe_y - self.ankle_y, toe_z, pitch);
        let tip = toes + below(-toe_y, TOE_TIP * self.foot - toe_z, toe_pitch);
        heel.min(toes - toe_y).min(tip)
    }
}
