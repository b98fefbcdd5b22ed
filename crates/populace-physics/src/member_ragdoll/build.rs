//! Creation of a ragdoll with the pose and velocity of its member.

use std::sync::Arc;

use populace::model::{JointIndex, Skeleton};
use populace::{Affine, MemberId};
use rapier3d::prelude::{
    ColliderBuilder, GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MassProperties,
    RigidBodyBuilder, RigidBodyHandle,
};

use super::{BodyConstraint, CarriedJoint, FASTEST_RAD_PER_SEC, MemberRagdoll};
use crate::math::{
    Pose, Rotation, Vector, local, rotation_of, rotation_vector_between, trs, twist_and_swing,
    yaw_rotation,
};
use crate::plan::JointDef;
use crate::snapshot::{FASTEST_M_PER_SEC, Snapshot};
use crate::world::{World, pack_owner};
use crate::{Limits, RagdollPlan};

/// Fraction of the velocity that is lost per second, approximately.
const LINEAR_DAMPING_PER_SEC: f32 = 0.05;
const ANGULAR_DAMPING_PER_SEC: f32 = 1.0;
/// Least moment of inertia of a body, relative to its greatest.
const LEAST_INERTIA: f32 = 0.3;
/// Factor on the sum of two radii. Bodies whose axes are nearer than that at the start never
/// collide with each other.
const OVERLAP_FACTOR: f32 = 1.05;
/// Slack in radians that is added to limits that the clip exceeds when the member goes limp.
const SLACK_RAD: f32 = 0.01;

/// The inputs for a ragdoll.
pub(crate) struct BuildParams<'a> {
    pub(crate) member: MemberId,
    pub(crate) skeleton: &'a Skeleton,
    pub(crate) plan: &'a Arc<RagdollPlan>,
    pub(crate) id: u64,
    pub(crate) limp: Vec<bool>,
    pub(crate) before: &'a Snapshot,
    pub(crate) now: Snapshot,
    /// Time from `before` to `now`.
    pub(crate) dt_secs: f32,
}

/// A capsule in world space.
#[derive(Clone, Copy)]
struct Capsule {
    from: Vector,
    to: Vector,
    radius: f32,
}

impl MemberRagdoll {
    /// Adds bodies and joints of a ragdoll to the world.
    pub(crate) fn build(params: BuildParams, world: &mut World) -> Self {
        let plan = params.plan;
        let capsules: Vec<Capsule> =
            (0..plan.bodies().len()).map(|b| capsule(&params, world, b)).collect();
        let bodies: Vec<_> =
            (0..capsules.len()).map(|b| add_body(&params, world, b, &capsules[b])).collect();
        world.set_overlaps(params.id, overlaps(plan, &capsules));
        let constraints =
            (0..capsules.len()).map(|b| connect(&params, world, &bodies, b)).collect();
        let carried = params.skeleton.joints().filter_map(|j| carried_joint(&params, j)).collect();
        Self {
            member: params.member,
            plan: Arc::clone(plan),
            id: params.id,
            limp: params.limp,
            bodies,
            constraints,
            carried,
            last: params.before.clone(),
            last_dt_secs: params.dt_secs,
            fade: None,
            resting_placement: None,
        }
    }
}

/// Returns the current capsule of a body, with the radius reduced to its distance from the floor.
fn capsule(params: &BuildParams, world: &World, body: usize) -> Capsule {
    let body = &params.plan.bodies()[body];
    let from = params.now.point(body.head, body.from);
    let to = params.now.point(body.head, body.to);
    let scale = params.now.placement.scale();
    let radius = body.radius_m * scale;
    let low = if from.y < to.y { from } else { to };
    let clear = world
        .floor_height_below(low + Vector::Y * radius, 2.0 * radius)
        .map_or(radius, |floor| low.y - floor);
    Capsule { from, to, radius: radius.min(clear).max(0.4 * radius).max(1e-4) }
}

/// Adds a body to the world: dynamic with the velocity of the clip if it is limp, else kinematic.
fn add_body(
    params: &BuildParams,
    world: &mut World,
    index: usize,
    capsule: &Capsule,
) -> RigidBodyHandle {
    let body = &params.plan.bodies()[index];
    let before = params.before.pose(body.head);
    let now = params.now.pose(body.head);
    let from = now.inverse_transform_point(capsule.from);
    let to = now.inverse_transform_point(capsule.to);
    let scale = params.now.placement.scale();
    let mass_kg = (body.mass_kg * scale * scale * scale).max(1e-6);
    let shape = ColliderBuilder::capsule_from_endpoints(from, to, capsule.radius)
        .mass_properties(mass_properties(
            from,
            to,
            capsule.radius,
            mass_kg,
            body.gyration_m * scale,
        ))
        .user_data(pack_owner(params.id, index));
    if !params.limp[index] {
        return world.add_body(RigidBodyBuilder::kinematic_position_based().pose(now), shape);
    }
    let middle = (from + to) * 0.5;
    let step = now.transform_point(middle) - before.transform_point(middle);
    let rotation = rotation_vector_between(before.rotation, now.rotation);
    let dynamic = RigidBodyBuilder::dynamic()
        .pose(now)
        .linvel((step / params.dt_secs).clamp_length_max(FASTEST_M_PER_SEC))
        .angvel((rotation / params.dt_secs).clamp_length_max(FASTEST_RAD_PER_SEC))
        .linear_damping(LINEAR_DAMPING_PER_SEC)
        .angular_damping(ANGULAR_DAMPING_PER_SEC);
    world.add_body(dynamic, shape)
}

/// Returns the mass properties of the capsule, with its moments of inertia raised to a minimum.
fn mass_properties(
    from: Vector,
    to: Vector,
    radius: f32,
    mass_kg: f32,
    gyration: f32,
) -> MassProperties {
    let mut properties = MassProperties::from_capsule(1.0, from, to, radius);
    properties.set_mass(mass_kg, true);
    let inertia = properties.principal_inertia();
    let least = (LEAST_INERTIA * inertia.max_element()).max(mass_kg * gyration * gyration);
    let frame = properties.principal_inertia_local_frame;
    let raised = inertia.max(Vector::splat(least));
    MassProperties::with_principal_inertia_frame(properties.local_com, mass_kg, raised, frame)
}

/// Returns the pairs of bodies that never collide: those that are connected or overlap now.
fn overlaps(plan: &RagdollPlan, capsules: &[Capsule]) -> Vec<(u16, u16)> {
    let mut pairs = Vec::new();
    for (b, two) in (0u16..).zip(capsules) {
        for (a, one) in (0..b).zip(capsules) {
            let is_parent = plan.bodies()[usize::from(b)].parent == Some(usize::from(a));
            if is_parent || axis_distance(one, two) < OVERLAP_FACTOR * (one.radius + two.radius) {
                pairs.push((a, b));
            }
        }
    }
    pairs
}

/// Returns the distance between the axes of two capsules (Ericson, Real-Time Collision Detection,
/// 2005, section 5.1.9).
fn axis_distance(one: &Capsule, two: &Capsule) -> f32 {
    let (d1, d2, r) = (one.to - one.from, two.to - two.from, one.from - two.from);
    let (a, e, f) = (d1.dot(d1).max(1e-12), d2.dot(d2).max(1e-12), d2.dot(r));
    let (c, b) = (d1.dot(r), d1.dot(d2));
    let across = a * e - b * b;
    let mut s =
        if across > 1e-9 * a * e { ((b * f - c * e) / across).clamp(0.0, 1.0) } else { 0.0 };
    let t = ((b * s + f) / e).clamp(0.0, 1.0);
    s = ((b * t - c) / a).clamp(0.0, 1.0);
    (one.from + d1 * s).distance(two.from + d2 * t)
}

/// Connects a limp body to its parent at their current poses.
fn connect(
    params: &BuildParams,
    world: &mut World,
    bodies: &[RigidBodyHandle],
    index: usize,
) -> Option<BodyConstraint> {
    let body = &params.plan.bodies()[index];
    let (plan, parent) = (body.joint_def.as_ref()?, body.parent?);
    if !params.limp[index] {
        return None;
    }
    let now = params.now.pose(body.head);
    let upper = params.now.pose(params.plan.bodies()[parent].head);
    let (parent_from_frame, limits) = fitted(params, plan, &upper, &now);
    let upper_frame =
        Pose::from_parts(upper.inverse_transform_point(now.translation), parent_from_frame);
    let frames = [Pose::from_rotation(plan.head_from_frame), upper_frame];
    let joint =
        world.physics.insert_impulse_joint(bodies[index], bodies[parent], joint(limits, frames));
    if let Limits::Cone { twist_rad, .. } = limits {
        let upper_twist = twist_limit(twist_rad, frames);
        world.physics.insert_impulse_joint(bodies[parent], bodies[index], upper_twist);
    }
    Some(BodyConstraint { joint, limits, parent_from_frame, body_from_frame: plan.head_from_frame })
}

/// Returns the upper frame and the limits to use. The hinge axis is that of the current pose, and
/// limits that the pose exceeds are widened, so that nothing snaps.
fn fitted(params: &BuildParams, plan: &JointDef, upper: &Pose, now: &Pose) -> (Rotation, Limits) {
    let carrier = params.now.rotation(plan.carrier) * plan.carrier_from_frame;
    let frame = now.rotation * plan.head_from_frame;
    let between = carrier.inverse() * frame;
    let (twist, swing) = twist_and_swing(between, Vector::X);
    let (carrier, limits) = match plan.limits {
        Limits::Hinge { min_rad, max_rad } => {
            let [min_rad, max_rad] = widened([min_rad, max_rad], twist);
            let bent = between * Rotation::from_rotation_x(-twist);
            (carrier * bent, Limits::Hinge { min_rad, max_rad })
        }
        Limits::Cone { swing_rad, twist_rad } => {
            let swing_rad = if swing > swing_rad { swing + SLACK_RAD } else { swing_rad };
            (carrier, Limits::Cone { swing_rad, twist_rad: widened(twist_rad, twist) })
        }
    };
    ((upper.rotation.inverse() * carrier).normalize(), limits)
}

/// Widens limits that `now` exceeds.
fn widened([least, most]: [f32; 2], now: f32) -> [f32; 2] {
    let least = if now < least { now - SLACK_RAD } else { least };
    [least, if now > most { now + SLACK_RAD } else { most }]
}

/// Builds the joint with the lower body first, which reverses the signs of the twist limits. Rapier
/// measures the twist about the axis of the first body, so the twist about the lower body's own
/// length stays correct for any swing.
fn joint(limits: Limits, [body_frame, upper_frame]: [Pose; 2]) -> GenericJoint {
    let frames = |axes| {
        let joint =
            GenericJointBuilder::new(axes).local_frame1(body_frame).local_frame2(upper_frame);
        joint.contacts_enabled(false)
    };
    match limits {
        Limits::Hinge { min_rad, max_rad } => frames(JointAxesMask::LOCKED_REVOLUTE_AXES)
            .limits(JointAxis::AngX, [-max_rad, -min_rad])
            .build(),
        Limits::Cone { swing_rad, twist_rad } => frames(JointAxesMask::LOCKED_SPHERICAL_AXES)
            .coupled_axes(JointAxesMask::ANG_Y | JointAxesMask::ANG_Z)
            .limits(JointAxis::AngX, [-twist_rad[1], -twist_rad[0]])
            .limits(JointAxis::AngY, [-1.0, swing_rad])
            .build(),
    }
}

/// Limits the same twist about the axis of the upper body. Without this second joint, a body that
/// rolls around its cone can twist without limit: the axis of the actual twist lies between those
/// of the two bodies.
fn twist_limit(twist_rad: [f32; 2], [body_frame, upper_frame]: [Pose; 2]) -> GenericJoint {
    let joint = GenericJointBuilder::new(JointAxesMask::empty());
    let joint = joint.local_frame1(upper_frame).local_frame2(body_frame).contacts_enabled(false);
    joint.limits(JointAxis::AngX, twist_rad).build()
}

/// Returns how a limp body moves `joint`, or `None` if no limp body does.
fn carried_joint(params: &BuildParams, joint: JointIndex) -> Option<CarriedJoint> {
    let body = params.plan.body_of(joint).filter(|&b| params.limp[b])?;
    let parent = params.skeleton.parent(joint);
    let carried_parent =
        parent.filter(|&p| params.plan.body_of(p).is_some()).map(JointIndex::index);
    let (head, joint) = (params.plan.bodies()[body].head, joint.index());
    let model = |j: usize| -> &Affine { &params.now.model_from_joints[j] };
    let start = match carried_parent {
        Some(parent) => local(Some(model(parent)), model(joint)),
        None => trs(model(joint)),
    };
    let pose = params.now.pose(head);
    let rotation = params.now.rotation(joint);
    Some(CarriedJoint {
        joint,
        body,
        body_from_joint: (pose.rotation.inverse() * rotation).normalize(),
        parent: carried_parent,
        start,
        position_in_body: pose.inverse_transform_point(params.now.pose(joint).translation),
        rotation_to_model: rotation.inverse()
            * yaw_rotation(&params.now.placement)
            * rotation_of(&trs(model(joint))),
    })
}
