//! Collects problems and notes while a file is read.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

use crate::{Note, Problem};

/// Proof that a problem is already in the log. The receiver skips everything that depends on the
/// missing value and continues with the rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reported;

/// A value, or [`Reported`] if a problem was logged instead.
pub(crate) type Checked<T> = Result<T, Reported>;

/// Maximum number of listed problems, and of listed notes. Without it, a corrupt file could give a
/// list longer than the file.
const LISTED: usize = 1000;

/// Problems and notes in the order in which they were found.
#[derive(Default)]
pub(crate) struct Log {
    problems: RefCell<Problems>,
    notes: RefCell<Notes>,
}

#[derive(Default)]
struct Problems {
    list: Vec<Problem>,
    known: HashSet<Problem>,
    unlisted: usize,
}

#[derive(Default)]
struct Notes {
    list: Vec<(Note, usize)>,
    by_what: HashMap<String, usize>,
    unlisted: usize,
}

impl Log {
    /// Adds a problem unless an identical one is in the log.
    pub(crate) fn problem(&self, place: impl Into<String>, what: impl Into<String>) -> Reported {
        let mut problems = self.problems.borrow_mut();
        let problem = Problem { place: place.into(), what: what.into() };
        if problems.list.len() >= LISTED {
            problems.unlisted += 1;
        } else if problems.known.insert(problem.clone()) {
            problems.list.push(problem);
        }
        Reported
    }

    /// Adds a note. Notes of equal text are merged into one with the first location and a count.
    pub(crate) fn note(&self, place: impl Into<String>, what: impl Into<String>) {
        let mut notes = self.notes.borrow_mut();
        let what = what.into();
        if let Some(&at) = notes.by_what.get(&what) {
            notes.list[at].1 += 1;
            return;
        }
        let at = notes.list.len();
        if at >= LISTED {
            notes.unlisted += 1;
            return;
        }
        notes.by_what.insert(what.clone(), at);
        let place = place.into();
        notes.list.push((Note { place, what }, 0));
    }

    /// Returns the problems as the error if there are any, and the notes otherwise.
    pub(crate) fn finish(self) -> Result<Vec<Note>, Vec<Problem>> {
        let Problems { mut list, unlisted, .. } = self.problems.into_inner();
        if unlisted > 0 {
            list.push(Problem {
                place: "file".into(),
                what: format!("has {unlisted} more problems"),
            });
        }
        if !list.is_empty() {
            return Err(list);
        }
        let Notes { list, unlisted, .. } = self.notes.into_inner();
        let rest = Note { place: "file".into(), what: format!("has {unlisted} more notes") };
        let rest = (unlisted > 0).then_some((rest, 0));
        Ok(list
            .into_iter()
            .chain(rest)
            .map(|(mut note, more)| {
                match more {
                    0 => {}
                    1 => note.what.push_str(" (and at 1 other location)"),
                    _ => note.what.push_str(&format!(" (and at {more} other locations)")),
                }
                note
            })
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_notes_are_counted_and_equal_problems_listed_once() {
        let log = Log::default();
        log.note("nodes[0]", "is odd");
        log.note("nodes[1]", "is odd");
        log.note("nodes[2]", "is odd");
        let notes = log.finish().unwrap();
        assert_eq!(notes.len(), 1);
        assert_eq!(notes[0].to_string(), "nodes[0]: is odd (and at 2 other locations)");

        let log = Log::default();
        log.problem("nodes[0]", "is wrong");
        log.problem("nodes[0]", "is wrong");
        log.problem("nodes[1]", "is wrong");
        assert_eq!(log.finish().unwrap_err().len(), 2);
    }

    #[test]
    fn list_is_truncated_and_the_rest_counted() {
        let log = Log::default();
        for i in 0..LISTED + 7 {
            log.problem(format!("nodes[{i}]"), "is wrong");
        }
        let problems = log.finish().unwrap_err();
        assert_eq!(problems.len(), LISTED + 1);
        assert_eq!(problems[LISTED].to_string(), "file: has 7 more problems");
        let log = Log::default();
        for i in 0..LISTED + 7 {
            log.note("nodes[0]", format!("is odd in way {i}"));
            log.note("nodes[1]", "is odd in way 0");
        }
        let notes = log.finish().unwrap();
        assert_eq!(notes.len(), LISTED + 1);
        assert_eq!(notes[0].what, "is odd in way 0 (and at 1007 other locations)");
        assert_eq!(notes[LISTED].to_string(), "file: has 7 more notes");
    }
}
