//! Errors in the data of a crowd.

use crate::error_kind::ErrorKind;
use crate::names::UnknownName;
use crate::property::Property;
use crate::role::Role;

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
    #[error("the {property:?} track of joint \"{joint}\" {fault}")]
    BadTrack {
        /// Name of the joint.
        joint: String,
        /// The property it drives.
        property: Property,
        /// The defect.
        fault: TrackFault,
    },
    /// A humanoid role that a joint cannot have.
    #[error("the role {role}: {fault}")]
    BadRole {
        /// The role.
        role: Role,
        /// The defect.
        fault: RoleFault,
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

impl Error {
    /// The kind of the error.
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::UnknownJoints { .. }
            | Self::BadRole {
                fault: RoleFault::UnknownJoint { .. } | RoleFault::NotOnBody, ..
            } => ErrorKind::NotFound,
            Self::TooLarge { .. } => ErrorKind::TooLarge,
            Self::NoJoints
            | Self::ParentOutOfRange { .. }
            | Self::Cycle { .. }
            | Self::BadRest { .. }
            | Self::DuplicateJointName { .. }
            | Self::BadTrack { .. }
            | Self::BadRole { .. }
            | Self::BadMask { .. } => ErrorKind::InvalidInput,
        }
    }
}

/// The defect of a track. Keys are counted from 0.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrackFault {
    /// No keys.
    #[error("has no keys; a track needs at least one")]
    NoKeys,
    /// A number of values that does not fit the keys.
    #[error("has {values} values for {keys} keys; {needed} are needed")]
    ValueCount {
        /// Values given.
        values: usize,
        /// Keys given.
        keys: usize,
        /// Values that the keys need.
        needed: usize,
    },
    /// A time that is not finite.
    #[error("key {key} has a time that is not a finite number")]
    TimeNotFinite {
        /// The first such key.
        key: usize,
    },
    /// A time that is not later than the one before.
    #[error(
        "key {key} at {time_secs} s does not come after key {} at {before_secs} s; times must \
         increase",
        key - 1
    )]
    TimeOrder {
        /// The first such key, at least 1.
        key: usize,
        /// Its time in seconds.
        time_secs: f32,
        /// The time of the key before.
        before_secs: f32,
    },
    /// A value that is not finite.
    #[error("key {key} has a value that is not a finite number")]
    ValueNotFinite {
        /// The first such key.
        key: usize,
    },
    /// A rotation of no direction.
    #[error("key {key} is a rotation of length zero")]
    ZeroRotation {
        /// The first such key.
        key: usize,
    },
}

/// The defect of a humanoid role, or of a map of roles.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RoleFault {
    /// A name of no joint.
    #[error("the skeleton has no joint \"{joint}\"")]
    UnknownJoint {
        /// The name.
        joint: String,
    },
    /// A joint that has another role.
    #[error("joint \"{joint}\" is {other} already; a joint can have only one role")]
    JointTaken {
        /// The joint's name.
        joint: String,
        /// The role that it has.
        other: Role,
    },
    /// Two joints for one role.
    #[error("both \"{first}\" and \"{second}\" are given; a role can have only one joint")]
    TwoJoints {
        /// Name of the first joint.
        first: String,
        /// Name of the second joint.
        second: String,
    },
    /// No joint for a role that is required.
    #[error(
        "no joint is given; hips, upper legs, lower legs and feet are required, other roles are \
         optional"
    )]
    NoJoint,
    /// A joint that is not below that of its parent role.
    #[error("joint \"{joint}\" is not below \"{above}\", which is {parent}")]
    NotBelow {
        /// The joint's name.
        joint: String,
        /// Name of the parent role's joint.
        above: String,
        /// The parent role.
        parent: Role,
    },
    /// A role that the body has no joint for.
    #[error("the body has no joint with this role; RoleMap::joint tells which roles it has")]
    NotOnBody,
    /// A map of roles for another skeleton.
    #[error("the roles are those of {wanted} joints, but there are {joints}")]
    OtherSkeleton {
        /// Joints of the map's skeleton.
        wanted: usize,
        /// Joints of the skeleton that it was given for.
        joints: usize,
    },
    /// A map of roles for another skeleton than that of a named character or clip.
    #[error(
        "the roles are for a skeleton of {wanted} joints, but the skeleton of \"{name}\" has \
         {joints}"
    )]
    OtherSkeletonOf {
        /// Name of the character or clip.
        name: String,
        /// Joints of the map's skeleton.
        wanted: usize,
        /// Joints of the named one's skeleton.
        joints: usize,
    },
}
