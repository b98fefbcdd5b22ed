//! The colours of people by a quantity or a column.

use populace_overlay::{Corner, Legend, Scale};
use populace_scene::{Moment, Motions, Replay};
use populace_trajectory::{Column, Recording, Values};

use super::densities;
use crate::failure::Failure;
use crate::names::hint;

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
    /// The column of this index, and the places of its words in the order of the legend.
    Column(usize, Vec<u32>),
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
        match name {
            "speed" => {
                let [_, most] = range(speeds(recording, motions));
                let legend = legend("Speed", "m/s", Scale::number(0.0, most.max(0.1)), &[]);
                Ok(Self { quantity: Quantity::Speed, legend, corner: Corner::TopRight })
            }
            "density" => {
                let legend = legend("Density", "1/m²", Scale::number(0.0, 5.0), &[]);
                Ok(Self { quantity: Quantity::Density, legend, corner: Corner::TopRight })
            }
            _ => Err(no_column(name, recording)),
        }
    }

    /// Returns the quantity of each person who is there; NaN where there is none.
    pub(super) fn values(&self, recording: &Recording, replay: &Replay) -> Vec<f64> {
        let moment = |agent: usize| replay.motions().agents[agent].at(replay.secs());
        let present = replay.present().map(|(agent, _)| agent);
        match &self.quantity {
            Quantity::Speed => present
                .map(|agent| moment(agent).map_or(f64::NAN, |at| speed(at.velocity)))
                .collect(),
            Quantity::Density => {
                let place = |at: Moment| [at.position[0], at.position[1], at.elevation_m];
                let places = present.map(|agent| moment(agent).map_or([0.0; 3], place));
                densities(&places.collect::<Vec<_>>())
            }
            Quantity::Column(..) => {
                let now = |agent| self.in_column(recording, (agent, replay.secs()));
                present.map(|agent| now(agent).unwrap_or(f64::NAN)).collect()
            }
        }
    }

    /// Returns the quantity of an agent at a time in seconds, from its moment then; `None` for
    /// density, which is that of all people of a time.
    pub(super) fn value_then(
        &self,
        recording: &Recording,
        then: (usize, f64),
        moment: &Moment,
    ) -> Option<f64> {
        match self.quantity {
            Quantity::Speed => Some(speed(moment.velocity)),
            Quantity::Density => None,
            Quantity::Column(..) => self.in_column(recording, then),
        }
    }

    /// Returns the value of an agent at a time in seconds in the column; of words, their place in
    /// the legend. `None` for other quantities.
    fn in_column(&self, recording: &Recording, (agent, secs): (usize, f64)) -> Option<f64> {
        let Quantity::Column(index, places) = &self.quantity else { return None };
        Some(value_at(recording, (&recording.columns[*index], places), agent, secs))
    }
}

fn speed([x, y]: [f32; 2]) -> f64 {
    f64::from(x.hypot(y))
}

/// Returns the value of a column in an agent's row at a time or before it; of words, their place.
fn value_at(
    recording: &Recording,
    (column, places): (&Column, &[u32]),
    agent: usize,
    secs: f64,
) -> f64 {
    let agent = &recording.agents[agent];
    let times = recording.track(agent).times;
    let row = recording.rows(agent).start + times.partition_point(|at| *at <= secs).max(1) - 1;
    match &column.values {
        Values::Numbers(numbers) => numbers.get(row).map_or(f64::NAN, |value| f64::from(*value)),
        Values::Words { indices, .. } => {
            let place = indices.get(row).and_then(|index| places.get(*index as usize));
            place.map_or(f64::NAN, |place| f64::from(*place))
        }
    }
}

fn column_colours(index: usize, recording: &Recording) -> Colours {
    let column = &recording.columns[index];
    let mut places = Vec::new();
    let (scale, words) = match &column.values {
        Values::Numbers(numbers) => {
            let [low, high] = range(thinned(numbers.iter().map(|v| f64::from(*v)), numbers.len()));
            (Scale::number(low, high), Vec::new())
        }
        Values::Words { words, .. } => {
            places = places_of(words);
            let mut sorted = words.clone();
            sorted.sort_unstable();
            (Scale::words(words.len()), sorted)
        }
    };
    let legend = legend(&column.name, "", scale, &words);
    Colours { quantity: Quantity::Column(index, places), legend, corner: Corner::TopRight }
}

fn legend(title: &str, unit: &str, scale: Scale, words: &[String]) -> Legend {
    let (title, unit, words) = (title.to_owned(), unit.to_owned(), words.to_owned());
    Legend { title, unit, scale, words, has_none: false }
}

/// Returns the place of each word in the order of the alphabet.
fn places_of(words: &[String]) -> Vec<u32> {
    let mut order: Vec<usize> = (0..words.len()).collect();
    order.sort_unstable_by_key(|nth| &words[*nth]);
    let mut places = vec![0; words.len()];
    for (place, nth) in (0_u32..).zip(order) {
        places[nth] = place;
    }
    places
}

fn no_column(name: &str, recording: &Recording) -> Failure {
    let names = || recording.columns.iter().map(|column| column.name.as_str());
    let is_column = |name: &&str| names().any(|column| column == *name);
    let computed = ["speed", "density"].into_iter().filter(|name| !is_column(name));
    let all: Vec<_> = computed.chain(names()).collect();
    let hint = hint(name, all.iter().copied());
    Failure::usage(format!(
        "people cannot be coloured by \"{name}\"{hint}; there are {}",
        all.join(", ")
    ))
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
mod tests {
    use super::super::tests::recording;
    use super::*;

    #[test]
    fn columns_of_the_file_come_before_quantities_of_the_same_name() {
        let recording = recording("id,t,x,y,density\na,0,0,0,150\na,1,1,0,250\n");
        let motions = Motions::new(&recording);
        let colours = |name| Colours::new(name, &recording, &motions);
        let density = colours("density").expect("a column");
        assert!(matches!(density.quantity, Quantity::Column(0, _)));
        assert_eq!(density.legend.title, "density");
        assert!(matches!(colours("speed").expect("computed").quantity, Quantity::Speed));
        let error = colours("sped").err().expect("no column").to_string();
        assert!(error.ends_with("there are speed, density"), "{error}");
    }

    #[test]
    fn speeds_of_the_whole_recording_are_looked_at() {
        let mut text = "id,t,x,y\n".to_owned();
        for agent in 0..1200 {
            text += &format!("{agent},0,0,{agent}\n{agent},1000,0,{agent}\n");
        }
        // The last one comes late and walks at 2 m/s.
        for second in 990..1000 {
            text += &format!("last,{second},{},0\n", 2 * second);
        }
        let recording = recording(&text);
        let speeds = speeds(&recording, &Motions::new(&recording));
        assert!(speeds.len() <= 50 * SAMPLES + 1201, "{}", speeds.len());
        assert!(speeds.iter().any(|speed| *speed > 1.5), "those at the end");
    }

    #[test]
    fn words_of_a_legend_are_in_the_order_of_the_alphabet() {
        let recording = recording("id,t,x,y,group\n1,0,0,0,B\n1,1,1,0,A\n2,0,0,9,C\n2,1,1,9,\n");
        let colours =
            Colours::new("group", &recording, &Motions::new(&recording)).expect("a column");
        assert_eq!(colours.legend.words, ["A", "B", "C"]);
        let at = |agent, secs| colours.in_column(&recording, (agent, secs)).expect("a column");
        assert_eq!([at(0, 0.5), at(0, 1.0), at(1, 0.0)], [1.0, 0.0, 2.0]);
        assert!(at(1, 1.0).is_nan(), "no group");
    }

    #[test]
    fn trails_have_the_colours_of_their_times() {
        let recording = recording("id,t,x,y,group\n1,0,0,0,B\n1,1,2,0,A\n2,0,0,9,C\n2,1,1,9,C\n");
        let motions = Motions::new(&recording);
        let then = |name: &str, secs: f64| {
            let moment = motions.agents[0].at(secs).expect("somebody");
            let colours = Colours::new(name, &recording, &motions).expect("a quantity");
            colours.value_then(&recording, (0, secs), &moment)
        };
        assert_eq!([then("group", 0.5), then("group", 1.0)], [Some(1.0), Some(0.0)]);
        assert!(then("speed", 0.5).is_some_and(|speed| (speed - 2.0).abs() < 0.1));
        assert_eq!(then("density", 0.5), None, "that of now");
    }

    #[test]
    fn ranges_leave_outliers_out() {
        let mut values: Vec<f64> = (0..100).map(f64::from).collect();
        values.extend([1e9, f64::NAN, -1e9]);
        assert_eq!(range(values), [1.0, 98.0]);
        assert_eq!(range(vec![]), [0.0; 2]);
    }
}
