//! A legend, trails, ids and a clock over pictures of trajectories, and people in the legend's colours.

mod corner;
mod density;
mod trails;

use populace::character::Image;
use populace::{CharacterId, Crowd, MemberLook};
use populace_overlay::{Canvas, Corner, Label, Legend, Scale, TextStyle};
use populace_render::Camera;
use populace_scene::{Moment, Motions, Person, Replay};
use populace_trajectory::{Column, Recording, Values};
use populace_variety::Dye;

use crate::cli::OverlayArgs;
use crate::failure::Failure;
use crate::names::hint;
use crate::roles::CrowdRole;

/// Share of numbers below the least and above the greatest of a scale: outliers take no colour away.
const OUTLIERS: f64 = 0.02;
/// Numbers from which a scale is made, at most.
const SAMPLES: usize = 20_000;
/// Height of labels above heads, in metres.
const LABEL_M: f32 = 0.12;

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
struct Colours {
    quantity: Quantity,
    legend: Legend,
    /// The corner of the legend.
    corner: Corner,
}

/// Drawings over pictures, and the colours of people.
pub(super) struct Overlays {
    colours: Option<Colours>,
    /// The clothes of each character, and each agent's character and look.
    dyes: Vec<(CharacterId, Dye)>,
    people: Vec<Person>,
    /// Heights of bodies in metres.
    heights: Vec<f32>,
    trail_secs: Option<f64>,
    ids: bool,
    /// The time in seconds that the clock counts from, if it is shown.
    clock_from_secs: Option<f64>,
}

impl Overlays {
    /// Prepares what was asked for. Refuses a column that the file does not have.
    pub(super) fn new(
        args: &OverlayArgs,
        recording: &Recording,
        motions: &Motions,
        roles: &[CrowdRole],
        (people, heights): (Vec<Person>, Vec<f32>),
    ) -> Result<Self, Failure> {
        let colours = args.colour_by.as_deref().map(|name| colours(name, recording, motions));
        let colours = colours.transpose()?;
        let dye = |role: &CrowdRole| (role.id, Dye::of(&role.character));
        let dyes = if colours.is_some() { roles.iter().map(dye).collect() } else { Vec::new() };
        let OverlayArgs { trails: trail_secs, ids, clock, .. } = *args;
        let clock_from_secs = clock.then(|| recording.secs()[0]);
        Ok(Self { colours, dyes, people, heights, trail_secs, ids, clock_from_secs })
    }

    /// Returns true if something is drawn over pictures.
    #[cfg(feature = "viewer")]
    pub(super) fn draw_something(&self) -> bool {
        self.colours.is_some()
            || self.trail_secs.is_some()
            || self.ids
            || self.clock_from_secs.is_some()
    }

    /// Dresses the people who are there.
    pub(super) fn dress(
        &self,
        crowd: &mut Crowd,
        recording: &Recording,
        replay: &Replay,
    ) -> Result<(), Failure> {
        let Some(colours) = &self.colours else { return Ok(()) };
        let values = colours.values(recording, replay);
        for ((agent, member), value) in replay.present().zip(values) {
            let person = &self.people[agent];
            let dye = self.dyes.iter().find(|(character, _)| *character == person.character);
            let Some((_, dye)) = dye else { continue };
            let look = person.look.unwrap_or(MemberLook::PLAIN);
            let color = colours.legend.scale.color(value).linear();
            let look = dye.dyed(look, color).with_opacity(replay.opacity(agent));
            crowd.member_mut(member)?.set_look(look);
        }
        Ok(())
    }

    /// Puts the legend to the corner in which it covers the fewest people of some pictures of a
    /// size, at times in seconds of the recording with a camera each.
    pub(super) fn place_legend(
        &mut self,
        size: [u32; 2],
        views: Vec<(f64, Camera)>,
        motions: &Motions,
    ) {
        let Some(colours) = &mut self.colours else { return };
        let seen = |(secs, camera): (f64, Camera)| {
            let all = motions.agents.iter().zip(&self.heights);
            let people = all.filter_map(|(motion, height_m)| {
                let Moment { position: [x, y], elevation_m, .. } = motion.at(secs)?;
                Some(([x, elevation_m, -y], *height_m))
            });
            (camera, people.collect())
        };
        let pictures: Vec<_> = views.into_iter().map(seen).collect();
        let has_clock = self.clock_from_secs.is_some();
        colours.corner = corner::free(&colours.legend, size, &pictures, has_clock);
    }

    /// Returns true if drawings need the depths of pixels.
    pub(super) fn needs_depths(&self) -> bool {
        self.trail_secs.is_some()
    }

    /// Draws over a picture of the replay's present time, which was taken by a camera and whose
    /// pixels have depths in metres.
    pub(super) fn draw(
        &self,
        picture: &mut Image,
        (camera, depths_m): (&Camera, &[f32]),
        recording: &Recording,
        replay: &Replay,
    ) -> Result<(), Failure> {
        let size = [picture.width, picture.height];
        let failed = |error: populace_overlay::Error| Failure::Run(error.into());
        let mut canvas = Canvas::new(&mut picture.rgba, size).map_err(failed)?;
        if let Some(secs) = self.trail_secs {
            canvas.trails(&self.trails(secs, camera, size, recording, replay), depths_m);
        }
        if self.ids {
            let style = TextStyle::new(0.8 * canvas.text_size());
            canvas.labels(&self.labels(camera, size, recording, replay), &style);
        }
        if let Some(colours) = &self.colours {
            canvas.legend(&colours.legend, colours.corner);
        }
        if let Some(from_secs) = self.clock_from_secs {
            canvas.clock(replay.secs() - from_secs, Corner::TopLeft);
        }
        Ok(())
    }

    /// Returns the ids of people above their heads.
    fn labels(
        &self,
        camera: &Camera,
        size: [u32; 2],
        recording: &Recording,
        replay: &Replay,
    ) -> Vec<Label> {
        let mut present: Vec<_> = replay.present().map(|(agent, _)| agent).collect();
        present.sort_unstable();
        let label = |agent: usize| {
            let moment = replay.motions().agents[agent].at(replay.secs())?;
            let [x, y] = moment.position;
            let top = moment.elevation_m + self.heights[agent] + LABEL_M;
            let at = camera.project([x, top, -y], size)?.map(f64::from);
            Some(Label { text: recording.agents[agent].id.clone(), at })
        };
        present.into_iter().filter_map(label).collect()
    }
}

impl Colours {
    /// Returns the quantity of each person who is there; NaN where there is none.
    fn values(&self, recording: &Recording, replay: &Replay) -> Vec<f64> {
        let moment = |agent: usize| replay.motions().agents[agent].at(replay.secs());
        let present = replay.present().map(|(agent, _)| agent);
        match &self.quantity {
            Quantity::Speed => present
                .map(|agent| moment(agent).map_or(f64::NAN, |at| speed(at.velocity)))
                .collect(),
            Quantity::Density => {
                let place = |at: Moment| [at.position[0], at.position[1], at.elevation_m];
                let places = present.map(|agent| moment(agent).map_or([0.0; 3], place));
                density::densities(&places.collect::<Vec<_>>())
            }
            Quantity::Column(..) => {
                let now = |agent| self.in_column(recording, (agent, replay.secs()));
                present.map(|agent| now(agent).unwrap_or(f64::NAN)).collect()
            }
        }
    }

    /// Returns the quantity of an agent at a time in seconds, from its moment then; `None` for
    /// density, which is that of all people of a time.
    fn value_then(
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

/// Returns the colours for the name of a column, or of a quantity that the file has no column of.
fn colours(name: &str, recording: &Recording, motions: &Motions) -> Result<Colours, Failure> {
    if let Some(index) = recording.columns.iter().position(|column| column.name == name) {
        return Ok(column_colours(index, recording));
    }
    match name {
        "speed" => {
            let [_, most] = range(speeds(recording, motions));
            let legend = legend("Speed", "m/s", Scale::number(0.0, most.max(0.1)), &[]);
            Ok(Colours { quantity: Quantity::Speed, legend, corner: Corner::TopRight })
        }
        "density" => {
            let legend = legend("Density", "1/m²", Scale::number(0.0, 5.0), &[]);
            Ok(Colours { quantity: Quantity::Density, legend, corner: Corner::TopRight })
        }
        _ => Err(no_column(name, recording)),
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
    Legend { title: title.to_owned(), unit: unit.to_owned(), scale, words: words.to_owned() }
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
    use super::*;

    pub(super) fn recording(text: &str) -> Recording {
        let settings = populace_trajectory::ReadSettings::default();
        let parsed = populace_trajectory::parse("rows.csv".as_ref(), text.into(), &settings);
        parsed.expect("a recording")
    }

    #[test]
    fn columns_of_the_file_come_before_quantities_of_the_same_name() {
        let recording = recording("id,t,x,y,density\na,0,0,0,150\na,1,1,0,250\n");
        let motions = Motions::new(&recording);
        let colours = |name| colours(name, &recording, &motions);
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
        let colours = colours("group", &recording, &Motions::new(&recording)).expect("a column");
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
            let colours = colours(name, &recording, &motions).expect("a quantity");
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
