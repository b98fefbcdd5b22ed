//! `obsmat.txt` of the ETH and UCY data sets: rows of frame, id, x, z, y, and the velocities
//! along x, z and y.

use std::collections::HashMap;

use crate::fields::{Separator, Splitter, number, whole_id};
use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::steps::Steps;
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Rows of an agent in a second: both data sets were annotated at this rate.
const ANNOTATIONS_PER_SEC: f64 = 2.5;
/// Slower velocities in metres per second are not compared with positions.
const SLOWEST_M_PER_SEC: f64 = 0.3;
/// Velocities confirm a frame rate if it is so near the one that they give.
const CONFIRMS: f64 = 0.2;
/// A file beside that lists the ids of a group in each line.
const GROUPS: &str = "groups.txt";

/// Frame rates that velocities give.
#[derive(Default)]
struct Velocities {
    /// The last frame and position of each agent.
    last: Vec<[f64; 3]>,
    fps: Vec<f64>,
}

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut rows = Rows::default();
    let [vx, vy] = ["vx", "vy"].map(|name| rows.add_numbers(name));
    let groups = groups(input)?;
    let group = rows.add_words("group");
    let (mut steps, mut velocities) = (Steps::default(), Velocities::default());
    let mut splitter = Splitter::new(Separator::Blanks);
    let mut buffer = String::new();
    input.for_each_line(|line, number_of_line| {
        let fields = splitter.split(line);
        if fields.len() == 0 || fields.get(0).starts_with('#') {
            return Ok(());
        }
        let place = Some(Location::Line(number_of_line));
        if fields.len() < 5 {
            rows.leave_out("rows with too few columns were left out", place);
            return Ok(());
        }
        let [frame, x, z, y, along_x, along_y] =
            [0, 2, 3, 4, 5, 7].map(|column| number(fields.get(column), false));
        let id = whole_id(fields.get(1), &mut buffer);
        let agent = rows.agent(id);
        rows.push(agent, frame, [x, y], place);
        if z != 0.0 {
            rows.set_elevation(z);
        }
        rows.set_number(vx, along_x);
        rows.set_number(vy, along_y);
        if let Some(name) = groups.get(id) {
            rows.set_word(group, name);
        }
        steps.take(agent, frame);
        velocities.take(agent, [frame, x, y], along_x.hypot(along_y));
        Ok(())
    })?;
    let fps = velocities.confirm(steps.usual() * ANNOTATIONS_PER_SEC, &mut rows);
    let (unit, place) = (Fact::of_file(Unit::Metres), Place::default());
    let format = (Format::Obsmat, String::new());
    rows.finish(Found { format, unit, clock: Clock::Frames(fps), place }, input.path(), settings)
}

impl Velocities {
    /// Takes a row: frame and position, and the speed in metres per second.
    fn take(&mut self, agent: u32, row: [f64; 3], speed: f64) {
        let agent = agent as usize;
        if self.last.len() <= agent {
            self.last.resize(agent + 1, [f64::NAN; 3]);
        }
        let last = std::mem::replace(&mut self.last[agent], row);
        let frames = row[0] - last[0];
        let length = (row[1] - last[1]).hypot(row[2] - last[2]);
        let fps = frames * speed / length;
        if speed > SLOWEST_M_PER_SEC && fps.is_finite() && fps > 0.0 {
            self.fps.push(fps);
        }
    }

    /// Returns a frame rate, as one of the file if velocities confirm it.
    fn confirm(mut self, fps: f64, rows: &mut Rows) -> Fact<f64> {
        if self.fps.is_empty() {
            return Fact::assumed(fps);
        }
        let middle = self.fps.len() / 2;
        let measured = *self.fps.select_nth_unstable_by(middle, f64::total_cmp).1;
        if (measured / fps - 1.0).abs() < CONFIRMS {
            return Fact::of_file(fps);
        }
        rows.warnings.whole(format!(
            "{ANNOTATIONS_PER_SEC} rows a second give {fps} frames a second, but velocities and \
             positions give {measured:.1}; --data-fps sets it"
        ));
        Fact::assumed(fps)
    }
}

/// Returns the name of the group of each id, from a file beside.
fn groups(input: &Input) -> Result<HashMap<String, String>, Error> {
    let mut groups = HashMap::new();
    let Some(path) = input.on_disk().map(|path| path.with_file_name(GROUPS)) else {
        return Ok(groups);
    };
    if !path.is_file() {
        return Ok(groups);
    }
    let mut count = 0;
    Input::of_file(&path).for_each_line(|line, _| {
        let ids = line.split_ascii_whitespace();
        // A line with one number is the number of groups.
        if ids.clone().nth(1).is_some() {
            count += 1;
            for id in ids {
                groups.entry(id.to_owned()).or_insert_with(|| count.to_string());
            }
        }
        Ok(())
    })?;
    Ok(groups)
}
