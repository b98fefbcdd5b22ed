//! Defects of constraint programs and user stages.

use std::fmt;

use populace_model::{LARGEST, LARGEST_SCALE};

use crate::layout::{MAX_FEET, MAX_LINKS, MAX_STAGES, MAX_STEP_ROTATIONS};

/// The defect of a user stage.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StageFault {
    /// A name that is no identifier of C.
    #[error("a name consists of A to Z, a to z, 0 to 9 and _, and does not begin with a digit")]
    Name,
    /// A stage without any function.
    #[error("it needs a text in OpenCL C, a function in Rust, or both")]
    NoForm,
    /// A zero character in the text.
    #[error("its text in OpenCL C contains a zero character")]
    ZeroCharacter,
    /// A stage too many.
    #[error(
        "the crowd already has {MAX_STAGES} stages, the most that are possible; remove one first"
    )]
    TooMany,
    /// A name that another stage has.
    #[error("another stage defines a different function \"{other}\"; rename one of them")]
    NameTaken {
        /// The name that both have.
        other: String,
    },
}

/// The defect of a constraint, an override, an attachment or the ground. Joints are given by name.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConstraintFault {
    /// A joint that the skeleton does not have.
    #[error("there is no joint {joint}; the skeleton has {count}")]
    NoJoint {
        /// The joint's index.
        joint: u32,
        /// Joints of the skeleton.
        count: usize,
    },
    /// A body with too few joints.
    #[error("constraints need bodies of at least {needed} joints, not {count}")]
    TooFewJoints {
        /// Joints that are needed.
        needed: usize,
        /// Joints of the skeleton.
        count: usize,
    },
    /// The end of a chain that is not below its first joint.
    #[error("joint \"{last}\" is not below joint \"{first}\"")]
    NotBelow {
        /// The first joint.
        first: String,
        /// The end.
        last: String,
    },
    /// A chain of too many joints.
    #[error(
        "the chain from \"{first}\" to \"{last}\" has {count} joints; at most {MAX_LINKS} are \
         supported"
    )]
    LongChain {
        /// The first joint.
        first: String,
        /// The end.
        last: String,
        /// Number of joints.
        count: usize,
    },
    /// A chain of one joint.
    #[error("a chain needs at least two joints")]
    ShortChain,
    /// A program in which too many joints are rotated one after the other.
    #[error(
        "the constraints of a member rotate {count} joints in sequence; at most \
         {MAX_STEP_ROTATIONS} are supported"
    )]
    TooManyRotations {
        /// Number of rotations.
        count: usize,
    },
    /// A value that is not finite.
    #[error("{part} has a value that is not finite")]
    NotFinite {
        /// Where the value is.
        part: ConstraintPart,
    },
    /// A value that is not finite or too large.
    #[error("{part} has a value that is not finite or whose magnitude exceeds {LARGEST:e}")]
    NotBounded {
        /// Where the value is.
        part: ConstraintPart,
    },
    /// A transform that no joint can have.
    #[error(
        "{part} needs finite values, a translation of at most {LARGEST:e}, scales of at most \
         {LARGEST_SCALE:e} and a rotation of length 1"
    )]
    Transform {
        /// The use of the transform.
        part: ConstraintPart,
    },
    /// A height field whose numbers do not fit each other.
    #[error(
        "a height field has {heights} heights in rows of {count_x}, {spacing_m} m apart; it needs \
         whole rows, at least two samples in each direction, heights of at most {LARGEST:e} m, and \
         a spacing above 0 m"
    )]
    HeightField {
        /// Number of heights.
        heights: usize,
        /// Samples in a row.
        count_x: usize,
        /// Distance of the samples in metres.
        spacing_m: f32,
    },
    /// A gaze without joints.
    #[error("a gaze needs at least one joint")]
    EmptyGaze,
    /// Shares or limits of a gaze out of range.
    #[error(
        "a gaze needs shares that are not negative and sum to more than 0, a yaw limit below pi, \
         and up and down limits below pi / 2"
    )]
    GazeRange,
    /// A facing direction of no length.
    #[error("the facing direction of a gaze has no length; +Z is that of usual characters")]
    GazeFacing,
    /// A fraction over which a limb straightens that is out of range.
    #[error("the `soft` fraction of a limb is {soft}; it must be above 0 and at most 0.5")]
    LimbSoft {
        /// The fraction given.
        soft: f32,
    },
    /// A fraction over which a chain straightens that is out of range.
    #[error("the `soft` fraction of a chain is {soft}; it must be above 0 and at most 0.5")]
    ChainSoft {
        /// The fraction given.
        soft: f32,
    },
    /// A middle joint that is not on its limb.
    #[error("joint \"{middle}\" is not between the first joint of its limb and joint \"{end}\"")]
    NotBetween {
        /// The middle joint.
        middle: String,
        /// The end of the limb.
        end: String,
    },
    /// Joints of a limb that are not each below the one before.
    #[error("a limb needs three joints, each below the one before; this limb ends at \"{end}\"")]
    LimbOrder {
        /// The end of the limb.
        end: String,
    },
    /// A joint that has no two joints above it.
    #[error(
        "joint {} does not end a limb of two bones: it needs a parent and a grandparent",
        name.as_ref().map_or_else(|| joint.to_string(), |name| format!("\"{name}\""))
    )]
    NoLimb {
        /// The joint's index.
        joint: u32,
        /// Its name, if the skeleton has the joint.
        name: Option<String>,
    },
    /// No feet, or too many.
    #[error("{count} feet are given; 1 to {MAX_FEET} are supported")]
    FootCount {
        /// Number of feet given.
        count: usize,
    },
    /// A weight of feet out of range.
    #[error("the weight of feet is {weight}; it must be from 0 to 1")]
    FeetWeight {
        /// The weight given.
        weight: f32,
    },
    /// A second constraint of feet.
    #[error("a member has two feet constraints; only one is supported")]
    SecondFeet,
    /// A leg that begins at the pelvis.
    #[error("the leg of \"{ankle}\" must begin below the pelvis, not at it")]
    LegAtPelvis {
        /// The leg's ankle.
        ankle: String,
    },
    /// A foot that does not hang on its leg.
    #[error(
        "the foot \"{foot}\" of \"{character}\" is not a child of its leg \"{shin}\" and would not \
         follow it; add the character that Character::with_feet_on_legs returns instead"
    )]
    LooseFoot {
        /// The character's name.
        character: String,
        /// The lower leg.
        shin: String,
        /// The foot.
        foot: String,
    },
    /// A character whose joint names do not tell its body parts.
    #[error(
        "the names of the joints of \"{character}\" do not tell which are its {part}; set them \
         with CharacterMut::set_roles, or name the joints in the call"
    )]
    UnknownRoles {
        /// The character's name.
        character: String,
        /// The body part.
        part: &'static str,
    },
    /// A weight of an override out of range.
    #[error("the weight of the override of joint \"{joint}\" must be from 0 to 1")]
    OverrideWeight {
        /// The joint.
        joint: String,
        /// The weight given.
        weight: f32,
    },
}

/// A part of a constraint program that holds numbers.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConstraintPart {
    /// The point or direction of a target.
    Target,
    /// The weight of a target.
    TargetWeight,
    /// The facing direction of a gaze.
    GazeFacing,
    /// The bend direction of a limb.
    LimbBend,
    /// The pole of a limb.
    Pole,
    /// The override of a joint.
    Override {
        /// The joint's name.
        joint: String,
    },
    /// The offset of an attachment.
    AttachmentOffset,
    /// The plane of the ground.
    GroundPlane,
}

impl fmt::Display for ConstraintPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Target => "a target",
            Self::TargetWeight => "the weight of a target",
            Self::GazeFacing => "the facing direction of a gaze",
            Self::LimbBend => "the bend direction of a limb",
            Self::Pole => "a pole",
            Self::Override { joint } => {
                return write!(f, "the override of joint \"{joint}\"");
            }
            Self::AttachmentOffset => "the offset of an attachment",
            Self::GroundPlane => "the plane of the ground",
        })
    }
}
