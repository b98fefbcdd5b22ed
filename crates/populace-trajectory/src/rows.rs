//! Rows of a file, collected in any order, checked and sorted.

use std::collections::HashMap;
use std::path::Path;

use crate::recording::{Agent, Column, Footstep, Kind, Recording, Values};
use crate::warnings::Warnings;
use crate::{Error, Fact, HeadingSource, Location, Place, ReadSettings, Source, Unit};

/// Coordinates in metres from here on are stored relative to an origin near them.
const FAR_M: f64 = 4096.0;
/// Origins are multiples of this length in metres.
const ORIGIN_STEP_M: f64 = 1000.0;
/// Nobody on foot is faster, in metres per second.
const FASTEST_M_PER_SEC: f64 = 15.0;
/// Frame rates; others are faults, and times by them would not be finite.
const RATES: std::ops::RangeInclusive<f64> = 1e-3..=1e6;
/// Times and frames from here on are faults: whole numbers beyond are not exact.
const LATEST: f64 = 9e15;
/// Body heights in metres; other values are no heights.
const BODY_HEIGHTS_M: std::ops::RangeInclusive<f32> = 0.5..=2.6;

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

/// The rows of a file, in its own units.
#[derive(Default)]
pub(crate) struct Rows {
    /// People and vehicles, which may have equal ids.
    by_id: [HashMap<Box<str>, u32>; 2],
    agents: Vec<Agent>,
    owners: Vec<u32>,
    clocks: Vec<f64>,
    positions: Vec<[f64; 2]>,
    elevations: Vec<f32>,
    headings: Vec<f32>,
    views: Vec<f32>,
    numbers: Vec<(String, Vec<f32>)>,
    words: Vec<Words>,
    /// Agents, times and positions of footsteps.
    steps: Vec<(u32, [f64; 2], [[f64; 2]; 2])>,
    /// Body heights of agents in the unit of the file; NaN or nothing where none is known.
    heights: Vec<f32>,
    /// True if the last row was kept.
    keeps: bool,
    /// The number of rows left out because they are broken, and the place of the first.
    broken: (usize, Option<Location>),
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

    /// Sets the kind of an agent.
    pub(crate) fn set_kind(&mut self, agent: u32, kind: Kind) {
        self.agents[agent as usize].kind = kind;
    }

    /// Raises the body height of an agent to at least a height in the unit of the file. A height
    /// that no body has is ignored in the end.
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
    pub(crate) fn raise_height(&mut self, agent: u32, height: f64) {
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
    /// numbers are left out with a warning, and so is what is set for them.
    pub(crate) fn push(&mut self, agent: u32, clock: f64, at: [f64; 2], place: Option<Location>) {
        self.keeps = clock.abs() < LATEST && at.iter().all(|v| v.is_finite() && v.abs() < 1e9);
        if !self.keeps {
            self.leave_out("rows without a number as time or position were left out", place);
            return;
        }
        self.owners.push(agent);
        self.clocks.push(clock);
        self.positions.push(at);
    }

    /// Leaves out a broken row, with a warning, and what is set for it.
    pub(crate) fn leave_out(&mut self, why: &str, place: Option<Location>) {
        self.keeps = false;
        self.broken = (self.broken.0 + 1, self.broken.1.or(place));
        self.warnings.row(why, place);
    }

    /// Sets the elevation of the last row, in the unit of the file.
    pub(crate) fn set_elevation(&mut self, elevation: f64) {
        self.set(elevation, |rows| &mut rows.elevations, 0.0);
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

    /// Takes all headings to be in degrees rather than radians.
    pub(crate) fn headings_from_degrees(&mut self) {
        self.headings.iter_mut().for_each(|angle| *angle = angle.to_radians());
    }

    /// Takes all directions of view to be in degrees rather than radians.
    pub(crate) fn views_from_degrees(&mut self) {
        self.views.iter_mut().for_each(|angle| *angle = angle.to_radians());
    }

    /// Adds a footstep of an agent: when it begins and ends in seconds, and where the middle of the
    /// body is then in metres.
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

impl Rows {
    /// Returns the recording: rows sorted by agent and time, in metres and seconds.
    pub(crate) fn finish(
        mut self,
        found: Found,
        path: &Path,
        settings: &ReadSettings,
    ) -> Result<Recording, Error> {
        self.refuse_if_broken(path)?;
        let order = self.order();
        let per_sec = match found.clock {
            Clock::Frames(fps) => fps.unless_set(settings.fps).value,
            Clock::Seconds => 1.0,
        };
        if !RATES.contains(&per_sec) {
            let problem =
                format!("a frame rate of {per_sec} is not possible; --data-fps N sets it");
            return Err(Error::Malformed { path: path.to_owned(), at: None, problem });
        }
        let fps = match found.clock {
            Clock::Frames(fps) => fps.unless_set(settings.fps),
            Clock::Seconds => Fact::of_file(self.rate(&order)),
        };
        let unit = self.unit(found.unit.unless_set(settings.unit), per_sec, &order);
        let metres = unit.value.in_metres();
        let origin_m = origin(self.positions[order[0]].map(|v| v * metres));
        let takes_headings = settings.heading != Some(HeadingSource::Motion);
        self.heights_in_metres(rounded(metres));
        let has_headings = takes_headings && self.headings.iter().any(|v| v.is_finite());
        let heading = if has_headings {
            Fact::of_file(HeadingSource::Data)
        } else {
            Fact::assumed(HeadingSource::Motion)
        };
        let heading = heading.unless_set(settings.heading.filter(|_| !has_headings));
        let count = self.clocks.len();
        let columns = self.columns(&order, count);
        let steps = self.steps_of_agents(origin_m);
        self.agents.retain(|agent| !agent.rows.is_empty());
        let recording = Recording {
            source: Source { format: found.format.0, version: found.format.1, unit, fps, heading },
            columns,
            place: found.place.relative_to(origin_m),
            origin_m,
            times: order.iter().map(|&row| self.clocks[row] / per_sec).collect(),
            positions: (order.iter())
                .map(|&row| relative(self.positions[row].map(|v| v * metres), origin_m))
                .collect(),
            elevations: (in_order(&self.elevations, &order, count, 0.0).into_iter())
                .map(|v| v * rounded(metres))
                .collect(),
            headings: if has_headings {
                in_order(&self.headings, &order, count, f32::NAN)
            } else {
                Vec::new()
            },
            views: in_order(&self.views, &order, count, f32::NAN),
            steps,
            agents: self.agents,
            warnings: self.warnings.into_vec(),
        };
        match recording.warnings.first() {
            Some(warning) if settings.strict => {
                Err(Error::Strict { path: path.to_owned(), warning: warning.clone() })
            }
            _ => Ok(recording),
        }
    }

    /// Returns an error if there are no rows, or if more are broken than not.
    fn refuse_if_broken(&self, path: &Path) -> Result<(), Error> {
        let (path, kept) = (path.to_owned(), self.clocks.len());
        match self.broken {
            (0, _) if kept == 0 => Err(Error::Empty { path }),
            (broken, at) if broken > kept => Err(Error::Malformed {
                path,
                at,
                problem: format!(
                    "{broken} of {} rows have no id, time or position in the columns where they \
                     are expected; check the first of them, or set the format by --format",
                    broken + kept
                ),
            }),
            _ => Ok(()),
        }
    }

    /// Gives agents their heights, where a body can have them.
    fn heights_in_metres(&mut self, metres: f32) {
        for (agent, height) in self.agents.iter_mut().zip(&self.heights) {
            let height_m = height * metres;
            agent.height_m =
                agent.height_m.or(Some(height_m)).filter(|m| BODY_HEIGHTS_M.contains(m));
        }
    }

    /// Returns the rows to keep, by agent and then by time, and gives each agent its range.
    fn order(&mut self) -> Vec<usize> {
        let mut last = vec![f64::MIN; self.agents.len()];
        let mut falls = false;
        for (owner, clock) in self.owners.iter().zip(&self.clocks) {
            let last = &mut last[*owner as usize];
            falls |= *clock < *last;
            *last = *clock;
        }
        if falls {
            self.warnings.whole("times run backwards within an agent; its rows were sorted");
        }
        let mut order: Vec<usize> = (0..self.clocks.len()).collect();
        order.sort_by(|&a, &b| {
            let owners = self.owners[a].cmp(&self.owners[b]);
            owners.then(self.clocks[a].total_cmp(&self.clocks[b]))
        });
        let twice = |a: usize, b: usize| {
            self.owners[a] == self.owners[b] && self.clocks[a] == self.clocks[b]
        };
        let all = order.len();
        let mut kept: Vec<usize> = Vec::with_capacity(all);
        for row in order {
            if kept.last().is_none_or(|before| !twice(*before, row)) {
                kept.push(row);
            }
        }
        if kept.len() < all {
            let dropped = all - kept.len();
            self.warnings.whole(format!(
                "{dropped} rows repeat an agent at the same time; the first of each was kept"
            ));
        }
        let mut from = 0;
        for (index, agent) in self.agents.iter_mut().enumerate() {
            let rest = &kept[from..];
            let until = from + rest.partition_point(|&row| self.owners[row] as usize <= index);
            agent.rows = from..until;
            from = until;
        }
        kept
    }

    /// Returns the rows of an agent in a second: by the median time between them.
    fn rate(&self, order: &[usize]) -> f64 {
        let mut between: Vec<f64> = (order.windows(2))
            .filter(|pair| self.owners[pair[0]] == self.owners[pair[1]])
            .map(|pair| self.clocks[pair[1]] - self.clocks[pair[0]])
            .collect();
        median(&mut between).map_or(1.0, |secs| 1.0 / secs)
    }

    /// Returns the unit, after a look at the speeds that it gives.
    fn unit(&mut self, unit: Fact<Unit>, per_sec: f64, order: &[usize]) -> Fact<Unit> {
        let people = |row: usize| self.agents[self.owners[row] as usize].kind == Kind::Person;
        let mut speeds: Vec<f64> = (order.windows(2))
            .filter(|pair| self.owners[pair[0]] == self.owners[pair[1]] && people(pair[0]))
            .map(|pair| {
                let [a, b] = [self.positions[pair[0]], self.positions[pair[1]]];
                let secs = (self.clocks[pair[1]] - self.clocks[pair[0]]) / per_sec;
                (b[0] - a[0]).hypot(b[1] - a[1]) * unit.value.in_metres() / secs
            })
            .collect();
        let Some(speed) = median(&mut speeds).filter(|speed| *speed > FASTEST_M_PER_SEC) else {
            return unit;
        };
        if unit == Fact::assumed(Unit::Metres) {
            self.warnings.whole(format!(
                "in metres people would move at {speed:.0} m/s, so centimetres are assumed"
            ));
            return Fact::assumed(Unit::Centimetres);
        }
        self.warnings
            .whole(format!("people move at {speed:.0} m/s; check the unit and the frame rate"));
        unit
    }

    /// Returns the extra columns in the order of the rows.
    fn columns(&mut self, order: &[usize], count: usize) -> Vec<Column> {
        let numbers = std::mem::take(&mut self.numbers).into_iter().map(|(name, numbers)| Column {
            name,
            values: Values::Numbers(in_order(&numbers, order, count, f32::NAN)),
        });
        let words = std::mem::take(&mut self.words).into_iter().map(|column| Column {
            name: column.name,
            values: Values::Words {
                words: column.words,
                indices: in_order(&column.indices, order, count, u32::MAX),
            },
        });
        let has_values = |column: &Column| match &column.values {
            Values::Numbers(numbers) => !numbers.is_empty(),
            Values::Words { indices, .. } => !indices.is_empty(),
        };
        numbers.chain(words).filter(has_values).collect()
    }

    /// Returns the footsteps by agent and time, and gives each agent its range.
    fn steps_of_agents(&mut self, origin_m: [f64; 2]) -> Vec<Footstep> {
        let mut steps = std::mem::take(&mut self.steps);
        steps.sort_by(|a, b| a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])));
        let mut from = 0;
        for (index, agent) in self.agents.iter_mut().enumerate() {
            let until = from + steps[from..].partition_point(|step| step.0 as usize <= index);
            agent.steps = from..until;
            from = until;
        }
        let steps = steps.into_iter();
        steps
            .map(|(_, secs, at)| Footstep { secs, at: at.map(|at| relative(at, origin_m)) })
            .collect()
    }
}

/// Returns values in an order, with a value for rows that have none; none at all if no row has one.
fn in_order<T: Copy>(values: &[T], order: &[usize], count: usize, none: T) -> Vec<T> {
    debug_assert!(values.len() <= count);
    if values.is_empty() {
        return Vec::new();
    }
    order.iter().map(|&row| values.get(row).copied().unwrap_or(none)).collect()
}

/// Returns the origin for coordinates near a point in metres.
fn origin(near: [f64; 2]) -> [f64; 2] {
    if near.iter().all(|v| v.abs() < FAR_M) {
        return [0.0; 2];
    }
    near.map(|v| (v / ORIGIN_STEP_M).round() * ORIGIN_STEP_M)
}

/// Returns a point in metres relative to an origin.
fn relative(at: [f64; 2], origin_m: [f64; 2]) -> [f32; 2] {
    [0, 1].map(|axis| rounded(at[axis] - origin_m[axis]))
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
fn rounded(value: f64) -> f32 {
    value as f32
}

/// Returns the median of positive finite values.
fn median(values: &mut Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite() && *value > 0.0);
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
