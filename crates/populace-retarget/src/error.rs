//! Errors of bindings.

/// A clip and a skeleton that do not fit. Messages say what is wrong, where, and how to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A clip that cannot move a skeleton.
    #[error("the clip \"{clip}\" cannot move this skeleton: {what}")]
    CannotBind {
        /// The clip's name.
        clip: String,
        /// The reason.
        what: String,
    },
}
