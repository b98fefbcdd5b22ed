//! Leaning with the back against a wall.

use glam::{DQuat, DVec3};

use super::{Timing, wave};
use crate::anatomy::{Limb, Side};
use crate::motion::figure::Figure;
use crate::motion::idle::{IdleState, stance};
use crate::motion::reach::{PALM_SPOT, Reach};
use crate::motion::stance::Stance;
use crate::motion::{Motion, curve};
use crate::places::LEAN_WALL_M;

/// Returns leaning against a wall, with the arms folded loosely before the belly.
pub(super) fn lean(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    let back = against(figure, &leaning(figure, &IDLE));
    Timing("Lean", 9.0, 8.0).looping(|phase| {
        let look = curve::at(
            &[(0.05, 0.1), (0.2, 0.6), (0.32, 0.65), (0.45, -0.2), (0.62, -0.5), (0.8, -0.4)],
            phase,
        );
        let state = IdleState {
            left: -0.5,
            breath: wave(phase, 3.0, 0.0),
            look: 0.4 * look,
            nod: 0.03 + 0.03 * wave(phase, 2.0, 0.2),
        };
        let mut stance = leaning(figure, &state);
        stance.pelvis_offset.z += back;
        stance.head = DQuat::from_rotation_y(0.6 * look) * stance.head;
        let mut pose = stance.solve(body);
        for side in [Side::Right, Side::Left] {
            // Each hand holds the other arm below the elbow.
            let over = if side == Side::Left { 0.026 } else { 0.0 };
            let reach = Reach {
                frame: figure.chest(&pose),
                at: DVec3::new(
                    -0.055 * h,
                    body.trunk_y(0.30) + over * 0.8 * h,
                    figure.belly.max(figure.front - 0.01 * h) + (0.028 + over) * h,
                ),
                spot: PALM_SPOT,
                fingers: DVec3::new(-1.0, 0.1, 0.0),
                palm: DVec3::new(0.0, -0.2, -1.0),
                elbow: DVec3::new(0.9, -1.0, 0.0),
                curl: [0.3, 0.35, 0.4, 0.4, 0.45].map(|c| c + 0.09 * wave(phase, 1.0, 0.0)),
            };
            figure.reach(&mut pose, side, &reach, 1.0);
        }
        pose
    })
}

const IDLE: IdleState = IdleState { left: -0.5, breath: 1.0, look: 0.0, nod: 0.0 };

/// Returns the stance with the hips behind the feet, and the left foot ahead.
fn leaning(figure: &Figure, state: &IdleState) -> Stance {
    let body = figure.body;
    let h = body.height;
    let mut stance = stance(body, state);
    stance.pelvis_offset += DVec3::new(0.0, -0.020, -0.075) * h;
    stance.pelvis *= DQuat::from_rotation_x(0.05);
    stance.chest *= DQuat::from_rotation_x(-0.16 - 0.6 * body.look.stoop_rad);
    let left = &mut stance.legs[Side::Left.index()];
    left.ankle.z += 0.055 * h;
    left.ankle.x = 0.9 * body.joint(Limb::Foot, Side::Left).x;
    stance
}

/// Returns how far the stance moves forward so that its back touches the wall.
fn against(figure: &Figure, stance: &Stance) -> f64 {
    let mut moved = 0.0;
    for _ in 0..4 {
        let mut stance = stance.clone();
        stance.pelvis_offset.z += moved;
        let back = figure.back(&stance.solve(figure.body));
        moved += back - f64::from(LEAN_WALL_M);
    }
    moved
}
