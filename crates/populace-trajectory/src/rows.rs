//! Rows of a file, collected in any order, checked and sorted.

mod degrees;
mod elevations;
mod finish;
mod heights;

use std::collections::HashMap;

use crate::recording::{Agent, Kind};
use crate::warnings::Warnings;
use crate::{Fact, Location, Place, Unit};

/// Times and frames from here on are faults: whole numbers beyond are not exact.
const LATEST: f64 = 9e15;
/// Coordinates from here on are faults in any unit.
const FARTHEST: f64 = 1e9;

/// The axis by which rows are in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Clock {
    /// Frames, and their number in a second.
    Frames(Fact<f64>),
    /// Seconds.
    Seconds,
}

/// Facts about a file that its reader has found.
pub(crate) struct Found {
    /// Format and version.
    pub(crate) format: (crate::Format, String),
    /// The unit of positions and elevations.
    pub(crate) unit: Fact<Unit>,
    pub(crate) clock: Clock,
    pub(crate) place: Place,
}

/// An extra column of words.
struct Words {
    name: String,
    by_word: HashMap<Box<str>, u32>,
    words: Vec<String>,
    indices: Vec<u32>,
}

impl Words {
    /// Returns the index of a word.
    fn index(&mut self, word: &str) -> u32 {
        if let Some(index) = self.by_word.get(word) {
            return *index;
        }
        let index = u32::try_from(self.words.len()).unwrap_or(u32::MAX);
        self.words.push(word.to_owned());
        self.by_word.insert(word.into(), index);
        index
    }
}

/// Rows that are broken.
#[derive(Default)]
struct Broken {
    rows: usize,
    /// The place of the first.
    first: Option<Location>,
    /// The value that the first has in place of an id, a time or a position, if its reader says so.
    why: String,
}

/// The rows of a file, in its own units.
#[derive(Default)]
pub(crate) struct Rows {
    /// People and vehicles, which may have equal ids.
    by_id: [HashMap<Box<str>, u32>; 2],
    agents: Vec<Agent>,
    owners: Vec<u32>,
    clocks: Vec<f64>,
    positions: Vec<[f64; 2]>,
    /// NaN where a row has none.
    elevations: Vec<f32>,
    /// The unit of elevations, if it is not that of positions.
    elevation_unit: Option<Unit>,
    headings: Vec<f32>,
    /// True if the unit of headings is told only by their size.
    guesses_headings: bool,
    views: Vec<f32>,
    numbers: Vec<(String, Vec<f32>)>,
    words: Vec<Words>,
    /// Agents, times and positions of footsteps.
    steps: Vec<(u32, [f64; 2], [[f64; 2]; 2])>,
    /// Body heights of agents in the unit of the file; NaN or nothing where none is known.
    heights: Vec<f32>,
    /// True if the last row was kept.
    keeps: bool,
    /// The rows left out because they are broken.
    broken: Broken,
    pub(crate) warnings: Warnings,
}

impl Rows {
    /// Returns the index of the agent with an id.
    pub(crate) fn agent(&mut self, id: &str) -> u32 {
        self.agent_of(Kind::Person, id)
    }

    /// Returns the index of the agent with an id, where people and vehicles may have equal ids.
    pub(crate) fn agent_of(&mut self, kind: Kind, id: &str) -> u32 {
        let by_id = &mut self.by_id[usize::from(kind == Kind::Vehicle)];
        if let Some(index) = by_id.get(id) {
            return *index;
        }
        let index = u32::try_from(self.agents.len()).unwrap_or(u32::MAX);
        by_id.insert(id.into(), index);
        let (id, rows, steps) = (id.to_owned(), 0..0, 0..0);
        self.agents.push(Agent { id, kind, height_m: None, rows, steps });
        index
    }

    /// Sets the kind of an agent, that of the last row.
    pub(crate) fn set_kind(&mut self, agent: u32, kind: Kind) {
        if self.keeps {
            self.agents[agent as usize].kind = kind;
        }
    }

    /// Raises the body height of an agent, that of the last row, to at least a height in metres. It
    /// comes before heights in the unit of the file. A height that no body has is ignored in the
    /// end.
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
    pub(crate) fn raise_height_m(&mut self, agent: u32, height_m: f64) {
        if self.keeps {
            let known = &mut self.agents[agent as usize].height_m;
            *known = Some(known.unwrap_or(f32::NAN).max(height_m as f32));
        }
    }

    /// Raises the body height of an agent, that of the last row, to at least a height in the unit
    /// of the file. A height that no body has is ignored in the end.
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
    pub(crate) fn raise_height(&mut self, agent: u32, height: f64) {
        if !self.keeps {
            return;
        }
        self.heights.resize(self.agents.len(), f32::NAN);
        let known = &mut self.heights[agent as usize];
        *known = known.max(height as f32);
    }

    /// Adds an extra column of numbers, and returns its index among those.
    pub(crate) fn add_numbers(&mut self, name: &str) -> usize {
        self.numbers.push((name.to_owned(), Vec::new()));
        self.numbers.len() - 1
    }

    /// Adds an extra column of words, and returns its index among those.
    pub(crate) fn add_words(&mut self, name: &str) -> usize {
        let (by_word, words, indices) = Default::default();
        self.words.push(Words { name: name.to_owned(), by_word, words, indices });
        self.words.len() - 1
    }

    /// Adds a row: an agent's clock and position in the units of the file. Rows without finite
    /// numbers are left out with a warning, and so is what is set for them; it returns false for
    /// those.
    pub(crate) fn push(
        &mut self,
        agent: u32,
        clock: f64,
        at: [f64; 2],
        place: Option<Location>,
    ) -> bool {
        self.keeps = is_clock(clock) && at.into_iter().all(is_coordinate);
        if !self.keeps {
            self.leave_out("rows without a number as time or position were left out", place);
            return false;
        }
        self.owners.push(agent);
        self.clocks.push(clock);
        self.positions.push(at);
        true
    }

    /// Leaves out a broken row, with a warning, and what is set for it.
    pub(crate) fn leave_out(&mut self, why: &str, place: Option<Location>) {
        self.keeps = false;
        self.broken.rows += 1;
        self.broken.first = self.broken.first.or(place);
        self.warnings.row(why, place);
    }

    /// Says what a row that was left out has instead of an id, a time or a position. What the first
    /// one has is part of the error if there are too many.
    pub(crate) fn explain(&mut self, why: impl FnOnce() -> String) {
        if self.broken.rows == 1 {
            self.broken.why = why();
        }
    }

    /// Sets the elevation of the last row, in the unit of the file.
    pub(crate) fn set_elevation(&mut self, elevation: f64) {
        self.set(elevation, |rows| &mut rows.elevations, f32::NAN);
    }

    /// Sets the elevation of the last row, and the unit of all elevations unless it is that of
    /// positions.
    pub(crate) fn set_elevation_in(&mut self, unit: Option<Unit>, elevation: f64) {
        self.elevation_unit = unit;
        self.set_elevation(elevation);
    }

    /// Sets the heading of the last row in radians.
    pub(crate) fn set_heading(&mut self, heading_rad: f64) {
        self.set(heading_rad, |rows| &mut rows.headings, f32::NAN);
    }

    /// Sets the heading of the last row by a vector; the vector 0, 0 is no heading.
    pub(crate) fn set_heading_vector(&mut self, [x, y]: [f64; 2]) {
        if x != 0.0 || y != 0.0 {
            self.set_heading(y.atan2(x));
        }
    }

    /// Sets the direction of view of the last row in radians.
    pub(crate) fn set_view(&mut self, view_rad: f64) {
        self.set(view_rad, |rows| &mut rows.views, f32::NAN);
    }

    /// Sets the number of the last row in an extra column.
    pub(crate) fn set_number(&mut self, column: usize, number: f64) {
        self.set(number, |rows| &mut rows.numbers[column].1, f32::NAN);
    }

    /// Sets the word of the last row in an extra column.
    pub(crate) fn set_word(&mut self, column: usize, word: &str) {
        if !self.keeps {
            return;
        }
        let last = self.clocks.len() - 1;
        let column = &mut self.words[column];
        let index = column.index(word);
        column.indices.resize(last, u32::MAX);
        column.indices.push(index);
    }

    /// Makes words of the numbers of an extra column, and returns its index among those of words.
    pub(crate) fn words_of_numbers(&mut self, column: usize) -> usize {
        let numbers = std::mem::take(&mut self.numbers[column].1);
        let name = self.numbers[column].0.clone();
        let words = self.add_words(&name);
        let column = &mut self.words[words];
        column.indices.reserve(numbers.len());
        for number in numbers {
            let index = if number.is_nan() { u32::MAX } else { column.index(&number.to_string()) };
            column.indices.push(index);
        }
        words
    }

    /// Reports headings as assumed: nothing but their size tells their unit.
    pub(crate) fn guess_headings(&mut self) {
        self.guesses_headings = true;
    }

    /// Takes all headings to be in degrees rather than radians.
    pub(crate) fn headings_from_degrees(&mut self) {
        self.headings.iter_mut().for_each(|angle| *angle = angle.to_radians());
    }

    /// Takes all directions of view to be in degrees rather than radians.
    pub(crate) fn views_from_degrees(&mut self) {
        self.views.iter_mut().for_each(|angle| *angle = angle.to_radians());
    }

    /// Adds a footstep of an agent: when it begins and ends in seconds, and where the middle of the
    /// body is then, in the unit of the file.
    pub(crate) fn push_step(&mut self, agent: u32, secs: [f64; 2], at: [[f64; 2]; 2]) {
        self.steps.push((agent, secs, at));
    }

    /// The number of rows so far.
    pub(crate) fn len(&self) -> usize {
        self.clocks.len()
    }

    #[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
    fn set(&mut self, value: f64, of: impl Fn(&mut Self) -> &mut Vec<f32>, none: f32) {
        if !self.keeps {
            return;
        }
        let last = self.clocks.len() - 1;
        let values = of(self);
        // A row may set a value twice; the last one counts.
        values.resize(last, none);
        values.push(if value.is_finite() { value as f32 } else { none });
    }
}

/// Returns true for a time or a frame that a row can have.
pub(crate) fn is_clock(clock: f64) -> bool {
    clock.abs() < LATEST
}

/// Returns true for a coordinate that a row can have.
pub(crate) fn is_coordinate(value: f64) -> bool {
    value.abs() < FARTHEST
}
