//! The simulated world: fixed obstacles, collision filter and time steps.

use std::collections::HashMap;

use rapier3d::na::Unit;
use rapier3d::prelude::{
    ActiveHooks, Collider, ColliderBuilder, ColliderHandle, Group, InteractionGroups,
    InteractionTestMode, PairFilterContext, PhysicsHooks, PhysicsWorld, QueryFilter, Ray,
    RigidBodyBuilder, RigidBodyHandle, SolverFlags,
};

use crate::math::{Pose, Rotation, Vector};

/// Longest simulation step in seconds. Longer frames are divided into equal steps.
const LONGEST_STEP_SECS: f32 = 1.0 / 120.0;
/// Longest simulated part of a frame in seconds, so that one slow frame does not cause another.
const LONGEST_FRAME_SECS: f32 = 0.5;
/// Friction coefficient of cloth and skin on a floor.
const FRICTION: f32 = 0.8;

/// Motion of a kinematic body in the coming frame.
pub(crate) struct KinematicMove {
    pub(crate) body: RigidBodyHandle,
    pub(crate) from: Pose,
    pub(crate) to: Pose,
}

/// Pairs of bodies of each ragdoll that do not collide, because they are connected or overlap from
/// the start.
#[derive(Clone, Default)]
struct Overlaps {
    by_ragdoll: HashMap<u64, Vec<(u16, u16)>>,
}

impl PhysicsHooks for Overlaps {
    fn filter_contact_pair(&self, context: &PairFilterContext) -> Option<SolverFlags> {
        let [a, b] =
            [context.collider1, context.collider2].map(|c| context.colliders.get(c).map(owner));
        let (Some((ragdoll, a)), Some((other, b))) = (a?, b?) else {
            return Some(SolverFlags::default());
        };
        let overlap = ragdoll == other
            && self.by_ragdoll.get(&ragdoll).is_some_and(|o| o.contains(&(a.min(b), a.max(b))));
        (!overlap).then(SolverFlags::default)
    }
}

/// Returns the ragdoll and the body index of a collider; `None` for fixed colliders.
fn owner(collider: &Collider) -> Option<(u64, u16)> {
    #[expect(clippy::cast_possible_truncation, reason = "packed by `pack_owner`")]
    let unpacked = ((collider.user_data >> 16) as u64, collider.user_data as u16);
    (collider.user_data != 0).then_some(unpacked)
}

/// Packs ragdoll and body index into user data. Ragdoll ids start at 1, so 0 means a fixed
/// collider.
pub(crate) fn pack_owner(ragdoll: u64, body: usize) -> u128 {
    u128::from(ragdoll) << 16 | body as u128 & 0xffff
}

/// Rapier's world with the floor and a collision filter.
pub(crate) struct World {
    pub(crate) physics: PhysicsWorld,
    overlaps: Overlaps,
    ground: ColliderHandle,
}

impl Clone for World {
    fn clone(&self) -> Self {
        let from = &self.physics;
        // The pipelines and the solver of continuous collisions are memory for work alone.
        let physics = PhysicsWorld {
            gravity: from.gravity,
            integration_parameters: from.integration_parameters,
            islands: from.islands.clone(),
            broad_phase: from.broad_phase.clone(),
            narrow_phase: from.narrow_phase.clone(),
            bodies: from.bodies.clone(),
            colliders: from.colliders.clone(),
            impulse_joints: from.impulse_joints.clone(),
            multibody_joints: from.multibody_joints.clone(),
            ..PhysicsWorld::new()
        };
        Self { physics, overlaps: self.overlaps.clone(), ground: self.ground }
    }
}

impl World {
    pub(crate) fn new(gravity: Vector) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = gravity;
        let parameters = &mut physics.integration_parameters;
        // Limbs are chains of light bodies on heavy ones, which converge slowly.
        parameters.num_solver_iterations = 12;
        // Bodies that start inside the ground leave it slowly.
        parameters.normalized_max_corrective_velocity = 10.0;
        let ground =
            ColliderBuilder::halfspace(Unit::new_unchecked(Vector::Y)).friction(FRICTION).build();
        let ground = physics.insert_collider(ground, None);
        Self { physics, overlaps: Overlaps::default(), ground }
    }

    pub(crate) fn set_ground(&mut self, height: f32) {
        if let Some(ground) = self.physics.colliders.get_mut(self.ground) {
            ground.set_translation(Vector::new(0.0, height, 0.0));
        }
    }

    pub(crate) fn add_box(&mut self, centre: Vector, half_sides: Vector, yaw_rad: f32) {
        let pose = Pose::from_parts(centre, Rotation::from_rotation_y(yaw_rad));
        let [x, y, z] = half_sides.to_array();
        self.physics.insert_collider(
            ColliderBuilder::cuboid(x, y, z).position(pose).friction(FRICTION),
            None,
        );
    }

    pub(crate) fn add_body(
        &mut self,
        body: RigidBodyBuilder,
        shape: ColliderBuilder,
    ) -> RigidBodyHandle {
        let body = self.physics.insert_body(body.build());
        let everything = InteractionGroups::new(Group::ALL, Group::ALL, InteractionTestMode::And);
        let hooks = ActiveHooks::FILTER_CONTACT_PAIRS;
        let shape = shape.friction(FRICTION).collision_groups(everything).active_hooks(hooks);
        self.physics.insert_collider(shape, Some(body));
        body
    }

    /// Sets the pairs of bodies of a ragdoll that do not collide, the lower index first.
    pub(crate) fn set_overlaps(&mut self, ragdoll: u64, pairs: Vec<(u16, u16)>) {
        self.overlaps.by_ragdoll.insert(ragdoll, pairs);
    }

    /// Removes a ragdoll and its bodies.
    pub(crate) fn remove(&mut self, ragdoll: u64, bodies: &[RigidBodyHandle]) {
        self.overlaps.by_ragdoll.remove(&ragdoll);
        for &body in bodies {
            self.physics.remove_body(body);
        }
    }

    /// Advances by one frame in equal steps.
    pub(crate) fn step(&mut self, dt_secs: f32, moves: &[KinematicMove]) {
        let frame = dt_secs.min(LONGEST_FRAME_SECS);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to 60")]
        let steps = (frame / LONGEST_STEP_SECS - 1e-3).ceil().max(1.0) as u32;
        self.physics.integration_parameters.dt = frame / steps as f32;
        for step in 1..=steps {
            let part = step as f32 / steps as f32;
            for target in moves {
                if let Some(body) = self.physics.bodies.get_mut(target.body) {
                    body.set_next_kinematic_position(target.from.lerp(&target.to, part));
                }
            }
            self.physics.step_with_events(&self.overlaps, &());
        }
    }

    /// Returns the height of the topmost fixed collider below `point`, within `reach` metres.
    pub(crate) fn floor_height_below(&self, point: Vector, reach: f32) -> Option<f32> {
        let ray = Ray::new(point, -Vector::Y);
        let filter = QueryFilter::only_fixed();
        self.physics.cast_ray(&ray, reach, true, filter).map(|(_, depth)| point.y - depth)
    }
}
