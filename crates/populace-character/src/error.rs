//! Errors in characters.

use populace_model::ErrorKind;

/// Data of no valid character. Messages say what is wrong, where, and how to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// An invalid skeleton, track or name.
    #[error(transparent)]
    Model(#[from] populace_model::Error),
    /// An invalid clip.
    #[error(transparent)]
    Clip(#[from] populace_clip::Error),
    /// A part of a character that does not fit the rest.
    #[error("{place}: {what}")]
    BadCharacter {
        /// The location of the part.
        place: String,
        /// The defect and the rule.
        what: String,
    },
}

impl Error {
    /// The kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Model(error) => error.kind(),
            Self::Clip(error) => error.kind(),
            Self::BadCharacter { .. } => ErrorKind::InvalidInput,
        }
    }
}
