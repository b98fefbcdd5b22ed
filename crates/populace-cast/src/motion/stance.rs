//! A stance: what the parts of a body do at one instant, in a walker's terms; solved to turns of
//! all segments.

use glam::{DMat3, DQuat, DVec3};

use super::Pose;
use crate::anatomy::{Body, HEAD, Limb, NECK, PELVIS, REST_SPREAD_RAD, SEGMENTS, SPINE, Side};

/// One arm, hanging where all is 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arm {
    /// Forward at the shoulder.
    pub(super) swing_rad: f64,
    /// Away from the body.
    pub(super) spread_rad: f64,
    pub(super) elbow_rad: f64,
    /// The upper arm about itself, forearm inwards.
    pub(super) twist_rad: f64,
    /// Each joint of the index finger; the others a little more.
    pub(super) curl_rad: f64,
}

/// One leg, by its foot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub(super) ankle: DVec3,
    /// Toes up.
    pub(super) pitch_rad: f64,
    /// Of the toes alone, toes up.
    pub(super) toe_pitch_rad: f64,
    /// Toes out.
    pub(super) yaw_rad: f64,
}

/// All of a body. Turns are in model space.
#[derive(Clone, Debug)]
pub(super) struct Stance {
    pub(super) pelvis_offset: DVec3,
    pub(super) pelvis: DQuat,
    pub(super) chest: DQuat,
    pub(super) head: DQuat,
    /// How far shoulders are raised.
    pub(super) shrug_rad: f64,
    pub(super) arms: [Arm; 2],
    pub(super) legs: [Leg; 2],
}

impl Stance {
    /// Turns of all segments.
    pub(super) fn solve(&self, body: &Body) -> Pose {
        let mut turns = [DQuat::IDENTITY; SEGMENTS];
        turns[PELVIS] = self.pelvis;
        for (at, &segment) in SPINE.iter().enumerate() {
            turns[segment] = self.pelvis.slerp(self.chest, (at + 1) as f64 / 4.0);
        }
        turns[NECK[0]] = self.chest.slerp(self.head, 0.4);
        turns[NECK[1]] = self.chest.slerp(self.head, 0.75);
        turns[HEAD] = self.head;
        for side in Side::BOTH {
            self.solve_arm(body, side, &mut turns);
            self.solve_leg(body, side, &mut turns);
        }
        Pose { turns, pelvis_offset: self.pelvis_offset }
    }

    fn solve_arm(&self, body: &Body, side: Side, turns: &mut [DQuat; SEGMENTS]) {
        let arm = &self.arms[side.index()];
        let left = |q: DQuat| side.turn(q);
        let clavicle =
            self.chest * left(DQuat::from_rotation_z(self.shrug_rad + 0.1 * arm.spread_rad));
        turns[Limb::Clavicle.of(side)] = clavicle;
        // Bent backs leave arms hanging: the shoulder takes up most of the chest's lean.
        let lean = self.chest.slerp(DQuat::IDENTITY, 0.7);
        let hang = DQuat::from_rotation_z(arm.spread_rad - REST_SPREAD_RAD);
        let upper = lean
            * left(
                DQuat::from_rotation_x(-arm.swing_rad)
                    * hang
                    * DQuat::from_axis_angle(body.along, arm.twist_rad),
            );
        let forearm = upper * left(DQuat::from_axis_angle(-body.outward, arm.elbow_rad));
        turns[Limb::UpperArm.of(side)] = upper;
        turns[Limb::Forearm.of(side)] = forearm;
        let hand = forearm * left(DQuat::from_axis_angle(DVec3::Z, 0.25 * arm.curl_rad));
        turns[Limb::Hand.of(side)] = hand;
        let towards_palm = body.along.cross(-body.outward).normalize();
        for finger in 1..5 {
            let mut turn = hand;
            let curl = arm.curl_rad * (0.85 + 0.15 * finger as f64);
            // The little finger spreads back, the index finger forward.
            let fan = DQuat::from_axis_angle(body.outward, 0.02 * (finger as f64 - 2.3));
            for (joint, part) in [0.9, 1.15, 0.7].into_iter().enumerate() {
                let bend = DQuat::from_axis_angle(towards_palm, curl * part);
                turn *= left(if joint == 0 { fan * bend } else { bend });
                turns[Limb::Finger(finger, joint).of(side)] = turn;
            }
        }
        let across = body.thumb.cross(-body.outward).normalize();
        let mut turn = hand;
        for (joint, part) in [0.42, 0.4, 0.5].into_iter().enumerate() {
            turn *= left(DQuat::from_axis_angle(across, arm.curl_rad * part));
            turns[Limb::Finger(0, joint).of(side)] = turn;
        }
    }

    fn solve_leg(&self, body: &Body, side: Side, turns: &mut [DQuat; SEGMENTS]) {
        let leg = &self.legs[side.index()];
        let yaw = DQuat::from_rotation_y(side.sign() * leg.yaw_rad);
        turns[Limb::Foot.of(side)] = yaw * DQuat::from_rotation_x(-leg.pitch_rad);
        turns[Limb::Toes.of(side)] = yaw * DQuat::from_rotation_x(-leg.toe_pitch_rad);
        let [hip, knee, ankle] =
            [Limb::Thigh, Limb::Shin, Limb::Foot].map(|limb| body.joint(limb, side));
        let from = self.hip(body, side);
        // The knee points where the foot and the pelvis do on the average.
        let front = (yaw * DVec3::Z).lerp(self.pelvis * DVec3::Z, 0.5);
        let (upper, lower) = ((knee - hip).length(), (ankle - knee).length());
        let to = leg.ankle - from;
        let reach = to.length().clamp((upper - lower).abs() + 1e-6, upper + lower - 1e-6);
        let down = to.normalize();
        let hinge = front.cross(down).normalize();
        let corner = |a: f64, b: f64, c: f64| {
            ((a * a + b * b - c * c) / (2.0 * a * b)).clamp(-1.0, 1.0).acos()
        };
        let thigh = DQuat::from_axis_angle(hinge, -corner(upper, reach, lower)) * down;
        let shin = DQuat::from_axis_angle(hinge, corner(lower, reach, upper)) * down;
        turns[Limb::Thigh.of(side)] = turn_between(knee - hip, thigh, hinge);
        turns[Limb::Shin.of(side)] = turn_between(ankle - knee, shin, hinge);
    }

    /// Where a hip joint is.
    pub(super) fn hip(&self, body: &Body, side: Side) -> DVec3 {
        let pelvis = body.joints[PELVIS];
        pelvis + self.pelvis_offset + self.pelvis * (body.joint(Limb::Thigh, side) - pelvis)
    }
}

/// Takes a bone at rest, which bends about X, to a direction, bending about `hinge`.
fn turn_between(rest: DVec3, dir: DVec3, hinge: DVec3) -> DQuat {
    let frame = |along: DVec3, side: DVec3| {
        let along = along.normalize();
        let side = (side - along * side.dot(along)).normalize();
        DMat3::from_cols(side, along, side.cross(along))
    };
    DQuat::from_mat3(&(frame(dir, hinge) * frame(rest, DVec3::X).transpose()))
}
