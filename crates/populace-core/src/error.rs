//! What can be wrong with the data of a crowd.

use crate::Property;
use crate::names::UnknownName;

/// Data that does not describe a crowd. Messages say what is wrong, where, and the rule.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A skeleton without joints.
    #[error("a skeleton needs at least one joint")]
    NoJoints,
    /// A parent index past the end.
    #[error(
        "joint {joint} \"{name}\" names joint {parent} as its parent, but there are {count} joints"
    )]
    ParentOutOfRange {
        /// Source index of the joint.
        joint: usize,
        /// Its name.
        name: String,
        /// The parent it names.
        parent: usize,
        /// How many joints there are.
        count: usize,
    },
    /// A chain of parents that comes back.
    #[error("joint {joint} \"{name}\" is its own ancestor; a skeleton must be a forest")]
    Cycle {
        /// Source index of a joint on the cycle.
        joint: usize,
        /// Its name.
        name: String,
    },
    /// A rest transform that is no transform.
    #[error("joint {joint} \"{name}\" has a rest transform with {what}")]
    BadRest {
        /// Source index of the joint.
        joint: usize,
        /// Its name.
        name: String,
        /// What is wrong.
        what: &'static str,
    },
    /// Two joints of one name: clips bind by name.
    #[error(
        "joints {first} and {second} are both named \"{name}\"; clips bind by name, so names must \
         differ"
    )]
    DuplicateJointName {
        /// Source index of the first.
        first: usize,
        /// Source index of the second.
        second: usize,
        /// The name.
        name: String,
    },
    /// A track that cannot be sampled.
    #[error("the {property:?} track of joint \"{joint}\" {what}")]
    BadTrack {
        /// Name of the joint.
        joint: String,
        /// The property it drives.
        property: Property,
        /// What is wrong.
        what: String,
    },
    /// Two tracks for one joint and property.
    #[error("two {property:?} tracks drive joint \"{joint}\"; there may be one")]
    DuplicateTrack {
        /// Name of the joint.
        joint: String,
        /// The property both drive.
        property: Property,
    },
    /// A part of a character that does not fit the rest of it.
    #[error("{place}: {what}")]
    BadCharacter {
        /// Which part.
        place: String,
        /// What is wrong and what the rule is.
        what: String,
    },
    /// A humanoid role that a joint cannot have.
    #[error("the role {role}: {what}")]
    BadRole {
        /// The role, as VRM names it.
        role: String,
        /// What is wrong and what the rule is.
        what: String,
    },
    /// A clip that cannot move a skeleton.
    #[error("the clip \"{clip}\" cannot move this skeleton: {what}")]
    CannotBind {
        /// The clip's name.
        clip: String,
        /// What was looked for.
        what: String,
    },
    /// A live clip that cannot be, or cannot be used so.
    #[error("the clip \"{clip}\" {what}")]
    BadLive {
        /// The clip's name.
        clip: String,
        /// What is wrong and what the rule is.
        what: String,
    },
    /// A clip that has no root motion to take out.
    #[error("the clip \"{clip}\" {what}")]
    NoMotion {
        /// The clip's name.
        clip: String,
        /// What is in the way.
        what: String,
    },
    /// A mask that does not fit its skeleton.
    #[error(
        "a mask has {weights} weights for a skeleton of {joints} joints; one per joint is needed, \
         each from 0 to 1"
    )]
    BadMask {
        /// Weights given.
        weights: usize,
        /// Joints of the skeleton.
        joints: usize,
    },
    /// A constraint or override that no device could solve.
    #[error("{what}")]
    BadConstraint {
        /// What is wrong and what the rule is.
        what: String,
    },
    /// A user's stage that cannot be one.
    #[error("the stage \"{stage}\": {what}")]
    BadStage {
        /// The stage's name.
        stage: String,
        /// What is wrong and what the rule is.
        what: String,
    },
    /// Joint names that the skeleton does not have.
    #[error("{}", joints.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    UnknownJoints {
        /// All of them, each with the nearest names.
        joints: Vec<UnknownName>,
    },
    /// An index that points at nothing a device could follow.
    #[error("invalid {what} {value}: it does not exist, or does not fit this member")]
    BadPlayback {
        /// What was named.
        what: &'static str,
        /// The index.
        value: u32,
    },
    /// A range that reaches past the end of its table: a fault of the library, found before a
    /// device follows it.
    #[error(
        "control {control} names {count} of {table} from {first} on, and there are {length}; this \
         is a fault of the library: please report it"
    )]
    OutOfRange {
        /// The table.
        table: &'static str,
        /// The control that names the range.
        control: usize,
        /// The first element of the range.
        first: usize,
        /// Elements of the range.
        count: usize,
        /// Elements of the table.
        length: usize,
    },
    /// A schedule's name that means nothing.
    #[error(
        "there is no schedule \"{name}\"; schedules are staged, fused, fused-wide and \
         fused-grouped"
    )]
    UnknownSchedule {
        /// The name given.
        name: String,
    },
    /// More data than 32-bit offsets reach.
    #[error("{what} would need {count} elements; devices address at most {limit}")]
    TooLarge {
        /// Which table.
        what: &'static str,
        /// Elements asked for.
        count: usize,
        /// Elements that can be addressed.
        limit: usize,
    },
}
