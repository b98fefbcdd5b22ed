//! What can be wrong with a file, and what is worth saying about one that loads.

use std::fmt;
use std::path::PathBuf;

/// One thing that is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Problem {
    /// Where in the file, as `animations[2].channels[0]`; `header` and `chunk 1` are places of a
    /// binary file.
    pub place: String,
    /// What is wrong, and the rule.
    pub what: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.what)
    }
}

/// Something that did not stop a file from loading: data that was ignored and why, or repaired.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Note {
    /// Where in the file, as `animations[2].channels[0]`; the first place, where there are several.
    pub place: String,
    /// What was found and what was made of it.
    pub what: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.what)
    }
}

/// Why a file did not load.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file itself could not be read. Files that it names are [`Problem`]s.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not what it should be. Displays one problem a line.
    #[error("{file} is refused:{}", lines(problems))]
    Rejected {
        /// The file's path, or `glTF data` for bytes without one.
        file: String,
        /// Every problem that was found, at least one.
        problems: Vec<Problem>,
    },
}

fn lines(problems: &[Problem]) -> String {
    problems.iter().map(|p| format!("\n{p}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_has_a_line() {
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
