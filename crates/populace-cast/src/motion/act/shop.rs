//! Looking: around, and into a shop window.

use glam::{DQuat, DVec3};

use super::{Timing, wave};
use crate::anatomy::Side;
use crate::motion::figure::Figure;
use crate::motion::idle::{IdleState, stance};
use crate::motion::reach::{PALM_SPOT, Reach};
use crate::motion::{Motion, curve};

/// Returns standing with looks to both sides, as before a street is crossed.
pub(super) fn look_around(figure: &Figure) -> Motion {
    let body = figure.body;
    let head: &curve::Knots = &[
        (0.03, 0.0),
        (0.11, 0.86),
        (0.21, 0.92),
        (0.30, 0.55),
        (0.36, 0.0),
        (0.44, -0.10),
        (0.53, -0.92),
        (0.66, -0.86),
        (0.76, -0.1),
        (0.88, 0.12),
    ];
    Timing("Idle_Look", 10.0, 8.0).looping(|phase| {
        let look = curve::at(head, phase);
        // Chest and weight follow the head late.
        let late = curve::at(head, phase - 0.035);
        let state = IdleState {
            left: 0.75 * (1.5 * wave(phase, 1.0, 0.12)).tanh(),
            breath: wave(phase, 3.0, 0.0),
            look: 0.35 * look,
            nod: 0.02 + 0.04 * wave(phase, 2.0, 0.3) - 0.03 * look * look,
        };
        let mut stance = stance(body, &state);
        let turn = |angle: f64| DQuat::from_rotation_y(angle);
        stance.pelvis = turn(0.05 * late) * stance.pelvis;
        stance.chest = turn(0.17 * late) * stance.chest;
        stance.head = turn(0.65 * look) * stance.head;
        stance.solve(body)
    })
}

/// Returns looking into a shop window: bent forward a little, now with a hand above the eyes.
pub(super) fn look_in(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Look_In", 9.0, 8.0).looping(|phase| {
        let shade = curve::at(&[(0.40, 0.0), (0.50, 1.0), (0.70, 1.0), (0.80, 0.0)], phase);
        let hand = curve::at(&[(0.35, 0.0), (0.45, 1.0), (0.75, 1.0), (0.86, 0.0)], phase);
        let bend = 0.75 + 0.25 * shade + 0.08 * wave(phase, 2.0, 0.1);
        let look =
            curve::at(&[(0.0, 0.3), (0.18, 0.42), (0.32, -0.2), (0.5, -0.32), (0.75, 0.2)], phase);
        let state = IdleState {
            left: 0.8 * (1.6 * wave(phase, 1.0, 0.05)).tanh(),
            breath: wave(phase, 3.0, 0.1),
            look,
            nod: 0.06,
        };
        let mut stance = stance(body, &state);
        stance.pelvis_offset += DVec3::new(0.0, -0.004, -0.028) * h * bend;
        stance.pelvis *= DQuat::from_rotation_x(0.14 * bend);
        stance.chest *= DQuat::from_rotation_x(0.34 * bend);
        stance.head *= DQuat::from_rotation_x(0.12 * bend - 0.16 * shade);
        let mut pose = stance.solve(body);
        let brow = DVec3::new(0.16 * body.head, body.chin_y + 0.66 * body.head, 0.50 * body.head);
        let reach = Reach {
            frame: figure.head(&pose),
            at: brow + DVec3::new(0.0, 0.0, 0.012) * h,
            spot: [PALM_SPOT[0] + 0.03, 0.0],
            fingers: DVec3::new(-0.95, 0.22, 0.18),
            palm: DVec3::new(-0.15, -0.85, 0.05),
            elbow: DVec3::new(0.8, -1.0, 0.35),
            curl: [0.2, 0.12, 0.14, 0.16, 0.2],
        };
        // The hand rises before the chest.
        let before = Reach {
            at: DVec3::new(0.45 * body.head, body.chin_y - 0.5 * body.head, 0.95 * body.head),
            fingers: DVec3::new(-0.6, 0.7, 0.3),
            palm: DVec3::new(-0.5, -0.3, -0.6),
            elbow: DVec3::new(0.7, -1.0, 0.0),
            ..reach
        };
        figure.reach(&mut pose, Side::Right, &before.towards(&reach, shade), hand);
        pose
    })
}
