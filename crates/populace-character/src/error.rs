//! What can be wrong with a character.

/// Pieces that do not make a character. Messages say what is wrong, where, and the rule.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A skeleton, a track or a name that is at fault.
    #[error(transparent)]
    Model(#[from] populace_model::Error),
    /// A clip that is at fault.
    #[error(transparent)]
    Clip(#[from] populace_clip::Error),
    /// A part of a character that does not fit the rest of it.
    #[error("{place}: {what}")]
    BadCharacter {
        /// Which part.
        place: String,
        /// What is wrong and what the rule is.
        what: String,
    },
}
