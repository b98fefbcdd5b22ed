//! Retargeting by its definition: places every joint of the target in model space, and derives its
//! local transform from there.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use populace_model::{ClipSource, JointSource, Role, Side};

use super::OracleBody;
use super::local::Local;
use super::sample::TracksByJoint;

/// Feet may sink by this fraction of the body's size before the body is lifted.
const ALLOWED_SINKING: f64 = 0.004;
/// The body is lifted by at most this fraction of its size.
const LARGEST_LIFT: f64 = 0.02;
/// A shoulder joint is a collarbone if it lies within this fraction of the way from the middle of
/// the shoulders to the upper arm.
const COLLARBONE_REACH: f64 = 0.6;

/// A body's joints in source order, their roles and their rest pose.
#[derive(Clone, Debug)]
struct Humanoid {
    body: OracleBody,
    roles: BTreeMap<Role, usize>,
    rest: Vec<ModelJoint>,
}

/// A joint's rotation and transform in model space.
#[derive(Clone, Copy, Debug)]
struct ModelJoint {
    rotation: DQuat,
    model: DAffine3,
}

impl ModelJoint {
    fn position(&self) -> DVec3 {
        self.model.translation
    }
}

/// A clip of one body retargeted to another.
#[derive(Clone, Debug)]
pub struct OracleRetarget {
    source: Humanoid,
    target: Humanoid,
    /// The corresponding source joint of each target joint.
    partners: Vec<Option<usize>>,
    /// The target in the common pose, with the hips at their rest position.
    common: Vec<ModelJoint>,
    scale: f64,
    lift: f64,
}

impl OracleRetarget {
    /// Retargets a clip of `source` to `target`, each given with its roles. `keys` are the clip's
    /// key times in seconds.
    #[must_use]
    pub fn new(
        clip: &ClipSource,
        keys: &[f32],
        source: (&OracleBody, &[(Role, usize)]),
        target: (&OracleBody, &[(Role, usize)]),
    ) -> Self {
        let (source, target) = (Humanoid::new(source), Humanoid::new(target));
        let partners = partners(&source, &target);
        let mut retarget =
            Self { source, target, partners, common: Vec::new(), scale: 1.0, lift: 0.0 };
        let rotations: Vec<DQuat> =
            (0..retarget.partners.len()).map(|j| retarget.common_rotation(j)).collect();
        retarget.common = retarget.pose_with(&rotations);
        let heights = |placed: &[ModelJoint], humanoid: &Humanoid| {
            let y = |role| placed[humanoid.roles[&role]].position().y;
            let [left, right] = [Side::Left, Side::Right];
            let feet = y(Role::Foot(left)).min(y(Role::Foot(right)));
            (feet, (y(Role::UpperLeg(left)) + y(Role::UpperLeg(right))) / 2.0)
        };
        let source = heights(&retarget.source.rest, &retarget.source);
        let rest = heights(&retarget.target.rest, &retarget.target);
        let common = heights(&retarget.common, &retarget.target);
        retarget.scale = (common.1 - common.0) / (source.1 - source.0);
        retarget.lift = rest.0 - common.0;
        let sinking =
            keys.iter().map(|&secs| retarget.sinking(clip, f64::from(secs))).fold(0.0, f64::max);
        let size = retarget.target.size();
        retarget.lift += (sinking - ALLOWED_SINKING * size).clamp(0.0, LARGEST_LIFT * size);
        retarget
    }

    /// Returns the target's local transforms at a time of the clip.
    #[must_use]
    pub fn locals(&self, clip: &ClipSource, time_secs: f64) -> Vec<Local> {
        let placed = self.placed(clip, time_secs);
        let local = |joint: usize| {
            let rest = self.target.body.rest(joint);
            let parent = self.target.parent(joint);
            let above = parent.map_or(DQuat::IDENTITY, |p| placed[p].rotation);
            let into = parent.map_or(DAffine3::IDENTITY, |p| placed[p].model.inverse());
            let translation = if self.is_in_model_space(joint) {
                into.transform_point3(placed[joint].position())
            } else {
                rest.translation
            };
            Local {
                translation,
                rotation: (above.inverse() * placed[joint].rotation).normalize(),
                scale: rest.scale,
            }
        };
        (0..self.partners.len()).map(local).collect()
    }

    /// Returns the source joints on which a joint's local rotation may depend, and the lever in
    /// metres by which its position depends on them; 0 if it keeps its local translation.
    #[must_use]
    pub fn depends_on(&self, joint: usize) -> (Vec<usize>, f64) {
        let Some(partner) = self.partners[joint] else {
            return (Vec::new(), 0.0);
        };
        let chain = |joint: usize| std::iter::successors(Some(joint), |&j| self.source.parent(j));
        let above = std::iter::successors(self.target.parent(joint), |&j| self.target.parent(j));
        let from = above.into_iter().find_map(|j| self.partners[j]);
        let mut joints: Vec<usize> = chain(partner).collect();
        let up: Vec<usize> = from.into_iter().flat_map(chain).collect();
        if self.limb(joint).is_some() {
            // The chain runs down the limb and up again.
            let limb = self.limb(joint).and_then(|limb| self.partners[limb]);
            joints.extend(limb.into_iter().flat_map(chain).flat_map(|j| [j, j]));
            joints.extend(up);
        } else {
            let shared: Vec<usize> = joints.iter().copied().filter(|j| up.contains(j)).collect();
            joints.extend(up);
            joints.retain(|j| !shared.contains(j));
        }
        let reach = if self.is_in_model_space(joint) { self.target.size() } else { 0.0 };
        (joints, reach)
    }

    /// Returns the ratio of the target's leg length to the source's.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns the source's joints, in source order.
    #[must_use]
    pub fn source_joints(&self) -> &[JointSource] {
        &self.source.body.joints
    }

    fn role(&self, joint: usize) -> Option<Role> {
        self.target.roles.iter().find(|(_, of)| **of == joint).map(|(role, _)| *role)
    }

    fn has_role(&self, joint: usize, role: Role) -> bool {
        self.target.roles.get(&role) == Some(&joint)
    }

    /// Returns the limb that a joint belongs to by its role, if it is not among the joint's
    /// ancestors.
    fn limb(&self, joint: usize) -> Option<usize> {
        self.partners[joint]?;
        let mut role = self.role(joint)?.parent();
        let limb = loop {
            match self.target.roles.get(&role?).filter(|of| self.partners[**of].is_some()) {
                Some(of) => break *of,
                None => role = role?.parent(),
            }
        };
        let mut above =
            std::iter::successors(self.target.parent(joint), |&j| self.target.parent(j));
        (!above.any(|j| j == limb)).then_some(limb)
    }

    /// Returns whether a joint's position is computed in model space: for the root, the hips, and
    /// joints that are not descendants of their limb.
    fn is_in_model_space(&self, joint: usize) -> bool {
        self.is_root(joint) || self.has_role(joint, Role::Hips) || self.limb(joint).is_some()
    }

    fn is_root(&self, joint: usize) -> bool {
        self.partners[joint].is_some()
            && self.target.root() == Some(joint)
            && self.role(joint).is_none()
    }

    /// Returns a joint's model-space rotation in the common pose.
    fn common_rotation(&self, joint: usize) -> DQuat {
        let rest = &self.target.rest;
        let role = self.role(joint).filter(|_| self.partners[joint].is_some());
        if matches!(role, Some(Role::Foot(_) | Role::Head)) {
            return rest[joint].rotation;
        }
        let guide = self.limb(joint).or_else(|| self.target.parent(joint));
        let rotation_from_rest =
            guide.map_or(DQuat::IDENTITY, |g| self.common_rotation(g) * rest[g].rotation.inverse());
        let end = match role {
            Some(Role::UpperArm(side)) => Role::LowerArm(side),
            Some(Role::LowerArm(side)) => Role::Hand(side),
            Some(Role::UpperLeg(side)) => Role::LowerLeg(side),
            Some(Role::LowerLeg(side)) => Role::Foot(side),
            _ => return rotation_from_rest * rest[joint].rotation,
        };
        let direction = |humanoid: &Humanoid, joint: usize| {
            (humanoid.rest[humanoid.roles[&end]].position() - humanoid.rest[joint].position())
                .normalize()
        };
        let wanted =
            self.partners[joint].map_or(DVec3::Y, |partner| direction(&self.source, partner));
        DQuat::from_rotation_arc(rotation_from_rest * direction(&self.target, joint), wanted)
            * rotation_from_rest
            * rest[joint].rotation
    }

    /// Poses the target with model-space rotations. Local translations are those of rest, except
    /// for joints that are not descendants of their limb.
    fn pose_with(&self, rotations: &[DQuat]) -> Vec<ModelJoint> {
        (0..rotations.len()).map(|joint| self.pose_joint_with(rotations, joint)).collect()
    }

    fn pose_joint_with(&self, rotations: &[DQuat], joint: usize) -> ModelJoint {
        let rest = self.target.body.rest(joint);
        let parent = self.target.parent(joint);
        let above = parent.map_or(DAffine3::IDENTITY, |p| self.pose_joint_with(rotations, p).model);
        let local = parent.map_or(DQuat::IDENTITY, |p| rotations[p]).inverse() * rotations[joint];
        let trs = DAffine3::from_scale_rotation_translation(rest.scale, local, rest.translation);
        let mut placed = ModelJoint { rotation: rotations[joint], model: above * trs };
        if let Some(limb) = self.limb(joint) {
            placed.model.translation = self.pose_joint_with(rotations, limb).position()
                + self.offset_from_limb(rotations[limb], joint, limb);
        }
        placed
    }

    /// Returns the vector from a limb to a joint that belongs to it, for the limb's rotation.
    fn offset_from_limb(&self, rotation: DQuat, joint: usize, limb: usize) -> DVec3 {
        let rest = &self.target.rest;
        rotation * rest[limb].rotation.inverse() * (rest[joint].position() - rest[limb].position())
    }

    /// Returns all joints of the target at a time.
    fn placed(&self, clip: &ClipSource, time_secs: f64) -> Vec<ModelJoint> {
        let moving = self.source.moving(clip, time_secs);
        (0..self.partners.len()).map(|joint| self.place_joint(&moving, joint)).collect()
    }

    fn place_joint(&self, moving: &[ModelJoint], joint: usize) -> ModelJoint {
        let rest = self.target.body.rest(joint);
        let parent = self.target.parent(joint).map(|parent| self.place_joint(moving, parent));
        let (above, parent_rotation) =
            parent.map_or((DAffine3::IDENTITY, DQuat::IDENTITY), |p| (p.model, p.rotation));
        let rotation = match self.partners[joint] {
            Some(partner) => self.rotation_from_rest(moving, partner) * self.common[joint].rotation,
            None => parent_rotation * rest.rotation,
        };
        let trs = DAffine3::from_scale_rotation_translation(
            rest.scale,
            parent_rotation.inverse() * rotation,
            rest.translation,
        );
        let mut placed = ModelJoint { rotation, model: above * trs };
        let Some(partner) = self.partners[joint] else {
            return placed;
        };
        let moved = |joint: usize| moving[joint].position() - self.source.rest[joint].position();
        if self.is_root(joint) {
            placed.model.translation = self.common[joint].position() + self.scale * moved(partner);
        } else if self.has_role(joint, Role::Hips) {
            let lifted = self.common[joint].position() + DVec3::Y * self.lift;
            placed.model.translation = match self.target.root().filter(|root| self.is_root(*root)) {
                None => lifted + self.scale * moved(partner),
                Some(root) => {
                    let other = self.partners[root].expect("roots have partners");
                    let (rotation_from_rest, rest) =
                        (self.rotation_from_rest(moving, other), &self.source.rest);
                    let own = moving[partner].position() - moving[other].position();
                    let carried =
                        rotation_from_rest * (rest[partner].position() - rest[other].position());
                    self.place_joint(moving, root).position()
                        + rotation_from_rest * (lifted - self.common[root].position())
                        + self.scale * (own - carried)
                }
            };
        } else if let Some(limb) = self.limb(joint) {
            let of = self.place_joint(moving, limb);
            placed.model.translation =
                of.position() + self.offset_from_limb(of.rotation, joint, limb);
        }
        placed
    }

    /// Returns the rotation of a source joint relative to rest, in model space.
    fn rotation_from_rest(&self, moving: &[ModelJoint], joint: usize) -> DQuat {
        moving[joint].rotation * self.source.rest[joint].rotation.inverse()
    }

    /// Returns how far a foot or its toes sink below their rest height.
    fn sinking(&self, clip: &ClipSource, time_secs: f64) -> f64 {
        let placed = self.placed(clip, time_secs);
        let soles = self.target.roles.iter().filter(|(role, joint)| {
            matches!(role, Role::Foot(_) | Role::Toes(_)) && self.partners[**joint].is_some()
        });
        soles
            .map(|(_, &j)| self.target.rest[j].position().y - placed[j].position().y)
            .fold(0.0, f64::max)
    }
}

impl Humanoid {
    fn new((body, roles): (&OracleBody, &[(Role, usize)])) -> Self {
        let mut humanoid =
            Self { body: body.clone(), roles: roles.iter().copied().collect(), rest: Vec::new() };
        let locals: Vec<Local> = (0..body.joints.len()).map(|joint| body.rest(joint)).collect();
        humanoid.rest =
            (0..locals.len()).map(|joint| humanoid.model_joint(&locals, joint)).collect();
        humanoid
    }

    fn parent(&self, joint: usize) -> Option<usize> {
        self.body.joints[joint].parent
    }

    fn root(&self) -> Option<usize> {
        self.parent(self.roles[&Role::Hips])
    }

    fn model_joint(&self, locals: &[Local], joint: usize) -> ModelJoint {
        let Local { translation, rotation, scale } = locals[joint];
        let local = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        match self.parent(joint).map(|parent| self.model_joint(locals, parent)) {
            None => ModelJoint { rotation, model: local },
            Some(parent) => {
                ModelJoint { rotation: parent.rotation * rotation, model: parent.model * local }
            }
        }
    }

    /// Returns all joints at a time of the clip.
    fn moving(&self, clip: &ClipSource, time_secs: f64) -> Vec<ModelJoint> {
        let tracks = TracksByJoint::new(clip);
        let local = |joint: usize| {
            tracks.local(&self.body.joints[joint].name, &self.body.rest(joint), time_secs)
        };
        let locals: Vec<Local> = (0..self.body.joints.len()).map(local).collect();
        (0..locals.len()).map(|joint| self.model_joint(&locals, joint)).collect()
    }

    /// Returns the largest side of the bounding box of the joints at rest.
    fn size(&self) -> f64 {
        let positions = || self.rest.iter().map(ModelJoint::position);
        let low = positions().fold(DVec3::INFINITY, DVec3::min);
        (positions().fold(DVec3::NEG_INFINITY, DVec3::max) - low).max_element()
    }

    fn has_collarbone(&self, side: Side) -> bool {
        let position = |role| self.roles.get(&role).map(|&joint| self.rest[joint].position());
        let arms = [Role::UpperArm(Side::Left), Role::UpperArm(Side::Right), Role::UpperArm(side)]
            .map(position);
        let (Some(shoulder), [Some(left), Some(right), Some(arm)]) =
            (position(Role::Shoulder(side)), arms)
        else {
            return false;
        };
        let middle = (left + right) / 2.0;
        shoulder.distance(middle) < COLLARBONE_REACH * arm.distance(middle)
    }
}

/// Returns the corresponding source joint of each target joint.
fn partners(source: &Humanoid, target: &Humanoid) -> Vec<Option<usize>> {
    let mut partners = vec![None; target.body.joints.len()];
    for (role, &joint) in &target.roles {
        let fits = match role {
            Role::Spine | Role::Chest | Role::UpperChest => false,
            Role::Shoulder(side) => source.has_collarbone(*side) && target.has_collarbone(*side),
            _ => true,
        };
        partners[joint] = source.roles.get(role).copied().filter(|_| fits);
    }
    let back = |humanoid: &Humanoid| {
        let roles = [Role::Spine, Role::Chest, Role::UpperChest];
        roles.iter().filter_map(|role| humanoid.roles.get(role).copied()).collect::<Vec<_>>()
    };
    let (mut from, mut onto) = (back(source), back(target));
    // The last joints of both backs carry the shoulders; the others are paired from below.
    if let (Some(last), Some(joint)) = (from.pop(), onto.pop()) {
        partners[joint] = Some(last);
    }
    for (from, onto) in from.into_iter().zip(onto) {
        partners[onto] = Some(from);
    }
    if let (Some(from), Some(onto)) = (source.root(), target.root()) {
        partners[onto] = Some(from);
    }
    partners
}
