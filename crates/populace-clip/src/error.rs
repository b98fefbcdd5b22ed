//! Errors in clips.

use populace_model::Property;

/// Data of no valid clip, or an invalid use of a clip. Messages say what is wrong, where, and how
/// to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// An invalid skeleton, track or name.
    #[error(transparent)]
    Model(#[from] populace_model::Error),
    /// Two tracks for one joint and property.
    #[error("two {property:?} tracks drive joint \"{joint}\"; only one is allowed")]
    DuplicateTrack {
        /// Name of the joint.
        joint: String,
        /// The property both drive.
        property: Property,
    },
    /// A live clip that is invalid, or used in an invalid way.
    #[error("the clip \"{clip}\" {what}")]
    BadLive {
        /// The clip's name.
        clip: String,
        /// The defect and the rule.
        what: String,
    },
    /// A clip without root motion.
    #[error("the clip \"{clip}\" {what}")]
    NoMotion {
        /// The clip's name.
        clip: String,
        /// The reason.
        what: String,
    },
}
