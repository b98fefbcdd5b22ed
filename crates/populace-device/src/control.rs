//! What beside clips moves a member: overrides, constraints, and what of it others look at.

use populace_model::math::{quat, vec3};
use populace_model::{JointIndex, Skeleton, Trs};

use crate::Error;
use crate::layout::{
    Float4, LEAST_WEIGHT, LINKS_MOST, TARGET_DIRECTION, TARGET_MODEL, TARGET_WATCHED, TARGET_WORLD,
    Target,
};
use crate::playback::{is_ramp_to, ramp, ramp_rate};
use crate::stage::StageUse;

/// What a transform is relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Space {
    /// To the parent joint.
    #[default]
    Local,
    /// To the character's root.
    Model,
}

/// A transform that the host gives a joint; its children follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointOverride {
    /// The joint.
    pub joint: JointIndex,
    /// What the transform is relative to. In local space it takes the place of what clips give, and
    /// constraints work on it; in model space it has the last word.
    pub space: Space,
    /// The transform.
    pub transform: Trs,
    /// From 0, which leaves the joint as it would be, to 1. Between, translations and scales are
    /// mixed, and rotations the short way.
    pub weight: f32,
}

impl Target {
    /// A target that weighs nothing yet.
    ///
    /// `kind` is a `TARGET_` constant.
    #[must_use]
    pub fn new(kind: u32, point: [f32; 3]) -> Self {
        Self { point: Float4::from_xyz(point), kind, ..Self::default() }
    }

    /// A point in the member's model space.
    #[must_use]
    pub fn in_model(point: [f32; 3]) -> Self {
        Self::new(TARGET_MODEL, point)
    }

    /// A point in the world.
    #[must_use]
    pub fn in_world(point: [f32; 3]) -> Self {
        Self::new(TARGET_WORLD, point)
    }

    /// A direction in the world.
    #[must_use]
    pub fn direction(direction: [f32; 3]) -> Self {
        Self::new(TARGET_DIRECTION, direction)
    }

    /// What of another member is watched, and what is added to its place in the world.
    #[must_use]
    pub fn watched(watched: u32, offset: [f32; 3]) -> Self {
        Self { watched, ..Self::new(TARGET_WATCHED, offset) }
    }

    /// Lets the weight run from `from` to `to` in `secs`, a tick at least, beginning at `tick`; at
    /// once where `secs` is not above zero.
    #[must_use]
    pub fn with_ramp(mut self, tick: u64, from: f32, to: f32, secs: f32) -> Self {
        let rate = ramp_rate(from, to, secs);
        self.start_weight = if rate != 0.0 { from } else { to };
        self.end_weight = to;
        self.weight_rate = rate;
        self.weight_tick = tick;
        self
    }

    /// Lets the weight run to `to` in `secs` from where it is at `tick`. A ramp that was begun with
    /// the same `to` and `secs` goes on.
    #[must_use]
    pub fn ramped_to(self, tick: u64, to: f32, secs: f32) -> Self {
        if is_ramp_to([self.start_weight, self.weight_rate, self.end_weight], to, secs) {
            return self;
        }
        self.with_ramp(tick, self.ramp_at(tick), to, secs)
    }

    /// The weight at a time of the clock as the ramp has it, before easing.
    #[inline]
    #[must_use]
    pub fn ramp_at(&self, tick: u64) -> f32 {
        ramp(
            tick.saturating_sub(self.weight_tick),
            self.start_weight,
            self.weight_rate,
            self.end_weight,
        )
    }

    /// The weight at a time of the clock, eased where the ramp begins and ends, and 0 below
    /// [`LEAST_WEIGHT`]; the twin of `target_weight` in `kernels/targets.cl`.
    #[inline]
    #[must_use]
    pub fn weight_at(&self, tick: u64) -> f32 {
        let w = self.ramp_at(tick);
        let eased = w * w * (3.0 - 2.0 * w);
        if eased > LEAST_WEIGHT { eased } else { 0.0 }
    }
}

/// How far a gaze turns at most from the front of what carries it, in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GazeLimits {
    /// To either side, above 0 and below pi.
    pub yaw_rad: f32,
    /// Up, from 0 to below pi / 2.
    pub up_rad: f32,
    /// Down, from 0 to below pi / 2.
    pub down_rad: f32,
}

/// A chain of joints that turns to look at targets, from the first, which turns the least, to the
/// last, which faces them.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaze {
    /// Joints from the first down to the last, each with its part of the turn: parts are not
    /// negative, and are divided by their sum. Joints between that are left out do not turn.
    pub chain: Vec<(JointIndex, f32)>,
    /// Where the last joint faces at rest, in model space: +Z unless the character is built
    /// otherwise.
    pub facing: [f32; 3],
    /// How far the last joint may face away from the front of what carries the chain.
    pub limits: GazeLimits,
    /// What to look at: weights are divided by their sum where that is above 1, else the rest is
    /// left to the clips.
    pub targets: Vec<Target>,
}

/// A limb of two bones that reaches for targets, such as an arm or a leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Limb {
    /// Shoulder or hip.
    pub first: JointIndex,
    /// Elbow or knee: below `first`.
    pub middle: JointIndex,
    /// Wrist or ankle: below `middle`.
    pub end: JointIndex,
    /// Where the middle joint bends to when the limb is straight, at rest and in model space.
    pub bend: [f32; 3],
    /// Where the middle joint is drawn to, as a direction in model space; `None` leaves it where
    /// the clips have it.
    pub pole: Option<[f32; 3]>,
    /// Whether the end keeps the rotation that it has without this.
    pub keeps_end: bool,
    /// The part of the full length in which the limb straightens: a target nearer than the rest of
    /// it is met, one beyond is approached. Above 0 and up to 0.5.
    pub soft: f32,
    /// What to reach for.
    pub targets: Vec<Target>,
}

/// A chain of any length whose last joint reaches for targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The first joint to turn.
    pub first: JointIndex,
    /// The joint that is to arrive, below `first`.
    pub end: JointIndex,
    /// As in [`Limb::soft`].
    pub soft: f32,
    /// What to reach for.
    pub targets: Vec<Target>,
}

/// A foot that keeps to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The hip.
    pub hip: JointIndex,
    /// The knee.
    pub knee: JointIndex,
    /// The ankle.
    pub ankle: JointIndex,
}

/// Feet that keep to the ground, and the pelvis that sinks so that they reach it.
#[derive(Clone, Debug, PartialEq)]
pub struct Feet {
    /// The joint that carries all legs.
    pub pelvis: JointIndex,
    /// The legs, 1 to 4.
    pub feet: Vec<Foot>,
    /// How much of this is done, 0 to 1.
    pub weight: f32,
}

/// What a device solves for a member.
#[derive(Clone, Debug, PartialEq)]
pub enum Constraint {
    /// Looks at something.
    Gaze(Gaze),
    /// Reaches with two bones.
    Limb(Limb),
    /// Reaches with many.
    Chain(Chain),
    /// Stands on the ground.
    Feet(Feet),
}

/// What beside clips moves a member.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Controls {
    /// Constraints, solved in this order where they meet in a joint.
    pub constraints: Vec<Constraint>,
    /// Overrides, at most one for each joint and space.
    pub overrides: Vec<JointOverride>,
    /// Users' stages, which run in this order where they meet in a joint; each at most once.
    pub stages: Vec<StageUse>,
    /// Joints that others look at, or that are read back, each with its place among what is
    /// watched.
    pub watches: Vec<(JointIndex, u32)>,
    /// Joints that other members are attached to, each with its place there.
    pub carries: Vec<(JointIndex, u32)>,
    /// What the member itself is attached to: the place of that joint, and where the member's roots
    /// are from there.
    pub attached: Option<(u32, Trs)>,
    /// Where in [`Tables::joint_scales`](crate::Tables::joint_scales) the lengths of its joints
    /// stand.
    pub proportions: Option<u32>,
    /// Set where clips move the whole body: another number lets it begin anew where the member
    /// stands.
    pub motion: Option<u32>,
}

impl Controls {
    /// Whether there is nothing to do.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.constraints.is_empty()
            && self.overrides.is_empty()
            && self.stages.is_empty()
            && self.watches.is_empty()
            && self.carries.is_empty()
            && self.attached.is_none()
            && self.proportions.is_none()
            && self.motion.is_none()
    }
}

/// The rotation of a joint at rest in model space, as if nothing were scaled.
pub(crate) fn rest_rotation(skeleton: &Skeleton, joint: JointIndex) -> [f32; 4] {
    let own = skeleton.rest(joint).rotation;
    skeleton.parent(joint).map_or(own, |parent| quat::mul(rest_rotation(skeleton, parent), own))
}

/// A direction in model space as a joint at rest has it.
pub(crate) fn in_joint(
    skeleton: &Skeleton,
    joint: Option<JointIndex>,
    direction: [f32; 3],
) -> [f32; 3] {
    let turn = joint.map_or(quat::identity(), |joint| rest_rotation(skeleton, joint));
    vec3::turned(quat::conjugate(turn), direction)
}

/// Every joint from `first` down to `last`.
///
/// # Errors
///
/// [`Error::BadConstraint`] where the one does not lead to the other, or by too many joints.
pub(crate) fn path(
    skeleton: &Skeleton,
    first: JointIndex,
    last: JointIndex,
) -> Result<Vec<JointIndex>, Error> {
    let bad = |what: String| Err(Error::BadConstraint { what });
    for joint in [first, last] {
        if joint.index() >= skeleton.joint_count() {
            return bad(format!(
                "there is no joint {}; the skeleton has {}",
                joint.0,
                skeleton.joint_count()
            ));
        }
    }
    let mut path = vec![last];
    while path[path.len() - 1] != first {
        match skeleton.parent(path[path.len() - 1]) {
            Some(parent) => path.push(parent),
            None => {
                let (first, last) = (skeleton.name(first), skeleton.name(last));
                return bad(format!("joint \"{last}\" does not hang on joint \"{first}\""));
            }
        }
    }
    if path.len() > LINKS_MOST as usize {
        let (first, last, count) = (skeleton.name(first), skeleton.name(last), path.len());
        return bad(format!(
            "from \"{first}\" to \"{last}\" are {count} joints; a chain has {LINKS_MOST} at most"
        ));
    }
    path.reverse();
    Ok(path)
}
