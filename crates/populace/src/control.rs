//! What members look at and reach for, and how much.

use populace_device::layout;
use populace_model::JointIndex;

use crate::error::{bounded, finite};
use crate::play::{check_secs, check_weight};
use crate::{Error, Member};

/// Something to look at or to reach.
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
        member: Member,
        /// Its joint, in level order.
        joint: JointIndex,
    },
}

impl Target {
    pub(crate) fn check(&self) -> Result<(), Error> {
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
                    rule: "of some length",
                })
            }
            Self::Joint { .. } => Ok(()),
        }
    }

    /// As devices have it; of a joint, by its place among what is watched.
    pub(crate) fn device_target(&self, watched: u32) -> layout::Target {
        match *self {
            Self::Point(point) => layout::Target::in_world(point),
            Self::InModel(point) => layout::Target::in_model(point),
            Self::Direction(direction) => {
                let largest = direction.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
                layout::Target::direction(direction.map(|v| v / largest))
            }
            Self::Joint { .. } => layout::Target::watched(watched, [0.0; 3]),
        }
    }
}

impl From<[f32; 3]> for Target {
    fn from(point: [f32; 3]) -> Self {
        Self::Point(point)
    }
}

/// How much a constraint counts, and how long it takes to come to that: it eases in and out.
///
/// A call may be repeated, each frame if need be. With the same weight and time the ease goes on;
/// with another weight or time a new one begins from the weight that the constraint has. With
/// another target of the same kind ([`Target::Point`], [`Target::InModel`] or
/// [`Target::Direction`]) it depends on when the last call was:
///
/// - Less than the time to ease ago: the calls follow one moving target. The target moves at once,
///   and the ease goes on.
/// - Longer ago: the constraint eases over from the target of before to the new one.
///
/// With a target of another kind, or another joint, the constraint always eases over.
/// [`easing_over`](Self::easing_over) asks for that in any case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    pub(crate) value: f32,
    pub(crate) secs: f32,
    pub(crate) eases_over: bool,
}

impl Weight {
    /// All of it, in 0.3 seconds.
    pub const FULL: Self = Self { value: 1.0, secs: 0.3, eases_over: false };

    /// From 0 to 1, in 0.3 seconds.
    ///
    /// # Errors
    ///
    /// A value that is not from 0 to 1.
    pub fn new(value: f32) -> Result<Self, Error> {
        check_weight("the weight of a constraint", value)?;
        Ok(Self { value, ..Self::FULL })
    }

    /// In so many seconds; at once for 0.
    #[must_use]
    pub const fn over_secs(mut self, secs: f32) -> Self {
        self.secs = secs;
        self
    }

    /// Eases over to another target even where calls have followed a moving one, such as from one
    /// shop window to the next. It is for the one call with which the target changes: repeated with
    /// a moving target, the ease begins over each time.
    #[must_use]
    pub const fn easing_over(mut self) -> Self {
        self.eases_over = true;
        self
    }

    pub(crate) fn check(self) -> Result<(), Error> {
        check_weight("the weight of a constraint", self.value)?;
        check_secs("the time to come to a weight", self.secs)
    }
}

impl Default for Weight {
    fn default() -> Self {
        Self::FULL
    }
}

/// How a limb of two bones reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    pub(crate) end: JointIndex,
    pub(crate) limb: Option<[JointIndex; 2]>,
    pub(crate) pole: Option<[f32; 3]>,
    pub(crate) bend: Option<[f32; 3]>,
    pub(crate) keeps_end: bool,
}

impl Reach {
    /// With the limb that ends in a joint. Unless others are named, what bends and turns above a
    /// hand or a foot is elbow and shoulder, or knee and hip, by the character's humanoid roles;
    /// above any other joint, its parent and that one's parent.
    #[must_use]
    pub const fn with(end: JointIndex) -> Self {
        Self { end, limb: None, pole: None, bend: None, keeps_end: false }
    }

    /// Names the joint that turns, shoulder or hip, and the one that bends, elbow or knee.
    #[must_use]
    pub const fn limb(mut self, first: JointIndex, middle: JointIndex) -> Self {
        self.limb = Some([first, middle]);
        self
    }

    /// Draws the joint that bends towards a direction in model space. Without this it stays on the
    /// side where the clips have it.
    #[must_use]
    pub const fn pole(mut self, direction: [f32; 3]) -> Self {
        self.pole = Some(direction);
        self
    }

    /// Where the middle joint bends to when the limb is straight, as a direction at rest in model
    /// space. Unless named, it is where the rest pose bends, else what is usual: knees to the
    /// front, elbows of outstretched arms to the back.
    #[must_use]
    pub const fn bending(mut self, direction: [f32; 3]) -> Self {
        self.bend = Some(direction);
        self
    }

    /// Lets the end keep the rotation that it has without the constraint; else it follows the limb.
    #[must_use]
    pub const fn keeping_rotation(mut self) -> Self {
        self.keeps_end = true;
        self
    }
}
