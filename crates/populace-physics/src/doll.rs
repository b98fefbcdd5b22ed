//! One member's ragdoll: its bodies in the simulated world, and the joints that they carry.

mod build;
mod get_up;
mod overrides;

use std::sync::Arc;

use populace::Member;
use populace::model::Trs;
use rapier3d::prelude::{ImpulseJointHandle, RigidBody, RigidBodyHandle};

use crate::math::{Pose, Rotation, Vector, turn_between, twist_and_swing};
use crate::snapshot::{FASTEST_M_PER_SEC, Snapshot};
use crate::world::{Driven, World};
use crate::{Limits, RagdollPlan};

pub(crate) use build::Recipe;

/// As [`FASTEST_M_PER_SEC`], for turns.
const FASTEST_RAD_PER_SEC: f32 = 40.0;

/// For how long one who gets up still holds out against constraints, such as planted feet.
const GRIP_SECS: f32 = 0.3;

/// A joint that a limp body carries.
struct Carried {
    joint: usize,
    body: usize,
    /// The joint's turn against its body's.
    body_from_joint: Rotation,
    /// Its parent, where a body carries that.
    parent: Option<usize>,
    /// As it was at the start, relative to its parent, or to the model where no body carries the
    /// parent.
    start: Trs,
    /// Its place in the body, in the world's metres; only used without such a parent.
    place_in_body: Vector,
    /// From the joint's turn to the rotation of its model transform; they differ where scales
    /// shear.
    turn_to_model: Rotation,
}

/// A body held by another.
struct Held {
    joint: ImpulseJointHandle,
    limits: Limits,
    parent_from_frame: Rotation,
    body_from_frame: Rotation,
}

/// On the way back to clips.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fade {
    pub(crate) elapsed_secs: f32,
    pub(crate) over_secs: f32,
}

impl Fade {
    /// What is left of the ragdoll's weight: eased at both ends, 0 once it is over.
    pub(crate) fn weight(&self) -> f32 {
        self.left(self.over_secs)
    }

    /// What is left of its hold against constraints.
    fn grip(&self) -> f32 {
        self.left(self.over_secs.min(GRIP_SECS))
    }

    fn left(&self, over_secs: f32) -> f32 {
        if self.elapsed_secs >= over_secs {
            return 0.0;
        }
        let t = self.elapsed_secs / over_secs;
        1.0 - t * t * (3.0 - 2.0 * t)
    }
}

pub(crate) struct Doll {
    pub(crate) member: Member,
    pub(crate) plan: Arc<RagdollPlan>,
    pub(crate) id: u64,
    /// Which bodies of the plan are limp; the others follow the clips.
    pub(crate) limp: Vec<bool>,
    bodies: Vec<RigidBodyHandle>,
    held: Vec<Option<Held>>,
    carried: Vec<Carried>,
    /// The last reading, and how long it was after the one before.
    last: Snapshot,
    last_dt_secs: f32,
    pub(crate) fade: Option<Fade>,
    /// What overrides were last written for, while nothing moves.
    settled_at: Option<populace::Placement>,
}

impl Doll {
    pub(crate) fn is_whole(&self) -> bool {
        self.limp.iter().all(|l| *l)
    }

    pub(crate) fn weight(&self) -> f32 {
        self.fade.map_or(1.0, |fade| fade.weight())
    }

    pub(crate) fn remove(&self, world: &mut World) {
        world.remove(self.id, &self.bodies);
    }

    /// Where the bodies that follow clips go in the coming frame: as far again as in the last one,
    /// since the clips have not been evaluated for it yet.
    pub(crate) fn drive(&mut self, world: &World, now: Snapshot, dt_secs: f32) -> Vec<Driven> {
        let mut driven = Vec::new();
        let times = dt_secs / self.last_dt_secs;
        for (index, body) in self.plan.bodies().iter().enumerate().filter(|(i, _)| !self.limp[*i]) {
            let Some(from) = world.physics.bodies.get(self.bodies[index]).map(|b| *b.position())
            else {
                continue;
            };
            let to = ahead(&self.last.pose(body.head), &now.pose(body.head), times, dt_secs);
            driven.push(Driven { body: self.bodies[index], from, to });
        }
        self.last = now;
        self.last_dt_secs = dt_secs;
        driven
    }

    /// The limp bodies in the world.
    fn limp_bodies<'a>(&'a self, world: &'a World) -> impl Iterator<Item = &'a RigidBody> {
        let limp = self.bodies.iter().zip(&self.limp).filter(|(_, limp)| **limp);
        limp.filter_map(|(body, _)| world.physics.bodies.get(*body))
    }

    pub(crate) fn is_asleep(&self, world: &World) -> bool {
        self.limp_bodies(world).all(RigidBody::is_sleeping)
    }

    /// Kinetic and potential energy of the limp bodies, in joules; height 0 is where the latter is
    /// 0.
    pub(crate) fn energy_j(&self, world: &World) -> f32 {
        let gravity = world.physics.gravity;
        let one = |b: &RigidBody| b.kinetic_energy() - b.mass() * gravity.dot(b.center_of_mass());
        self.limp_bodies(world).map(one).sum()
    }

    /// A body's pose: that of the joint at its head, without scale.
    fn pose(&self, world: &World, body: usize) -> Pose {
        world.physics.bodies.get(self.bodies[body]).map_or(Pose::IDENTITY, |b| *b.position())
    }

    pub(crate) fn root_pose(&self, world: &World) -> Pose {
        self.pose(world, 0)
    }

    pub(crate) fn body_mut<'a>(
        &self,
        world: &'a mut World,
        body: usize,
    ) -> Option<&'a mut RigidBody> {
        world.physics.bodies.get_mut(self.bodies[body]).filter(|_| self.limp[body])
    }

    /// How each held body is bent, with its limits.
    pub(crate) fn bends<'a>(&'a self, world: &'a World) -> impl Iterator<Item = Bend> + 'a {
        self.held.iter().enumerate().filter_map(|(index, held)| {
            let held = held.as_ref()?;
            let parent = self.plan.bodies()[index].parent?;
            let upper = self.pose(world, parent).rotation * held.parent_from_frame;
            let lower = self.pose(world, index).rotation * held.body_from_frame;
            let (twist_rad, swing_rad) = twist_and_swing(upper.inverse() * lower, Vector::X);
            world.physics.impulse_joints.get(held.joint)?;
            Some(Bend { body: index, twist_rad, swing_rad, limits: held.limits })
        })
    }
}

/// How far a body is turned against the one that it hangs on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// The body, by its place in [`RagdollPlan::bodies`].
    pub body: usize,
    /// About the hinge's axis or the body's own length, in radians.
    pub twist_rad: f32,
    /// From the cone's middle, in radians; for a hinge, how far its axis is bent, which should be
    /// 0.
    pub swing_rad: f32,
    /// What holds it: the plan's limits, widened where the body was already beyond them when it
    /// went limp.
    pub limits: Limits,
}

/// So many times as far again as from `before` to `now`, or no further where that would be faster
/// than anything goes.
fn ahead(before: &Pose, now: &Pose, times: f32, dt_secs: f32) -> Pose {
    let step = (now.translation - before.translation) * times;
    let turn = turn_between(before.rotation, now.rotation) * times;
    if step.length() > FASTEST_M_PER_SEC * dt_secs || turn.length() > FASTEST_RAD_PER_SEC * dt_secs
    {
        return *now;
    }
    Pose::from_parts(
        now.translation + step,
        (Rotation::from_scaled_axis(turn) * now.rotation).normalize(),
    )
}
