//! The ragdoll of one member: its bodies in the simulated world and the joints that they move.

mod build;
mod ease;
mod get_up;
mod overrides;

use std::sync::Arc;

use populace::MemberId;
use populace::model::Trs;
use rapier3d::prelude::{ImpulseJointHandle, RigidBody, RigidBodyHandle};

use crate::math::{Pose, Rotation, Vector, rotation_vector_between, twist_and_swing};
use crate::snapshot::{FASTEST_M_PER_SEC, Snapshot};
use crate::world::{KinematicMove, World};
use crate::{Limits, RagdollPlan};

pub(crate) use build::BuildParams;
pub(crate) use ease::Ease;

/// Largest plausible angular velocity, like [`FASTEST_M_PER_SEC`] for linear velocity.
const FASTEST_RAD_PER_SEC: f32 = 40.0;

/// Time in seconds from the start of getting up during which model-space overrides still prevail
/// over constraints such as planted feet.
const MODEL_OVERRIDE_SECS: f32 = 0.3;

/// A joint that is moved by a limp body.
#[derive(Clone)]
struct CarriedJoint {
    joint: usize,
    body: usize,
    /// Rotation of the joint relative to its body.
    body_from_joint: Rotation,
    /// The parent joint, if a body moves it.
    parent: Option<usize>,
    /// Initial transform of the joint, relative to `parent`, or in model space if `parent` is
    /// `None`.
    start: Trs,
    /// Position of the joint in the space of the body, in metres of the world. Used only if
    /// `parent` is `None`.
    position_in_body: Vector,
    /// From the joint's rotation down the hierarchy to the rotation of its model transform. The two
    /// differ if scales cause shear.
    rotation_to_model: Rotation,
}

/// The physics joint between a body and its parent body.
#[derive(Clone)]
struct BodyConstraint {
    joint: ImpulseJointHandle,
    limits: Limits,
    parent_from_frame: Rotation,
    body_from_frame: Rotation,
}

/// Progress of the blend back to the clips.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fade {
    pub(crate) elapsed_secs: f32,
    pub(crate) over_secs: f32,
}

impl Fade {
    /// Returns the remaining weight of the ragdoll, eased in and out. 0 once the blend has ended.
    pub(crate) fn weight(&self) -> f32 {
        self.remaining(self.over_secs)
    }

    /// Returns the weight of the model-space overrides, which fade out within
    /// [`MODEL_OVERRIDE_SECS`].
    fn model_override_weight(&self) -> f32 {
        self.remaining(self.over_secs.min(MODEL_OVERRIDE_SECS))
    }

    /// Returns 1 minus the smoothstep of the elapsed fraction of `over_secs`.
    fn remaining(&self, over_secs: f32) -> f32 {
        if self.elapsed_secs >= over_secs {
            return 0.0;
        }
        let t = self.elapsed_secs / over_secs;
        1.0 - t * t * (3.0 - 2.0 * t)
    }
}

/// The ragdoll of one member.
#[derive(Clone)]
pub(crate) struct MemberRagdoll {
    pub(crate) member: MemberId,
    pub(crate) plan: Arc<RagdollPlan>,
    pub(crate) id: u64,
    /// Whether each body of the plan is limp. The others follow the clips.
    pub(crate) limp: Vec<bool>,
    bodies: Vec<RigidBodyHandle>,
    constraints: Vec<Option<BodyConstraint>>,
    carried: Vec<CarriedJoint>,
    /// The last snapshot, and the time from the one before in seconds.
    last: Snapshot,
    last_dt_secs: f32,
    pub(crate) fade: Option<Fade>,
    /// The placement for which overrides were last written, while all bodies are asleep.
    resting_placement: Option<populace::Placement>,
}

impl MemberRagdoll {
    /// Returns whether all bodies are limp.
    pub(crate) fn is_fully_limp(&self) -> bool {
        self.limp.iter().all(|l| *l)
    }

    /// Returns the weight of the overrides: 1, or less while the member gets up.
    pub(crate) fn weight(&self) -> f32 {
        self.fade.map_or(1.0, |fade| fade.weight())
    }

    /// Removes all bodies from the world.
    pub(crate) fn remove(&self, world: &mut World) {
        world.remove(self.id, &self.bodies);
    }

    /// Returns the motion of the bodies that follow clips for the coming frame. It continues that
    /// of the last frame, because the clips have not been evaluated for this frame yet.
    pub(crate) fn kinematic_moves(
        &mut self,
        world: &World,
        now: Snapshot,
        dt_secs: f32,
    ) -> Vec<KinematicMove> {
        let mut moves = Vec::new();
        let times = dt_secs / self.last_dt_secs;
        for (index, body) in self.plan.bodies().iter().enumerate().filter(|(i, _)| !self.limp[*i]) {
            let Some(from) = world.physics.bodies.get(self.bodies[index]).map(|b| *b.position())
            else {
                continue;
            };
            let to = extrapolate(&self.last.pose(body.head), &now.pose(body.head), times, dt_secs);
            moves.push(KinematicMove { body: self.bodies[index], from, to });
        }
        self.last = now;
        self.last_dt_secs = dt_secs;
        moves
    }

    /// Returns the limp bodies in the world.
    fn limp_bodies<'a>(&'a self, world: &'a World) -> impl Iterator<Item = &'a RigidBody> {
        let limp = self.bodies.iter().zip(&self.limp).filter(|(_, limp)| **limp);
        limp.filter_map(|(body, _)| world.physics.bodies.get(*body))
    }

    /// Returns whether all limp bodies are at rest.
    pub(crate) fn is_asleep(&self, world: &World) -> bool {
        self.limp_bodies(world).all(RigidBody::is_sleeping)
    }

    /// Returns the kinetic plus potential energy of the limp bodies in joules. The potential energy
    /// is relative to height 0.
    pub(crate) fn energy_j(&self, world: &World) -> f32 {
        let gravity = world.physics.gravity;
        let one = |b: &RigidBody| b.kinetic_energy() - b.mass() * gravity.dot(b.center_of_mass());
        self.limp_bodies(world).map(one).sum()
    }

    /// Returns the pose of a body, which is that of its head joint without scale.
    fn pose(&self, world: &World, body: usize) -> Pose {
        world.physics.bodies.get(self.bodies[body]).map_or(Pose::IDENTITY, |b| *b.position())
    }

    /// Returns the pose of the first body.
    pub(crate) fn root_pose(&self, world: &World) -> Pose {
        self.pose(world, 0)
    }

    /// Returns a body for changes, or `None` if it is not limp.
    pub(crate) fn body_mut<'a>(
        &self,
        world: &'a mut World,
        body: usize,
    ) -> Option<&'a mut RigidBody> {
        world.physics.bodies.get_mut(self.bodies[body]).filter(|_| self.limp[body])
    }

    /// Returns the angles of each limp body with a parent, and their limits.
    pub(crate) fn joint_angles<'a>(
        &'a self,
        world: &'a World,
    ) -> impl Iterator<Item = JointAngles> + 'a {
        self.constraints.iter().enumerate().filter_map(|(index, constraint)| {
            let constraint = constraint.as_ref()?;
            let parent = self.plan.bodies()[index].parent?;
            let upper = self.pose(world, parent).rotation * constraint.parent_from_frame;
            let lower = self.pose(world, index).rotation * constraint.body_from_frame;
            let (twist_rad, swing_rad) = twist_and_swing(upper.inverse() * lower, Vector::X);
            world.physics.impulse_joints.get(constraint.joint)?;
            Some(JointAngles { body: index, twist_rad, swing_rad, limits: constraint.limits })
        })
    }
}

/// Rotation of a body against its parent body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointAngles {
    /// Index of the body in [`RagdollPlan::bodies`].
    pub body: usize,
    /// Rotation about the hinge axis or the body's own length, in radians.
    pub twist_rad: f32,
    /// Angle to the cone axis in radians. For a hinge, the deviation of its axis, which should be
    /// 0.
    pub swing_rad: f32,
    /// Limits of the simulation: those of the plan, widened if the body already exceeded them when
    /// it went limp.
    pub limits: Limits,
}

/// Extrapolates `now` by `times` the motion from `before` to `now`. Returns `now` if the result
/// would be implausibly fast.
fn extrapolate(before: &Pose, now: &Pose, times: f32, dt_secs: f32) -> Pose {
    let step = (now.translation - before.translation) * times;
    let rotation = rotation_vector_between(before.rotation, now.rotation) * times;
    if step.length() > FASTEST_M_PER_SEC * dt_secs
        || rotation.length() > FASTEST_RAD_PER_SEC * dt_secs
    {
        return *now;
    }
    Pose::from_parts(
        now.translation + step,
        (Rotation::from_scaled_axis(rotation) * now.rotation).normalize(),
    )
}
