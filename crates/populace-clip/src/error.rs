//! What can be wrong with a clip.

use populace_model::Property;

/// A motion that cannot be a clip, or a clip that cannot be used so. Messages say what is wrong,
/// where, and the rule.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A skeleton, a track or a name that is at fault.
    #[error(transparent)]
    Model(#[from] populace_model::Error),
    /// Two tracks for one joint and property.
    #[error("two {property:?} tracks drive joint \"{joint}\"; there may be one")]
    DuplicateTrack {
        /// Name of the joint.
        joint: String,
        /// The property both drive.
        property: Property,
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
}
