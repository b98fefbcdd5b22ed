//! Putting a ragdoll into the world, with the pose and the speed that its member has.

use std::sync::Arc;

use populace::model::{JointIndex, Skeleton};
use populace::{Affine, Member};
use rapier3d::prelude::{
    ColliderBuilder, GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MassProperties,
    RigidBodyBuilder, RigidBodyHandle,
};

use super::{Carried, Doll, FASTEST_RAD_PER_SEC, Held};
use crate::math::{
    Pose, Rotation, Vector, heading, local, rotation_of, trs, turn_between, twist_and_swing,
};
use crate::plan::Hold;
use crate::snapshot::{FASTEST_M_PER_SEC, Snapshot};
use crate::world::{World, mark};
use crate::{Limits, RagdollPlan};

/// Flesh takes speed away, about this part of it each second.
const LINEAR_DAMPING_PER_SEC: f32 = 0.05;
const ANGULAR_DAMPING_PER_SEC: f32 = 1.0;
/// A body's least moment of inertia, as a part of its greatest.
const LEAST_INERTIA: f32 = 0.3;
/// Bodies whose axes are nearer than this many times their radii at the start pass through each
/// other from then on.
const NEAR: f32 = 1.05;
/// What is beyond its limits when it goes limp may stay so, and this little more, in radians.
const SLACK_RAD: f32 = 0.01;

/// What a ragdoll is built from.
pub(crate) struct Recipe<'a> {
    pub(crate) member: Member,
    pub(crate) skeleton: &'a Skeleton,
    pub(crate) plan: &'a Arc<RagdollPlan>,
    pub(crate) id: u64,
    pub(crate) limp: Vec<bool>,
    pub(crate) before: &'a Snapshot,
    pub(crate) now: Snapshot,
    /// Between the two.
    pub(crate) dt_secs: f32,
}

/// A capsule in the world.
#[derive(Clone, Copy)]
struct Capsule {
    from: Vector,
    to: Vector,
    radius: f32,
}

impl Doll {
    pub(crate) fn build(recipe: Recipe, world: &mut World) -> Self {
        let plan = recipe.plan;
        let capsules: Vec<Capsule> =
            (0..plan.bodies().len()).map(|b| capsule(&recipe, world, b)).collect();
        let bodies: Vec<_> =
            (0..capsules.len()).map(|b| add_body(&recipe, world, b, &capsules[b])).collect();
        world.set_overlaps(recipe.id, overlaps(plan, &capsules));
        let held = (0..capsules.len()).map(|b| hold(&recipe, world, &bodies, b)).collect();
        let carried = recipe.skeleton.joints().filter_map(|j| carry(&recipe, j)).collect();
        Self {
            member: recipe.member,
            plan: Arc::clone(plan),
            id: recipe.id,
            limp: recipe.limp,
            bodies,
            held,
            carried,
            last: recipe.before.clone(),
            last_dt_secs: recipe.dt_secs,
            fade: None,
            settled_at: None,
        }
    }
}

/// A body's capsule as the member holds it now, no thicker than what is between it and the ground.
fn capsule(recipe: &Recipe, world: &World, body: usize) -> Capsule {
    let body = &recipe.plan.bodies()[body];
    let from = recipe.now.point(body.head, body.from);
    let to = recipe.now.point(body.head, body.to);
    let scale = recipe.now.place.scale();
    let radius = body.radius_m * scale;
    let low = if from.y < to.y { from } else { to };
    let clear = world
        .floor_under(low + Vector::Y * radius, 2.0 * radius)
        .map_or(radius, |floor| low.y - floor);
    Capsule { from, to, radius: radius.min(clear).max(0.4 * radius).max(1e-4) }
}

fn add_body(
    recipe: &Recipe,
    world: &mut World,
    index: usize,
    capsule: &Capsule,
) -> RigidBodyHandle {
    let body = &recipe.plan.bodies()[index];
    let before = recipe.before.pose(body.head);
    let now = recipe.now.pose(body.head);
    let from = now.inverse_transform_point(capsule.from);
    let to = now.inverse_transform_point(capsule.to);
    let scale = recipe.now.place.scale();
    let mass_kg = (body.mass_kg * scale * scale * scale).max(1e-6);
    let shape = ColliderBuilder::capsule_from_endpoints(from, to, capsule.radius)
        .mass_properties(mass_properties(
            from,
            to,
            capsule.radius,
            mass_kg,
            body.gyration_m * scale,
        ))
        .user_data(mark(recipe.id, index));
    if !recipe.limp[index] {
        return world.add_body(RigidBodyBuilder::kinematic_position_based().pose(now), shape);
    }
    let middle = (from + to) * 0.5;
    let step = now.transform_point(middle) - before.transform_point(middle);
    let turn = turn_between(before.rotation, now.rotation);
    let dynamic = RigidBodyBuilder::dynamic()
        .pose(now)
        .linvel((step / recipe.dt_secs).clamp_length_max(FASTEST_M_PER_SEC))
        .angvel((turn / recipe.dt_secs).clamp_length_max(FASTEST_RAD_PER_SEC))
        .linear_damping(LINEAR_DAMPING_PER_SEC)
        .angular_damping(ANGULAR_DAMPING_PER_SEC);
    world.add_body(dynamic, shape)
}

/// Those of the capsule, with what it lacks to its least moment of inertia.
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
    let eased = inertia.max(Vector::splat(least));
    MassProperties::with_principal_inertia_frame(properties.local_com, mass_kg, eased, frame)
}

/// Pairs of bodies that touch each other now.
fn overlaps(plan: &RagdollPlan, capsules: &[Capsule]) -> Vec<(u16, u16)> {
    let mut pairs = Vec::new();
    for (b, two) in (0u16..).zip(capsules) {
        for (a, one) in (0..b).zip(capsules) {
            let is_held = plan.bodies()[usize::from(b)].parent == Some(usize::from(a));
            if is_held || apart(one, two) < NEAR * (one.radius + two.radius) {
                pairs.push((a, b));
            }
        }
    }
    pairs
}

/// The distance between two capsules' axes (Ericson, Real-Time Collision Detection, 2005, section
/// 5.1.9).
fn apart(one: &Capsule, two: &Capsule) -> f32 {
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

/// Hangs a limp body on the one above it, where both are now.
fn hold(
    recipe: &Recipe,
    world: &mut World,
    bodies: &[RigidBodyHandle],
    index: usize,
) -> Option<Held> {
    let body = &recipe.plan.bodies()[index];
    let (plan, parent) = (body.hold.as_ref()?, body.parent?);
    if !recipe.limp[index] {
        return None;
    }
    let now = recipe.now.pose(body.head);
    let upper = recipe.now.pose(recipe.plan.bodies()[parent].head);
    let (parent_from_frame, limits) = fitted(recipe, plan, &upper, &now);
    let upper_frame =
        Pose::from_parts(upper.inverse_transform_point(now.translation), parent_from_frame);
    let frames = [Pose::from_rotation(plan.head_from_frame), upper_frame];
    let joint =
        world.physics.insert_impulse_joint(bodies[index], bodies[parent], joint(limits, frames));
    if let Limits::Cone { twist_rad, .. } = limits {
        let seen_from_above = twist_alone(twist_rad, frames);
        world.physics.insert_impulse_joint(bodies[parent], bodies[index], seen_from_above);
    }
    Some(Held { joint, limits, parent_from_frame, body_from_frame: plan.head_from_frame })
}

/// The upper frame, and limits that hold now: a hinge's axis goes where the clip holds it, and
/// limits that the clip breaks are widened, so that nothing snaps.
fn fitted(recipe: &Recipe, plan: &Hold, upper: &Pose, now: &Pose) -> (Rotation, Limits) {
    let carrier = recipe.now.turn(plan.carrier) * plan.carrier_from_frame;
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

fn widened([least, most]: [f32; 2], now: f32) -> [f32; 2] {
    let least = if now < least { now - SLACK_RAD } else { least };
    [least, if now > most { now + SLACK_RAD } else { most }]
}

/// Rapier holds a turn against the first body's axis, so the held body comes first: turning it
/// about its own length is then held rightly however far it swings.
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

/// The same twist held against the upper body's axis. Without it, what rolls around its cone twists
/// unheld, since neither axis alone is the one that a twist is measured about: that lies between
/// them.
fn twist_alone(twist_rad: [f32; 2], [body_frame, upper_frame]: [Pose; 2]) -> GenericJoint {
    let joint = GenericJointBuilder::new(JointAxesMask::empty());
    let joint = joint.local_frame1(upper_frame).local_frame2(body_frame).contacts_enabled(false);
    joint.limits(JointAxis::AngX, twist_rad).build()
}

/// How a joint goes along with a limp body.
fn carry(recipe: &Recipe, joint: JointIndex) -> Option<Carried> {
    let body = recipe.plan.body_of(joint).filter(|&b| recipe.limp[b])?;
    let parent = recipe.skeleton.parent(joint);
    let carried_parent =
        parent.filter(|&p| recipe.plan.body_of(p).is_some()).map(JointIndex::index);
    let (head, joint) = (recipe.plan.bodies()[body].head, joint.index());
    let model = |j: usize| -> &Affine { &recipe.now.model_from_joints[j] };
    let start = match carried_parent {
        Some(parent) => local(Some(model(parent)), model(joint)),
        None => trs(model(joint)),
    };
    let pose = recipe.now.pose(head);
    let turn = recipe.now.turn(joint);
    Some(Carried {
        joint,
        body,
        body_from_joint: (pose.rotation.inverse() * turn).normalize(),
        parent: carried_parent,
        start,
        place_in_body: pose.inverse_transform_point(recipe.now.pose(joint).translation),
        turn_to_model: turn.inverse()
            * heading(&recipe.now.place)
            * rotation_of(&trs(model(joint))),
    })
}
