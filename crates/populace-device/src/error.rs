//! Errors in tables, constraint programs and user stages.

use populace_model::ErrorKind;

use crate::fault::{ConstraintFault, StageFault};

/// Tables, constraint programs or stages that no device could evaluate. Messages say what is wrong,
/// where, and how to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A constraint or override that no device could solve.
    #[error(transparent)]
    BadConstraint(#[from] ConstraintFault),
    /// A user stage that is invalid.
    #[error("the stage \"{stage}\": {fault}")]
    BadStage {
        /// The stage's name.
        stage: String,
        /// The defect.
        fault: StageFault,
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

impl Error {
    /// The kind of the error.
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::BadConstraint(ConstraintFault::NoJoint { .. })
            | Self::BadPlayback { .. }
            | Self::UnknownSchedule { .. } => ErrorKind::NotFound,
            Self::BadStage { fault: StageFault::TooMany, .. } | Self::TooLarge { .. } => {
                ErrorKind::TooLarge
            }
            Self::BadConstraint(_) | Self::BadStage { .. } => ErrorKind::InvalidInput,
            Self::OutOfRange { .. } => ErrorKind::Internal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ConstraintPart;

    #[test]
    fn defects_have_a_kind_and_a_sentence() {
        let joint = ConstraintFault::NoJoint { joint: 9, count: 3 };
        let part = ConstraintPart::Override { joint: "hips".into() };
        let stage = "sway".to_owned();
        for (error, kind, text) in [
            (joint.into(), ErrorKind::NotFound, "there is no joint 9; the skeleton has 3"),
            (
                ConstraintFault::NotBounded { part }.into(),
                ErrorKind::InvalidInput,
                "the override of joint \"hips\" has a value that is not finite or whose magnitude \
                 exceeds 1e9",
            ),
            (
                Error::BadStage { stage, fault: StageFault::TooMany },
                ErrorKind::TooLarge,
                "the stage \"sway\": the crowd already has 8 stages, the most that are possible; \
                 remove one first",
            ),
        ] {
            assert_eq!((error.kind(), error.to_string().as_str()), (kind, text));
        }
    }
}
