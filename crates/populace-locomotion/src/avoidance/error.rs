//! Errors of avoidance.

use populace::ErrorKind;

/// The reason why a call was refused. Nothing has changed after an error.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting out of its range.
    #[error("the setting {what} is {value}; it must be {rule}")]
    BadSetting {
        /// Name of the setting.
        what: &'static str,
        /// The value.
        value: f32,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// A number of a walker out of its range.
    #[error("{what} of walker {walker} is {value}; it must be {rule}")]
    BadValue {
        /// The quantity.
        what: &'static str,
        /// Index of the walker.
        walker: usize,
        /// The value.
        value: f32,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// A number of a bystander out of its range.
    #[error("{what} of bystander {bystander} is {value}; it must be {rule}")]
    BadBystander {
        /// The quantity.
        what: &'static str,
        /// Index of the bystander.
        bystander: usize,
        /// The value.
        value: f32,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// A slice of another length than the positions.
    #[error("there are {positions} positions, but {found} {what}; give one for each walker")]
    UnequalLengths {
        /// Content of the slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The number of positions.
        positions: usize,
    },
    /// A stagger that names no share of the walkers.
    #[error("share {nth} of {count} does not exist; nth must be less than count")]
    BadStagger {
        /// Number of shares.
        count: usize,
        /// The share asked for.
        nth: usize,
    },
    /// An obstacle that is no line.
    #[error("obstacle {obstacle} has {points} points; it needs at least 2")]
    TooFewPoints {
        /// Index of the obstacle.
        obstacle: usize,
        /// Number of its points.
        points: usize,
    },
    /// A point of an obstacle that is not finite, or too far away.
    #[error("point {point} of obstacle {obstacle} has the coordinate {value}; it must be {rule}")]
    BadPoint {
        /// Index of the obstacle.
        obstacle: usize,
        /// Index of the point.
        point: usize,
        /// The coordinate.
        value: f32,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// A point of an obstacle at the place of the point before it.
    #[error("points {before} and {point} of obstacle {obstacle} are equal; remove one")]
    RepeatedPoint {
        /// Index of the obstacle.
        obstacle: usize,
        /// Index of the point before.
        before: usize,
        /// Index of the point.
        point: usize,
    },
}

impl Error {
    /// An error of a bystander that was checked like a walker.
    pub(crate) fn of_bystander(self) -> Self {
        match self {
            Self::BadValue { what, walker: bystander, value, rule } => {
                Self::BadBystander { what, bystander, value, rule }
            }
            other => other,
        }
    }

    /// Returns the kind of the error.
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::BadSetting { .. }
            | Self::BadValue { .. }
            | Self::BadBystander { .. }
            | Self::UnequalLengths { .. }
            | Self::BadStagger { .. }
            | Self::TooFewPoints { .. }
            | Self::BadPoint { .. }
            | Self::RepeatedPoint { .. } => ErrorKind::InvalidInput,
        }
    }
}
