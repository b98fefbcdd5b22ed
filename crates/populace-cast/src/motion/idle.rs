//! Idle motions: breathing, and shifting the weight between the legs.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::stance::{Arm, Leg, Stance};
use super::{Motion, Pose};
use crate::anatomy::{Body, Limb, Side};

/// Keys per second.
const KEYS_PER_SEC: f64 = 12.0;

/// Duration in seconds of standing still for two breaths.
const BREATHE_SECS: f64 = 7.0;

/// Returns the motion of standing still for two breaths.
pub(super) fn breathe(body: &Body) -> Motion {
    sampled("Idle", BREATHE_SECS, body, breathing)
}

/// Returns the stance at a time of standing still.
pub(super) fn at(body: &Body, secs: f64) -> Stance {
    stance(body, &breathing(secs / BREATHE_SECS))
}

/// Returns the first pose of standing still.
pub(super) fn first(body: &Body) -> Pose {
    at(body, 0.0).solve(body)
}

fn breathing(phase: f64) -> IdleState {
    let wave = |cycles: f64, shift: f64| (TAU * (cycles * phase - shift)).sin();
    IdleState {
        left: 0.12 * wave(1.0, 0.0),
        breath: wave(2.0, 0.0),
        look: 0.10 * wave(1.0, 0.3),
        nod: 0.03 * wave(2.0, 0.15),
    }
}

/// Returns the motion of standing with the weight alternating between the legs.
pub(super) fn shift(body: &Body) -> Motion {
    let secs = 9.0;
    sampled("Idle_Shift", secs, body, |phase| {
        let wave = |cycles: f64, shift: f64| (TAU * (cycles * phase - shift)).sin();
        // The tanh lengthens the rests at both sides and shortens the transitions.
        let left = (1.8 * wave(1.0, 0.0)).tanh() / 1.8_f64.tanh();
        IdleState {
            left,
            breath: wave(3.0, 0.1),
            look: -0.28 * wave(1.0, 0.08) + 0.1 * wave(2.0, 0.0),
            nod: 0.05 * wave(1.0, 0.4),
        }
    })
}

/// State of a standing person at one instant.
pub(super) struct IdleState {
    /// Weight on the left leg (1), on the right leg (-1), or on both (0).
    pub(super) left: f64,
    /// Breath, fully in (1) to fully out (-1).
    pub(super) breath: f64,
    /// Rotation of the head to the left in radians.
    pub(super) look: f64,
    /// Rotation of the head downwards in radians.
    pub(super) nod: f64,
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few dozen keys")]
fn sampled(name: &'static str, secs: f64, body: &Body, state: impl Fn(f64) -> IdleState) -> Motion {
    let keys = (secs * KEYS_PER_SEC).round() as usize;
    Motion::sampled(name, secs, keys, body, |phase| stance(body, &state(phase)))
}

/// Returns the stance of a standing person.
pub(super) fn stance(body: &Body, state: &IdleState) -> Stance {
    let h = body.height;
    let IdleState { left, breath, look, nod } = *state;
    let tilt = 0.055 * left;
    let pelvis = DQuat::from_rotation_y(0.04 * left) * DQuat::from_rotation_z(tilt);
    let chest = DQuat::from_rotation_y(-0.03 * left + 0.2 * look)
        * DQuat::from_rotation_z(-0.6 * tilt)
        * DQuat::from_rotation_x(0.02 + body.look.stoop_rad - 0.012 * breath);
    let head = DQuat::from_rotation_y(look)
        * DQuat::from_rotation_z(0.3 * tilt)
        * DQuat::from_rotation_x(0.3 * body.look.stoop_rad + nod);
    let sway = 0.020 * h * left;
    let drop = -0.006 * h - 0.004 * h * left * left;
    Stance {
        pelvis_offset: DVec3::new(sway, drop, 0.002 * h * breath),
        pelvis,
        chest,
        head,
        shrug_rad: 0.012 * breath,
        arms: Side::BOTH.map(|side| arm(body, side, state)),
        legs: Side::BOTH.map(|side| {
            let yaw: f64 = 0.16;
            let rest = body.joint(Limb::Foot, side);
            let apart = if side == Side::Left { 1.15 } else { 1.3 };
            Leg {
                ankle: DVec3::new(apart * rest.x, rest.y, rest.z + 0.01 * h * side.sign()),
                pitch_rad: 0.0,
                toe_pitch_rad: 0.0,
                yaw_rad: yaw,
            }
        }),
    }
}

fn arm(body: &Body, side: Side, state: &IdleState) -> Arm {
    let own = state.left * side.sign();
    // A wide waist spreads the arms.
    let clearance = 0.3 * (body.look.waist - 1.0).max(0.0);
    Arm {
        swing_rad: 0.03 + 0.02 * state.breath + 0.03 * own,
        spread_rad: 0.12 + clearance + 0.015 * state.breath - 0.03 * own,
        elbow_rad: 0.26 + 0.03 * state.breath + 0.05 * own,
        twist_rad: 0.1,
        curl_rad: 0.38 + 0.08 * state.breath + 0.07 * own,
    }
}
