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
    /// A humanoid role that a joint cannot have.
    #[error("the role {role}: {what}")]
    BadRole {
        /// The role, as VRM names it.
        role: String,
        /// The defect and the rule.
        what: String,
    },
    /// A mask that does not fit its skeleton.
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
    /// Joint names that the skeleton does not have.
    #[error("{}", joints.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    UnknownJoints {
        /// All missing names, each with the nearest existing names.
        joints: Vec<UnknownName>,
    },
    /// More data than 32-bit offsets reach.
    #[error("{what} would need {count} elements; devices address at most {limit}")]
    TooLarge {
        /// The table.
        what: &'static str,
        /// Number of elements that are needed.
        count: usize,
        /// Number of elements that can be addressed.
        limit: usize,
    },
}
