//! Errors in tables, constraint programs and user stages.

/// Tables, constraint programs or stages that no device could evaluate. Messages say what is wrong,
/// where, and how to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A constraint or override that no device could solve.
    #[error("{what}")]
    BadConstraint {
        /// The defect and the rule.
        what: String,
    },
    /// A user stage that is invalid.
    #[error("the stage \"{stage}\": {what}")]
    BadStage {
        /// The stage's name.
        stage: String,
        /// The defect and the rule.
        what: String,
    },
    /// An index of something that does not exist for the member.
    #[error("there is no {what} {value} for this member")]
    BadPlayback {
        /// The kind of index.
        what: &'static str,
        /// The index.
        value: u32,
    },
    /// A range past the end of its table: a bug in the library, found before a device follows the
    /// range.
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
    /// A name of no schedule.
    #[error(
        "there is no schedule \"{name}\"; schedules are staged, fused, fused-wide and \
         fused-grouped"
    )]
    UnknownSchedule {
        /// The name given.
        name: String,
    },
    /// More data than 32-bit offsets can address.
    #[error("{what} would need {count} elements; devices address at most {limit}")]
    TooLarge {
        /// The table.
        what: &'static str,
        /// The number of elements that are needed.
        count: usize,
        /// Elements that can be addressed.
        limit: usize,
    },
}
