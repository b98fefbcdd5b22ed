//! Constraint programs: overrides, constraints, stages and attachments that move a member besides
//! its clips.

use std::f32::consts::PI;

use populace_model::math::{quat, vec3};
use populace_model::{JointIndex, Skeleton, Trs};

use crate::Error;
use crate::fault::ConstraintFault;
use crate::layout::{
    Float4, LEAST_WEIGHT, MAX_LINKS, TARGET_DIRECTION, TARGET_MODEL, TARGET_WATCHED, TARGET_WORLD,
    Target,
};
use crate::playback::{is_ramp_to, ramp, ramp_rate};
use crate::stage::StageUse;

/// The space that a transform is relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Space {
    /// Relative to the parent joint.
    #[default]
    Local,
    /// Relative to the character's root.
    Model,
}

/// A transform that the host sets on a joint. Its descendants follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointOverride {
    /// The joint.
    pub joint: JointIndex,
    /// The space of the transform. In local space it replaces the clips' transform, and constraints
    /// are applied on top. In model space it is applied last.
    pub space: Space,
    /// The transform.
    pub transform: Trs,
    /// Weight from 0 (no effect) to 1. In between, translations and scales are interpolated
    /// linearly, rotations along the shorter arc.
    pub weight: f32,
}

impl Target {
    /// Creates a target of weight 0.
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

    /// A joint of another member, by the index of the watched joint, with an offset in world space.
    #[must_use]
    pub fn watched(watched: u32, offset: [f32; 3]) -> Self {
        Self { watched, ..Self::new(TARGET_WATCHED, offset) }
    }

    /// Changes the weight `from` one value `to` another in `secs`, at least one tick, beginning at
    /// `tick`. The change is immediate if `secs` is not above zero.
    #[must_use]
    pub fn with_ramp(mut self, tick: u64, from: f32, to: f32, secs: f32) -> Self {
        let rate = ramp_rate(from, to, secs);
        self.start_weight = if rate != 0.0 { from } else { to };
        self.end_weight = to;
        self.weight_rate = rate;
        self.weight_tick = tick;
        self
    }

    /// Changes the weight to `to` in `secs`, from its value at `tick`. A ramp that was created with
    /// the same `to` and `secs` continues.
    #[must_use]
    pub fn ramped_to(self, tick: u64, to: f32, secs: f32) -> Self {
        if is_ramp_to([self.start_weight, self.weight_rate, self.end_weight], to, secs) {
            return self;
        }
        self.with_ramp(tick, self.ramp_at(tick), to, secs)
    }

    /// The weight of the linear ramp at a clock tick, before easing.
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

    /// The weight at a clock tick, eased at both ends of the ramp, and 0 up to [`LEAST_WEIGHT`].
    /// Twin of `target_weight` in `kernels/targets.cl`.
    #[inline]
    #[must_use]
    pub fn weight_at(&self, tick: u64) -> f32 {
        let w = self.ramp_at(tick);
        let eased = w * w * (3.0 - 2.0 * w);
        if eased > LEAST_WEIGHT { eased } else { 0.0 }
    }
}

/// Maximum angles of a gaze from the front of the joint above its chain, in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GazeLimits {
    /// Maximum angle to either side, above 0 and below pi.
    pub yaw_rad: f32,
    /// Maximum angle up, from 0 to below pi / 2.
    pub up_rad: f32,
    /// Maximum angle down, from 0 to below pi / 2.
    pub down_rad: f32,
}

impl GazeLimits {
    /// The limits of a human head and back together: 85 degrees to either side, 45 up, 50 down.
    pub const HEAD: Self =
        Self { yaw_rad: 85.0 / 180.0 * PI, up_rad: 45.0 / 180.0 * PI, down_rad: 50.0 / 180.0 * PI };
}

impl Default for GazeLimits {
    /// Returns the limits of a [head](Self::HEAD).
    fn default() -> Self {
        Self::HEAD
    }
}

/// A look-at constraint: a chain of joints turns so that its last joint faces the targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaze {
    /// Joints from the first down to the last, each with its share of the rotation. Shares are not
    /// negative and are divided by their sum. Joints in between that are not listed do not turn.
    pub chain: Vec<(JointIndex, f32)>,
    /// Facing direction of the last joint at rest, in model space, of any length above 0; +Z for
    /// usual characters.
    pub facing: [f32; 3],
    /// Maximum angles between the last joint's facing and the front of the joint above the chain.
    pub limits: GazeLimits,
    /// Targets to look at. Their weights are divided by their sum if it is above 1; otherwise the
    /// clips get the remaining weight.
    pub targets: Vec<Target>,
}

/// A two-bone IK constraint on a limb, such as an arm or a leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Limb {
    /// Shoulder or hip.
    pub first: JointIndex,
    /// Elbow or knee: below `first`.
    pub middle: JointIndex,
    /// Wrist or ankle: below `middle`.
    pub end: JointIndex,
    /// Direction in which the middle joint bends if the limb is straight, at rest and in model
    /// space.
    pub bend: [f32; 3],
    /// Pole: the direction in model space that the middle joint points to; `None` leaves it where
    /// the clips have it.
    pub pole: Option<[f32; 3]>,
    /// True if the end joint keeps the rotation that it has without the constraint.
    pub keeps_end: bool,
    /// Fraction of the limb's length over which it straightens, above 0 and up to 0.5. A target
    /// within the remaining length is reached exactly, one beyond is only approached.
    pub soft: f32,
    /// Targets to reach for.
    pub targets: Vec<Target>,
}

/// An IK constraint on a chain of any length, whose last joint reaches for targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The first joint to turn.
    pub first: JointIndex,
    /// The joint that reaches the target, below `first`.
    pub end: JointIndex,
    /// As in [`Limb::soft`].
    pub soft: f32,
    /// Targets to reach for.
    pub targets: Vec<Target>,
}

/// A leg of a [`Feet`] constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The hip.
    pub hip: JointIndex,
    /// The knee.
    pub knee: JointIndex,
    /// The ankle.
    pub ankle: JointIndex,
}

/// Feet that stay on the ground, and a pelvis that is lowered so that they reach it.
#[derive(Clone, Debug, PartialEq)]
pub struct Feet {
    /// The joint that all legs descend from.
    pub pelvis: JointIndex,
    /// The legs, 1 to 4.
    pub feet: Vec<Foot>,
    /// Weight of the constraint, 0 to 1.
    pub weight: f32,
}

/// A constraint that devices solve for a member.
#[derive(Clone, Debug, PartialEq)]
pub enum Constraint {
    /// Looks at targets.
    Gaze(Gaze),
    /// Reaches for targets with two bones.
    Limb(Limb),
    /// Reaches for targets with a chain of any length.
    Chain(Chain),
    /// Keeps feet on the ground.
    Feet(Feet),
}

/// The constraint program of a member: all that moves it besides its clips.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Controls {
    /// Constraints, solved in this order if they share a joint.
    pub constraints: Vec<Constraint>,
    /// Overrides, at most one per joint and space.
    pub overrides: Vec<JointOverride>,
    /// User stages, run in this order if they share a joint; each stage at most once.
    pub stages: Vec<StageUse>,
    /// Joints that other members look at or that are read back, each with its index of a watched
    /// joint.
    pub watches: Vec<(JointIndex, u32)>,
    /// Joints that other members are attached to, each with its index of a watched joint.
    pub carries: Vec<(JointIndex, u32)>,
    /// Attachment of the member: the index of the parent's watched joint, and the transform of the
    /// member's roots relative to that joint.
    pub attached: Option<(u32, Trs)>,
    /// Offset in [`Tables::joint_scales`](crate::Tables::joint_scales) of the length factors of the
    /// member's joints.
    pub proportions: Option<u32>,
    /// Set if clips move the whole body. A different number restarts root motion where the member
    /// stands.
    pub motion: Option<u32>,
}

impl Controls {
    /// Returns whether the program does nothing.
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
    let up = std::iter::successors(Some(joint), |joint| skeleton.parent(*joint));
    let rotations: Vec<_> = up.map(|joint| skeleton.rest(joint).rotation).collect();
    rotations.into_iter().rev().reduce(quat::mul).unwrap_or(quat::identity())
}

/// Converts a direction from model space to the space of a joint at rest.
pub(crate) fn in_joint(
    skeleton: &Skeleton,
    joint: Option<JointIndex>,
    direction: [f32; 3],
) -> [f32; 3] {
    let rotation = joint.map_or(quat::identity(), |joint| rest_rotation(skeleton, joint));
    vec3::rotated(quat::conjugate(rotation), direction)
}

/// Returns every joint from `first` down to `last`.
///
/// # Errors
///
/// [`Error::BadConstraint`] if `last` is not below `first` or the chain has more than
/// [`MAX_LINKS`] joints.
pub(crate) fn path(
    skeleton: &Skeleton,
    first: JointIndex,
    last: JointIndex,
) -> Result<Vec<JointIndex>, Error> {
    let named = |joint: JointIndex| skeleton.name(joint).to_owned();
    for joint in [first, last] {
        if joint.index() >= skeleton.joint_count() {
            let (joint, count) = (joint.0, skeleton.joint_count());
            return Err(ConstraintFault::NoJoint { joint, count }.into());
        }
    }
    let mut path = vec![last];
    while path[path.len() - 1] != first {
        match skeleton.parent(path[path.len() - 1]) {
            Some(parent) => path.push(parent),
            None => {
                let (first, last) = (named(first), named(last));
                return Err(ConstraintFault::NotBelow { first, last }.into());
            }
        }
    }
    if path.len() > MAX_LINKS as usize {
        let (first, last, count) = (named(first), named(last), path.len());
        return Err(ConstraintFault::LongChain { first, last, count }.into());
    }
    path.reverse();
    Ok(path)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_1_SQRT_2;

    use populace_model::{JointSource, Trs};

    use super::*;

    #[test]
    fn rest_rotations_of_long_chains_need_no_deep_stack() {
        let quarter = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
        let link = |index: usize| JointSource {
            name: format!("link {index}"),
            parent: index.checked_sub(1),
            rest: if index < 3 {
                Trs { rotation: quarter, ..Trs::IDENTITY }
            } else {
                Trs::IDENTITY
            },
        };
        let skeleton = Skeleton::new(&(0..100_000).map(link).collect::<Vec<_>>()).unwrap();
        let [x, y, z, w] = rest_rotation(&skeleton, JointIndex(99_999));
        assert_eq!([x, y], [0.0; 2]);
        assert!((z - FRAC_1_SQRT_2).abs() < 1e-6 && (w + FRAC_1_SQRT_2).abs() < 1e-6, "{z} {w}");
    }
}
