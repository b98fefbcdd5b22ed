//! Gestures: waving, clapping, cheering and pointing.

use glam::{DQuat, DVec3};

use super::{Timing, standing, wave};
use crate::Rig;
use crate::anatomy::{Limb, Side};
use crate::motion::figure::Figure;
use crate::motion::idle::{IdleState, stance};
use crate::motion::reach::{Frame, PALM_SPOT, Reach, TIP_SPOT};
use crate::motion::{Motion, curve};

/// Returns waving with the right hand.
pub(super) fn wave_hand(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Wave", 2.4, 15.0).looping(|phase| {
        let swing = wave(phase, 4.0, 0.0) * (0.85 + 0.15 * wave(phase, 1.0, 0.1));
        let late = wave(phase, 4.0, 0.11);
        let state = IdleState {
            left: 0.25 + 0.1 * wave(phase, 1.0, 0.0),
            breath: wave(phase, 1.0, 0.2),
            look: 0.04 * wave(phase, 1.0, 0.4),
            nod: -0.05 + 0.02 * wave(phase, 2.0, 0.0),
        };
        let mut stance = stance(body, &state);
        stance.chest *= DQuat::from_rotation_z(-0.05 + 0.015 * swing);
        let mut pose = stance.solve(body);
        let reach = Reach {
            frame: figure.chest(&pose),
            at: DVec3::new(
                body.joint(Limb::UpperArm, Side::Left).x + (0.105 + 0.048 * swing) * h,
                body.trunk_y(1.0) + (0.095 - 0.010 * swing * swing) * h,
                0.09 * h,
            ),
            spot: PALM_SPOT,
            fingers: DVec3::new(0.12 + 0.42 * late, 1.0, 0.05),
            palm: DVec3::new(-0.15, -0.05, 1.0),
            elbow: DVec3::new(0.75, -1.0, -0.1),
            curl: [0.1, 0.12, 0.14, 0.16, 0.2].map(|curl| curl + 0.06 * late),
        };
        figure.reach(&mut pose, Side::Right, &reach, 1.0);
        pose
    })
}

/// Distance between the palms before each clap, relative to the widest.
const CLAPS: [f64; 8] = [1.0, 0.82, 0.93, 0.76, 0.9, 1.0, 0.8, 0.88];

/// Returns clapping: eight claps, of which the right hand does most.
pub(super) fn clap(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    // Six keys for each clap, one of them at the contact.
    Timing("Clap", 2.4, 20.0).looping(|phase| {
        let count = CLAPS.len() as f64;
        let clap = phase * count;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 8")]
        let width = CLAPS[(clap.floor() as usize).min(CLAPS.len() - 1)];
        let open = 0.5 - 0.5 * (std::f64::consts::TAU * clap).cos();
        let apart = 0.085 * h * width * open.powf(0.8);
        let state = IdleState {
            left: 0.15 * wave(phase, 1.0, 0.0),
            breath: 0.5 * wave(phase, 1.0, 0.3),
            look: 0.06 * wave(phase, 1.0, 0.1),
            nod: -0.02 + 0.02 * wave(phase, 8.0, 0.2),
        };
        let mut pose = stance(body, &state).solve(body);
        let meet = DVec3::new(
            -0.006 * h,
            body.trunk_y(0.63) + 0.006 * h * wave(phase, 1.0, 0.2),
            figure.front + 0.125 * h,
        );
        // From the right palm to the left one. The right hand claps from above.
        let axis = DVec3::new(0.92, -0.39, 0.0);
        for (side, share) in [(Side::Left, 0.35), (Side::Right, 0.65)] {
            let away = axis * side.sign();
            let tilt = if side == Side::Left { 0.42 } else { 0.30 };
            let reach = Reach {
                frame: figure.chest(&pose),
                at: side.mirror_point(meet + away * apart * share),
                spot: PALM_SPOT,
                fingers: side.mirror_point(DVec3::new(away.x * 0.35 * open, tilt, 0.9)),
                palm: side.mirror_point(-away),
                elbow: DVec3::new(0.75, -1.0, -0.3),
                curl: [0.12, 0.12, 0.14, 0.16, 0.18].map(|curl| curl + 0.08 * open),
            };
            figure.reach(&mut pose, side, &reach, 1.0);
        }
        pose
    })
}

/// Returns cheering: both fists up, with bounces from the knees.
pub(super) fn cheer(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Cheer", 2.2, 18.0).looping(|phase| {
        let bounce = 0.5 - 0.5 * (std::f64::consts::TAU * (4.0 * phase)).cos();
        let state = IdleState {
            left: 0.3 * wave(phase, 2.0, 0.1),
            breath: wave(phase, 1.0, 0.0),
            look: 0.12 * wave(phase, 1.0, 0.2),
            nod: -0.14 + 0.05 * bounce,
        };
        let mut stance = stance(body, &state);
        stance.pelvis_offset.y -= 0.022 * h * bounce;
        stance.chest *= DQuat::from_rotation_x(-0.05 + 0.05 * bounce);
        let mut pose = stance.solve(body);
        for side in Side::BOTH {
            let (late, high) = if side == Side::Left { (0.18, -0.02) } else { (0.06, 0.015) };
            let pump = wave(phase, 4.0, late) * (0.8 + 0.2 * wave(phase, 1.0, late));
            let turn = wave(phase, 2.0, 2.0 * late);
            let reach = Reach {
                frame: figure.chest(&pose),
                at: DVec3::new(
                    body.joint(Limb::UpperArm, Side::Left).x + (0.055 + 0.012 * turn) * h,
                    body.trunk_y(1.0) + (0.195 + high + 0.032 * pump) * h,
                    (0.035 - 0.02 * pump) * h,
                ),
                spot: PALM_SPOT,
                fingers: DVec3::new(0.12 - 0.08 * turn, 1.0, -0.02 + 0.12 * pump),
                palm: DVec3::new(-0.97, 0.0, -0.08),
                elbow: DVec3::new(1.0, -0.35, 0.45),
                curl: [0.6, 1.05, 1.08, 1.1, 1.12].map(|curl| curl + 0.1 * pump),
            };
            figure.reach(&mut pose, side, &reach, 1.0);
        }
        pose
    })
}

/// Returns pointing ahead with the right hand, in seconds from standing to standing.
pub(super) fn point(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    let secs = 2.6;
    Timing("Point", secs, 16.0).once(|at| {
        let weight = curve::through(&[(0.05, 0.0), (0.6, 1.0), (1.75, 1.0), (2.5, 0.0)], at);
        let look = curve::through(&[(0.0, 0.0), (0.35, 1.0), (1.9, 1.0), (2.5, 0.0)], at);
        // The hand overshoots, and stresses what it points at.
        let stress = curve::through(
            &[(0.5, 0.0), (0.72, 1.0), (0.9, -0.3), (1.2, 0.6), (1.45, 0.0), (2.0, 0.0)],
            at,
        );
        let mut stance = standing(body, at / secs);
        stance.chest *= DQuat::from_rotation_y(0.16 * look);
        stance.head *= DQuat::from_rotation_y(-0.12 * look) * DQuat::from_rotation_x(-0.04 * look);
        let mut pose = stance.solve(body);
        let shoulder = body.joint(Limb::UpperArm, Side::Left);
        let lean = body.look.rig == Rig::Lean;
        // One joint of the lean rig bends all fingers.
        let others = if lean { 0.15 } else { 1.15 };
        let reach = Reach {
            frame: Frame { turn: glam::DQuat::IDENTITY, ..figure.chest(&pose) },
            at: DVec3::new(shoulder.x + 0.035 * h, shoulder.y, 0.0)
                + DVec3::new(0.0, (0.03 + 0.018 * stress) * h, (0.385 + 0.006 * stress) * h),
            spot: TIP_SPOT,
            fingers: DVec3::new(0.0, 0.05 + 0.1 * stress, 1.0),
            palm: DVec3::new(-0.75, -0.65, 0.0),
            elbow: DVec3::new(0.5, -1.0, 0.0),
            curl: [0.55, 0.06, others, others, others].map(|c| c + 0.06 * stress),
        };
        figure.reach(&mut pose, Side::Right, &reach, weight);
        pose
    })
}
