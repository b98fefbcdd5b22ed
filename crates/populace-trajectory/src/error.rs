//! Reasons why a file cannot be read.

use std::path::PathBuf;

use thiserror::Error;

use crate::{Location, Warning};

/// A file that cannot be read as trajectories.
#[non_exhaustive]
#[derive(Debug, Error)]
pub enum Error {
    /// The file, or one beside it, cannot be opened or read.
    #[error("cannot read {}: {reason}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// No format has this content.
    #[error("{}: not a trajectory file that is known ({seen}); {remedy}", path.display())]
    Unknown {
        /// Path of the file.
        path: PathBuf,
        /// A description of the content.
        seen: String,
        /// A hint for the user.
        remedy: String,
    },
    /// The content breaks the rules of its format.
    #[error("{}{}: {problem}", path.display(), at.map(|at| format!(", {at}")).unwrap_or_default())]
    Malformed {
        /// Path of the file.
        path: PathBuf,
        /// Place in the file, if it is known.
        at: Option<Location>,
        /// The problem, and how to mend it.
        problem: String,
    },
    /// A fact that the file lacks and that has no default.
    #[error("{}: {what} is not in the file; {remedy}", path.display())]
    Missing {
        /// Path of the file.
        path: PathBuf,
        /// The fact.
        what: &'static str,
        /// A hint for the user.
        remedy: String,
    },
    /// No agent has a position.
    #[error("{}: holds no positions", path.display())]
    Empty {
        /// Path of the file.
        path: PathBuf,
    },
    /// A warning, with [`ReadSettings::strict`](crate::ReadSettings::strict).
    #[error("{}: {warning} (an error because warnings are refused)", path.display())]
    Strict {
        /// Path of the file.
        path: PathBuf,
        /// The warning.
        warning: Warning,
    },
}
