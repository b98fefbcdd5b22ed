//! What can be wrong with a binding.

/// A clip and a skeleton that do not fit. Messages say what is wrong, where, and the rule.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A clip that cannot move a skeleton.
    #[error("the clip \"{clip}\" cannot move this skeleton: {what}")]
    CannotBind {
        /// The clip's name.
        clip: String,
        /// What was looked for.
        what: String,
    },
}
