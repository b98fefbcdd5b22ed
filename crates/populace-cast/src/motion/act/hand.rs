//! Hands on things: a box, a bar, a door, and another person.

use glam::{DQuat, DVec3};

use super::{Timing, standing, wave};
use crate::anatomy::Side;
use crate::motion::figure::Figure;
use crate::motion::idle::{IdleState, stance};
use crate::motion::reach::{FIST, Frame, GRIP_SPOT, PALM_SPOT, Reach};
use crate::motion::stance::Stance;
use crate::motion::{Motion, curve};
use crate::places::{CARRY_WIDTH, DOOR_HANDLE_M, DOOR_HINGE_M, DOOR_OPEN_RAD, PUSH_BAR};

/// Returns carrying a box before the belly, with both hands.
pub(super) fn carry(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Carry", 5.0, 8.0).looping(|phase| {
        let state = IdleState {
            left: 0.5 * wave(phase, 1.0, 0.0),
            breath: wave(phase, 2.0, 0.0),
            look: 0.14 * wave(phase, 1.0, 0.3),
            nod: 0.05 + 0.03 * wave(phase, 1.0, 0.6),
        };
        let mut stance = stance(body, &state);
        // The trunk balances the weight.
        stance.chest *= DQuat::from_rotation_x(-0.07);
        let mut pose = stance.solve(body);
        for side in Side::BOTH {
            let lift = 0.004 * wave(phase, 2.0, 0.06) + 0.003 * wave(phase, 1.0, 0.2);
            let reach = Reach {
                frame: figure.chest(&pose),
                at: DVec3::new(
                    f64::from(CARRY_WIDTH) / 2.0 * h,
                    body.trunk_y(0.16) + lift * h,
                    figure.belly + 0.105 * h,
                ),
                spot: PALM_SPOT,
                fingers: DVec3::new(-0.28, -0.12, 0.95),
                palm: DVec3::new(-0.86, 0.42, -0.2),
                elbow: DVec3::new(0.55, -0.8, -0.75),
                curl: [0.2, 0.3, 0.32, 0.34, 0.36].map(|c| c + 0.05 * wave(phase, 1.0, 0.1)),
            };
            figure.reach(&mut pose, side, &reach, 1.0);
        }
        pose
    })
}

/// Returns pushing: both hands on a bar.
pub(super) fn push(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    let [up, ahead] = PUSH_BAR.map(f64::from);
    Timing("Push", 5.0, 8.0).looping(|phase| {
        let state = IdleState {
            left: 0.35 * wave(phase, 1.0, 0.0),
            breath: wave(phase, 2.0, 0.0),
            look: 0.12 * wave(phase, 1.0, 0.4),
            nod: 0.06 + 0.03 * wave(phase, 2.0, 0.2),
        };
        let mut stance = stance(body, &state);
        stance.chest *= DQuat::from_rotation_x(0.10);
        let mut pose = stance.solve(body);
        for side in Side::BOTH {
            let grip = 0.04 * wave(phase, 1.0, 0.2 * side.sign());
            let reach = Reach {
                frame: Frame::MODEL,
                at: DVec3::new(0.105, up, ahead) * h,
                spot: GRIP_SPOT,
                fingers: DVec3::new(-0.12, -0.05, 1.0),
                palm: DVec3::new(0.0, -1.0, -0.1),
                elbow: DVec3::new(0.55, -1.0, -0.5),
                curl: FIST.map(|curl| curl + grip),
            };
            figure.reach(&mut pose, side, &reach, 1.0);
        }
        pose
    })
}

/// Returns opening a door: the right hand pulls its handle, from standing to standing.
pub(super) fn open_door(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    let handle = |open: f64| {
        let [at, hinge] = [DOOR_HANDLE_M, DOOR_HINGE_M].map(|p| DVec3::from(p.map(f64::from)));
        let arm = DVec3::new(at.x - hinge.x, 0.0, at.z - hinge.z);
        let turned = DQuat::from_rotation_y(-open * f64::from(DOOR_OPEN_RAD)) * arm;
        DVec3::new(-(hinge.x + turned.x), at.y, hinge.z + turned.z)
    };
    let reach = |open: f64| {
        let turn = DQuat::from_rotation_y(open * f64::from(DOOR_OPEN_RAD));
        Reach {
            frame: Frame::MODEL,
            at: handle(open),
            spot: GRIP_SPOT,
            fingers: turn * DVec3::new(-0.35, 0.1, 0.9),
            palm: turn * DVec3::new(-0.85, -0.35, -0.3),
            elbow: DVec3::new(0.5, -1.0, -0.5),
            curl: FIST,
        }
    };
    let bend = figure.bend_to(&standing(body, 0.0), Side::Right, &reach(0.0), 0.93);
    let secs = 2.8;
    Timing("Open_Door", secs, 16.0).once(|at| {
        let near = curve::through(&[(0.1, 0.0), (0.7, 1.0), (1.0, 1.0), (1.7, 0.0)], at);
        let open = curve::through(&[(0.95, 0.0), (1.8, 1.0)], at);
        let weight = curve::through(&[(0.1, 0.0), (0.72, 1.0), (1.8, 1.0), (2.6, 0.0)], at);
        let back = curve::through(&[(0.8, 0.0), (1.45, 1.0), (2.0, 0.7), (2.7, 0.0)], at);
        let close = curve::through(&[(0.55, 0.0), (0.85, 1.0), (1.75, 1.0), (1.95, 0.0)], at);
        let mut stance = bent(&standing(body, at / secs), bend * near);
        stance.chest *= DQuat::from_rotation_y(0.12 * near - 0.22 * back);
        stance.pelvis_offset += DVec3::new(-0.004, -0.006, -0.016) * h * back;
        stance.head *= DQuat::from_rotation_x(0.22 * near.max(back));
        let mut pose = stance.solve(body);
        let grip = Reach { curl: FIST.map(|curl| 0.2 + (curl - 0.2) * close), ..reach(open) };
        figure.reach(&mut pose, Side::Right, &grip, weight);
        pose
    })
}

/// Returns pushing another person away with both palms, from standing to standing.
pub(super) fn push_away(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    let secs = 1.7;
    Timing("Push_Away", secs, 20.0).once(|at| {
        let weight = curve::through(&[(0.0, 0.0), (0.34, 1.0), (0.85, 1.0), (1.55, 0.0)], at);
        let thrust = curve::through(
            &[(0.0, 0.0), (0.3, -0.25), (0.38, -0.2), (0.6, 1.0), (0.78, 1.0), (1.4, 0.0)],
            at,
        );
        let mut stance = standing(body, at / secs);
        stance.pelvis_offset += DVec3::new(0.0, -0.010 * thrust.abs(), 0.028 * thrust) * h;
        stance.chest *= DQuat::from_rotation_x(0.22 * thrust);
        stance.head *= DQuat::from_rotation_x(0.04 * thrust);
        let mut pose = stance.solve(body);
        for side in Side::BOTH {
            let own = if side == Side::Left { 0.012 } else { -0.008 };
            let ahead = 0.16 + 0.17 * thrust.max(0.0) + 0.05 * thrust.min(0.0) + own;
            let reach = Reach {
                frame: figure.chest(&pose),
                at: DVec3::new(0.085 * h, body.trunk_y(0.72), figure.front + ahead * h),
                spot: PALM_SPOT,
                fingers: DVec3::new(-0.12, 1.0, 0.15),
                palm: DVec3::new(0.0, -0.15, 1.0),
                elbow: DVec3::new(0.8, -1.0, -0.3),
                curl: [0.15, 0.12, 0.14, 0.16, 0.2],
            };
            figure.reach(&mut pose, side, &reach, weight);
        }
        pose
    })
}

/// Returns a stance whose trunk bends forward from the hips.
fn bent(stance: &Stance, angle: f64) -> Stance {
    let mut bent = stance.clone();
    bent.pelvis = DQuat::from_rotation_x(0.45 * angle) * bent.pelvis;
    bent.chest = DQuat::from_rotation_x(angle) * bent.chest;
    bent
}

/// Most that a trunk bends to bring a hand nearer, in radians.
const MOST_BEND_RAD: f64 = 0.75;

impl Figure<'_> {
    /// Returns the angle in radians by which the trunk bends forward so that a hand reaches with
    /// the arm stretched to the fraction `most` of its length.
    pub(super) fn bend_to(&self, stance: &Stance, side: Side, reach: &Reach, most: f64) -> f64 {
        let excess = |angle: f64| {
            let mut pose = bent(stance, angle).solve(self.body);
            let wrist = self.reach(&mut pose, side, reach, 1.0);
            self.stretch(&pose, side, wrist) - most
        };
        let (mut low, mut high) = (0.0, MOST_BEND_RAD);
        if excess(low) <= 0.0 {
            return low;
        }
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if excess(middle) > 0.0 { low = middle } else { high = middle }
        }
        high
    }
}
