//! Errors in the data of a crowd.

use crate::Property;
use crate::names::UnknownName;

/// Invalid data of a crowd. Messages say what is wrong, where, and how to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The skeleton has no joints.
    #[error("a skeleton needs at least one joint")]
    NoJoints,
    /// A parent index is out of range.
    #[error(
        "joint {joint} \"{name}\" names joint {parent} as its parent, but there are {count} joints"
    )]
    ParentOutOfRange {
        /// Source index of the joint.
        joint: usize,
        /// Its name.
        name: String,
        /// Index of the parent.
        parent: usize,
        /// Number of joints.
        count: usize,
    },
    /// The parents of a joint form a cycle.
    #[error("joint {joint} \"{name}\" is its own ancestor; a skeleton must be a forest")]
    Cycle {
        /// Source index of a joint on the cycle.
        joint: usize,
        /// Its name.
        name: String,
    },
    /// A rest transform is invalid.
    #[error("joint {joint} \"{name}\" has a rest transform with {what}")]
    BadRest {
        /// Source index of the joint.
        joint: usize,
        /// Its name.
        name: String,
        /// The defect.
        what: &'static str,
    },
    /// Two joints have the same name, but clips bind by name.
    #[error(
        "joints {first} and {second} are both named \"{name}\"; clips bind by name, so names must \
         differ"
    )]
    DuplicateJointName {
        /// Source index of the first joint.
        first: usize,
        /// Source index of the second joint.
        second: usize,
        /// The name.
        name: String,
    },
    /// A track cannot be sampled.
    #[error("the {property:?} track of joint \"{joint}\" {what}")]
    BadTrack {
        /// Name of the joint.
        joint: String,
        /// The property it drives.
        property: Property,
        /// The defect.
        what: String,
    },
    /// Two tracks drive the same property of a joint.
    #[error("two {property:?} tracks drive joint \"{joint}\"; only one is allowed")]
    DuplicateTrack {
        /// Name of the joint.
        joint: String,
        /// The property both drive.
        property: Property,
    },
    /// A part of a character is inconsistent with the rest.
    #[error("{place}: {what}")]
    BadCharacter {
        /// The part.
        place: String,
        /// The defect and the rule.
        what: String,
    },
    /// A joint cannot have a humanoid role.
    #[error("the role {role}: {what}")]
    BadRole {
        /// The role, as VRM names it.
        role: String,
        /// The defect and the rule.
        what: String,
    },
    /// A clip cannot be bound to a skeleton.
    #[error("the clip \"{clip}\" cannot move this skeleton: {what}")]
    CannotBind {
        /// The clip's name.
        clip: String,
        /// The reason and the remedy.
        what: String,
    },
    /// A live clip cannot be created or used this way.
    #[error("the clip \"{clip}\" {what}")]
    BadLive {
        /// The clip's name.
        clip: String,
        /// The defect and the rule.
        what: String,
    },
    /// A clip has no root motion that can be taken out.
    #[error("the clip \"{clip}\" {what}")]
    NoMotion {
        /// The clip's name.
        clip: String,
        /// The reason.
        what: String,
    },
    /// A mask does not fit its skeleton.
    #[error(
        "a mask has {weights} weights for a skeleton of {joints} joints; one per joint is needed, \
         each from 0 to 1"
    )]
    BadMask {
        /// Number of weights given.
        weights: usize,
        /// Number of joints of the skeleton.
        joints: usize,
    },
    /// A constraint, override or ground cannot be used.
    #[error("{what}")]
    BadConstraint {
        /// The defect and the rule.
        what: String,
    },
    /// A user stage is invalid.
    #[error("the stage \"{stage}\": {what}")]
    BadStage {
        /// The stage's name.
        stage: String,
        /// The defect and the rule.
        what: String,
    },
    /// The skeleton lacks joint names that were asked for.
    #[error("{}", joints.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    UnknownJoints {
        /// All missing names, each with the nearest existing names.
        joints: Vec<UnknownName>,
    },
    /// An index is out of range, or does not fit a member.
    #[error("invalid {what} {value}: it does not exist, or does not fit this member")]
    BadPlayback {
        /// Kind of the index.
        what: &'static str,
        /// The index.
        value: u32,
    },
    /// A range exceeds its table: a bug in the library, found before a device follows the range.
    #[error(
        "control {control} uses {count} elements of {table} from {first} on, but there are only \
         {length}; this is a bug in the library: please report it"
    )]
    OutOfRange {
        /// The table.
        table: &'static str,
        /// The control that uses the range.
        control: usize,
        /// The first element of the range.
        first: usize,
        /// Number of elements of the range.
        count: usize,
        /// Number of elements of the table.
        length: usize,
    },
    /// A schedule's name is unknown.
    #[error(
        "there is no schedule \"{name}\"; schedules are staged, fused, fused-wide and \
         fused-grouped"
    )]
    UnknownSchedule {
        /// The name that was given.
        name: String,
    },
    /// Data exceeds the range of 32-bit offsets.
    #[error("{what} would need {count} elements; devices can address at most {limit}")]
    TooLarge {
        /// The table.
        what: &'static str,
        /// Number of elements that are needed.
        count: usize,
        /// Number of elements that can be addressed.
        limit: usize,
    },
}
