//! What a ragdoll is made of, planned once for a skeleton and shared by all its members.

mod limits;
mod names;
mod rest;
mod select;
mod shape;

use populace::model::{JointIndex, Skeleton};

use crate::math::{Rotation, Vector, joint_index, point_before};
use limits::Anatomy;
use rest::Rest;

/// How far a body may turn against the one that it hangs on, in radians.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limits {
    /// About one axis, as knees and elbows do; 0 is the rest pose, and positive angles bend
    /// further.
    Hinge {
        /// The least angle.
        min_rad: f32,
        /// The greatest.
        max_rad: f32,
    },
    /// Away from the middle of a cone in any direction, and about its own length.
    Cone {
        /// The most that the body may swing from the cone's middle.
        swing_rad: f32,
        /// The least and the most that it may turn about its length; 0 is the rest pose.
        twist_rad: [f32; 2],
    },
}

/// How a body hangs on another: the frames whose x axes a hinge or a cone's middle lie along.
#[derive(Clone, Debug)]
pub(crate) struct Hold {
    /// The joint whose turns carry the upper frame along.
    pub(crate) carrier: usize,
    pub(crate) carrier_from_frame: Rotation,
    pub(crate) head_from_frame: Rotation,
    pub(crate) limits: Limits,
}

/// A rigid part of a ragdoll: a capsule, carrying one joint or several.
#[derive(Clone, Debug)]
pub struct PlannedBody {
    pub(crate) head: usize,
    pub(crate) parent: Option<usize>,
    /// The capsule's ends in the head joint's own space.
    pub(crate) from: Vector,
    pub(crate) to: Vector,
    pub(crate) length_m: f32,
    pub(crate) radius_m: f32,
    pub(crate) mass_kg: f32,
    /// The least radius of gyration: no body is as easily turned as a thin capsule would be, since
    /// limits could not hold what turns that lightly.
    pub(crate) gyration_m: f32,
    /// `None` for the first body, which nothing holds.
    pub(crate) hold: Option<Hold>,
}

impl PlannedBody {
    /// The joint at which the body begins, and about which it turns.
    #[must_use]
    pub fn joint(&self) -> JointIndex {
        joint_index(self.head)
    }

    /// The body that it hangs on, by its place in [`RagdollPlan::bodies`]; `None` for the first.
    #[must_use]
    pub fn parent(&self) -> Option<usize> {
        self.parent
    }

    /// From one end of the capsule's axis to the other, in metres, for a member of scale 1.
    #[must_use]
    pub fn length_m(&self) -> f32 {
        self.length_m
    }

    /// The capsule's radius in metres, for a member of scale 1.
    #[must_use]
    pub fn radius_m(&self) -> f32 {
        self.radius_m
    }

    /// Its mass in kg, for a member of scale 1.
    #[must_use]
    pub fn mass_kg(&self) -> f32 {
        self.mass_kg
    }

    /// How far it may turn; `None` for the first body, which nothing holds.
    #[must_use]
    pub fn limits(&self) -> Option<Limits> {
        self.hold.as_ref().map(|hold| hold.limits)
    }
}

/// Bodies, masses and limits of a ragdoll, found from a skeleton alone: from where its joints lie
/// at rest, how far they move vertices, and what their names tell where they tell something. Any
/// skeleton has one; one of a single joint is a single body.
#[derive(Clone, Debug)]
pub struct RagdollPlan {
    bodies: Vec<PlannedBody>,
    body_of: Vec<Option<usize>>,
    rest_turn: Rotation,
    rest_place: Vector,
}

impl RagdollPlan {
    /// Plans a ragdoll: a capsule for each bone that matters, with fingers, twists and props as
    /// part of the body that they hang on. A person of 1.8 m weighs 75 kg; others go by the cube of
    /// their size.
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
                from: point_before(model_from_head, capsule.from),
                to: point_before(model_from_head, capsule.to),
                length_m: capsule.from.distance(capsule.to),
                radius_m: capsule.radius,
                mass_kg: masses[index],
                gyration_m: rest.size * if is_trunk[index] { 0.08 } else { 0.03 },
                hold: body.parent.map(|_| anatomy.hold(index)),
            }
        };
        let root = chosen[0].head;
        Self {
            bodies: (0..chosen.len()).map(planned).collect(),
            rest_turn: rest.turns[root],
            rest_place: rest.places[root],
            body_of,
        }
    }

    /// The bodies, each after the one that it hangs on.
    #[must_use]
    pub fn bodies(&self) -> &[PlannedBody] {
        &self.bodies
    }

    /// The body that carries a joint, by its place in [`bodies`](Self::bodies); `None` where none
    /// does, as above the first body's joint.
    #[must_use]
    pub fn body_of(&self, joint: JointIndex) -> Option<usize> {
        self.body_of.get(joint.index()).copied().flatten()
    }

    /// The mass of all bodies in kg, for a member of scale 1.
    #[must_use]
    pub fn mass_kg(&self) -> f32 {
        self.bodies.iter().map(PlannedBody::mass_kg).sum()
    }

    /// Joints of the skeleton that this was planned from.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.body_of.len()
    }

    /// The first body's joint at rest in model space: its turn and its place.
    pub(crate) fn rest(&self) -> (Rotation, Vector) {
        (self.rest_turn, self.rest_place)
    }

    /// A body and all that hang on it.
    pub(crate) fn with_all_below(&self, body: usize) -> Vec<bool> {
        let mut below = vec![false; self.bodies.len()];
        below[body] = true;
        for index in body + 1..self.bodies.len() {
            below[index] = self.bodies[index].parent.is_some_and(|p| below[p]);
        }
        below
    }
}
