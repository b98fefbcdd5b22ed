//! A recording of the rows of a file: sorted, checked, in metres and seconds.

use std::path::Path;

use super::{Broken, Clock, Found, Rows};
use crate::recording::{Column, Footstep, Kind, Recording, Values};
use crate::{Error, Fact, HeadingSource, ReadSettings, Source, Unit};

/// Coordinates in metres from here on are stored relative to an origin near them.
const FAR_M: f64 = 4096.0;
/// Origins are multiples of this length in metres.
const ORIGIN_STEP_M: f64 = 1000.0;
/// Median speed in metres per second above which the unit is another: more than that of the fastest
/// sprinters, 12 m/s, since the noise of positions adds to it.
const OTHER_UNIT_M_PER_SEC: f64 = 15.0;
/// Most people who move are not slower, in metres per second.
const SLOWEST_M_PER_SEC: f64 = 0.01;
/// The way in metres from which on somebody moves; less is noise.
const MOVES_M: f64 = 0.02;
/// Frame rates; others are faults, and times by them would not be finite.
const RATES: std::ops::RangeInclusive<f64> = 1e-3..=1e6;

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
        let per_sec = per_sec(found.clock, path, settings)?;
        let fps = match found.clock {
            Clock::Frames(fps) => fps.unless_set(settings.fps),
            Clock::Seconds => {
                self.warn_of_rate(settings);
                Fact::of_file(self.rate(&order))
            }
        };
        let unit = self.unit(found.unit.unless_set(told_unit(path, settings)?), per_sec, &order);
        let metres = unit.value.in_metres();
        self.warn_if_slow(found.clock, metres, per_sec, &order);
        self.warn_if_degrees(unit, &order);
        let origin_m = origin(self.positions[order[0]].map(|v| v * metres));
        let takes_headings = settings.heading != Some(HeadingSource::Motion);
        self.heights_in_metres(rounded(metres));
        let has_headings = takes_headings && self.headings.iter().any(|v| v.is_finite());
        let heading = self.heading(has_headings, settings.heading);
        let count = self.clocks.len();
        let columns = self.columns(&order, count);
        let steps = self.steps_of_agents(metres, origin_m);
        let elevations = self.elevations_in_metres(&order, metres);
        self.agents.retain(|agent| !agent.rows.is_empty());
        let recording = Recording {
            source: Source { format: found.format.0, version: found.format.1, unit, fps, heading },
            columns,
            // Unless the unit is told, places are in metres.
            place: found
                .place
                .scaled(settings.unit.map_or(1.0, Unit::in_metres))
                .relative_to(origin_m),
            origin_m,
            times: order.iter().map(|&row| self.clocks[row] / per_sec).collect(),
            positions: (order.iter())
                .map(|&row| relative(self.positions[row].map(|v| v * metres), origin_m))
                .collect(),
            elevations,
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

    /// Returns the source of headings. Warns if those of the file are asked for and it has none.
    fn heading(&mut self, has: bool, asked: Option<HeadingSource>) -> Fact<HeadingSource> {
        match asked {
            _ if has && self.guesses_headings => Fact::assumed(HeadingSource::Data),
            _ if has => Fact::of_file(HeadingSource::Data),
            Some(HeadingSource::Data) => {
                self.warnings.whole(
                    "the file has no headings, so --heading data has no effect; people face where \
                     they go",
                );
                Fact::assumed(HeadingSource::Motion)
            }
            asked => Fact::assumed(HeadingSource::Motion).unless_set(asked),
        }
    }

    /// Warns if a frame rate is set for times that need none.
    fn warn_of_rate(&mut self, settings: &ReadSettings) {
        if settings.fps.is_some() {
            self.warnings.whole("the file has times of its own, so --data-fps has no effect");
        }
    }

    /// Returns an error if there are no rows, or if more are broken than not.
    fn refuse_if_broken(&self, path: &Path) -> Result<(), Error> {
        let (path, kept) = (path.to_owned(), self.clocks.len());
        let Broken { rows: broken, first: at, why } = &self.broken;
        if *broken == 0 && kept == 0 {
            return Err(Error::Empty { path });
        }
        if *broken <= kept {
            return Ok(());
        }
        let check = match why.as_str() {
            "" => "check the first of them".to_owned(),
            why => format!("the first has {why}; check it"),
        };
        let problem = format!(
            "{broken} of {} rows have no id, time or position in the columns where they are \
             expected; {check}, or set the format by --format",
            broken + kept
        );
        Err(Error::Malformed { path, at: *at, problem })
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
        let speed = self.median_speed(order) * unit.value.in_metres() * per_sec;
        if speed <= OTHER_UNIT_M_PER_SEC {
            return unit;
        }
        if unit == Fact::assumed(Unit::Metres) {
            self.warnings.whole(format!(
                "in metres people would move at {speed:.0} m/s, so centimetres are assumed; --unit \
                 sets another unit, such as the metres of a pixel by --unit 0.02"
            ));
            return Fact::assumed(Unit::Centimetres);
        }
        self.warnings
            .whole(format!("people move at {speed:.0} m/s; check the unit and the frame rate"));
        unit
    }

    /// Warns of people who are so slow that times must have another unit.
    fn warn_if_slow(&mut self, clock: Clock, metres: f64, per_sec: f64, order: &[usize]) {
        let is_slow = |speed: f64| speed > 0.0 && speed * metres * per_sec < SLOWEST_M_PER_SEC;
        // Both have to be slow: those who wait have many slow rows, and those who come again after
        // a day have long ways in long times.
        if is_slow(self.median_speed(order)) && is_slow(self.median_pace(MOVES_M / metres, order)) {
            let remedy = match clock {
                Clock::Frames(_) => "the unit and the frame rate; --data-fps N sets it",
                Clock::Seconds => {
                    "the unit, and that times are in seconds; milliseconds are read in a column \
                     with the name t_ms"
                }
            };
            self.warnings.whole(format!(
                "most people who move are slower than {SLOWEST_M_PER_SEC} m/s; check {remedy}"
            ));
        }
    }

    /// Returns the median speed of people who move from one row to the next, in units of the file
    /// and of its clock; 0 if nobody does.
    fn median_speed(&self, order: &[usize]) -> f64 {
        let is_person = |row: usize| self.agents[self.owners[row] as usize].kind == Kind::Person;
        let mut speeds: Vec<f64> = (order.windows(2))
            .filter(|pair| self.owners[pair[0]] == self.owners[pair[1]] && is_person(pair[0]))
            .map(|pair| self.way(pair) / (self.clocks[pair[1]] - self.clocks[pair[0]]))
            .collect();
        median(&mut speeds).unwrap_or(0.0)
    }

    /// Returns the median speed over all their time of people whose ways are not shorter than
    /// `least`, in units of the file and of its clock; 0 if there are none.
    fn median_pace(&self, least: f64, order: &[usize]) -> f64 {
        let pace = |rows: &[usize]| {
            let way = rows.windows(2).map(|pair| self.way(pair)).sum::<f64>();
            let [first, last] = [rows.first()?, rows.last()?];
            (way >= least).then(|| way / (self.clocks[*last] - self.clocks[*first]))
        };
        let people = self.agents.iter().filter(|agent| agent.kind == Kind::Person);
        let mut paces: Vec<f64> =
            people.filter_map(|agent| pace(order.get(agent.rows.clone())?)).collect();
        median(&mut paces).unwrap_or(0.0)
    }

    /// Returns the distance between two rows in the unit of the file.
    fn way(&self, pair: &[usize]) -> f64 {
        let [a, b] = [self.positions[pair[0]], self.positions[pair[1]]];
        (b[0] - a[0]).hypot(b[1] - a[1])
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
    fn steps_of_agents(&mut self, metres: f64, origin_m: [f64; 2]) -> Vec<Footstep> {
        let mut steps = std::mem::take(&mut self.steps);
        steps.sort_by(|a, b| a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])));
        let mut from = 0;
        for (index, agent) in self.agents.iter_mut().enumerate() {
            let until = from + steps[from..].partition_point(|step| step.0 as usize <= index);
            agent.steps = from..until;
            from = until;
        }
        let in_metres = |at: [f64; 2]| relative(at.map(|v| v * metres), origin_m);
        let steps = steps.into_iter();
        steps.map(|(_, secs, at)| Footstep { secs, at: at.map(in_metres) }).collect()
    }
}

/// Returns how much a clock counts in a second.
fn per_sec(clock: Clock, path: &Path, settings: &ReadSettings) -> Result<f64, Error> {
    let per_sec = match clock {
        Clock::Frames(fps) => fps.unless_set(settings.fps).value,
        Clock::Seconds => 1.0,
    };
    if RATES.contains(&per_sec) {
        return Ok(per_sec);
    }
    let problem = format!("a frame rate of {per_sec} is not possible; --data-fps N sets it");
    Err(Error::Malformed { path: path.to_owned(), at: None, problem })
}

/// Returns the unit that overrules that of the file.
fn told_unit(path: &Path, settings: &ReadSettings) -> Result<Option<Unit>, Error> {
    let is_possible = |unit: Unit| Unit::SIZES_M.contains(&unit.in_metres());
    match settings.unit {
        Some(unit) if !is_possible(unit) => {
            let problem = format!("a unit of {unit} is not possible; --unit N sets it");
            Err(Error::Malformed { path: path.to_owned(), at: None, problem })
        }
        told => Ok(told),
    }
}

/// Returns values in an order, with a value for rows that have none; none at all if no row has one.
pub(super) fn in_order<T: Copy>(values: &[T], order: &[usize], count: usize, none: T) -> Vec<T> {
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
pub(super) fn rounded(value: f64) -> f32 {
    value as f32
}

/// Returns the median of positive finite values.
fn median(values: &mut Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite() && *value > 0.0);
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
