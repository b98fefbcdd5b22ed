//! A foot's way through one cycle in place: rolling from heel to toe over ground that passes at an
//! even speed, then swinging as published thigh and knee angles would have it.

use super::curve::{self, Knots};
use crate::anatomy::{Body, HEEL_BACK, Limb, Side, TOE_JOINT, TOE_TIP};
use crate::surface::smooth;

/// What a gait's legs do; phases are parts of the cycle since the foot's own strike, angles are
/// degrees.
pub(super) struct Legs {
    /// When the toes leave the ground.
    pub(super) off: f64,
    /// How much the hips' height is set by the heel's strike rather than by the whole stance.
    pub(super) strike: f64,
    /// When the ankle passes under the hip.
    pub(super) under: f64,
    /// Toes up, over the ground.
    pub(super) foot_pitch: &'static Knots,
    /// Forward from the vertical.
    pub(super) thigh: &'static Knots,
    /// Flexion.
    pub(super) knee: &'static Knots,
    /// Metres that the sole clears the ground by in mid-swing, for an adult.
    pub(super) clearance: f64,
    /// How much of the ground's speed the foot has taken on before it strikes.
    pub(super) settle: f64,
    /// Metres that early swing lifts an adult's ankle by, which the pull to the ground at both ends
    /// took away.
    pub(super) lift: f64,
}

/// Where an ankle is: height and place before the hip joint at rest, with the pitch of foot and
/// toes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) y: f64,
    pub(super) z: f64,
    pub(super) pitch: f64,
    pub(super) toe_pitch: f64,
    /// How far rolling has carried the ankle along the foot, of what is in `z`.
    pub(super) roll: f64,
}

/// The legs of one body at one gait.
pub(super) struct Stride<'a> {
    pub(super) legs: &'a Legs,
    /// Metres of ground per cycle.
    pub(super) length: f64,
    foot: f64,
    ankle_y: f64,
    upper: f64,
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

    /// The foot's pitch in radians.
    fn pitch(&self, phase: f64) -> f64 {
        curve::at(self.legs.foot_pitch, phase).to_radians()
    }

    /// On the ground: height and place of the ankle. The foot turns about its heel while its toes
    /// are up, about the joint of its toes while its heel is.
    pub(super) fn planted(&self, phase: f64) -> [f64; 2] {
        let (sin, cos) = self.pitch(phase).sin_cos();
        let flat = self.length * (self.legs.under - phase);
        let [toe_y, toe_z] = TOE_JOINT.map(|v| v * self.foot);
        let heel = HEEL_BACK * self.foot;
        let (pivot_y, pivot_z) = if sin > 0.0 { (0.0, -heel) } else { (toe_y, toe_z) };
        let (y, z) = (self.ankle_y - pivot_y, -pivot_z);
        [pivot_y + z * sin + y * cos, flat + pivot_z + z * cos - y * sin]
    }

    fn roll(&self, phase: f64) -> f64 {
        self.planted(phase)[1] - self.length * (self.legs.under - phase)
    }

    /// From the roll at the end of a stance to that at its beginning.
    fn roll_back(&self, t: f64) -> f64 {
        let (off, step) = (self.legs.off, 1e-4);
        let scale = (1.0 - off) / step;
        let (last, first) = (self.roll(off), self.roll(0.0));
        let slopes = [(last - self.roll(off - step)) * scale, (self.roll(step) - first) * scale];
        curve::hermite(t, [last, first], slopes)
    }

    /// Where published angles put the ankle under a hip at this height.
    fn free(&self, phase: f64, hip_y: f64) -> [f64; 2] {
        let thigh = curve::at(self.legs.thigh, phase).to_radians();
        let shin = thigh - curve::at(self.legs.knee, phase).to_radians();
        [
            hip_y - self.upper * thigh.cos() - self.lower * shin.cos(),
            self.upper * thigh.sin() + self.lower * shin.sin(),
        ]
    }

    /// The hip's height over a planted foot if the knee is bent as published.
    pub(super) fn hip_over(&self, phase: f64) -> f64 {
        let knee = curve::at(self.legs.knee, phase).to_radians();
        self.over(phase, self.reach(knee))
    }

    /// The hip's height over a planted foot with the leg nearly straight.
    pub(super) fn hip_limit(&self, phase: f64) -> f64 {
        self.over(phase, self.reach(0.07))
    }

    fn reach(&self, knee: f64) -> f64 {
        let (a, b) = (self.upper, self.lower);
        (a * a + b * b + 2.0 * a * b * knee.cos()).sqrt()
    }

    fn over(&self, phase: f64, reach: f64) -> f64 {
        let [y, z] = self.planted(phase);
        y + (reach * reach - z * z).max(0.0).sqrt()
    }

    /// The foot at a phase of its own cycle, from 0 to 1; `hip_y` tells the hip's height at any
    /// phase of it.
    pub(super) fn step(&self, phase: f64, hip_y: &dyn Fn(f64) -> f64) -> Step {
        let off = self.legs.off;
        let pitch = self.pitch(phase);
        if phase <= off {
            let [y, z] = self.planted(phase);
            return Step { y, z, pitch, toe_pitch: pitch.max(0.0), roll: self.roll(phase) };
        }
        let t = (phase - off) / (1.0 - off);
        let [mut y, z] = self.swing(phase, t, hip_y);
        // Highest, at 1, after a third of the swing.
        y += self.legs.lift * self.foot * 45.56 * t * t * (1.0 - t).powi(4);
        let toe_pitch = if pitch > 0.0 { pitch } else { pitch * smooth(0.0, 0.55, t) };
        let lift = (std::f64::consts::PI * t).sin().powi(2);
        let need = self.legs.clearance * self.foot * lift - self.lowest(pitch, toe_pitch);
        let eps = 1e-6 + 0.01 * lift;
        let short = need - y;
        y += 0.5 * (short + (short * short + eps * eps).sqrt());
        Step { y, z, pitch, toe_pitch, roll: self.roll_back(t) }
    }

    /// The swing of published angles, pulled at both ends to where the planted foot is, in place
    /// and in speed.
    fn swing(&self, phase: f64, t: f64, hip_y: &dyn Fn(f64) -> f64) -> [f64; 2] {
        let off = self.legs.off;
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
                self.legs.settle * (after[axis] - strike[axis]) * scale,
            ];
            free[axis] + curve::hermite(t, [leave[axis], strike[axis]], slopes)
        })
    }

    /// How far the sole's lowest corner is above the ankle (so: below 0).
    fn lowest(&self, pitch: f64, toe_pitch: f64) -> f64 {
        let below = |y: f64, z: f64, pitch: f64| z * pitch.sin() + y * pitch.cos();
        let [toe_y, toe_z] = TOE_JOINT.map(|v| v * self.foot);
        let heel = below(-self.ankle_y, -HEEL_BACK * self.foot, pitch);
        let toes = below(toe_y - self.ankle_y, toe_z, pitch);
        let tip = toes + below(-toe_y, TOE_TIP * self.foot - toe_z, toe_pitch);
        heel.min(toes - toe_y).min(tip)
    }
}
