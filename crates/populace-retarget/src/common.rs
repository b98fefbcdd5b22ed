//! Which joints of two skeletons belong together, and the pose in which they stand alike.
//!
//! Both skeletons face +Z with +Y up, as glTF says. `Gs` and `Gt` are rotations in model space of a
//! joint of the source (the clip's own skeleton) and of the target, `0` marks the rest pose, `c`
//! the target's common pose. A joint of the target that has a joint of the source of its role turns
//! away from the common pose as that one turns away from its rest pose:
//! `Gt = Gs * inverse(Gs0) * Gtc`. All other joints of the target keep their local rest.

mod chain;
mod feet;
mod ground;
mod soles;

use glam::{DAffine3, DQuat, DVec3};
use populace_model::humanoid::{Role, RoleMap, Side};
use populace_model::{JointIndex, Skeleton, f64math};

pub(crate) use chain::{Chain, ColumnMotion, Value};
pub(crate) use soles::Soles;

/// Lengths below this part of the body's size have no direction.
const SHORT: f64 = 1e-5;
/// The longest run of joints that hang elsewhere, each from the one before.
const LOOSE: usize = 4;
/// Collarbones begin within this part of the way from the middle of the shoulders to an upper arm.
const COLLARBONE: f64 = 0.6;

/// A skeleton at rest and its roles.
pub(crate) struct Figure<'a> {
    pub(crate) skeleton: &'a Skeleton,
    roles: &'a RoleMap,
    /// In model space.
    rest: Vec<DAffine3>,
    /// In model space, without the scales above.
    turn: Vec<DQuat>,
}

impl<'a> Figure<'a> {
    pub(crate) fn new(skeleton: &'a Skeleton, roles: &'a RoleMap) -> Self {
        let parents: Vec<_> = skeleton.joints().map(|j| skeleton.parent(j)).collect();
        let local = |j: JointIndex| f64math::quat(skeleton.rest(j).rotation).normalize();
        let rest = skeleton.joints().map(|j| f64math::affine(skeleton.rest(j)));
        let turn = f64math::turns(&parents, skeleton.joints().map(local));
        Self { skeleton, roles, rest: f64math::model_from_joints(&parents, rest), turn }
    }

    fn place(&self, joint: JointIndex) -> DVec3 {
        self.rest[joint.index()].translation
    }

    /// How much longer what hangs on a joint is in model space than in its own, in the mean over
    /// all directions.
    fn scale(&self, joint: Option<JointIndex>) -> f64 {
        joint.map_or(1.0, |joint| {
            self.rest[joint.index()].matrix3.determinant().abs().cbrt().max(1e-9)
        })
    }

    /// The joint that carries the whole body over the ground, where there is one: the hips' parent.
    fn root(&self) -> Option<JointIndex> {
        self.skeleton.parent(self.roles.joint(Role::Hips)?)
    }

    /// Whether the joint between chest and upper arm leads outwards, as collarbones do. Some rigs
    /// have a joint in its place that turns the arm in the shoulder: what it does is part of what
    /// the upper arm does.
    fn has_collarbone(&self, side: Side) -> bool {
        let place = |role| Some(self.place(self.roles.joint(role)?));
        let arms = [Side::Left, Side::Right].map(|side| place(Role::UpperArm(side)));
        let (Some(left), Some(right), Some(shoulder)) =
            (arms[0], arms[1], place(Role::Shoulder(side)))
        else {
            return false;
        };
        let (middle, arm) = ((left + right) / 2.0, if side == Side::Left { left } else { right });
        shoulder.distance(middle) < COLLARBONE * arm.distance(middle)
    }

    /// Joints of the back, from below.
    fn back(&self) -> Vec<JointIndex> {
        let roles = [Role::Spine, Role::Chest, Role::UpperChest];
        roles.into_iter().filter_map(|role| self.roles.joint(role)).collect()
    }
}

/// A joint of the target and what it follows.
#[derive(Clone, Copy, Debug)]
struct Pair {
    source: JointIndex,
    /// `None` for roots.
    role: Option<Role>,
}

/// Two figures, and the pose in which the target stands as the source does at rest.
pub(crate) struct Common<'a> {
    pub(crate) source: Figure<'a>,
    pub(crate) target: Figure<'a>,
    /// By joint of the target.
    pairs: Vec<Option<Pair>>,
    /// By joint of the target, in model space.
    turn: Vec<DQuat>,
    place: Vec<DVec3>,
    /// How much higher than at rest the hips stand, so that feet stay on the ground.
    lift: f64,
    /// The target's legs over the source's.
    scale: f64,
}

impl<'a> Common<'a> {
    pub(crate) fn new(source: Figure<'a>, target: Figure<'a>) -> Self {
        let pairs = pairs(&source, &target);
        let mut common = Self {
            source,
            target,
            pairs,
            turn: Vec::new(),
            place: Vec::new(),
            lift: 0.0,
            scale: 1.0,
        };
        common.turn = common.turns();
        common.place = common.places();
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
            (|j| target.place(j).y, |j: JointIndex| common.place[j.index()].y);
        let ground = lowest(&in_common, target).unwrap_or(0.0);
        let lift = lowest(&at_rest, target).unwrap_or(0.0) - ground;
        let source_height = |j| source.place(j).y;
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

    /// How long the target's legs are, in parts of the source's.
    pub(crate) fn legs(&self) -> f32 {
        f64math::to_f32([self.scale])[0]
    }

    /// How far a joint of the target turns from rest to the common pose, in radians.
    pub(crate) fn turned_rad(&self, joint: JointIndex) -> f64 {
        self.turn[joint.index()].angle_between(self.target.turn[joint.index()])
    }

    /// The joint of the target whose turn from rest to the common pose a joint shares before its
    /// own is added: its parent, or what it follows where it hangs elsewhere.
    fn guide(&self, joint: JointIndex) -> Option<JointIndex> {
        self.detached(joint)
            .or_else(|| {
                let followed =
                    self.target.roles.followers().iter().find(|(_, follower)| *follower == joint);
                followed.and_then(|(role, _)| self.target.roles.joint(*role))
            })
            .or_else(|| self.target.skeleton.parent(joint))
    }

    /// The joint that a joint with a role should hang on and does not, where both are paired.
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

    /// Rotations of the common pose. A joint's guide comes first; should guides lead in a circle,
    /// what is left stays at rest.
    fn turns(&self) -> Vec<DQuat> {
        let skeleton = self.target.skeleton;
        let guides: Vec<_> = skeleton.joints().map(|j| self.guide(j)).collect();
        let mut turns: Vec<Option<DQuat>> = vec![None; guides.len()];
        let mut progress = true;
        while progress {
            progress = false;
            for joint in skeleton.joints() {
                let at_rest = self.target.turn[joint.index()];
                let from_rest = match guides[joint.index()] {
                    None => Some(DQuat::IDENTITY),
                    Some(g) => {
                        turns[g.index()].map(|turn| turn * self.target.turn[g.index()].inverse())
                    }
                };
                if let (None, Some(from_rest)) = (turns[joint.index()], from_rest) {
                    turns[joint.index()] = Some(self.common_turn(joint, from_rest) * at_rest);
                    progress = true;
                }
            }
        }
        turns
            .into_iter()
            .zip(&self.target.turn)
            .map(|(turn, rest)| turn.unwrap_or(*rest).normalize())
            .collect()
    }

    /// How a joint turns from rest to the common pose, where `inherited` is how its guide does.
    fn common_turn(&self, joint: JointIndex, inherited: DQuat) -> DQuat {
        let Some(Pair { source, role: Some(role) }) = self.pairs[joint.index()] else {
            return inherited;
        };
        match role {
            // Ankles and heads differ from body to body; soles lie flat and faces look ahead in
            // every rest pose.
            Role::Foot(_) | Role::Head => return DQuat::IDENTITY,
            _ if self.target.roles.joint(role) != Some(joint) => return inherited,
            _ => {}
        }
        let swing = end(role).and_then(|end| {
            let (to_source, to_target) =
                (self.source.roles.joint(end)?, self.target.roles.joint(end)?);
            let wanted = self.source.place(to_source) - self.source.place(source);
            let inherits = inherited * (self.target.place(to_target) - self.target.place(joint));
            let long =
                |v: DVec3, of: &Figure<'_>| v.length() > SHORT * f64::from(of.skeleton.size_m());
            let both = long(wanted, &self.source) && long(inherits, &self.target);
            both.then(|| DQuat::from_rotation_arc(inherits.normalize(), wanted.normalize()))
        });
        swing.unwrap_or(DQuat::IDENTITY) * inherited
    }

    /// Places of the common pose, the hips where they are at rest.
    fn places(&self) -> Vec<DVec3> {
        let skeleton = self.target.skeleton;
        let mut models: Vec<DAffine3> = Vec::with_capacity(self.turn.len());
        for joint in skeleton.joints() {
            let trs = skeleton.rest(joint);
            let parent = skeleton.parent(joint);
            let above = parent.map_or(DQuat::IDENTITY, |p| self.turn[p.index()]);
            let local = DAffine3::from_scale_rotation_translation(
                f64math::vec3(trs.scale),
                above.inverse() * self.turn[joint.index()],
                f64math::vec3(trs.translation),
            );
            models.push(parent.map_or(local, |p| models[p.index()] * local));
        }
        let stood = |joint: JointIndex| models[joint.index()].translation;
        let mut shifts = vec![DVec3::ZERO; models.len()];
        // What hangs elsewhere may come before what it follows, and a hand and three joints of a
        // finger may all do.
        for _ in 0..=LOOSE {
            for joint in skeleton.joints() {
                let parent = skeleton.parent(joint).map_or(DVec3::ZERO, |p| shifts[p.index()]);
                shifts[joint.index()] = self.detached(joint).map_or(parent, |of| {
                    let turn = self.turn[of.index()] * self.target.turn[of.index()].inverse();
                    let arm = self.target.place(joint) - self.target.place(of);
                    stood(of) + shifts[of.index()] + turn * arm - stood(joint)
                });
            }
        }
        skeleton.joints().map(|joint| stood(joint) + shifts[joint.index()]).collect()
    }
}

/// Where the limb of a role leads to. Hands and fingers keep their own shape: a palm may be cupped
/// at rest, and pulling it straight would tear it.
fn end(role: Role) -> Option<Role> {
    match role {
        Role::UpperArm(side) => Some(Role::LowerArm(side)),
        Role::LowerArm(side) => Some(Role::Hand(side)),
        Role::UpperLeg(side) => Some(Role::LowerLeg(side)),
        Role::LowerLeg(side) => Some(Role::Foot(side)),
        _ => None,
    }
}

/// Joints of the source by joint of the target: those of one role, and roots. Backs of unlike many
/// joints are paired from both ends: where one has a chest and the other an upper chest, on either
/// of them hang the shoulders.
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
