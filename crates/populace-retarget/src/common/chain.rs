//! What a joint of the target computes from the source's local rotations.
//!
//! `inverse(Gt(parent)) * Gt` is, for the nearest joint above that is paired,
//! `before * path * after`, where `path` is the product of the source's local rotations from that
//! joint's partner to the own one: up, undone, and down again. Rotations that do not move are
//! multiplied into their neighbours, so most joints are left with one between two.

use glam::{DQuat, DVec3};
use populace_model::humanoid::Role;
use populace_model::{JointIndex, f64math};

use super::{Common, Figure, Pair};

/// A value of the clip that stands still, or one that moves with its rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value<T> {
    Still(T),
    Moving,
}

/// What a clip does to a joint of its own skeleton.
pub(crate) struct ColumnMotion {
    pub(crate) rotation: Value<DQuat>,
    pub(crate) translation: Value<DVec3>,
}

/// A rotation of the source on the way, and what is added to the translation before it turns.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    /// The source's joint, of what moves.
    pub(crate) column: JointIndex,
    /// The rotation moves; else it is none.
    pub(crate) turns: bool,
    /// The rotation is undone.
    pub(crate) undone: bool,
    /// Added to the translation, in the space of the rotation so far.
    pub(crate) arm: DVec3,
    /// And so many times the source's translation where that moves; else 0.
    pub(crate) arm_scale: f64,
    /// A rotation that follows.
    pub(crate) after: DQuat,
}

/// A joint's local rotation is `before` times, for each link, its rotation times its `after`; the
/// local translation is `base` and the arms.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) before: DQuat,
    /// `None` where the translation stays at rest.
    pub(crate) base: Option<DVec3>,
    pub(crate) links: Vec<Link>,
}

/// A step on the way, not yet folded.
struct Step {
    link: Link,
    still: DQuat,
}

/// Lays out the way to one joint.
struct Walk<'a> {
    common: &'a Common<'a>,
    motion: &'a dyn Fn(JointIndex) -> ColumnMotion,
    /// From lengths in the source's model space to those of the target's parent.
    per_metre: f64,
    steps: Vec<Step>,
    /// What the next step adds to the translation.
    arm: DVec3,
}

impl Common<'_> {
    /// The joint of the source that a joint of the target follows.
    pub(crate) fn partner(&self, joint: JointIndex) -> Option<JointIndex> {
        self.pairs[joint.index()].map(|pair| pair.source)
    }

    /// What a joint of the target computes; `None` where it keeps its rest.
    pub(crate) fn chain(
        &self,
        joint: JointIndex,
        motion: &dyn Fn(JointIndex) -> ColumnMotion,
    ) -> Option<Chain> {
        let Pair { source, .. } = self.pairs[joint.index()]?;
        let skeleton = self.target.skeleton;
        let parent = skeleton.parent(joint);
        let above = skeleton.ancestors(joint).find_map(|a| Some((a, self.partner(a)?)));
        let parent_turn = parent.map_or(DQuat::IDENTITY, |p| self.turn[p.index()]);
        let space = self.target.scale(parent);
        let mut walk = Walk {
            common: self,
            motion,
            per_metre: self.scale / space,
            steps: Vec::new(),
            arm: DVec3::ZERO,
        };
        let way = self.way(joint, above.map(|(a, _)| a));
        let moves = way.len() > 1 || self.is_carried(joint);
        let from_parent = |to: JointIndex| {
            let start = parent.map_or(DVec3::ZERO, |p| self.place[p.index()]);
            parent_turn.inverse() * (self.place_of(to) - start) / space
        };
        let base = moves.then(|| from_parent(way[0]));
        let mut at = above.map(|(_, source)| source);
        for (n, &stop) in way.iter().enumerate() {
            let partner = self.partner(stop)?;
            walk.path(at, partner, self.is_carried(stop));
            if let Some(&next) = way.get(n + 1) {
                let arm = self.place_of(next) - self.place_of(stop);
                walk.arm += self.source.turn[partner.index()].inverse() * arm / space;
            }
            at = Some(partner);
        }
        let before = parent_turn.inverse()
            * above.map_or(DQuat::IDENTITY, |(_, s)| self.source.turn[s.index()]);
        let after = self.source.turn[source.index()].inverse() * self.turn[joint.index()];
        Some(fold(Chain { before, base, links: Vec::new() }, walk, after))
    }

    /// Joints of the target through whose places the way to a joint leads, itself last: those that
    /// it should hang on and does not.
    fn way(&self, joint: JointIndex, above: Option<JointIndex>) -> Vec<JointIndex> {
        let Some(of) = self.detached(joint) else {
            return vec![joint];
        };
        let skeleton = self.target.skeleton;
        let reached = above.is_none_or(|above| skeleton.is_below(of, above) || of == above);
        let chain = std::iter::once(of).chain(skeleton.ancestors(of));
        let mut way: Vec<_> = chain
            .take_while(|j| Some(*j) != above)
            .filter(|j| self.partner(*j).is_some())
            .collect();
        // What hangs on neither is left where it is.
        if !reached {
            way.clear();
        }
        way.reverse();
        way.push(joint);
        way
    }

    /// Whether the source's translations carry a joint: the root and the hips.
    fn is_carried(&self, joint: JointIndex) -> bool {
        self.pairs[joint.index()].is_some_and(|pair| matches!(pair.role, None | Some(Role::Hips)))
    }

    /// A place of the common pose, the whole body lifted so that feet are on the ground; the root
    /// stays there.
    pub(super) fn place_of(&self, joint: JointIndex) -> DVec3 {
        let is_root = self.pairs[joint.index()].is_some_and(|pair| pair.role.is_none());
        let lift = if is_root { 0.0 } else { self.lift };
        self.place[joint.index()] + DVec3::new(0.0, lift, 0.0)
    }
}

impl Walk<'_> {
    /// From a joint of the source to another; from none, from above all. Where translations are
    /// carried, what they are at rest is taken off.
    fn path(&mut self, from: Option<JointIndex>, to: JointIndex, carried: bool) {
        let source = &self.common.source;
        let upwards: Vec<JointIndex> = from
            .into_iter()
            .flat_map(|f| std::iter::once(f).chain(source.skeleton.ancestors(f)))
            .collect();
        let downwards: Vec<JointIndex> = std::iter::once(to)
            .chain(source.skeleton.ancestors(to))
            .take_while(|j| !upwards.contains(j))
            .collect();
        let meets = downwards.last().map_or(Some(to), |top| source.skeleton.parent(*top));
        for &joint in upwards.iter().take_while(|j| Some(**j) != meets) {
            self.step(joint, true, None);
        }
        if carried {
            self.arm -= rest_offset(source, &downwards, |joint| self.metres(joint));
        }
        for &joint in downwards.iter().rev() {
            let metres = carried.then(|| self.metres(joint));
            self.step(joint, false, metres);
        }
    }

    /// From the units of a joint's translation to those of the target's parent.
    fn metres(&self, joint: JointIndex) -> f64 {
        let source = &self.common.source;
        self.per_metre * source.scale(source.skeleton.parent(joint))
    }

    fn step(&mut self, joint: JointIndex, undone: bool, carried: Option<f64>) {
        let motion = (self.motion)(joint);
        let (turns, still) = match motion.rotation {
            Value::Moving => (true, DQuat::IDENTITY),
            Value::Still(turn) if undone => (false, turn.inverse()),
            Value::Still(turn) => (false, turn),
        };
        let mut arm = std::mem::take(&mut self.arm);
        let mut arm_scale = 0.0;
        if let Some(scale) = carried {
            match motion.translation {
                Value::Moving => arm_scale = scale,
                Value::Still(translation) => arm += scale * translation,
            }
        }
        let link = Link { column: joint, turns, undone, arm, arm_scale, after: DQuat::IDENTITY };
        self.steps.push(Step { link, still });
    }
}

/// How far the source's joints down to one lead at rest, in the space of the joint that the first
/// hangs on.
fn rest_offset(
    source: &Figure<'_>,
    downwards: &[JointIndex],
    scale: impl Fn(JointIndex) -> f64,
) -> DVec3 {
    let (mut offset, mut turn) = (DVec3::ZERO, DQuat::IDENTITY);
    for &joint in downwards.iter().rev() {
        let rest = source.skeleton.rest(joint);
        offset += turn * (scale(joint) * f64math::vec3(rest.translation));
        turn *= f64math::quat(rest.rotation).normalize();
    }
    offset
}

/// Multiplies what stands still into what does not.
fn fold(mut chain: Chain, walk: Walk<'_>, after: DQuat) -> Chain {
    let mut arm = DVec3::ZERO;
    for Step { mut link, still } in walk.steps {
        link.arm += arm;
        arm = DVec3::ZERO;
        if link.turns || link.arm_scale != 0.0 {
            link.after = still;
            chain.links.push(link);
        } else if let Some(last) = chain.links.last_mut() {
            last.after *= still;
            arm = still.inverse() * link.arm;
        } else {
            chain.base = chain.base.map(|base| base + chain.before * link.arm);
            chain.before *= still;
        }
    }
    arm += walk.arm;
    match chain.links.last_mut() {
        None => {
            chain.base = chain.base.map(|base| base + chain.before * arm);
            chain.before *= after;
        }
        Some(last) if arm == DVec3::ZERO => last.after *= after,
        Some(last) => {
            let column = last.column;
            chain.links.push(Link {
                column,
                turns: false,
                undone: false,
                arm,
                arm_scale: 0.0,
                after,
            });
        }
    }
    chain
}
