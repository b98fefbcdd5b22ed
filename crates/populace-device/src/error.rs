//! What can be wrong with what a device is to evaluate.

/// Tables, controls or stages that no device could evaluate. Messages say what is wrong, where, and
/// the rule.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
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
    /// An index that points at nothing a device could follow.
    #[error("there is no {what} {value} for this member")]
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
