//! Telephones: a call at the ear, and a text in the hand.

use glam::{DQuat, DVec3};

use super::{Timing, wave};
use crate::anatomy::Side;
use crate::motion::figure::Figure;
use crate::motion::idle::{IdleState, stance};
use crate::motion::reach::{PALM_SPOT, Reach};
use crate::motion::{Motion, curve};

/// Returns a call: the right hand at the ear.
pub(super) fn call(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Phone", 8.0, 8.0).looping(|phase| {
        let state = IdleState {
            left: 0.7 * (1.4 * wave(phase, 1.0, 0.0)).tanh(),
            breath: wave(phase, 2.0, 0.0),
            look: 0.17 * wave(phase, 1.0, 0.2) + 0.06 * wave(phase, 3.0, 0.0),
            nod: 0.06 + 0.03 * wave(phase, 4.0, 0.2),
        };
        let mut stance = stance(body, &state);
        stance.head *= DQuat::from_rotation_z(0.07 + 0.02 * wave(phase, 2.0, 0.3));
        let left = &mut stance.arms[Side::Left.index()];
        let talks = curve::at(&[(0.1, 0.0), (0.25, 1.0), (0.45, 0.8), (0.6, 0.0)], phase);
        left.elbow_rad += 0.55 * talks + 0.1 * talks * wave(phase, 8.0, 0.0);
        left.twist_rad += 0.35 * talks;
        let mut pose = stance.solve(body);
        // The elbow stays before the chest when the head turns.
        let (head, chest) = (figure.head(&pose).turn, figure.chest(&pose).turn);
        let down =
            head.inverse() * chest * DVec3::new(-0.5, -1.0, 0.75 + 0.08 * wave(phase, 2.0, 0.1));
        let down = Side::Right.mirror_point(down);
        let ear = DVec3::new(0.37 * body.head, body.chin_y + 0.40 * body.head, 0.03 * body.head);
        let reach = Reach {
            frame: figure.head(&pose),
            at: ear + DVec3::new(0.003 + 0.012 * body.look.limbs, -0.016, 0.008) * h,
            spot: [PALM_SPOT[0] + 0.006, 0.016],
            fingers: DVec3::new(-0.26, 0.88, -0.40),
            palm: DVec3::new(-1.0, -0.22, 0.20),
            elbow: down,
            curl: [0.35, 0.42, 0.45, 0.5, 0.55].map(|c| c + 0.08 * wave(phase, 3.0, 0.0)),
        };
        figure.reach(&mut pose, Side::Right, &reach, 1.0);
        pose
    })
}

/// Returns a text: a look at the phone in the right hand.
pub(super) fn text(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Text", 7.0, 8.0).looping(|phase| {
        let glance = curve::at(&[(0.6, 0.0), (0.66, 1.0), (0.78, 1.0), (0.84, 0.0)], phase);
        let state = IdleState {
            left: 0.5 * wave(phase, 1.0, 0.6),
            breath: wave(phase, 2.0, 0.0),
            look: -0.06 + 0.25 * glance,
            nod: 0.46 - 0.36 * glance + 0.02 * wave(phase, 2.0, 0.0),
        };
        let mut pose = stance(body, &state).solve(body);
        let reach = Reach {
            frame: figure.chest(&pose),
            at: DVec3::new(
                0.035 * h,
                body.trunk_y(0.50) - (0.012 * glance - 0.003 * wave(phase, 3.0, 0.2)) * h,
                figure.front + 0.115 * h,
            ),
            spot: PALM_SPOT,
            fingers: DVec3::new(-0.62, 0.42, 0.62),
            palm: DVec3::new(-0.02, 0.80, -0.58),
            elbow: DVec3::new(0.5, -1.0, -0.2),
            // The thumb taps.
            curl: [0.55 + 0.35 * wave(phase, 13.0, 0.0) * (1.0 - glance), 0.4, 0.5, 0.55, 0.6]
                .map(|c| c + 0.03 * wave(phase, 2.0, 0.0)),
        };
        figure.reach(&mut pose, Side::Right, &reach, 1.0);
        pose
    })
}
