//! Targets, weights and settings of look-at and IK constraints.

use populace_device::GazeLimits;
use populace_device::layout;
use populace_model::JointIndex;

use crate::check::{Check, bounded, check_secs, check_weight, finite};
use crate::error::Error;
use crate::fault::Allowed;
use crate::ids::MemberId;

/// The target of a look-at or reach constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// A point in the world, in metres.
    Point([f32; 3]),
    /// A point in the member's own model space, in metres.
    InModel([f32; 3]),
    /// A direction in the world, of any length above 0.
    Direction([f32; 3]),
    /// A joint of another member, where it was in the frame before.
    Joint {
        /// The other member.
        member: MemberId,
        /// Its joint, in level order.
        joint: JointIndex,
    },
}

impl Check for Target {
    fn check(&self) -> Result<(), Error> {
        match self {
            Self::Point(v) | Self::InModel(v) => bounded("a target", v),
            Self::Direction(v) => {
                finite("the direction of a target", v)?;
                if v.iter().any(|v| *v != 0.0) {
                    return Ok(());
                }
                Err(Error::BadValue {
                    what: "the direction of a target",
                    value: 0.0,
                    allowed: Allowed::SomeLength,
                })
            }
            Self::Joint { .. } => Ok(()),
        }
    }
}

/// Returns a target as devices store it; `watched` is the index of a watched joint.
#[must_use]
pub fn device_target(target: &Target, watched: u32) -> layout::Target {
    match *target {
        Target::Point(point) => layout::Target::in_world(point),
        Target::InModel(point) => layout::Target::in_model(point),
        Target::Direction(direction) => {
            let largest = direction.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
            layout::Target::direction(direction.map(|v| v / largest))
        }
        Target::Joint { .. } => layout::Target::watched(watched, [0.0; 3]),
    }
}

impl From<[f32; 3]> for Target {
    fn from(point: [f32; 3]) -> Self {
        Self::Point(point)
    }
}

/// A look-at constraint: the joints that share the rotation, and how far they turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaze {
    /// The joints, from the root towards the one that is to face the target, each with its share of
    /// the rotation. The shares are relative to each other.
    pub chain: Vec<(JointIndex, f32)>,
    /// The direction that the last joint faces at rest, in model space, of any length above 0.
    pub facing: [f32; 3],
    /// The limits of the rotation.
    pub limits: GazeLimits,
}

/// The weight of a constraint, and the time in which it eases to that weight.
///
/// A call may be repeated in every frame. With the same weight and time the ease continues; with
/// another weight or time a new ease starts from the constraint's present weight. With another
/// target of the same kind ([`Target::Point`], [`Target::InModel`] or
/// [`Target::Direction`]) it depends on the time since the
/// last call:
///
/// - Less than the ease time: the calls follow one moving target. The target moves at once, and the
///   ease continues.
/// - More: the constraint eases from the earlier target to the new one.
///
/// With a target of another kind, or another joint, the constraint always eases over.
/// [`easing_over`](Self::easing_over) forces it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight(pub(crate) WeightParts);

/// The parts of a [`Weight`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightParts {
    /// The weight, 0 to 1.
    pub value: f32,
    /// The ease time.
    pub secs: f32,
    /// Whether the constraint eases over to another target in any case.
    pub eases_over: bool,
}

impl Weight {
    /// Weight 1, reached in 0.3 seconds.
    pub const FULL: Self = Self(WeightParts { value: 1.0, secs: 0.3, eases_over: false });

    /// Returns a weight of 0 to 1 that is reached in 0.3 seconds.
    ///
    /// # Errors
    ///
    /// A value that is not from 0 to 1.
    pub fn new(value: f32) -> Result<Self, Error> {
        check_weight("the weight of a constraint", value)?;
        Ok(Self(WeightParts { value, ..Self::FULL.0 }))
    }

    /// Sets the ease time; 0 applies the weight at once.
    #[must_use]
    pub const fn over_secs(mut self, secs: f32) -> Self {
        self.0.secs = secs;
        self
    }

    /// Eases over to another target even if recent calls followed a moving one, such as from one
    /// shop window to the next. Use it for the one call that changes the target: repeated with a
    /// moving target, each call restarts the ease.
    #[must_use]
    pub const fn easing_over(mut self) -> Self {
        self.0.eases_over = true;
        self
    }
}

impl Check for Weight {
    fn check(&self) -> Result<(), Error> {
        check_weight("the weight of a constraint", self.0.value)?;
        check_secs("the time to come to a weight", self.0.secs)
    }
}

impl Default for Weight {
    fn default() -> Self {
        Self::FULL
    }
}

/// Settings of two-bone IK.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach(pub(crate) ReachParts);

/// The parts of a [`Reach`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachParts {
    /// The joint that meets the target.
    pub end: JointIndex,
    /// The first and the middle joint of the limb, where set.
    pub limb: Option<[JointIndex; 2]>,
    /// The direction towards which the middle joint is pulled, in model space.
    pub pole: Option<[f32; 3]>,
    /// The direction in which a straight limb bends, at rest in model space.
    pub bend: Option<[f32; 3]>,
    /// Whether the end keeps its rotation.
    pub keeps_end: bool,
}

impl Reach {
    /// Selects the limb that ends in `end`. For a hand or a foot the humanoid roles name elbow and
    /// shoulder, or knee and hip; for any other joint the limb consists of its parent and
    /// grandparent.
    #[must_use]
    pub const fn with(end: JointIndex) -> Self {
        Self(ReachParts { end, limb: None, pole: None, bend: None, keeps_end: false })
    }

    /// Sets the first joint (shoulder, hip) and the middle joint (elbow, knee) of the limb.
    #[must_use]
    pub const fn limb(mut self, first: JointIndex, middle: JointIndex) -> Self {
        self.0.limb = Some([first, middle]);
        self
    }

    /// Pulls the middle joint towards a direction in model space, of any length above 0. Without a
    /// pole it bends to the side to which the clips bend it.
    #[must_use]
    pub const fn pole(mut self, direction: [f32; 3]) -> Self {
        self.0.pole = Some(direction);
        self
    }

    /// Sets the direction in which a straight limb bends, at rest in model space. Unless set it is
    /// the bend of the rest pose; a straight rest pose bends knees to the front and elbows to the
    /// back.
    #[must_use]
    pub const fn bending(mut self, direction: [f32; 3]) -> Self {
        self.0.bend = Some(direction);
        self
    }

    /// Keeps the rotation that the end has without the constraint. Otherwise it follows the limb.
    #[must_use]
    pub const fn keeping_rotation(mut self) -> Self {
        self.0.keeps_end = true;
        self
    }
}
