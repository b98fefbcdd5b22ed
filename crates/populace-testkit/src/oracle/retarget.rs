//! Retargeting by its definition: where every joint of either body is in model space, and from
//! there its local transform.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use populace_model::{ClipSource, JointSource, Role, Side};

use super::sample::TracksByJoint;
use super::{Local, OracleBody};

/// Feet may sink by this part of the body's size; whoever sinks deeper is lifted, by no more than
/// that part.
const SINKS: f64 = 0.004;
const MOST: f64 = 0.02;
/// Collarbones begin within this part of the way to an upper arm.
const COLLARBONE: f64 = 0.6;

/// A body's joints in the order of the source, and which of them has which role.
#[derive(Clone, Debug)]
struct Humanoid {
    body: OracleBody,
    roles: BTreeMap<Role, usize>,
    rest: Vec<Placed>,
}

/// A joint in model space.
#[derive(Clone, Copy, Debug)]
struct Placed {
    turn: DQuat,
    model: DAffine3,
}

impl Placed {
    fn place(&self) -> DVec3 {
        self.model.translation
    }
}

/// A clip of one body on another.
#[derive(Clone, Debug)]
pub struct OracleRetarget {
    source: Humanoid,
    target: Humanoid,
    /// By joint of the target.
    partners: Vec<Option<usize>>,
    /// The target's joints in the common pose, hips where they are at rest.
    common: Vec<Placed>,
    scale: f64,
    lift: f64,
}

impl OracleRetarget {
    /// Of a clip of `source` for `target`, each with its roles; `keys` are the clip's key times.
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
        let turns: Vec<DQuat> =
            (0..retarget.partners.len()).map(|j| retarget.common_turn(j)).collect();
        retarget.common = retarget.stand(&turns);
        let heights = |placed: &[Placed], figure: &Humanoid| {
            let y = |role| placed[figure.roles[&role]].place().y;
            let [left, right] = [Side::Left, Side::Right];
            let feet = y(Role::Foot(left)).min(y(Role::Foot(right)));
            (feet, (y(Role::UpperLeg(left)) + y(Role::UpperLeg(right))) / 2.0)
        };
        let source = heights(&retarget.source.rest, &retarget.source);
        let rest = heights(&retarget.target.rest, &retarget.target);
        let common = heights(&retarget.common, &retarget.target);
        retarget.scale = (common.1 - common.0) / (source.1 - source.0);
        retarget.lift = rest.0 - common.0;
        let depth =
            keys.iter().map(|&secs| retarget.depth(clip, f64::from(secs))).fold(0.0, f64::max);
        let size = retarget.target.size();
        retarget.lift += (depth - SINKS * size).clamp(0.0, MOST * size);
        retarget
    }

    /// The target's local transforms at a time of the clip.
    #[must_use]
    pub fn locals(&self, clip: &ClipSource, time_secs: f64) -> Vec<Local> {
        let placed = self.placed(clip, time_secs);
        let local = |joint: usize| {
            let rest = self.target.body.rest(joint);
            let parent = self.target.parent(joint);
            let above = parent.map_or(DQuat::IDENTITY, |p| placed[p].turn);
            let into = parent.map_or(DAffine3::IDENTITY, |p| placed[p].model.inverse());
            let translation = if self.is_placed(joint) {
                into.transform_point3(placed[joint].place())
            } else {
                rest.translation
            };
            Local {
                translation,
                rotation: (above.inverse() * placed[joint].turn).normalize(),
                scale: rest.scale,
            }
        };
        (0..self.partners.len()).map(local).collect()
    }

    /// Rotations of the source that a joint's local rotation comes from at most, and how far its
    /// place hangs on them in metres: 0 where it keeps its local place.
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
            // Down the limb and up again.
            let limb = self.limb(joint).and_then(|limb| self.partners[limb]);
            joints.extend(limb.into_iter().flat_map(chain).flat_map(|j| [j, j]));
            joints.extend(up);
        } else {
            let shared: Vec<usize> = joints.iter().copied().filter(|j| up.contains(j)).collect();
            joints.extend(up);
            joints.retain(|j| !shared.contains(j));
        }
        let reach = if self.is_placed(joint) { self.target.size() } else { 0.0 };
        (joints, reach)
    }

    /// The target's legs over the source's.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Names of the source's joints, in order.
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

    /// The limb that a joint belongs to and does not hang on.
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

    /// Whether a joint's place is said in model space: the root, the hips, and what does not hang
    /// on its limb.
    fn is_placed(&self, joint: usize) -> bool {
        self.is_root(joint) || self.has_role(joint, Role::Hips) || self.limb(joint).is_some()
    }

    fn is_root(&self, joint: usize) -> bool {
        self.partners[joint].is_some()
            && self.target.root() == Some(joint)
            && self.role(joint).is_none()
    }

    /// The rotation of the common pose.
    fn common_turn(&self, joint: usize) -> DQuat {
        let rest = &self.target.rest;
        let role = self.role(joint).filter(|_| self.partners[joint].is_some());
        if matches!(role, Some(Role::Foot(_) | Role::Head)) {
            return rest[joint].turn;
        }
        let guide = self.limb(joint).or_else(|| self.target.parent(joint));
        let away = guide.map_or(DQuat::IDENTITY, |g| self.common_turn(g) * rest[g].turn.inverse());
        let end = match role {
            Some(Role::UpperArm(side)) => Role::LowerArm(side),
            Some(Role::LowerArm(side)) => Role::Hand(side),
            Some(Role::UpperLeg(side)) => Role::LowerLeg(side),
            Some(Role::LowerLeg(side)) => Role::Foot(side),
            _ => return away * rest[joint].turn,
        };
        let direction = |figure: &Humanoid, joint: usize| {
            (figure.rest[figure.roles[&end]].place() - figure.rest[joint].place()).normalize()
        };
        let wanted =
            self.partners[joint].map_or(DVec3::Y, |partner| direction(&self.source, partner));
        DQuat::from_rotation_arc(away * direction(&self.target, joint), wanted)
            * away
            * rest[joint].turn
    }

    /// The target standing with these rotations, its local places those of rest but for what does
    /// not hang on its limb.
    fn stand(&self, turns: &[DQuat]) -> Vec<Placed> {
        (0..turns.len()).map(|joint| self.stand_joint(turns, joint)).collect()
    }

    fn stand_joint(&self, turns: &[DQuat], joint: usize) -> Placed {
        let rest = self.target.body.rest(joint);
        let parent = self.target.parent(joint);
        let above = parent.map_or(DAffine3::IDENTITY, |p| self.stand_joint(turns, p).model);
        let local = parent.map_or(DQuat::IDENTITY, |p| turns[p]).inverse() * turns[joint];
        let trs = DAffine3::from_scale_rotation_translation(rest.scale, local, rest.translation);
        let mut placed = Placed { turn: turns[joint], model: above * trs };
        if let Some(limb) = self.limb(joint) {
            placed.model.translation =
                self.stand_joint(turns, limb).place() + self.beside(turns[limb], joint, limb);
        }
        placed
    }

    /// From a limb to what belongs to it, where the limb turned.
    fn beside(&self, turn: DQuat, joint: usize, limb: usize) -> DVec3 {
        let rest = &self.target.rest;
        turn * rest[limb].turn.inverse() * (rest[joint].place() - rest[limb].place())
    }

    /// All joints of the target at a time.
    fn placed(&self, clip: &ClipSource, time_secs: f64) -> Vec<Placed> {
        let moving = self.source.moving(clip, time_secs);
        (0..self.partners.len()).map(|joint| self.place_joint(&moving, joint)).collect()
    }

    fn place_joint(&self, moving: &[Placed], joint: usize) -> Placed {
        let rest = self.target.body.rest(joint);
        let parent = self.target.parent(joint).map(|parent| self.place_joint(moving, parent));
        let (above, turned) =
            parent.map_or((DAffine3::IDENTITY, DQuat::IDENTITY), |p| (p.model, p.turn));
        let turn = match self.partners[joint] {
            Some(partner) => self.away(moving, partner) * self.common[joint].turn,
            None => turned * rest.rotation,
        };
        let trs = DAffine3::from_scale_rotation_translation(
            rest.scale,
            turned.inverse() * turn,
            rest.translation,
        );
        let mut placed = Placed { turn, model: above * trs };
        let Some(partner) = self.partners[joint] else {
            return placed;
        };
        let moved = |joint: usize| moving[joint].place() - self.source.rest[joint].place();
        if self.is_root(joint) {
            placed.model.translation = self.common[joint].place() + self.scale * moved(partner);
        } else if self.has_role(joint, Role::Hips) {
            let lifted = self.common[joint].place() + DVec3::Y * self.lift;
            placed.model.translation = match self.target.root().filter(|root| self.is_root(*root)) {
                None => lifted + self.scale * moved(partner),
                Some(root) => {
                    let other = self.partners[root].expect("roots have partners");
                    let (away, rest) = (self.away(moving, other), &self.source.rest);
                    let own = moving[partner].place() - moving[other].place();
                    let carried = away * (rest[partner].place() - rest[other].place());
                    self.place_joint(moving, root).place()
                        + away * (lifted - self.common[root].place())
                        + self.scale * (own - carried)
                }
            };
        } else if let Some(limb) = self.limb(joint) {
            let of = self.place_joint(moving, limb);
            placed.model.translation = of.place() + self.beside(of.turn, joint, limb);
        }
        placed
    }

    /// How a joint of the source has turned away from rest.
    fn away(&self, moving: &[Placed], joint: usize) -> DQuat {
        moving[joint].turn * self.source.rest[joint].turn.inverse()
    }

    /// How far a foot or toes sink below where they rest.
    fn depth(&self, clip: &ClipSource, time_secs: f64) -> f64 {
        let placed = self.placed(clip, time_secs);
        let soles = self.target.roles.iter().filter(|(role, joint)| {
            matches!(role, Role::Foot(_) | Role::Toes(_)) && self.partners[**joint].is_some()
        });
        soles.map(|(_, &j)| self.target.rest[j].place().y - placed[j].place().y).fold(0.0, f64::max)
    }
}

impl Humanoid {
    fn new((body, roles): (&OracleBody, &[(Role, usize)])) -> Self {
        let mut figure =
            Self { body: body.clone(), roles: roles.iter().copied().collect(), rest: Vec::new() };
        let locals: Vec<Local> = (0..body.joints.len()).map(|joint| body.rest(joint)).collect();
        figure.rest = (0..locals.len()).map(|joint| figure.place(&locals, joint)).collect();
        figure
    }

    fn parent(&self, joint: usize) -> Option<usize> {
        self.body.joints[joint].parent
    }

    fn root(&self) -> Option<usize> {
        self.parent(self.roles[&Role::Hips])
    }

    fn place(&self, locals: &[Local], joint: usize) -> Placed {
        let Local { translation, rotation, scale } = locals[joint];
        let local = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        match self.parent(joint).map(|parent| self.place(locals, parent)) {
            None => Placed { turn: rotation, model: local },
            Some(parent) => Placed { turn: parent.turn * rotation, model: parent.model * local },
        }
    }

    /// All joints as the clip moves them.
    fn moving(&self, clip: &ClipSource, time_secs: f64) -> Vec<Placed> {
        let tracks = TracksByJoint::new(clip);
        let local = |joint: usize| {
            tracks.local(&self.body.joints[joint].name, &self.body.rest(joint), time_secs)
        };
        let locals: Vec<Local> = (0..self.body.joints.len()).map(local).collect();
        (0..locals.len()).map(|joint| self.place(&locals, joint)).collect()
    }

    /// The largest side of the box around the joints at rest.
    fn size(&self) -> f64 {
        let places = || self.rest.iter().map(Placed::place);
        let low = places().fold(DVec3::INFINITY, DVec3::min);
        (places().fold(DVec3::NEG_INFINITY, DVec3::max) - low).max_element()
    }

    fn collarbone(&self, side: Side) -> bool {
        let place = |role| self.roles.get(&role).map(|&joint| self.rest[joint].place());
        let arms = [Role::UpperArm(Side::Left), Role::UpperArm(Side::Right), Role::UpperArm(side)]
            .map(place);
        let (Some(shoulder), [Some(left), Some(right), Some(arm)]) =
            (place(Role::Shoulder(side)), arms)
        else {
            return false;
        };
        let middle = (left + right) / 2.0;
        shoulder.distance(middle) < COLLARBONE * arm.distance(middle)
    }
}

/// Joints of the source by joint of the target.
fn partners(source: &Humanoid, target: &Humanoid) -> Vec<Option<usize>> {
    let mut partners = vec![None; target.body.joints.len()];
    for (role, &joint) in &target.roles {
        let fits = match role {
            Role::Spine | Role::Chest | Role::UpperChest => false,
            Role::Shoulder(side) => source.collarbone(*side) && target.collarbone(*side),
            _ => true,
        };
        partners[joint] = source.roles.get(role).copied().filter(|_| fits);
    }
    let back = |figure: &Humanoid| {
        let roles = [Role::Spine, Role::Chest, Role::UpperChest];
        roles.iter().filter_map(|role| figure.roles.get(role).copied()).collect::<Vec<_>>()
    };
    let (mut from, mut onto) = (back(source), back(target));
    // Shoulders hang on the last; the others belong together from below.
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
