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
    /// The file is not valid glTF, uses an unsupported feature, or exceeds a limit. Displays the
    /// first ten problems, one per line, and the number of the others, which often follow from
    /// these.
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

/// The most problems that an error displays.
const DISPLAYED: usize = 10;

fn lines(problems: &[Problem]) -> String {
    let mut lines: String = problems.iter().take(DISPLAYED).map(|p| format!("\n{p}")).collect();
    if let Some(others @ 1..) = problems.len().checked_sub(DISPLAYED) {
        lines += &format!("\nand {others} more");
    }
    lines
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

    #[test]
    fn rejected_displays_ten_problems_of_many() {
        let problem = |n: usize| Problem { place: format!("nodes[{n}]"), what: "is bad".into() };
        let words = |count: usize| {
            let problems = (0..count).map(problem).collect();
            Error::Rejected { file: "a.glb".into(), problems }.to_string()
        };
        assert!(words(10).ends_with("\nnodes[9]: is bad"), "{}", words(10));
        assert!(words(4_000).ends_with("\nnodes[9]: is bad\nand 3990 more"), "{}", words(4_000));
    }
}
