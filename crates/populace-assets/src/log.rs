//! Where problems and notes gather while a file is read.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

use crate::{Note, Problem};

/// Stands for a problem that is already in the log; whoever gets it gives up on what depends on it
/// and goes on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reported;

/// A value, or the knowledge that a problem was logged.
pub(crate) type Checked<T> = Result<T, Reported>;

/// Problems and notes listed at most; a file of garbage would otherwise give a longer list than
/// itself.
const LISTED: usize = 1000;

/// Problems and notes in the order they were found.
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
    /// Adds a problem, unless the very same is known.
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

    /// Adds a note; the same note at several places is kept once, with the first place and a count.
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

    /// Everything found: problems, if there is one, else notes.
    pub(crate) fn finish(self) -> Result<Vec<Note>, Vec<Problem>> {
        let Problems { mut list, unlisted, .. } = self.problems.into_inner();
        if unlisted > 0 {
            list.push(Problem {
                place: "file".into(),
                what: format!("has {unlisted} problems beyond these"),
            });
        }
        if !list.is_empty() {
            return Err(list);
        }
        let Notes { list, unlisted, .. } = self.notes.into_inner();
        let beyond =
            Note { place: "file".into(), what: format!("has {unlisted} notes beyond these") };
        let beyond = (unlisted > 0).then_some((beyond, 0));
        Ok(list
            .into_iter()
            .chain(beyond)
            .map(|(mut note, more)| {
                match more {
                    0 => {}
                    1 => note.what.push_str(" (and at one more place)"),
                    _ => note.what.push_str(&format!(" (and at {more} more places)")),
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
    fn equal_notes_are_counted_and_equal_problems_kept_once() {
        let log = Log::default();
        log.note("nodes[0]", "is odd");
        log.note("nodes[1]", "is odd");
        log.note("nodes[2]", "is odd");
        let notes = log.finish().unwrap();
        assert_eq!(notes.len(), 1);
        assert_eq!(notes[0].to_string(), "nodes[0]: is odd (and at 2 more places)");

        let log = Log::default();
        log.problem("nodes[0]", "is wrong");
        log.problem("nodes[0]", "is wrong");
        log.problem("nodes[1]", "is wrong");
        assert_eq!(log.finish().unwrap_err().len(), 2);
    }

    #[test]
    fn a_flood_of_problems_or_notes_is_cut_and_counted() {
        let log = Log::default();
        for i in 0..LISTED + 7 {
            log.problem(format!("nodes[{i}]"), "is wrong");
        }
        let problems = log.finish().unwrap_err();
        assert_eq!(problems.len(), LISTED + 1);
        assert_eq!(problems[LISTED].to_string(), "file: has 7 problems beyond these");
        let log = Log::default();
        for i in 0..LISTED + 7 {
            log.note("nodes[0]", format!("is odd in way {i}"));
            log.note("nodes[1]", "is odd in way 0");
        }
        let notes = log.finish().unwrap();
        assert_eq!(notes.len(), LISTED + 1);
        assert_eq!(notes[0].what, "is odd in way 0 (and at 1007 more places)");
        assert_eq!(notes[LISTED].to_string(), "file: has 7 notes beyond these");
    }
}
