//! What can be wrong with a skeleton, its tracks, roles and masks.

use crate::Property;
use crate::names::UnknownName;

/// Data that does not describe a skeleton, a track, roles or a mask. Messages say what is wrong,
/// where, and the rule.
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
    /// A humanoid role that a joint cannot have.
    #[error("the role {role}: {what}")]
    BadRole {
        /// The role, as VRM names it.
        role: String,
        /// What is wrong and what the rule is.
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
    /// Joint names that the skeleton does not have.
    #[error("{}", joints.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    UnknownJoints {
        /// All of them, each with the nearest names.
        joints: Vec<UnknownName>,
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
