//! Hands that reach for points: on the body, or in model space.

use glam::{DQuat, DVec3};

use super::Pose;
use super::figure::Figure;
use super::stance::{rotation_between, solve_hand};
use crate::anatomy::{HEAD, Limb, PELVIS, SEGMENTS, SPINE, Segment, Side, parent};
use crate::surface::smooth;

/// Place of the coordinates in which a reach is given.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) origin: DVec3,
    pub(super) turn: DQuat,
}

impl Frame {
    /// Model space.
    pub(super) const MODEL: Self = Self { origin: DVec3::ZERO, turn: DQuat::IDENTITY };
}

/// Where a hand goes, and how it lies there. Points and directions are those of the left hand in a
/// [`Frame`]; the right hand takes their mirror images.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) frame: Frame,
    /// Place of the hand's spot, in metres.
    pub(super) at: DVec3,
    /// Spot of the hand: distances from the wrist along the hand and out of the palm, as fractions
    /// of the body's height.
    pub(super) spot: [f64; 2],
    /// Direction of the stretched fingers.
    pub(super) fingers: DVec3,
    /// Direction into which the palm faces.
    pub(super) palm: DVec3,
    /// Direction in which the elbow points.
    pub(super) elbow: DVec3,
    /// Flexion of thumb, index finger and so on in radians.
    pub(super) curl: [f64; 5],
}

impl Reach {
    /// Returns the reach a fraction of the way to another of the same frame.
    pub(super) fn towards(&self, end: &Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * part;
        Self {
            frame: self.frame,
            at: self.at.lerp(end.at, part),
            spot: [0, 1].map(|i| mix(self.spot[i], end.spot[i])),
            fingers: self.fingers.lerp(end.fingers, part),
            palm: self.palm.lerp(end.palm, part),
            elbow: self.elbow.lerp(end.elbow, part),
            curl: [0, 1, 2, 3, 4].map(|i| mix(self.curl[i], end.curl[i])),
        }
    }
}

/// The middle of the palm's surface.
pub(super) const PALM_SPOT: [f64; 2] = [0.048, 0.012];
/// The axis of a bar in the fist.
pub(super) const GRIP_SPOT: [f64; 2] = [0.056, 0.019];
/// The tip of the fingers.
pub(super) const TIP_SPOT: [f64; 2] = [0.104, 0.004];
/// Flexion of the fingers around a bar.
pub(super) const FIST: [f64; 5] = [0.75, 1.1, 1.1, 1.1, 1.1];

impl Figure<'_> {
    /// Returns the frame that a segment carries, in which points have their coordinates at rest.
    pub(super) fn frame(&self, pose: &Pose, segment: Segment) -> Frame {
        let turn = pose.rotations[segment];
        let (at, rest) = self.place(&self.positions(pose), segment);
        Frame { origin: at - turn * rest, turn }
    }

    /// Returns the frame of the chest.
    pub(super) fn chest(&self, pose: &Pose) -> Frame {
        self.frame(pose, SPINE[3])
    }

    /// Returns the frame of the head.
    pub(super) fn head(&self, pose: &Pose) -> Frame {
        self.frame(pose, HEAD)
    }

    /// Moves a hand to a reach, by a weight from 0 (the arm stays as it is) to 1. Returns where the
    /// wrist should be.
    pub(super) fn reach(&self, pose: &mut Pose, side: Side, reach: &Reach, weight: f64) -> DVec3 {
        let before = pose.rotations;
        let out = |v: DVec3| reach.frame.turn * side.mirror_point(v);
        let to = reach.frame.origin + out(reach.at);
        let [along, back] = [self.body.along, self.body.outward].map(|v| side.mirror_point(v));
        let (fingers, palm) = (out(reach.fingers), out(reach.palm));
        pose.rotations[Limb::Hand.of(side)] = rotation_between([along, back], [fingers, -palm]);
        solve_hand(self.body, side, reach.curl, &mut pose.rotations);
        let [ahead, inwards] = reach.spot.map(|v| v * self.body.height);
        let spot = along * ahead - back * inwards;
        let wrist = to - pose.rotations[Limb::Hand.of(side)] * spot;
        self.raise(pose, side, wrist);
        let shoulder = self.joint(&self.positions(pose), Limb::UpperArm, side);
        self.bend_arm(pose, side, out(reach.elbow), [shoulder, wrist]);
        mix_arm(pose, side, &before, weight);
        wrist
    }

    /// Turns the clavicle towards where the wrist goes: up, and forwards.
    fn raise(&self, pose: &mut Pose, side: Side, wrist: DVec3) {
        let chest = pose.rotations[SPINE[3]];
        let clavicle = Limb::Clavicle.of(side);
        let shoulder = self.joint(&self.positions(pose), Limb::UpperArm, side);
        let towards = chest.inverse() * (wrist - shoulder);
        let reach = towards.length() / (0.32 * self.body.height);
        let towards = side.mirror_point(towards.normalize_or(DVec3::NEG_Y));
        let far = smooth(0.75, 1.15, reach);
        let up = 0.5 * smooth(-0.2, 1.0, towards.y) * smooth(0.45, 0.95, reach);
        let forward = 0.3 * towards.z.max(0.0) * far;
        let turn = DQuat::from_rotation_y(-forward) * DQuat::from_rotation_z(up);
        pose.rotations[clavicle] *= side.mirror_rotation(turn);
    }

    /// Returns how far a wrist is from its shoulder, as a fraction of the arm's length.
    pub(super) fn stretch(&self, pose: &Pose, side: Side, wrist: DVec3) -> f64 {
        let [upper, lower, hand] =
            [Limb::UpperArm, Limb::Forearm, Limb::Hand].map(|limb| self.body.joint(limb, side));
        let shoulder = self.joint(&self.positions(pose), Limb::UpperArm, side);
        shoulder.distance(wrist) / (upper.distance(lower) + lower.distance(hand))
    }
}

/// Mixes an arm with its rotations before, each relative to its parent.
fn mix_arm(pose: &mut Pose, side: Side, before: &[DQuat; SEGMENTS], weight: f64) {
    if weight >= 1.0 {
        return;
    }
    if weight <= 0.0 {
        pose.rotations = *before;
        return;
    }
    let after = pose.rotations;
    let fingers = (0..5).flat_map(|f| (0..3).map(move |j| Limb::Finger(f, j)));
    let arm = [Limb::Clavicle, Limb::UpperArm, Limb::Forearm, Limb::Hand];
    for segment in arm.into_iter().chain(fingers).map(|limb| limb.of(side)) {
        let parent = parent(segment).unwrap_or(PELVIS);
        let [old, new] = [before, &after].map(|r| r[parent].inverse() * r[segment]);
        pose.rotations[segment] = pose.rotations[parent] * old.slerp(new, weight);
    }
}
