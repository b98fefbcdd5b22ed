//! Talking with the hands, and listening.

use glam::{DQuat, DVec3};

use super::{Timing, wave};
use crate::anatomy::{Body, Side};
use crate::motion::curve;
use crate::motion::figure::Figure;
use crate::motion::idle::{IdleState, stance};
use crate::motion::reach::{PALM_SPOT, Reach};
use crate::motion::{Motion, Pose};

/// Weights of the gestures of the left and of the right hand over the loop.
const GESTURES: [&curve::Knots; 2] = [
    &[(0.0, 0.0), (0.30, 0.0), (0.37, 0.95), (0.47, 0.85), (0.56, 1.0), (0.66, 0.0), (0.9, 0.0)],
    &[(0.02, 0.0), (0.09, 1.0), (0.24, 0.9), (0.42, 1.0), (0.49, 0.3), (0.72, 0.35), (0.78, 1.0)],
];

/// Returns talking: one hand gestures, then both.
pub(super) fn talk(figure: &Figure) -> Motion {
    let body = figure.body;
    Timing("Talk", 8.0, 12.0).looping(|phase| {
        let state = IdleState {
            left: 0.5 * wave(phase, 1.0, 0.1),
            breath: wave(phase, 3.0, 0.0),
            look: 0.16 * wave(phase, 1.0, 0.3) + 0.07 * wave(phase, 3.0, 0.2),
            nod: 0.03 + 0.05 * wave(phase, 5.0, 0.1) * (0.6 + 0.4 * wave(phase, 2.0, 0.4)),
        };
        let mut stance = stance(body, &state);
        stance.head *= DQuat::from_rotation_z(0.06 * wave(phase, 2.0, 0.15));
        stance.chest *= DQuat::from_rotation_y(0.05 * wave(phase, 2.0, 0.0));
        let mut pose = stance.solve(body);
        for side in Side::BOTH {
            let weight = curve::at(GESTURES[side.index()], phase);
            let reach = gesture(figure, &pose, side, phase);
            figure.reach(&mut pose, side, &reach, weight);
        }
        pose
    })
}

/// Returns where a gesturing hand is: before the chest, with beats.
fn gesture(figure: &Figure, pose: &Pose, side: Side, phase: f64) -> Reach {
    let body = figure.body;
    let h = body.height;
    let late = 0.13 * side.index() as f64;
    let beat = wave(phase, 9.0, late) * (0.55 + 0.45 * wave(phase, 2.0, 0.3 + late));
    let open = 0.5 + 0.5 * wave(phase, 2.0, 0.1 + late);
    let at = DVec3::new(
        (0.075 + 0.055 * open) * h,
        body.trunk_y(0.42) + (0.022 * beat + 0.02 * wave(phase, 1.0, late)) * h,
        figure.belly + (0.12 + 0.02 * wave(phase, 3.0, late)) * h,
    );
    Reach {
        frame: figure.chest(pose),
        at,
        spot: PALM_SPOT,
        fingers: DVec3::new(-0.35 + 0.35 * open, 0.25 + 0.25 * beat, 0.9),
        palm: DVec3::new(-0.85 + 0.45 * open, 0.55 + 0.25 * open, 0.05),
        elbow: DVec3::new(0.45, -1.0, -0.35),
        curl: [0.25, 0.25, 0.32, 0.38, 0.45].map(|curl| curl + 0.1 * (1.0 - open)),
    }
}

/// Returns listening: hands joined before the belly, nods, and a shift of the weight.
pub(super) fn listen(figure: &Figure) -> Motion {
    let body = figure.body;
    let nods: &curve::Knots = &[
        (0.0, 0.0),
        (0.16, 0.0),
        (0.195, 0.16),
        (0.23, 0.02),
        (0.265, 0.12),
        (0.31, 0.0),
        (0.62, 0.0),
        (0.66, 0.13),
        (0.70, 0.0),
        (0.9, 0.0),
    ];
    Timing("Talk_Listen", 8.0, 8.0).looping(|phase| {
        let state = IdleState {
            left: (1.6 * wave(phase, 1.0, 0.35)).tanh() * 0.85,
            breath: wave(phase, 2.0, 0.1),
            look: 0.09 * wave(phase, 1.0, 0.55) + 0.04 * wave(phase, 2.0, 0.1),
            nod: curve::at(nods, phase),
        };
        let mut stance = stance(body, &state);
        let tilt = 0.09 * (0.5 + 0.5 * wave(phase, 1.0, 0.2));
        stance.head *= DQuat::from_rotation_z(tilt);
        let mut pose = stance.solve(body);
        joined_hands(figure, &mut pose, body, 0.004 * wave(phase, 2.0, 0.1));
        pose
    })
}

/// Lays the left hand over the right one before the belly.
fn joined_hands(figure: &Figure, pose: &mut Pose, body: &Body, rise: f64) {
    let h = body.height;
    for side in [Side::Right, Side::Left] {
        let over = if side == Side::Left { 0.016 } else { 0.0 };
        let reach = Reach {
            frame: figure.chest(pose),
            at: DVec3::new(
                0.004 * h,
                body.trunk_y(0.1) + (rise - 0.01) * h,
                figure.belly + (0.022 + over) * h,
            ),
            spot: [0.062, 0.010],
            fingers: DVec3::new(-0.82, -0.5, 0.12),
            palm: DVec3::new(-0.1, 0.0, -1.0),
            elbow: DVec3::new(1.0, -0.5, -0.6),
            curl: [0.3, 0.35, 0.35, 0.4, 0.4].map(|curl| curl + 20.0 * rise),
        };
        figure.reach(pose, side, &reach, 1.0);
    }
}
