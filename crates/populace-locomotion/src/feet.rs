//! The feet of a body: which joints carry them, and which points of them touch the ground.

use glam::{Affine3A, Mat3, Vec3};
use populace::character::{Character, sole_points};
use populace::model::{Role, RoleMap, Side, Skeleton};
use populace::{Affine, JointIndex};

/// Points up to this fraction of the body's height above its lowest touch the ground at rest.
const TOUCHES: f32 = 0.03;
/// Ankles are up to this fraction of the body's height above its lowest point.
const ANKLE: f32 = 0.25;

/// A point that a joint carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    joint: JointIndex,
    /// In the space of the joint.
    at: Vec3,
}

impl Carried {
    /// Attaches a point of the body at rest, in model space, to a joint. `None` for a joint without
    /// extent at rest.
    fn new(skeleton: &Skeleton, joint: JointIndex, at_rest: Vec3) -> Option<Self> {
        let joint_from_model = affine(&skeleton.rest_model(joint)).inverse();
        let at = joint_from_model.transform_point3(at_rest);
        at.is_finite().then_some(Self { joint, at })
    }

    /// The joint that carries it.
    pub(crate) const fn joint(&self) -> JointIndex {
        self.joint
    }

    /// Returns the place in model space of a pose.
    pub(crate) fn place(&self, model_from_joints: &[Affine]) -> Vec3 {
        model_from_joints[self.joint.index()].transform_point(self.at.to_array()).into()
    }
}

/// One foot of a body.
#[derive(Clone, Debug)]
pub(crate) struct Foot {
    pub(crate) ankle: Carried,
    /// The points that may touch the ground; at least one.
    pub(crate) sole: Vec<Carried>,
    /// `None` for a body without humanoid names.
    pub(crate) leg: Option<Leg>,
}

/// The leg of a foot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leg {
    pub(crate) hip: Carried,
    /// From hip over knee to ankle, in metres.
    pub(crate) length_m: f32,
    /// Where the middle of its steps is along Z, in metres of model space.
    pub(crate) middle_z: f32,
}

/// The two feet of a body.
#[derive(Clone, Debug)]
pub(crate) struct Feet {
    /// Left and right.
    pub(crate) feet: [Foot; 2],
    /// The joint that carries both legs, if they have one in common.
    pub(crate) hips: Option<Carried>,
}

impl Feet {
    /// Finds the feet of a humanoid by its roles, and those of any other body by where it touches
    /// the ground at rest. `None` for a body that does not stand on two feet.
    pub(crate) fn find(character: &Character) -> Option<Self> {
        let skeleton = character.skeleton.in_bind_pose();
        let mut soles: Vec<Vec<Vec3>> = skeleton
            .joints()
            .map(|joint| skeleton.soles(joint).iter().copied().map(Vec3::from).collect())
            .collect();
        if soles.iter().all(Vec::is_empty) {
            // A skeleton that was not told its soles.
            let found = sole_points(skeleton, &character.palette, &character.parts);
            soles = found.into_iter().map(|of| of.into_iter().map(Vec3::from).collect()).collect();
        }
        match RoleMap::detect(skeleton) {
            Some(roles) => by_roles(character, &roles, &soles),
            None => by_touch(character, &soles),
        }
    }
}

fn by_roles(character: &Character, roles: &RoleMap, soles: &[Vec<Vec3>]) -> Option<Feet> {
    let skeleton = character.skeleton.in_bind_pose();
    let foot = |side| {
        let ankle = roles.joint(Role::Foot(side))?;
        let mut sole = points_below(skeleton, ankle, soles);
        if sole.is_empty() {
            sole = joints_below(character, ankle);
        }
        let leg = leg(skeleton, roles, side);
        let ankle = carried_origin(skeleton, ankle)?;
        (!sole.is_empty()).then_some(Foot { ankle, sole, leg })
    };
    let hips = roles.joint(Role::Hips).and_then(|hips| carried_origin(skeleton, hips));
    Some(Feet { feet: [foot(Side::Left)?, foot(Side::Right)?], hips })
}

/// Returns the leg of one side; `None` if a joint of it has no humanoid name.
#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
fn leg(skeleton: &Skeleton, roles: &RoleMap, side: Side) -> Option<Leg> {
    let joints = [Role::UpperLeg(side), Role::LowerLeg(side), Role::Foot(side)];
    let [hip, knee, ankle] = joints.map(|role| roles.joint(role));
    let leg = [hip?, knee?, ankle?];
    let (length_m, middle_z) = (skeleton.leg_length_m(leg), skeleton.middle_of_steps_z(leg));
    let hip = carried_origin(skeleton, leg[0])?;
    Some(Leg { hip, length_m: length_m as f32, middle_z: middle_z as f32 })
}

/// Finds the joint on each side of the body that carries all points which touch the ground at rest.
/// On a four-legged body one joint carries points of both sides, so it has no feet.
fn by_touch(character: &Character, soles: &[Vec<Vec3>]) -> Option<Feet> {
    let skeleton = character.skeleton.in_bind_pose();
    let bounds = character.rest_bounds()?;
    let height = character.height_m();
    let touches = |place: &Vec3| place.y <= bounds.low[1] + TOUCHES * height;
    let touching: Vec<(JointIndex, Vec3)> = skeleton
        .joints()
        .filter_map(|joint| {
            let points = soles[joint.index()].iter().copied().filter(touches);
            Some((joint, mean(&points.collect::<Vec<_>>())?))
        })
        .collect();
    let tops = [0, 2].into_iter().find_map(|axis| tops(skeleton, &touching, axis))?;
    let foot = |top| {
        let sole = points_below(skeleton, top, soles);
        // A leg in one piece has no ankle: its joint is the hip.
        let own = origin(skeleton, top);
        let is_low = own.y <= bounds.low[1] + ANKLE * height;
        let at = if is_low { own } else { mean(&soles[top.index()]).unwrap_or(own) };
        let ankle = Carried::new(skeleton, top, at)?;
        (!sole.is_empty()).then_some(Foot { ankle, sole, leg: None })
    };
    let hips = common(skeleton, &tops).and_then(|hips| carried_origin(skeleton, hips));
    Some(Feet { feet: [foot(tops[0])?, foot(tops[1])?], hips })
}

/// Divides joints that touch the ground along an axis of model space, X or Z, and returns the joint
/// of the left foot and that of the right one. `None` if the joints of one side are not apart from
/// those of the other.
fn tops(
    skeleton: &Skeleton,
    touching: &[(JointIndex, Vec3)],
    axis: usize,
) -> Option<[JointIndex; 2]> {
    let middle = mean(&touching.iter().map(|(_, place)| *place).collect::<Vec<_>>())?;
    let on_side = |more: bool| {
        let own = touching.iter().filter(|(_, place)| (place[axis] > middle[axis]) == more);
        common(skeleton, &own.map(|(joint, _)| *joint).collect::<Vec<_>>())
    };
    let (more, less) = (on_side(true)?, on_side(false)?);
    let apart = more != less && !skeleton.is_below(more, less) && !skeleton.is_below(less, more);
    // A body whose feet are apart along Z faces the way that its toes point.
    let toes =
        touching.iter().map(|(joint, place)| place.x - origin(skeleton, *joint).x).sum::<f32>();
    let swapped = axis == 2 && toes > 0.0;
    apart.then_some(if swapped { [less, more] } else { [more, less] })
}

/// Returns the points that a joint and those below it carry.
fn points_below(skeleton: &Skeleton, top: JointIndex, soles: &[Vec<Vec3>]) -> Vec<Carried> {
    let of = |joint: JointIndex| {
        soles[joint.index()].iter().filter_map(move |at| Carried::new(skeleton, joint, *at))
    };
    at_and_below(skeleton, top).flat_map(of).collect()
}

/// Returns a point on the ground below each joint of a foot: the sole of a foot without vertices.
fn joints_below(character: &Character, top: JointIndex) -> Vec<Carried> {
    let skeleton = character.skeleton.in_bind_pose();
    let lowest_joint = || at_and_below(skeleton, top).map(|joint| origin(skeleton, joint).y);
    let ground = character
        .rest_bounds()
        .map_or_else(|| lowest_joint().fold(f32::INFINITY, f32::min), |bounds| bounds.low[1]);
    let below = |joint| {
        let at = origin(skeleton, joint);
        Carried::new(skeleton, joint, Vec3::new(at.x, ground, at.z))
    };
    at_and_below(skeleton, top).filter_map(below).collect()
}

fn at_and_below(skeleton: &Skeleton, top: JointIndex) -> impl Iterator<Item = JointIndex> {
    skeleton.joints().filter(move |joint| *joint == top || skeleton.is_below(*joint, top))
}

/// Returns the lowest joint that all of these are at or below.
fn common(skeleton: &Skeleton, joints: &[JointIndex]) -> Option<JointIndex> {
    let first = *joints.first()?;
    let holds = |top: &JointIndex| {
        joints.iter().all(|joint| joint == top || skeleton.is_below(*joint, *top))
    };
    std::iter::once(first).chain(skeleton.ancestors(first)).find(holds)
}

fn mean(points: &[Vec3]) -> Option<Vec3> {
    (!points.is_empty()).then(|| points.iter().sum::<Vec3>() / points.len() as f32)
}

fn origin(skeleton: &Skeleton, joint: JointIndex) -> Vec3 {
    skeleton.rest_model(joint).origin().into()
}

fn carried_origin(skeleton: &Skeleton, joint: JointIndex) -> Option<Carried> {
    Carried::new(skeleton, joint, origin(skeleton, joint))
}

fn affine(from: &Affine) -> Affine3A {
    let [x, y, z] = from.rows;
    let columns = |c: usize| Vec3::new(x[c], y[c], z[c]);
    let linear = Mat3::from_cols(columns(0), columns(1), columns(2));
    Affine3A::from_mat3_translation(linear, columns(3))
}
