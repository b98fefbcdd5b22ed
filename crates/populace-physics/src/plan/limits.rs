//! Rotation limits of bodies.

use super::names::{JointKind, joint_kind_from_name};
use super::rest::Rest;
use super::select::SelectedBody;
use super::shape::Capsule;
use super::{JointDef, Limits};
use crate::math::{Rotation, Vector, joint_index};

/// Least bend at rest, in radians, from which its direction determines the hinge axis.
const CLEAR_BEND_RAD: f32 = 0.1;
/// Angle in radians by which knees and elbows bend beyond straight.
const BEYOND_STRAIGHT_RAD: f32 = 0.035;
/// Largest bend of knees and elbows, measured from straight.
const MAX_BEND_RAD: f32 = 2.53;

/// Kind of a limb.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Limb {
    Leg,
    Arm,
    /// On the axis of the body: a neck or a tail.
    Axial,
}

/// The inputs for limits, with the orientation and vertical range of the body.
pub(super) struct Anatomy<'a> {
    pub(super) rest: &'a Rest<'a>,
    pub(super) bodies: &'a [SelectedBody],
    pub(super) capsules: &'a [Capsule],
    pub(super) is_trunk: &'a [bool],
    front: Vector,
    low: f32,
    high: f32,
}

impl<'a> Anatomy<'a> {
    pub(super) fn new(
        rest: &'a Rest<'a>,
        bodies: &'a [SelectedBody],
        capsules: &'a [Capsule],
        is_trunk: &'a [bool],
    ) -> Self {
        let ends = capsules.iter().flat_map(|c| [c.from.y, c.to.y]);
        let low = ends.clone().fold(f32::MAX, f32::min);
        let high = ends.fold(f32::MIN, f32::max);
        let mut anatomy = Self { rest, bodies, capsules, is_trunk, front: Vector::Z, low, high };
        anatomy.front = anatomy.find_front();
        anatomy
    }

    /// Returns the direction of the feet, or +Z without feet.
    fn find_front(&self) -> Vector {
        let mut front = Vector::ZERO;
        for (index, capsule) in self.capsules.iter().enumerate() {
            let is_last = !self.bodies.iter().any(|b| b.parent == Some(index));
            if is_last && self.limb(index) == Limb::Leg {
                front += (capsule.to - capsule.from) * Vector::new(1.0, 0.0, 1.0);
            }
        }
        if front.length() > 0.05 * self.rest.size { front.normalize() } else { Vector::Z }
    }

    /// Returns the index of a body in its limb, counted from the trunk, and the number of bodies of
    /// the limb.
    fn index_in_limb(&self, body: usize) -> (usize, usize) {
        let mut before = 0;
        let mut at = body;
        while let Some(parent) = self.bodies[at].parent.filter(|&p| !self.is_trunk[p]) {
            before += 1;
            at = parent;
        }
        (before, before + self.limb_from(body).len())
    }

    /// Returns the bodies from `body` to the end of its limb.
    fn limb_from(&self, body: usize) -> Vec<usize> {
        let mut limb = vec![body];
        let mut at = body;
        while let Some(next) =
            (at + 1..self.bodies.len()).find(|&b| self.bodies[b].parent == Some(at))
        {
            limb.push(next);
            at = next;
        }
        limb
    }

    /// Returns the kind of a body's limb from where it ends: near the ground, or to the side.
    fn limb(&self, body: usize) -> Limb {
        let mut first = body;
        while let Some(parent) = self.bodies[first].parent.filter(|&p| !self.is_trunk[p]) {
            first = parent;
        }
        let limb = self.limb_from(body);
        let end =
            limb.last().map_or(f32::MAX, |&b| self.capsules[b].from.y.min(self.capsules[b].to.y));
        if end < self.low + 0.12 * (self.high - self.low) {
            return Limb::Leg;
        }
        let side = |b: usize| {
            let root = self.rest.positions[self.bodies[0].head];
            let away = self.rest.positions[self.bodies[b].head] - root;
            away.x.abs().max(if self.has_mirror_limb(b) { away.z.abs() } else { 0.0 })
        };
        let is_aside = side(first).max(side(*limb.last().unwrap_or(&body))) > 0.06 * self.rest.size;
        if is_aside && self.has_mirror_limb(first) { Limb::Arm } else { Limb::Axial }
    }

    /// Returns whether another limb of the same length starts at the same body.
    fn has_mirror_limb(&self, first: usize) -> bool {
        let length = self.limb_from(first).len();
        let siblings =
            (0..self.bodies.len()).filter(|&b| self.bodies[b].parent == self.bodies[first].parent);
        let mut candidates = siblings.filter(|&b| b != first && !self.is_trunk[b]);
        candidates.any(|b| self.limb_from(b).len() == length)
    }

    /// Returns the direction of a body's capsule.
    fn bone(&self, body: usize) -> Vector {
        let capsule = &self.capsules[body];
        (capsule.to - capsule.from).normalize_or(Vector::Y)
    }

    /// Returns the direction from the head of the parent body to the head of `body`.
    fn upper_bone(&self, body: usize) -> Vector {
        let parent = self.bodies[body].parent.unwrap_or(0);
        let span = self.rest.positions[self.bodies[body].head]
            - self.rest.positions[self.bodies[parent].head];
        span.normalize_or(Vector::Y)
    }

    /// Returns the kind of the joint at a body's head, from its name if known, else from its limb.
    fn joint_kind(&self, body: usize) -> Option<JointKind> {
        let head = self.bodies[body].head;
        let (index, length) = self.index_in_limb(body);
        let named = joint_kind_from_name(self.rest.skeleton.name(joint_index(head)));
        let is_last = index + 1 == length && length > 2;
        let shaped = match (self.limb(body), index) {
            (Limb::Axial, _) => None,
            (Limb::Leg, 0) => Some(JointKind::Hip),
            (Limb::Arm, 0) => Some(JointKind::Shoulder),
            (Limb::Leg, _) if is_last => Some(JointKind::Ankle),
            (Limb::Arm, _) if is_last => Some(JointKind::Wrist),
            (Limb::Leg, _) => Some(JointKind::Knee),
            (Limb::Arm, _) => Some(JointKind::Elbow),
        };
        // Forelegs of animals have the names of arms, but they reach the ground.
        match (named, shaped) {
            (Some(JointKind::Elbow), Some(JointKind::Knee))
            | (Some(JointKind::Shoulder), Some(JointKind::Hip)) => shaped,
            (Some(JointKind::Wrist), Some(JointKind::Ankle)) => shaped,
            _ => named.or(shaped),
        }
    }

    /// Returns the joint definition between a body and its parent.
    pub(super) fn joint_def(&self, body: usize) -> JointDef {
        let bone = self.bone(body);
        let away = self.capsules[body].from - self.rest.positions[self.bodies[0].head];
        let side = (away - self.front * away.dot(self.front)) * Vector::new(1.0, 0.0, 1.0);
        let side = side.normalize_or(Vector::ZERO);
        let degrees = |d: f32| d.to_radians();
        let cone = |centre: Vector, swing: f32, twist: f32| {
            self.cone(body, centre, degrees(swing), degrees(twist))
        };
        if self.is_trunk[body] {
            return cone(bone, 25.0, 25.0);
        }
        match self.joint_kind(body) {
            Some(JointKind::Knee) => self.hinge(body, self.upper_bone(body).cross(-self.front)),
            Some(JointKind::Elbow) => self.hinge(body, self.upper_bone(body).cross(self.front)),
            Some(JointKind::Hip) => {
                cone((self.front * 0.6 + side * 0.15 - Vector::Y).normalize(), 55.0, 35.0)
            }
            Some(JointKind::Shoulder) => {
                cone((side * 0.7 + self.front * 0.5 - Vector::Y * 0.5).normalize(), 80.0, 60.0)
            }
            Some(JointKind::Ankle) => cone(bone, 35.0, 20.0),
            Some(JointKind::Wrist) => cone(bone, 50.0, 60.0),
            None => cone(bone, 40.0, 45.0),
        }
    }

    /// Returns a cone joint with `swing` and `twist` in radians.
    fn cone(&self, body: usize, centre: Vector, swing: f32, twist: f32) -> JointDef {
        let bone = self.bone(body);
        // If the bone at rest is outside the usual cone of people, as with animals, the cone is
        // centred on the bone.
        let is_within = centre.angle_between(bone) < swing - 0.15;
        let centre = if is_within { centre } else { bone };
        let frame = Rotation::from_rotation_arc(Vector::X, centre);
        let child = Rotation::from_rotation_arc(centre, bone) * frame;
        let limits = Limits::Cone { swing_rad: swing, twist_rad: [-twist, twist] };
        self.joint_def_from_model(body, frame, child, limits)
    }

    /// Returns a hinge joint. Its axis is that of the bend at rest, or `usual_axis` if the limb is
    /// nearly straight.
    fn hinge(&self, body: usize, usual_axis: Vector) -> JointDef {
        let upper = self.upper_bone(body);
        let lower = self.bone(body);
        let bend = upper.angle_between(lower);
        let across = upper.cross(lower);
        let is_clear = (CLEAR_BEND_RAD..3.0).contains(&bend);
        let usual = usual_axis.normalize_or(upper.any_orthonormal_vector());
        let axis = if is_clear { across.normalize_or(usual) } else { usual };
        let bend = bend * axis.dot(across).signum();
        let frame = Rotation::from_rotation_arc(Vector::X, axis);
        let min_rad = -bend.max(0.0) - BEYOND_STRAIGHT_RAD;
        self.joint_def_from_model(
            body,
            frame,
            frame,
            Limits::Hinge { min_rad, max_rad: MAX_BEND_RAD - bend },
        )
    }

    /// Converts frames from model space to the spaces of the joints that they rotate with.
    fn joint_def_from_model(
        &self,
        body: usize,
        frame: Rotation,
        child: Rotation,
        limits: Limits,
    ) -> JointDef {
        let head = self.bodies[body].head;
        let parent = self.bodies[body].parent.unwrap_or(0);
        let carrier = self.rest.parents[head].unwrap_or(self.bodies[parent].head);
        JointDef {
            carrier,
            carrier_from_frame: self.rest.rotations[carrier].inverse() * frame,
            head_from_frame: self.rest.rotations[head].inverse() * child,
            limits,
        }
    }
}
