//! Faults of a file that have a sensible reading.

use std::fmt;

use crate::Location;

/// A fault of a file, and how it was read. Equal faults of many rows are one warning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The fault and its reading, for example "rows without a number as position were left out".
    pub text: String,
    /// Rows with this fault; 0 for a fault of the whole file.
    pub rows: u64,
    /// The first of those rows.
    pub first: Option<Location>,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)?;
        match (self.rows, self.first) {
            (0, _) => Ok(()),
            (1, Some(first)) => write!(f, " ({first})"),
            (rows, Some(first)) => write!(f, " ({rows} rows, the first in {first})"),
            (rows, None) => write!(f, " ({rows} rows)"),
        }
    }
}

/// The warnings of one file.
#[derive(Debug, Default)]
pub(crate) struct Warnings(Vec<Warning>);

impl Warnings {
    /// Adds a fault of the whole file.
    pub(crate) fn whole(&mut self, text: impl Into<String>) {
        self.0.push(Warning { text: text.into(), rows: 0, first: None });
    }

    /// Counts a fault of one row.
    pub(crate) fn row(&mut self, text: &str, at: Option<Location>) {
        match self.0.iter_mut().find(|warning| warning.rows > 0 && warning.text == text) {
            Some(warning) => warning.rows += 1,
            None => self.0.push(Warning { text: text.to_owned(), rows: 1, first: at }),
        }
    }

    pub(crate) fn into_vec(self) -> Vec<Warning> {
        self.0
    }
}
