//! Problems of refused files and notes about loaded ones.

use std::fmt;
use std::path::PathBuf;

/// One problem of a refused file.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Problem {
    /// Location in the file: a JSON path such as `animations[2].channels[0]`, or `header` or
    /// `chunk 1` of a binary file, or `file` for the file as a whole.
    pub place: String,
    /// The defect and the rule that it breaks.
    pub what: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.what)
    }
}

/// A remark about a file that was loaded: data that was ignored or repaired, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Note {
    /// Location in the file, such as `animations[2].channels[0]`. If the note applies to several
    /// locations, this is the first one.
    pub place: String,
    /// The finding and its consequence.
    pub what: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.what)
    }
}

/// The reason why a file was not loaded, or a character not written.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file itself could not be read. Failures to read files that it refers to are reported as
    /// [`Problem`]s.
    #[error("{} cannot be read", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is not valid glTF, uses an unsupported feature, or exceeds a limit. Displays one
    /// problem per line.
    #[error("{file} is refused:{}", lines(problems))]
    Rejected {
        /// Path of the file, or `glTF data` for bytes in memory.
        file: String,
        /// All problems that were found, at least one.
        problems: Vec<Problem>,
    },
    /// A character cannot be written as glTF.
    #[error("\"{character}\" cannot be written as glTF: {what}")]
    Unwritable {
        /// Name of the character.
        character: String,
        /// The part of the character that glTF cannot hold.
        what: String,
    },
}

fn lines(problems: &[Problem]) -> String {
    problems.iter().map(|p| format!("\n{p}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejected_displays_one_problem_per_line() {
        let problem = |place: &str| Problem { place: place.into(), what: "is wrong".into() };
        let error = Error::Rejected {
            file: "a.glb".into(),
            problems: vec![problem("nodes[0]"), problem("nodes[1].mesh")],
        };
        assert_eq!(
            error.to_string(),
            "a.glb is refused:\nnodes[0]: is wrong\nnodes[1].mesh: is wrong"
        );
    }
}
