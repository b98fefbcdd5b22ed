//! Bodies and limits of a ragdoll, planned once per skeleton and shared by all members.

mod limits;
mod names;
mod rest;
mod select;
mod shape;

use populace::model::{JointIndex, Skeleton};

use crate::math::{Rotation, Vector, inverse_transform_point, joint_index};
use limits::Anatomy;
use rest::Rest;

/// Limits of a body's rotation against its parent body, in radians.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limits {
    /// Rotation about one axis, as of knees and elbows. 0 is the rest pose, and positive angles
    /// bend further.
    Hinge {
        /// Least angle.
        min_rad: f32,
        /// Greatest angle.
        max_rad: f32,
    },
    /// Swing in any direction within a cone, and twist about the body's own length.
    Cone {
        /// Largest angle between the body and the axis of the cone.
        swing_rad: f32,
        /// Least and greatest twist. 0 is the rest pose.
        twist_rad: [f32; 2],
    },
}

/// Definition of the joint between a body and its parent. The x axes of both frames lie along the
/// hinge axis or the cone axis.
#[derive(Clone, Debug)]
pub(crate) struct JointDef {
    /// Index of the skeleton joint that the upper frame rotates with.
    pub(crate) carrier: usize,
    pub(crate) carrier_from_frame: Rotation,
    pub(crate) head_from_frame: Rotation,
    pub(crate) limits: Limits,
}

/// A rigid body of a ragdoll: a capsule that moves one or more joints.
#[derive(Clone, Debug)]
pub struct PlannedBody {
    pub(crate) head: usize,
    pub(crate) parent: Option<usize>,
    /// Ends of the capsule's axis in the space of the head joint.
    pub(crate) from: Vector,
    pub(crate) to: Vector,
    pub(crate) length_m: f32,
    pub(crate) radius_m: f32,
    pub(crate) mass_kg: f32,
    /// Least radius of gyration. Thin capsules would have so little inertia that the solver could
    /// not enforce their limits.
    pub(crate) gyration_m: f32,
    /// `None` for the first body, which has no parent.
    pub(crate) joint_def: Option<JointDef>,
}

impl PlannedBody {
    /// Returns the joint at the head of the body, about which it rotates.
    #[must_use]
    pub fn joint(&self) -> JointIndex {
        joint_index(self.head)
    }

    /// Returns the index of the parent body in [`RagdollPlan::bodies`], or `None` for the first
    /// body.
    #[must_use]
    pub fn parent(&self) -> Option<usize> {
        self.parent
    }

    /// Returns the length of the capsule's axis in metres for a member of scale 1.
    #[must_use]
    pub fn length_m(&self) -> f32 {
        self.length_m
    }

    /// Returns the capsule's radius in metres for a member of scale 1.
    #[must_use]
    pub fn radius_m(&self) -> f32 {
        self.radius_m
    }

    /// Returns the mass in kg for a member of scale 1.
    #[must_use]
    pub fn mass_kg(&self) -> f32 {
        self.mass_kg
    }

    /// Returns the rotation limits, or `None` for the first body, which has no parent.
    #[must_use]
    pub fn limits(&self) -> Option<Limits> {
        self.joint_def.as_ref().map(|joint_def| joint_def.limits)
    }
}

/// Bodies, masses and limits of a ragdoll. They are derived from the skeleton alone: from the
/// positions of joints at rest, the reach of their vertices, and known words in joint names. Every
/// skeleton has a plan; a skeleton of a single joint gives a single body.
#[derive(Clone, Debug)]
pub struct RagdollPlan {
    bodies: Vec<PlannedBody>,
    body_of: Vec<Option<usize>>,
    /// Rotations of all joints at rest in model space.
    rest_rotations: Vec<Rotation>,
    rest_position: Vector,
}

impl RagdollPlan {
    /// Plans a ragdoll with a capsule for each significant bone. Fingers, twist joints and props
    /// belong to the body of their parents. A person of 1.8 m weighs 75 kg, and the mass of others
    /// is proportional to the cube of their size.
    #[must_use]
    pub fn from_skeleton(skeleton: &Skeleton) -> Self {
        let rest = Rest::new(skeleton);
        let (chosen, body_of) = select::select(&rest);
        let is_trunk = shape::trunk(&rest, &chosen);
        let capsules = shape::capsules(&rest, &chosen, &body_of, &is_trunk);
        let masses = shape::masses(&rest, &chosen, &capsules, &is_trunk);
        let anatomy = Anatomy::new(&rest, &chosen, &capsules, &is_trunk);
        let planned = |index: usize| {
            let (body, capsule) = (&chosen[index], &capsules[index]);
            let model_from_head = &rest.model_from_joint[body.head];
            PlannedBody {
                head: body.head,
                parent: body.parent,
                from: inverse_transform_point(model_from_head, capsule.from),
                to: inverse_transform_point(model_from_head, capsule.to),
                length_m: capsule.from.distance(capsule.to),
                radius_m: capsule.radius,
                mass_kg: masses[index],
                gyration_m: rest.size * if is_trunk[index] { 0.08 } else { 0.03 },
                joint_def: body.parent.map(|_| anatomy.joint_def(index)),
            }
        };
        let root = chosen[0].head;
        Self {
            bodies: (0..chosen.len()).map(planned).collect(),
            rest_position: rest.positions[root],
            rest_rotations: rest.rotations,
            body_of,
        }
    }

    /// Returns the bodies. Parents come before their children.
    #[must_use]
    pub fn bodies(&self) -> &[PlannedBody] {
        &self.bodies
    }

    /// Returns the index in [`bodies`](Self::bodies) of the body that moves `joint`. Returns `None`
    /// if there is none, as for joints above the first body.
    #[must_use]
    pub fn body_of(&self, joint: JointIndex) -> Option<usize> {
        self.body_of.get(joint.index()).copied().flatten()
    }

    /// Returns the mass of all bodies in kg for a member of scale 1.
    #[must_use]
    pub fn mass_kg(&self) -> f32 {
        self.bodies.iter().map(PlannedBody::mass_kg).sum()
    }

    /// Returns the number of joints of the skeleton that the plan was made from.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.body_of.len()
    }

    /// Returns rotation and position of the first body's joint at rest in model space.
    pub(crate) fn rest(&self) -> (Rotation, Vector) {
        (self.rest_rotations[self.bodies[0].head], self.rest_position)
    }

    /// Returns the rotation of a joint at rest in model space.
    pub(crate) fn rest_rotation(&self, joint: JointIndex) -> Rotation {
        self.rest_rotations.get(joint.index()).copied().unwrap_or(Rotation::IDENTITY)
    }

    /// Returns for each body whether it is `body` or one of its descendants.
    pub(crate) fn with_descendants(&self, body: usize) -> Vec<bool> {
        let mut included = vec![false; self.bodies.len()];
        included[body] = true;
        for index in body + 1..self.bodies.len() {
            included[index] = self.bodies[index].parent.is_some_and(|p| included[p]);
        }
        included
    }
}
