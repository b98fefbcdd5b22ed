//! Computation of a target joint from local rotations of the source.
//!
//! Let *above* be the nearest paired ancestor of a target joint. Its local rotation
//! `inverse(Gt(parent)) * Gt` is `before * path * after`. `path` is the product of the source's
//! local rotations from the partner of *above* to the joint's own partner: inverted on the way up,
//! then plain on the way down. `before` and `after` are constant.

use glam::{DQuat, DVec3};
use populace_clip::{Clip, Local};
use populace_model::humanoid::Role;
use populace_model::{JointIndex, f64math};

use super::{Common, Figure, Pair};

/// A step along a path: a rotation of the source, and the arm that is added to the translation
/// before it.
#[derive(Clone, Debug)]
struct Step {
    /// The source joint.
    joint: JointIndex,
    /// True if the rotation is inverted.
    undone: bool,
    /// Offset added to the translation, in the space of the rotation so far.
    arm: DVec3,
    /// Factor of the source's translation, which is added too; 0 if it is not.
    arm_scale: f64,
}

/// The way to a joint's local transform. The rotation is `before`, multiplied for each step by its
/// rotation, and by `after`. The translation is `base` plus the arms.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    before: DQuat,
    /// `None` if the translation stays at rest.
    base: Option<DVec3>,
    steps: Vec<Step>,
    /// Offset added to the translation before `after`.
    arm: DVec3,
    after: DQuat,
}

impl Chain {
    /// Returns whether the translation leaves its rest.
    pub(crate) fn moves(&self) -> bool {
        self.base.is_some()
    }

    /// Returns the joint's local transform in a pose of the source's joints.
    pub(crate) fn local(&self, rest: &Local, pose: &[Local]) -> Local {
        let (mut rotation, mut offset) = (self.before, DVec3::ZERO);
        for Step { joint, undone, arm, arm_scale } in &self.steps {
            let source = &pose[joint.index()];
            offset += rotation * (*arm + *arm_scale * source.translation);
            rotation *= if *undone { source.rotation.conjugate() } else { source.rotation };
        }
        offset += rotation * self.arm;
        Local {
            rotation: (rotation * self.after).normalize(),
            translation: self.base.map_or(rest.translation, |base| base + offset),
            scale: rest.scale,
        }
    }
}

/// Collects the path to one joint.
struct Walk<'a> {
    common: &'a Common<'a>,
    /// Ratio of lengths in the space of the target's parent to those in the source's model space.
    per_metre: f64,
    steps: Vec<Step>,
    /// Offset that the next step adds to the translation.
    arm: DVec3,
}

impl Common<'_> {
    /// Returns the source joint that a target joint follows.
    pub(crate) fn partner(&self, joint: JointIndex) -> Option<JointIndex> {
        self.pairs[joint.index()].map(|pair| pair.source)
    }

    /// Iterates over the target joints whose partners a clip drives.
    pub(crate) fn driven_joints(&self, clip: &Clip) -> impl Iterator<Item = JointIndex> {
        let driven = |joint: &JointIndex| self.partner(*joint).is_some_and(|of| clip.drives(of));
        self.target.skeleton.joints().filter(driven)
    }

    /// Returns the way to a target joint; `None` if it keeps its rest.
    pub(crate) fn chain(&self, joint: JointIndex) -> Option<Chain> {
        let Pair { source, .. } = self.pairs[joint.index()]?;
        let skeleton = self.target.skeleton;
        let parent = skeleton.parent(joint);
        let above = skeleton.ancestors(joint).find_map(|a| Some((a, self.partner(a)?)));
        let parent_rotation = parent.map_or(DQuat::IDENTITY, |p| self.rotation[p.index()]);
        let space = self.target.scale(parent);
        let mut walk = Walk {
            common: self,
            per_metre: self.scale / space,
            steps: Vec::new(),
            arm: DVec3::ZERO,
        };
        let waypoints = self.waypoints(joint, above.map(|(a, _)| a));
        let moves = waypoints.len() > 1 || self.is_carried(joint);
        let from_parent = |to: JointIndex| {
            let start = parent.map_or(DVec3::ZERO, |p| self.position[p.index()]);
            parent_rotation.inverse() * (self.raised_position(to) - start) / space
        };
        let base = moves.then(|| from_parent(waypoints[0]));
        let mut at = above.map(|(_, source)| source);
        for (n, &stop) in waypoints.iter().enumerate() {
            let partner = self.partner(stop)?;
            walk.path(at, partner, self.is_carried(stop));
            if let Some(&next) = waypoints.get(n + 1) {
                let arm = self.raised_position(next) - self.raised_position(stop);
                walk.arm += self.source.rotation[partner.index()].inverse() * arm / space;
            }
            at = Some(partner);
        }
        let before = parent_rotation.inverse()
            * above.map_or(DQuat::IDENTITY, |(_, s)| self.source.rotation[s.index()]);
        let after = self.source.rotation[source.index()].inverse() * self.rotation[joint.index()];
        Some(Chain { before, base, steps: walk.steps, arm: walk.arm, after })
    }

    /// Returns the target joints through whose positions the path to a detached joint leads, ending
    /// with the joint itself.
    fn waypoints(&self, joint: JointIndex, above: Option<JointIndex>) -> Vec<JointIndex> {
        let Some(of) = self.detached(joint) else {
            return vec![joint];
        };
        let skeleton = self.target.skeleton;
        let reached = above.is_none_or(|above| skeleton.is_below(of, above) || of == above);
        let chain = std::iter::once(of).chain(skeleton.ancestors(of));
        let mut waypoints: Vec<_> = chain
            .take_while(|j| Some(*j) != above)
            .filter(|j| self.partner(*j).is_some())
            .collect();
        // If the joint descends from neither, it stays where it is.
        if !reached {
            waypoints.clear();
        }
        waypoints.reverse();
        waypoints.push(joint);
        waypoints
    }

    /// Returns whether translations of the source move the joint: the root and the hips.
    fn is_carried(&self, joint: JointIndex) -> bool {
        self.pairs[joint.index()].is_some_and(|pair| matches!(pair.role, None | Some(Role::Hips)))
    }

    /// Returns a position of the common pose, raised so that the feet are on the ground. The root
    /// is not raised.
    pub(super) fn raised_position(&self, joint: JointIndex) -> DVec3 {
        let is_root = self.pairs[joint.index()].is_some_and(|pair| pair.role.is_none());
        let lift = if is_root { 0.0 } else { self.lift };
        self.position[joint.index()] + DVec3::new(0.0, lift, 0.0)
    }
}

impl Walk<'_> {
    /// Adds the path from one source joint to another, or from above all roots. If translations are
    /// carried, their rest is subtracted.
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

    /// Returns the ratio of lengths in the space of the target's parent to those of the joint's
    /// translation.
    fn metres(&self, joint: JointIndex) -> f64 {
        let source = &self.common.source;
        self.per_metre * source.scale(source.skeleton.parent(joint))
    }

    fn step(&mut self, joint: JointIndex, undone: bool, carried: Option<f64>) {
        let arm = std::mem::take(&mut self.arm);
        self.steps.push(Step { joint, undone, arm, arm_scale: carried.unwrap_or_default() });
    }
}

/// Returns the offset at rest over the source joints in `downwards`, in the space of the parent of
/// the topmost.
fn rest_offset(
    source: &Figure<'_>,
    downwards: &[JointIndex],
    scale: impl Fn(JointIndex) -> f64,
) -> DVec3 {
    let (mut offset, mut rotation) = (DVec3::ZERO, DQuat::IDENTITY);
    for &joint in downwards.iter().rev() {
        let rest = source.skeleton.rest(joint);
        offset += rotation * (scale(joint) * f64math::vec3(rest.translation));
        rotation *= f64math::quat(rest.rotation).normalize();
    }
    offset
}
