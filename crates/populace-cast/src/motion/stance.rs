//! Stances: anatomical angles and foot positions at one instant, solved to rotations of all
//! segments.

use glam::{DMat3, DQuat, DVec3};

use super::Pose;
use crate::anatomy::{Body, HEAD, Limb, NECK, PELVIS, REST_SPREAD_RAD, SEGMENTS, SPINE, Side};

/// Angles of one arm in radians; the arm hangs straight down if all are 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arm {
    /// Rotation at the shoulder, positive forward.
    pub(super) swing_rad: f64,
    /// Rotation at the shoulder, positive away from the body.
    pub(super) spread_rad: f64,
    /// Flexion of the elbow.
    pub(super) elbow_rad: f64,
    /// Rotation of the upper arm about its axis, positive if it moves the forearm inwards.
    pub(super) twist_rad: f64,
    /// Flexion of the joints of the index finger; the other fingers bend slightly more.
    pub(super) curl_rad: f64,
}

/// Position of one leg's foot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    /// Position of the ankle in model space, in metres.
    pub(super) ankle: DVec3,
    /// Pitch of the foot, positive if the toes point up.
    pub(super) pitch_rad: f64,
    /// Pitch of the toe segment, positive if it points up.
    pub(super) toe_pitch_rad: f64,
    /// Yaw of the foot, positive if the toes point outwards.
    pub(super) yaw_rad: f64,
}

impl Leg {
    /// Returns the leg a fraction of the way to another.
    pub(super) fn towards(&self, end: &Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * part;
        Self {
            ankle: self.ankle.lerp(end.ankle, part),
            pitch_rad: mix(self.pitch_rad, end.pitch_rad),
            toe_pitch_rad: mix(self.toe_pitch_rad, end.toe_pitch_rad),
            yaw_rad: mix(self.yaw_rad, end.yaw_rad),
        }
    }
}

/// Stance of a body. Rotations are relative to rest, in model space.
#[derive(Clone, Debug)]
pub(super) struct Stance {
    /// Translation of the pelvis in metres.
    pub(super) pelvis_offset: DVec3,
    pub(super) pelvis: DQuat,
    pub(super) chest: DQuat,
    pub(super) head: DQuat,
    /// Rotation of the clavicles, positive if the shoulders are raised.
    pub(super) shrug_rad: f64,
    pub(super) arms: [Arm; 2],
    pub(super) legs: [Leg; 2],
}

impl Stance {
    /// Returns a stance whose trunk is a fraction of the way to that of another. Arms are those of
    /// `self`.
    pub(super) fn towards(&self, end: &Self, part: f64) -> Self {
        Self {
            pelvis_offset: self.pelvis_offset.lerp(end.pelvis_offset, part),
            pelvis: self.pelvis.slerp(end.pelvis, part),
            chest: self.chest.slerp(end.chest, part),
            head: self.head.slerp(end.head, part),
            shrug_rad: self.shrug_rad + (end.shrug_rad - self.shrug_rad) * part,
            arms: self.arms,
            legs: std::array::from_fn(|side| self.legs[side].towards(&end.legs[side], part)),
        }
    }

    /// Returns the rotations of all segments.
    pub(super) fn solve(&self, body: &Body) -> Pose {
        let mut rotations = [DQuat::IDENTITY; SEGMENTS];
        rotations[PELVIS] = self.pelvis;
        for (at, &segment) in SPINE.iter().enumerate() {
            rotations[segment] = self.pelvis.slerp(self.chest, (at + 1) as f64 / 4.0);
        }
        rotations[NECK[0]] = self.chest.slerp(self.head, 0.4);
        rotations[NECK[1]] = self.chest.slerp(self.head, 0.75);
        rotations[HEAD] = self.head;
        for side in Side::BOTH {
            self.solve_arm(body, side, &mut rotations);
            self.solve_leg(body, side, &mut rotations);
        }
        Pose { rotations, pelvis_offset: self.pelvis_offset }
    }

    fn solve_arm(&self, body: &Body, side: Side, rotations: &mut [DQuat; SEGMENTS]) {
        let arm = &self.arms[side.index()];
        let on_side = |q: DQuat| side.mirror_rotation(q);
        let clavicle =
            self.chest * on_side(DQuat::from_rotation_z(self.shrug_rad + 0.1 * arm.spread_rad));
        rotations[Limb::Clavicle.of(side)] = clavicle;
        // The arms hang down even if the back is bent: the shoulder compensates most of the lean.
        let lean = self.chest.slerp(DQuat::IDENTITY, 0.7);
        let hang = DQuat::from_rotation_z(arm.spread_rad - REST_SPREAD_RAD);
        let upper = lean
            * on_side(
                DQuat::from_rotation_x(-arm.swing_rad)
                    * hang
                    * DQuat::from_axis_angle(body.along, arm.twist_rad),
            );
        let forearm = upper * on_side(DQuat::from_axis_angle(-body.outward, arm.elbow_rad));
        rotations[Limb::UpperArm.of(side)] = upper;
        rotations[Limb::Forearm.of(side)] = forearm;
        let hand = forearm * on_side(DQuat::from_axis_angle(DVec3::Z, 0.25 * arm.curl_rad));
        rotations[Limb::Hand.of(side)] = hand;
        solve_fingers(body, side, arm.curl_rad, rotations);
    }

    fn solve_leg(&self, body: &Body, side: Side, rotations: &mut [DQuat; SEGMENTS]) {
        let leg = &self.legs[side.index()];
        let yaw = DQuat::from_rotation_y(side.sign() * leg.yaw_rad);
        rotations[Limb::Foot.of(side)] = yaw * DQuat::from_rotation_x(-leg.pitch_rad);
        rotations[Limb::Toes.of(side)] = yaw * DQuat::from_rotation_x(-leg.toe_pitch_rad);
        let [hip, knee, ankle] =
            [Limb::Thigh, Limb::Shin, Limb::Foot].map(|limb| body.joint(limb, side));
        let from = self.hip(body, side);
        // The knee points halfway between the directions of the foot and of the pelvis.
        let front = (yaw * DVec3::Z).lerp(self.pelvis * DVec3::Z, 0.5);
        let (upper, lower) = ((knee - hip).length(), (ankle - knee).length());
        let to = leg.ankle - from;
        let reach = to.length().clamp((upper - lower).abs() + 1e-6, upper + lower - 1e-6);
        let down = to.normalize();
        let hinge = front.cross(down).normalize();
        // Angle between the sides a and b of a triangle, by the law of cosines.
        let angle = |a: f64, b: f64, c: f64| {
            ((a * a + b * b - c * c) / (2.0 * a * b)).clamp(-1.0, 1.0).acos()
        };
        let thigh = DQuat::from_axis_angle(hinge, -angle(upper, reach, lower)) * down;
        let shin = DQuat::from_axis_angle(hinge, angle(lower, reach, upper)) * down;
        rotations[Limb::Thigh.of(side)] = rotation_between([knee - hip, DVec3::X], [thigh, hinge]);
        rotations[Limb::Shin.of(side)] = rotation_between([ankle - knee, DVec3::X], [shin, hinge]);
    }

    /// Returns the position of a hip joint in model space.
    pub(super) fn hip(&self, body: &Body, side: Side) -> DVec3 {
        let pelvis = body.joints[PELVIS];
        pelvis + self.pelvis_offset + self.pelvis * (body.joint(Limb::Thigh, side) - pelvis)
    }
}

/// Sets the rotations of a hand's fingers and thumb. `curl_rad` is that of [`Arm`].
pub(super) fn solve_fingers(
    body: &Body,
    side: Side,
    curl_rad: f64,
    rotations: &mut [DQuat; SEGMENTS],
) {
    solve_hand(body, side, [curl_rad; 5], rotations);
}

/// Sets the rotations of a hand's thumb and fingers, each with its own flexion in radians.
pub(super) fn solve_hand(
    body: &Body,
    side: Side,
    curl_rad: [f64; 5],
    rotations: &mut [DQuat; SEGMENTS],
) {
    let on_side = |q: DQuat| side.mirror_rotation(q);
    let hand = rotations[Limb::Hand.of(side)];
    let towards_palm = body.along.cross(-body.outward).normalize();
    for finger in 1..5 {
        let mut rotation = hand;
        let curl = curl_rad[finger] * (0.85 + 0.15 * finger as f64);
        // The little finger spreads backwards, the index finger forwards.
        let fan = DQuat::from_axis_angle(body.outward, 0.02 * (finger as f64 - 2.3));
        for (joint, part) in [0.9, 1.15, 0.7].into_iter().enumerate() {
            let bend = DQuat::from_axis_angle(towards_palm, curl * part);
            rotation *= on_side(if joint == 0 { fan * bend } else { bend });
            rotations[Limb::Finger(finger, joint).of(side)] = rotation;
        }
    }
    let across = body.thumb.cross(-body.outward).normalize();
    let mut rotation = hand;
    for (joint, part) in [0.42, 0.4, 0.5].into_iter().enumerate() {
        rotation *= on_side(DQuat::from_axis_angle(across, curl_rad[0] * part));
        rotations[Limb::Finger(0, joint).of(side)] = rotation;
    }
}

/// Returns the rotation that takes the bone direction and the bending axis at rest to those of
/// `posed`.
pub(super) fn rotation_between(rest: [DVec3; 2], posed: [DVec3; 2]) -> DQuat {
    let frame = |[along, side]: [DVec3; 2]| {
        let along = along.normalize();
        let side = (side - along * side.dot(along)).normalize();
        DMat3::from_cols(side, along, side.cross(along))
    };
    DQuat::from_mat3(&(frame(posed) * frame(rest).transpose()))
}
