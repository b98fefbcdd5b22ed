//! Walking and running in place.
//!
//! The curves of joint angles interpolate a few knots that were set by hand to the shape of
//! published normal curves. Sources for walking: M. P. Kadaba, H. K. Ramakrishnan and M. E.
//! Wootten, "Measurement of lower extremity kinematics during level walking", J. Orthopaedic
//! Research 8 (1990), 383-392; D. A. Winter, "The Biomechanics and Motor Control of Human Gait",
//! 2nd edition (1991). Source for running: T. F. Novacheck, "The biomechanics of running", Gait and
//! Posture 7 (1998), 77-95.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3};

use super::stance::{Arm, Leg, Stance};
use super::stride::{Legs, Stride};
use super::{Motion, curve};
use crate::anatomy::{Body, Limb, PELVIS, Side};

/// Keys per cycle of walking and running.
const KEYS: usize = 48;

const WALK_LEGS: Legs = Legs {
    toe_off: 0.60,
    strike_weight: 8.0,
    mid_stance: 0.238,
    foot_pitch: &[
        (0.0, 19.0),
        (0.04, 9.0),
        (0.085, 0.0),
        (0.31, 0.0),
        (0.40, -3.0),
        (0.46, -10.0),
        (0.52, -26.0),
        (0.56, -43.0),
        (0.60, -62.0),
        (0.65, -64.0),
        (0.73, -40.0),
        (0.81, -10.0),
        (0.88, 10.0),
        (0.95, 19.0),
    ],
    thigh: &[
        (0.0, 22.0),
        (0.10, 19.0),
        (0.20, 9.0),
        (0.30, -1.0),
        (0.40, -11.0),
        (0.50, -17.0),
        (0.55, -16.0),
        (0.62, -6.0),
        (0.68, 5.0),
        (0.74, 14.0),
        (0.82, 23.0),
        (0.90, 26.0),
        (0.96, 24.0),
    ],
    knee: &[
        (0.0, 5.0),
        (0.06, 12.0),
        (0.12, 18.0),
        (0.20, 15.0),
        (0.30, 8.0),
        (0.40, 4.0),
        (0.45, 6.0),
        (0.50, 11.0),
        (0.56, 23.0),
        (0.62, 39.0),
        (0.67, 53.0),
        (0.72, 60.0),
        (0.78, 54.0),
        (0.85, 34.0),
        (0.92, 12.0),
        (0.96, 4.5),
    ],
    clearance: 0.014,
    speed_match: 0.5,
    lift: 0.07,
};

const RUN_LEGS: Legs = Legs {
    toe_off: 0.36,
    strike_weight: 0.0,
    mid_stance: 0.150,
    foot_pitch: &[
        (0.0, 9.0),
        (0.03, 4.0),
        (0.06, 0.0),
        (0.17, 0.0),
        (0.23, -10.0),
        (0.30, -32.0),
        (0.36, -56.0),
        (0.42, -76.0),
        (0.50, -88.0),
        (0.60, -75.0),
        (0.70, -42.0),
        (0.80, -12.0),
        (0.90, 8.0),
        (0.96, 12.0),
    ],
    thigh: &[
        (0.0, 27.0),
        (0.08, 23.0),
        (0.16, 12.0),
        (0.25, -5.0),
        (0.36, -21.0),
        (0.42, -20.7),
        (0.50, -11.7),
        (0.60, 9.0),
        (0.70, 29.0),
        (0.80, 39.0),
        (0.88, 38.0),
        (0.95, 31.0),
    ],
    knee: &[
        (0.0, 15.0),
        (0.06, 29.0),
        (0.14, 42.0),
        (0.20, 39.0),
        (0.28, 27.0),
        (0.36, 19.0),
        (0.41, 26.0),
        (0.48, 56.0),
        (0.56, 84.0),
        (0.63, 93.0),
        (0.70, 84.0),
        (0.80, 50.0),
        (0.90, 20.0),
        (0.96, 12.0),
    ],
    clearance: 0.05,
    speed_match: 1.0,
    lift: 0.0,
};

/// Parameters of a gait. Angles are in degrees.
struct Style {
    name: &'static str,
    legs: Legs,
    /// Speed of a body of 1.75 m at pace 1.
    speed_m_per_sec: f64,
    /// Duration of the cycle of a body of 1.75 m at pace 1.
    cycle_secs: f64,
    /// Distance between the planted feet, relative to rest.
    width: f64,
    /// Amplitude of the pelvis' sideways motion, as a fraction of the body's height.
    sway: f64,
    /// Amplitude of the pelvis' rotation about Y.
    pelvis_yaw: f64,
    /// Amplitude of the pelvis' rotation about Z.
    pelvis_drop: f64,
    /// Amplitude of the chest's rotation about Y.
    chest_yaw: f64,
    /// Mean forward lean of the chest.
    lean: f64,
    /// Amplitude of the arms' swing.
    arm_swing: f64,
    /// Mean angle of the arms, positive forward.
    arm_forward: f64,
    /// Angle of the arms away from the body.
    arm_spread: f64,
    /// Rotation of the upper arms that moves the forearms inwards.
    arm_twist: f64,
    /// Mean flexion of the elbow.
    elbow: f64,
    /// Amplitude of the elbow's flexion.
    elbow_swing: f64,
    /// Mean flexion of the fingers.
    curl: f64,
}

/// Returns the walk: 1.3 m/s for a body of 1.75 m.
pub(super) fn walk(body: &Body) -> Motion {
    let style = Style {
        name: "Walk",
        legs: WALK_LEGS,
        speed_m_per_sec: 1.3,
        cycle_secs: 1.03,
        width: 0.75,
        sway: 0.018,
        pelvis_yaw: 5.0,
        pelvis_drop: 3.5,
        chest_yaw: 4.0,
        lean: 2.5,
        arm_swing: 21.0,
        arm_forward: -3.0,
        arm_spread: 7.0,
        arm_twist: 8.0,
        elbow: 16.0,
        elbow_swing: 9.0,
        curl: 24.0,
    };
    motion(body, &style)
}

/// Returns the run: 2.9 m/s for a body of 1.75 m.
pub(super) fn run(body: &Body) -> Motion {
    let style = Style {
        name: "Run",
        legs: RUN_LEGS,
        speed_m_per_sec: 2.9,
        cycle_secs: 0.72,
        width: 0.35,
        sway: 0.008,
        pelvis_yaw: 6.0,
        pelvis_drop: 4.0,
        chest_yaw: 11.0,
        lean: 8.0,
        arm_swing: 34.0,
        arm_forward: -6.0,
        arm_spread: 13.0,
        arm_twist: 26.0,
        elbow: 88.0,
        elbow_swing: 10.0,
        curl: 48.0,
    };
    motion(body, &style)
}

fn motion(body: &Body, style: &Style) -> Motion {
    // Gaits are similar at equal Froude numbers: speed and cycle duration are proportional to the
    // square root of the leg's length.
    let root = (body.hip_y / (0.525 * 1.75)).sqrt();
    let pace = body.look.pace;
    let cycle_secs = style.cycle_secs * root / pace.sqrt();
    let speed = style.speed_m_per_sec * root * pace;
    let stride = Stride::new(body, &style.legs, speed * cycle_secs);
    let bob = Bob::fit(&stride);
    let gait = Gait { body, style, stride, bob, effort: pace.sqrt() };
    Motion::sampled(style.name, cycle_secs, KEYS, body, |phase| gait.stance(phase))
}

/// Height of the hips in metres: a mean and a sinusoid with two periods per cycle.
struct Bob {
    mean: f64,
    cos: f64,
    sin: f64,
}

impl Bob {
    fn at(&self, phase: f64) -> f64 {
        let (sin, cos) = (2.0 * TAU * phase).sin_cos();
        self.mean + self.cos * cos + self.sin * sin
    }

    /// Returns the weighted least squares fit to the hip height at the published knee angle of the
    /// planted leg, lowered until the leg reaches the ground at every phase.
    fn fit(stride: &Stride) -> Self {
        let off = stride.legs.toe_off;
        let phases = || (0..=60).map(|i| off * f64::from(i) / 60.0);
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for phase in phases() {
            // The weight is largest in mid-stance and falls to toe-off. A walker's heel strike has
            // a weight of its own, since the leg then takes over the body's weight.
            let strike = stride.legs.strike_weight * (-(phase / 0.03).powi(2)).exp();
            let weight = (std::f64::consts::PI * phase / off).sin() + 0.02 + strike;
            let (sin, cos) = (2.0 * TAU * phase).sin_cos();
            let row = DVec3::new(1.0, cos, sin);
            normal += DMat3::from_cols(row * row.x, row * row.y, row * row.z) * weight;
            right += row * stride.hip_target(phase) * weight;
        }
        let wave = normal.inverse() * right;
        let mut bob = Self { mean: wave.x, cos: wave.y, sin: wave.z };
        let excess =
            phases().map(|phase| bob.at(phase) - stride.hip_limit(phase)).fold(0.0, f64::max);
        bob.mean -= excess;
        bob
    }
}

/// A gait of one body.
struct Gait<'a> {
    body: &'a Body,
    style: &'a Style,
    stride: Stride<'a>,
    bob: Bob,
    /// Factor of the amplitudes of arms and trunk: the square root of the pace.
    effort: f64,
}

impl Gait<'_> {
    /// Returns the stance at a phase of the cycle, which begins at the strike of the left heel.
    fn stance(&self, phase: f64) -> Stance {
        let (style, body) = (self.style, self.body);
        let wave = |shift: f64| (TAU * (phase - shift)).cos();
        let deg = |degrees: f64| (degrees * self.effort).to_radians();
        let yaw = |degrees: f64| DQuat::from_rotation_y(deg(degrees));
        let sway = style.sway * body.height * wave(style.legs.toe_off * 0.5);
        let drop = deg(style.pelvis_drop) * wave(style.legs.toe_off * 0.22);
        let lean = style.lean.to_radians() * self.effort;
        let pelvis = yaw(-style.pelvis_yaw * wave(0.0))
            * DQuat::from_rotation_z(drop)
            * DQuat::from_rotation_x(0.4 * lean);
        let chest = yaw(style.chest_yaw * wave(0.02))
            * DQuat::from_rotation_z(-0.35 * drop)
            * DQuat::from_rotation_x(
                lean + body.look.stoop_rad + 0.012 * (2.0 * TAU * (phase - 0.1)).cos(),
            );
        let head = yaw(0.12 * style.chest_yaw * wave(0.02))
            * DQuat::from_rotation_x(
                0.35 * body.look.stoop_rad - 0.01 * (2.0 * TAU * (phase - 0.1)).cos(),
            );
        let hip_rest = body.joint(Limb::Thigh, Side::Left).y;
        let offset = DVec3::new(sway, self.bob.at(phase) - hip_rest, -body.joints[PELVIS].z);
        Stance {
            pelvis_offset: offset,
            pelvis,
            chest,
            head,
            shrug_rad: -0.02,
            arms: Side::BOTH.map(|side| self.arm(phase, side)),
            legs: Side::BOTH.map(|side| self.leg(phase, side)),
        }
    }

    fn arm(&self, phase: f64, side: Side) -> Arm {
        let style = self.style;
        let own = phase + 0.5 * side.index() as f64;
        // Each arm swings with the leg of the other side.
        let forward = -(TAU * (own - 0.02)).cos();
        let late = -(TAU * (own - 0.07)).cos();
        let swing = (style.arm_forward + style.arm_swing * self.effort * forward).to_radians();
        Arm {
            swing_rad: swing,
            spread_rad: (style.arm_spread + 9.0 * (self.body.look.waist - 1.0).max(0.0) * 2.0)
                .to_radians(),
            elbow_rad: (style.elbow + style.elbow_swing * self.effort * late).to_radians(),
            twist_rad: style.arm_twist.to_radians(),
            curl_rad: (style.curl + 4.0 * late).to_radians(),
        }
    }

    fn leg(&self, phase: f64, side: Side) -> Leg {
        let shift = 0.5 * side.index() as f64;
        let own = (phase + shift).rem_euclid(1.0);
        let step = self.stride.step(own, &|p| self.bob.at(p));
        let rest = self.body.joint(Limb::Foot, side);
        let yaw: f64 = 0.10;
        let swing = curve::at(&[(0.0, 0.0), (self.style.legs.toe_off, 0.0), (0.85, 1.0)], own);
        let wide = self.style.width + 0.12 * swing;
        Leg {
            // A foot that points outwards also rolls outwards.
            ankle: DVec3::new(rest.x * wide + side.sign() * yaw.sin() * step.roll, step.y, step.z),
            pitch_rad: step.pitch,
            toe_pitch_rad: step.toe_pitch,
            yaw_rad: yaw,
        }
    }
}
