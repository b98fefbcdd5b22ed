//! Battles: shield, spear, and blows.

use glam::{DQuat, DVec3};

use super::{Timing, standing, wave};
use crate::anatomy::Side;
use crate::motion::figure::Figure;
use crate::motion::idle::{IdleState, stance};
use crate::motion::reach::{FIST, GRIP_SPOT, PALM_SPOT, Reach};
use crate::motion::{Motion, Pose, curve};

/// Returns standing behind a shield in the left hand, with bent knees.
pub(super) fn shield(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Shield", 5.0, 8.0).looping(|phase| {
        let state = IdleState {
            left: 0.35 * wave(phase, 1.0, 0.0),
            breath: wave(phase, 2.0, 0.0),
            look: 0.10 * wave(phase, 1.0, 0.3),
            nod: 0.07 + 0.02 * wave(phase, 2.0, 0.4),
        };
        let mut stance = stance(body, &state);
        let bounce = 0.004 * wave(phase, 2.0, 0.15);
        stance.pelvis_offset += DVec3::new(0.0, -0.035 + bounce, -0.012) * h;
        stance.pelvis = DQuat::from_rotation_y(-0.16) * stance.pelvis;
        stance.chest = DQuat::from_rotation_y(-0.22) * stance.chest * DQuat::from_rotation_x(0.10);
        stance.legs[0].ankle.z += 0.07 * h;
        stance.legs[1].ankle.z -= 0.05 * h;
        stance.legs[1].yaw_rad += 0.25;
        let mut pose = stance.solve(body);
        let upright =
            DQuat::from_rotation_x(-0.1 - body.look.stoop_rad) * DQuat::from_rotation_y(0.22);
        // The face of the shield looks along the back of the hand, forward in model space.
        let reach = Reach {
            frame: figure.chest(&pose),
            at: DVec3::new(
                0.02 * h,
                body.trunk_y(0.52) + 0.006 * h * wave(phase, 2.0, 0.3),
                figure.front + 0.13 * h,
            ),
            spot: GRIP_SPOT,
            fingers: upright * DVec3::new(-1.0, 0.06, 0.0),
            palm: upright * DVec3::new(0.0, 0.0, -1.0),
            elbow: DVec3::new(0.75, -1.0, 0.1),
            curl: FIST.map(|curl| curl + 0.08 * wave(phase, 1.0, 0.0)),
        };
        figure.reach(&mut pose, Side::Left, &reach, 1.0);
        let ready = Reach {
            frame: figure.chest(&pose),
            at: DVec3::new(0.15 * h, body.trunk_y(0.12), 0.05 * h),
            spot: GRIP_SPOT,
            fingers: DVec3::new(0.0, -0.75, 0.66),
            palm: DVec3::new(-1.0, 0.0, 0.0),
            elbow: DVec3::new(0.5, -0.3, -1.0),
            curl: FIST.map(|curl| curl - 0.06 * (1.0 + wave(phase, 1.0, 0.3))),
        };
        figure.reach(&mut pose, Side::Right, &ready, 1.0);
        pose
    })
}

/// Returns where the right hand holds a spear: `ahead` of the hip by a fraction of the height, with
/// the point raised by an angle in radians.
fn on_spear(figure: &Figure, pose: &Pose, [out, up, ahead]: [f64; 3], raised: f64) -> Reach {
    let body = figure.body;
    // A bent back does not lower the point.
    let (sin, cos) = (raised + body.look.stoop_rad).sin_cos();
    Reach {
        frame: figure.chest(pose),
        at: DVec3::new(out, 0.0, ahead) * body.height + DVec3::Y * body.trunk_y(up),
        spot: GRIP_SPOT,
        // The shaft runs to the thumb.
        fingers: DVec3::new(0.0, -cos, sin),
        palm: DVec3::new(-1.0, 0.0, 0.0),
        elbow: DVec3::new(0.6, 0.1, -1.0),
        curl: FIST,
    }
}

/// Returns standing with a spear in the right hand, its point up and forward.
pub(super) fn spear(figure: &Figure) -> Motion {
    let body = figure.body;
    Timing("Spear", 5.0, 8.0).looping(|phase| {
        let state = IdleState {
            left: 0.3 * wave(phase, 1.0, 0.5),
            breath: wave(phase, 2.0, 0.0),
            look: 0.10 * wave(phase, 1.0, 0.1),
            nod: 0.03 + 0.02 * wave(phase, 2.0, 0.4),
        };
        let mut stance = stance(body, &state);
        stance.chest = DQuat::from_rotation_y(-0.12) * stance.chest;
        let mut pose = stance.solve(body);
        let at = [0.145, 0.22 + 0.01 * wave(phase, 2.0, 0.1), 0.10 + 0.006 * wave(phase, 1.0, 0.2)];
        let reach = on_spear(figure, &pose, at, 0.75 + 0.05 * wave(phase, 1.0, 0.25));
        let curl = reach.curl.map(|curl| curl + 0.08 * wave(phase, 2.0, 0.0));
        figure.reach(&mut pose, Side::Right, &Reach { curl, ..reach }, 1.0);
        pose
    })
}

/// Returns a thrust with the spear, from standing to standing.
pub(super) fn thrust(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Spear_Thrust", 1.6, 20.0).once(|at| {
        let through = |knots: &curve::Knots| curve::through(knots, at);
        let weight = through(&[(0.0, 0.0), (0.32, 1.0), (1.05, 1.0), (1.55, 0.0)]);
        let reach = through(&[
            (0.2, 0.0),
            (0.42, -0.35),
            (0.5, -0.3),
            (0.80, 1.0),
            (0.92, 1.0),
            (1.45, 0.0),
        ]);
        let raised = through(&[(0.0, 0.75), (0.4, 0.15), (0.72, 0.24), (0.9, 0.24), (1.5, 0.75)]);
        let crouch = through(&[(0.0, 0.0), (0.45, 0.6), (0.72, 1.0), (0.9, 1.0), (1.5, 0.0)]);
        let mut stance = standing(body, at / 1.6);
        stance.pelvis_offset += DVec3::new(0.0, -0.030 * crouch, 0.045 * reach) * h;
        stance.pelvis = DQuat::from_rotation_y(0.22 * reach) * stance.pelvis;
        stance.chest = DQuat::from_rotation_y(0.55 * reach)
            * stance.chest
            * DQuat::from_rotation_x(0.16 * reach.max(0.0) + 0.05 * crouch);
        let mut pose = stance.solve(body);
        let ahead = reach.max(0.0);
        let place = [0.145 - 0.04 * ahead, 0.34 + 0.28 * ahead, 0.06 + 0.27 * reach];
        // The shaft points forward in model space, whichever way the chest turns.
        let mut own = on_spear(figure, &pose, place, raised);
        let unturned = DQuat::from_rotation_y(-0.55 * reach * Side::Right.sign());
        (own.fingers, own.palm) = (unturned * own.fingers, unturned * own.palm);
        figure.reach(&mut pose, Side::Right, &own, weight);
        pose
    })
}

/// Returns being hit from the front: a flinch, and a recovery.
pub(super) fn hit(figure: &Figure) -> Motion {
    let body = figure.body;
    let h = body.height;
    Timing("Hit", 1.6, 20.0).once(|at| {
        let through = |knots: &curve::Knots| curve::through(knots, at);
        let blow = through(&[(0.0, 0.0), (0.16, 1.0), (0.5, 0.55), (0.9, -0.18), (1.45, 0.0)]);
        let curl = through(&[(0.05, 0.0), (0.42, 1.0), (0.7, 0.8), (1.4, 0.0)]);
        let nod = through(&[(0.0, 0.0), (0.1, -0.6), (0.3, 1.0), (0.75, 0.5), (1.4, 0.0)]);
        let mut stance = standing(body, at / 1.6);
        stance.pelvis_offset +=
            DVec3::new(0.012 * blow, -0.012 * blow.abs() - 0.026 * curl, -0.05 * blow) * h;
        stance.pelvis *= DQuat::from_rotation_x(0.18 * curl);
        stance.chest = DQuat::from_rotation_y(0.20 * blow)
            * stance.chest
            * DQuat::from_rotation_x(-0.26 * blow + 0.46 * curl);
        stance.head *= DQuat::from_rotation_x(0.30 * nod) * DQuat::from_rotation_y(-0.12 * blow);
        stance.shrug_rad += 0.14 * through(&[(0.0, 0.0), (0.14, 1.0), (0.6, 0.7), (1.3, 0.0)]);
        let mut pose = stance.solve(body);
        for side in Side::BOTH {
            let late = if side == Side::Left { 0.0 } else { 0.05 };
            let weight = curve::through(
                &[(0.02 + late, 0.0), (0.2 + late, 0.85), (0.6 + late, 0.95), (1.4 + late, 0.0)],
                at,
            );
            let (wide, up) = if side == Side::Left { (0.045, 0.48) } else { (0.02, 0.34) };
            let reach = Reach {
                frame: figure.chest(&pose),
                at: DVec3::new(
                    (wide + 0.10 * blow.max(0.0)) * h,
                    body.trunk_y(up) + 0.06 * blow * h,
                    figure.front + (0.05 + 0.10 * blow.max(0.0)) * h,
                ),
                spot: PALM_SPOT,
                fingers: DVec3::new(-0.75, 0.7, 0.25),
                palm: DVec3::new(-0.2, 0.0, -1.0),
                elbow: DVec3::new(0.9, -0.8, -0.2),
                curl: [0.6, 0.5, 0.55, 0.6, 0.65],
            };
            figure.reach(&mut pose, side, &reach, weight);
        }
        pose
    })
}
