//! Matching of the joints of two skeletons, and the common pose of both.
//!
//! Both skeletons face +Z with +Y up, as glTF specifies. `Gs` and `Gt` are model-space rotations of
//! a joint of the source (the clip's own skeleton) and of the target; `0` marks the rest pose, `c`
//! the target's common pose. A target joint whose role has a source joint rotates away from the
//! common pose as the source joint rotates away from its rest pose: `Gt = Gs * inverse(Gs0) * Gtc`.
//! All other joints of the target keep their local rest.
//!
//! A joint with a role is *detached* if it is not a descendant of the joint of its parent role, as
//! the feet of rigs whose feet are IK targets.

mod chain;
mod feet;
mod ground;
mod soles;

use glam::{DAffine3, DQuat, DVec3};
use populace_model::humanoid::{Role, RoleMap, Side};
use populace_model::{JointIndex, Skeleton, f64math};

pub(crate) use chain::Chain;
pub(crate) use soles::Soles;

/// Lengths below this fraction of the body's size have no direction.
const SHORT: f64 = 1e-5;
/// Longest run of detached joints that follow each other.
const MAX_DETACHED: usize = 4;
/// Maximum distance of a collarbone's start from the middle of the shoulders, as a fraction of the
/// distance of the upper arm.
const COLLARBONE: f64 = 0.6;

/// A skeleton at rest, with its roles.
pub(crate) struct Figure<'a> {
    pub(crate) skeleton: &'a Skeleton,
    roles: &'a RoleMap,
    /// Rest transforms in model space.
    rest: Vec<DAffine3>,
    /// Rest rotations in model space, without the scales of ancestors.
    rotation: Vec<DQuat>,
}

impl<'a> Figure<'a> {
    pub(crate) fn new(skeleton: &'a Skeleton, roles: &'a RoleMap) -> Self {
        let parents: Vec<_> = skeleton.joints().map(|j| skeleton.parent(j)).collect();
        let local = |j: JointIndex| f64math::quat(skeleton.rest(j).rotation).normalize();
        let rest = skeleton.joints().map(|j| f64math::affine(skeleton.rest(j)));
        let rotation = f64math::model_rotations(&parents, skeleton.joints().map(local));
        Self { skeleton, roles, rest: f64math::model_from_joints(&parents, rest), rotation }
    }

    fn position(&self, joint: JointIndex) -> DVec3 {
        self.rest[joint.index()].translation
    }

    /// Returns the ratio of lengths in model space to those in the space of a joint, averaged over
    /// all directions.
    fn scale(&self, joint: Option<JointIndex>) -> f64 {
        joint.map_or(1.0, |joint| {
            self.rest[joint.index()].matrix3.determinant().abs().cbrt().max(1e-9)
        })
    }

    /// Returns the joint that moves the whole body over the ground, if there is one: the parent of
    /// the hips.
    fn root(&self) -> Option<JointIndex> {
        self.skeleton.parent(self.roles.joint(Role::Hips)?)
    }

    /// Returns whether the joint between chest and upper arm leads outwards like a collarbone. Some
    /// rigs have a joint there that rotates the arm within the shoulder; its effect belongs to that
    /// of the upper arm.
    fn has_collarbone(&self, side: Side) -> bool {
        let position = |role| Some(self.position(self.roles.joint(role)?));
        let arms = [Side::Left, Side::Right].map(|side| position(Role::UpperArm(side)));
        let (Some(left), Some(right), Some(shoulder)) =
            (arms[0], arms[1], position(Role::Shoulder(side)))
        else {
            return false;
        };
        let (middle, arm) = ((left + right) / 2.0, if side == Side::Left { left } else { right });
        shoulder.distance(middle) < COLLARBONE * arm.distance(middle)
    }

    /// Returns the joints of the back, lowest first.
    fn back(&self) -> Vec<JointIndex> {
        let roles = [Role::Spine, Role::Chest, Role::UpperChest];
        roles.into_iter().filter_map(|role| self.roles.joint(role)).collect()
    }
}

/// A joint of the target and the source joint that it follows.
#[derive(Clone, Copy, Debug)]
struct Pair {
    source: JointIndex,
    /// `None` for roots.
    role: Option<Role>,
}

/// Two figures, and the common pose: the pose of the target that matches the source's rest.
pub(crate) struct Common<'a> {
    pub(crate) source: Figure<'a>,
    pub(crate) target: Figure<'a>,
    /// For each joint of the target.
    pairs: Vec<Option<Pair>>,
    /// Rotations of the common pose in model space, for each joint of the target.
    rotation: Vec<DQuat>,
    position: Vec<DVec3>,
    /// Height of the hips above their rest, so that the feet stay on the ground.
    lift: f64,
    /// Leg length of the target divided by that of the source.
    scale: f64,
}

impl<'a> Common<'a> {
    pub(crate) fn new(source: Figure<'a>, target: Figure<'a>) -> Self {
        let pairs = pairs(&source, &target);
        let mut common = Self {
            source,
            target,
            pairs,
            rotation: Vec::new(),
            position: Vec::new(),
            lift: 0.0,
            scale: 1.0,
        };
        common.rotation = common.rotations();
        common.position = common.positions();
        let sides = [Side::Left, Side::Right];
        let lowest = |height: &dyn Fn(JointIndex) -> f64, of: &Figure<'_>| {
            let feet = sides.into_iter().filter_map(|side| of.roles.joint(Role::Foot(side)));
            feet.map(height).reduce(f64::min)
        };
        let top = |height: &dyn Fn(JointIndex) -> f64, of: &Figure<'_>| {
            let legs = sides.into_iter().filter_map(|side| of.roles.joint(Role::UpperLeg(side)));
            legs.map(height).sum::<f64>() / 2.0
        };
        let (source, target) = (&common.source, &common.target);
        let (at_rest, in_common) =
            (|j| target.position(j).y, |j: JointIndex| common.position[j.index()].y);
        let ground = lowest(&in_common, target).unwrap_or(0.0);
        let lift = lowest(&at_rest, target).unwrap_or(0.0) - ground;
        let source_height = |j| source.position(j).y;
        let legs = (
            top(&in_common, target) - ground,
            top(&source_height, source) - lowest(&source_height, source).unwrap_or(0.0),
        );
        let size = f64::from(target.skeleton.size_m()) / f64::from(source.skeleton.size_m());
        let short = |length: f64, of: &Figure<'_>| length <= 0.01 * f64::from(of.skeleton.size_m());
        let scale =
            if short(legs.0, target) || short(legs.1, source) { size } else { legs.0 / legs.1 };
        (common.lift, common.scale) = (lift, scale);
        common
    }

    /// Leg length of the target divided by that of the source.
    pub(crate) fn leg_ratio(&self) -> f32 {
        f64math::to_f32([self.scale])[0]
    }

    /// Angle of a target joint between rest and common pose, in radians.
    pub(crate) fn rotated_rad(&self, joint: JointIndex) -> f64 {
        self.rotation[joint.index()].angle_between(self.target.rotation[joint.index()])
    }

    /// Returns the target joint whose rotation from rest to the common pose is applied to `joint`
    /// before its own: its parent, or the joint that it follows if it is detached.
    fn guide(&self, joint: JointIndex) -> Option<JointIndex> {
        self.detached(joint)
            .or_else(|| {
                let followed =
                    self.target.roles.followers().iter().find(|(_, follower)| *follower == joint);
                followed.and_then(|(role, _)| self.target.roles.joint(*role))
            })
            .or_else(|| self.target.skeleton.parent(joint))
    }

    /// Returns the joint that a joint with a role should descend from but does not, if both are
    /// paired.
    fn detached(&self, joint: JointIndex) -> Option<JointIndex> {
        let role = self.pairs[joint.index()]?.role?;
        if self.target.roles.joint(role) != Some(joint) {
            return None;
        }
        let mut above = std::iter::successors(role.parent(), |role| role.parent());
        let of = above
            .find_map(|r| self.target.roles.joint(r).filter(|j| self.pairs[j.index()].is_some()))?;
        (!self.target.skeleton.is_below(joint, of)).then_some(of)
    }

    /// Computes the rotations of the common pose. A joint's guide is processed first. If guides
    /// form a cycle, the remaining joints stay at rest.
    fn rotations(&self) -> Vec<DQuat> {
        let skeleton = self.target.skeleton;
        let guides: Vec<_> = skeleton.joints().map(|j| self.guide(j)).collect();
        let mut rotations: Vec<Option<DQuat>> = vec![None; guides.len()];
        let mut progress = true;
        while progress {
            progress = false;
            for joint in skeleton.joints() {
                let at_rest = self.target.rotation[joint.index()];
                let from_rest = match guides[joint.index()] {
                    None => Some(DQuat::IDENTITY),
                    Some(g) => rotations[g.index()]
                        .map(|rotation| rotation * self.target.rotation[g.index()].inverse()),
                };
                if let (None, Some(from_rest)) = (rotations[joint.index()], from_rest) {
                    rotations[joint.index()] =
                        Some(self.common_rotation(joint, from_rest) * at_rest);
                    progress = true;
                }
            }
        }
        rotations
            .into_iter()
            .zip(&self.target.rotation)
            .map(|(rotation, rest)| rotation.unwrap_or(*rest).normalize())
            .collect()
    }

    /// Returns a joint's rotation from rest to the common pose; `inherited` is that of its guide.
    fn common_rotation(&self, joint: JointIndex, inherited: DQuat) -> DQuat {
        let Some(Pair { source, role: Some(role) }) = self.pairs[joint.index()] else {
            return inherited;
        };
        match role {
            // Ankles and heads differ between bodies, but in every rest pose soles are flat and
            // faces look ahead.
            Role::Foot(_) | Role::Head => return DQuat::IDENTITY,
            _ if self.target.roles.joint(role) != Some(joint) => return inherited,
            _ => {}
        }
        let swing = end(role).and_then(|end| {
            let (to_source, to_target) =
                (self.source.roles.joint(end)?, self.target.roles.joint(end)?);
            let wanted = self.source.position(to_source) - self.source.position(source);
            let inherits =
                inherited * (self.target.position(to_target) - self.target.position(joint));
            let long =
                |v: DVec3, of: &Figure<'_>| v.length() > SHORT * f64::from(of.skeleton.size_m());
            let both = long(wanted, &self.source) && long(inherits, &self.target);
            both.then(|| DQuat::from_rotation_arc(inherits.normalize(), wanted.normalize()))
        });
        swing.unwrap_or(DQuat::IDENTITY) * inherited
    }

    /// Computes the positions of the common pose, with the hips at their rest position.
    fn positions(&self) -> Vec<DVec3> {
        let skeleton = self.target.skeleton;
        let mut models: Vec<DAffine3> = Vec::with_capacity(self.rotation.len());
        for joint in skeleton.joints() {
            let trs = skeleton.rest(joint);
            let parent = skeleton.parent(joint);
            let above = parent.map_or(DQuat::IDENTITY, |p| self.rotation[p.index()]);
            let local = DAffine3::from_scale_rotation_translation(
                f64math::vec3(trs.scale),
                above.inverse() * self.rotation[joint.index()],
                f64math::vec3(trs.translation),
            );
            models.push(parent.map_or(local, |p| models[p.index()] * local));
        }
        let unshifted = |joint: JointIndex| models[joint.index()].translation;
        let mut shifts = vec![DVec3::ZERO; models.len()];
        // A detached joint may come before the joint that it follows, and a hand and three joints
        // of a finger may all be detached.
        for _ in 0..=MAX_DETACHED {
            for joint in skeleton.joints() {
                let parent = skeleton.parent(joint).map_or(DVec3::ZERO, |p| shifts[p.index()]);
                shifts[joint.index()] = self.detached(joint).map_or(parent, |of| {
                    let rotation =
                        self.rotation[of.index()] * self.target.rotation[of.index()].inverse();
                    let arm = self.target.position(joint) - self.target.position(of);
                    unshifted(of) + shifts[of.index()] + rotation * arm - unshifted(joint)
                });
            }
        }
        skeleton.joints().map(|joint| unshifted(joint) + shifts[joint.index()]).collect()
    }
}

/// Returns the role at the far end of a limb. Hands and fingers keep their own shape: a palm may be
/// cupped at rest, and straightening it would distort the mesh.
fn end(role: Role) -> Option<Role> {
    match role {
        Role::UpperArm(side) => Some(Role::LowerArm(side)),
        Role::LowerArm(side) => Some(Role::Hand(side)),
        Role::UpperLeg(side) => Some(Role::LowerLeg(side)),
        Role::LowerLeg(side) => Some(Role::Foot(side)),
        _ => None,
    }
}

/// Returns the source joint for each joint of the target: joints of the same role, and roots. Backs
/// with different numbers of joints are paired from both ends, because the shoulders descend from
/// the chest on one body and from the upper chest on another.
fn pairs(source: &Figure<'_>, target: &Figure<'_>) -> Vec<Option<Pair>> {
    let mut pairs = vec![None; target.skeleton.joint_count()];
    for (role, joint) in target.roles.iter().chain(target.roles.followers().iter().copied()) {
        let same = source.roles.joint(role).filter(|_| match role {
            Role::Spine | Role::Chest | Role::UpperChest => false,
            Role::Shoulder(side) => source.has_collarbone(side) && target.has_collarbone(side),
            _ => true,
        });
        pairs[joint.index()] = same.map(|source| Pair { source, role: Some(role) });
    }
    let (from, onto) = (source.back(), target.back());
    let role =
        |joint: JointIndex| target.roles.iter().find(|(_, j)| *j == joint).map(|(role, _)| role);
    for (at, &joint) in onto.iter().enumerate() {
        let last = at + 1 == onto.len();
        let other = if last { from.last() } else { from.get(at).filter(|_| at + 1 < from.len()) };
        pairs[joint.index()] = other.map(|&source| Pair { source, role: role(joint) });
    }
    if let (Some(from), Some(onto)) = (source.root(), target.root())
        && pairs[onto.index()].is_none()
    {
        pairs[onto.index()] = Some(Pair { source: from, role: None });
    }
    pairs
}
