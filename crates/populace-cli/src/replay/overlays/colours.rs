//! The colours of people by a quantity, a column or their ids.

use std::cmp::Reverse;

use populace::model::did_you_mean;
use populace::nearest_names;
use populace_overlay::{Corner, Legend, Scale, WORD_COLORS};
use populace_scene::{Moment, Motions, Replay};
use populace_trajectory::{Agent, Kind, Recording, Values};

use super::density::densities;
use crate::failure::Failure;

/// Share of numbers below the least and above the greatest of a scale: outliers take no colour away.
const OUTLIERS: f64 = 0.02;
/// Numbers from which a scale is made, at most.
const SAMPLES: usize = 20_000;

/// The quantity that colours people.
enum Quantity {
    /// Metres per second.
    Speed,
    /// People per square metre.
    Density,
    /// Metres.
    Elevation,
    /// A number of each row, or the place of its word in the legend; NaN where a row has none.
    Rows(Vec<f32>),
}

/// The colours of people by a quantity.
pub(super) struct Colours {
    quantity: Quantity,
    pub(super) legend: Legend,
    /// The corner of the legend.
    pub(super) corner: Corner,
}

impl Colours {
    /// Returns the colours for the name of a column, or of a quantity that the file has no column
    /// of.
    pub(super) fn new(
        name: &str,
        recording: &Recording,
        motions: &Motions,
    ) -> Result<Self, Failure> {
        if let Some(index) = recording.columns.iter().position(|column| column.name == name) {
            return Ok(column_colours(index, recording));
        }
        let (quantity, legend) = match name {
            "speed" => {
                let [_, most] = range(speeds(recording, motions));
                let scale = Scale::number(0.0, most.max(0.1));
                (Quantity::Speed, legend("Speed", "m/s", scale, Vec::new()))
            }
            "density" => {
                let scale = Scale::number(0.0, 5.0);
                (Quantity::Density, legend("Density", "1/m²", scale, Vec::new()))
            }
            "z" if has_elevations(recording) => {
                let all: Vec<f64> = elevations(recording).collect();
                let [low, high] = range(thinned(all.iter().copied(), all.len()));
                let scale = Scale::number(low, high);
                (Quantity::Elevation, legend("Elevation", "m", scale, Vec::new()))
            }
            "id" => return Ok(id_colours(recording)),
            _ => return Err(no_column(name, recording)),
        };
        Ok(Self { quantity, legend, corner: Corner::TopRight })
    }

    /// Returns the quantity of each person who is there; NaN where there is none.
    pub(super) fn values(&self, recording: &Recording, replay: &Replay) -> Vec<f64> {
        let secs = replay.secs();
        let moment = |agent: usize| replay.motions().agents[agent].at(secs);
        let present = replay.present().map(|(agent, _)| (agent, moment(agent)));
        if let Quantity::Density = self.quantity {
            let place = |at: Moment| [at.position[0], at.position[1], at.elevation_m];
            let places = present.map(|(_, moment)| moment.map_or([0.0; 3], place));
            return densities(&places.collect::<Vec<_>>());
        }
        let value = |(agent, moment): (usize, Option<Moment>)| {
            moment.and_then(|moment| self.value_then(recording, (agent, secs), &moment))
        };
        present.map(|at| value(at).unwrap_or(f64::NAN)).collect()
    }

    /// Returns the quantity of an agent at a time in seconds, from its moment then; `None` for
    /// density, which is that of all people of a time.
    pub(super) fn value_then(
        &self,
        recording: &Recording,
        (agent, secs): (usize, f64),
        moment: &Moment,
    ) -> Option<f64> {
        match &self.quantity {
            Quantity::Speed => Some(speed(moment.velocity)),
            Quantity::Density => None,
            Quantity::Elevation => Some(moment.elevation_m.into()),
            Quantity::Rows(values) => {
                values.get(row_at(recording, agent, secs)).map(|v| (*v).into())
            }
        }
    }
}

fn speed([x, y]: [f32; 2]) -> f64 {
    f64::from(x.hypot(y))
}

/// Returns the row of an agent at a time in seconds or before it.
fn row_at(recording: &Recording, agent: usize, secs: f64) -> usize {
    let agent = &recording.agents[agent];
    let times = recording.track(agent).times;
    recording.rows(agent).start + times.partition_point(|at| *at <= secs).max(1) - 1
}

fn column_colours(index: usize, recording: &Recording) -> Colours {
    let column = &recording.columns[index];
    let numbers = match &column.values {
        Values::Words { words, indices } => {
            return word_colours(&column.name, words, indices, recording);
        }
        Values::Numbers(numbers) => numbers,
    };
    if let Some((words, indices)) = few_whole(numbers, recording) {
        return word_colours(&column.name, &words, &indices, recording);
    }
    let [low, high] = range(thinned(numbers.iter().map(|v| f64::from(*v)), numbers.len()));
    let legend = legend(&column.name, "", Scale::number(low, high), Vec::new());
    row_colours(legend, numbers.clone(), recording)
}

fn id_colours(recording: &Recording) -> Colours {
    let ends = recording.agents.iter().map(|agent| recording.rows(agent).end);
    let mut indices = vec![u32::MAX; ends.max().unwrap_or(0)];
    for (index, agent) in (0_u32..).zip(&recording.agents) {
        indices[recording.rows(agent)].fill(index);
    }
    let ids: Vec<String> = recording.agents.iter().map(|agent| agent.id.clone()).collect();
    word_colours("id", &ids, &indices, recording)
}

/// Returns the colours of words, with the index of the word of each row. The words of most people
/// have colours of their own.
fn word_colours(title: &str, words: &[String], indices: &[u32], recording: &Recording) -> Colours {
    let counts = people_of_words(words.len(), indices, recording);
    let mut order: Vec<usize> = (0..words.len()).filter(|word| counts[*word] > 0).collect();
    order.sort_by_cached_key(|word| by_number_or_alphabet(&words[*word]));
    let mut by_count = order.clone();
    by_count.sort_by_key(|word| Reverse(counts[*word]));
    let coloured = &by_count[..by_count.len().min(WORD_COLORS)];
    order.sort_by_key(|word| !coloured.contains(word));
    // Places of others are beyond all that have a colour.
    let mut places = vec![f32::INFINITY; words.len()];
    for (place, word) in (0_u8..).zip(&order[..coloured.len()]) {
        places[*word] = place.into();
    }
    let place = |index: &u32| places.get(*index as usize).copied().unwrap_or(f32::NAN);
    let values = indices.iter().map(place).collect();
    let scale = Scale::words(order.len());
    let words = order.into_iter().map(|word| words[word].clone()).collect();
    row_colours(legend(title, "", scale, words), values, recording)
}

/// Returns the colours of the values of rows. Says in the legend if somebody lacks one.
fn row_colours(legend: Legend, values: Vec<f32>, recording: &Recording) -> Colours {
    let lacks = |person: &Agent| values[recording.rows(person)].iter().any(|v| v.is_nan());
    let legend = Legend { has_none: people(recording).any(lacks), ..legend };
    Colours { quantity: Quantity::Rows(values), legend, corner: Corner::TopRight }
}

/// Returns the number of people who have each word in one of their rows.
fn people_of_words(words: usize, indices: &[u32], recording: &Recording) -> Vec<usize> {
    let mut counts = vec![0; words];
    for person in people(recording) {
        let mut own: Vec<u32> = indices[recording.rows(person)].to_vec();
        own.sort_unstable();
        own.dedup();
        for index in own {
            // Rows without a word have an index beyond them.
            if let Some(count) = counts.get_mut(index as usize) {
                *count += 1;
            }
        }
    }
    counts
}

/// Returns the key by which words are sorted: whole numbers by their value, before the alphabet.
fn by_number_or_alphabet(word: &str) -> (bool, Option<i128>, String) {
    let number = word.parse().ok();
    (number.is_none(), number, word.to_owned())
}

/// Returns the numbers of people as words, and the index of each row's word, if the numbers are
/// whole and few.
fn few_whole(numbers: &[f32], recording: &Recording) -> Option<(Vec<String>, Vec<u32>)> {
    let mut found: Vec<f32> = Vec::new();
    let mut indices = vec![u32::MAX; numbers.len()];
    for row in people(recording).flat_map(|person| recording.rows(person)) {
        let number = numbers[row];
        if number.is_nan() {
            continue;
        }
        let known = found.iter().position(|other| *other == number);
        if known.is_none() {
            if number.fract() != 0.0 || found.len() == WORD_COLORS {
                return None;
            }
            found.push(number);
        }
        indices[row] = u32::try_from(known.unwrap_or(found.len() - 1)).ok()?;
    }
    // The sum has no minus before 0.
    Some((found.iter().map(|number| (number + 0.0).to_string()).collect(), indices))
}

fn people(recording: &Recording) -> impl Iterator<Item = &Agent> {
    recording.agents.iter().filter(|agent| agent.kind == Kind::Person)
}

fn legend(title: &str, unit: &str, scale: Scale, words: Vec<String>) -> Legend {
    let (title, unit) = (title.to_owned(), unit.to_owned());
    Legend { title, unit, scale, words, has_none: false }
}

fn no_column(name: &str, recording: &Recording) -> Failure {
    let names = || recording.columns.iter().map(|column| column.name.as_str());
    let is_column = |name: &&str| names().any(|column| column == *name);
    let elevation = has_elevations(recording).then_some("z");
    let computed = ["speed", "density", "id"].into_iter().chain(elevation);
    let all: Vec<_> = computed.filter(|name| !is_column(name)).chain(names()).collect();
    let hint = did_you_mean(&nearest_names(name, all.iter().copied()));
    let all = all.join(", ");
    Failure::usage(format!("people cannot be coloured by \"{name}\"{hint}; there are {all}"))
}

fn has_elevations(recording: &Recording) -> bool {
    elevations(recording).next().is_some()
}

/// Returns the elevations of people in metres.
fn elevations(recording: &Recording) -> impl Iterator<Item = f64> {
    let of = |person: &Agent| recording.track(person).elevations.iter();
    people(recording).flat_map(of).map(|metres| f64::from(*metres))
}

/// Returns the speeds of people once a second, or less often in recordings of many people.
fn speeds(recording: &Recording, motions: &Motions) -> Vec<f64> {
    let [from, until] = recording.secs();
    let values = (until - from) * motions.agents.len() as f64;
    let step_secs = (values / (50 * SAMPLES) as f64).max(1.0);
    let times = (0_u32..).map(|nth| from + f64::from(nth) * step_secs);
    let at = |secs: f64| motions.agents.iter().filter_map(move |motion| motion.at(secs));
    let times = times.take_while(|secs| *secs <= until);
    times.flat_map(at).map(|moment| speed(moment.velocity)).collect()
}

/// Returns some of many values, evenly chosen.
fn thinned(values: impl Iterator<Item = f64>, count: usize) -> Vec<f64> {
    values.step_by(count.div_ceil(SAMPLES).max(1)).collect()
}

/// Returns the least and the greatest of values but for outliers.
fn range(mut values: Vec<f64>) -> [f64; 2] {
    values.retain(|value| value.is_finite());
    values.sort_unstable_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a part of a length"
    )]
    let cut = (OUTLIERS * values.len() as f64) as usize;
    let last = values.len().saturating_sub(1);
    [cut, last.saturating_sub(cut)].map(|index| values.get(index).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests;
