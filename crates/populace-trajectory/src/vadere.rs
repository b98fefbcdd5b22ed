//! Footsteps of Vadere: `postvis.traj`, with the topography in the scenario beside it.

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::extra::Extra;
use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit, area};

/// Greatest time in seconds between two steps that follow each other without a wait.
const JOINT_SECS: f64 = 1e-6;
/// Greatest distance in metres between the end of such a step and the beginning of the next.
const JOINT_M: f64 = 1e-3;

/// The columns with a meaning: the index of each.
struct Columns {
    id: usize,
    start: usize,
    end: usize,
    from: [usize; 2],
    to: [usize; 2],
    extras: Vec<Extra>,
}

impl Columns {
    /// Returns the columns that a line names; nothing if it is no header of footsteps.
    fn of_header(line: &str) -> Option<Self> {
        // `endTime-PID3`: the number is that of a part of the simulation.
        let names: Vec<&str> = fields(line)
            .map(|word| word.split_once("-PID").map_or(word, |(name, _)| name))
            .collect();
        let place = |aliases: &[&str]| {
            let known = |name: &&str| aliases.iter().any(|alias| name.eq_ignore_ascii_case(alias));
            names.iter().position(known)
        };
        let mut columns = Self {
            id: place(&["pedestrianId", "id"])?,
            start: place(&["simTime", "startTime", "time"])?,
            end: place(&["endTime"])?,
            from: [place(&["startX"])?, place(&["startY"])?],
            to: [place(&["endX"])?, place(&["endY"])?],
            extras: Vec::new(),
        };
        let [x, y] = columns.from;
        let [to_x, to_y] = columns.to;
        let known = [columns.id, columns.start, columns.end, x, y, to_x, to_y];
        let extras = names.iter().enumerate().filter(|(index, _)| !known.contains(index));
        columns.extras = extras.map(|(_, name)| Extra::new(name)).collect();
        Some(columns)
    }
}

/// Returns true if a line names the columns of footsteps.
pub(crate) fn is_header(line: &str) -> bool {
    Columns::of_header(line).is_some()
}

/// A step as the file has it.
struct Step {
    agent: u32,
    /// Begin and end.
    secs: [f64; 2],
    at: [[f64; 2]; 2],
    line: u64,
    /// Its extra fields, as a range of their text.
    extras: Range<usize>,
}

/// The steps of a file, in its order.
#[derive(Default)]
struct Steps {
    steps: Vec<Step>,
    /// The extra fields of all steps, each with a blank behind it.
    text: String,
}

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut rows = Rows::default();
    let mut columns: Option<Columns> = None;
    let mut steps = Steps::default();
    input.for_each_line(|line, number| {
        if line.trim().is_empty() || line.starts_with('#') {
            return Ok(());
        }
        if let Some(columns) = &columns {
            steps.add(line, columns, &mut rows, number);
            return Ok(());
        }
        columns = Columns::of_header(line);
        let problem = "no header with pedestrianId, simTime, endTime, startX, startY, endX and \
                       endY; let Vadere write them by a FootStepProcessor";
        let at = Some(Location::Line(number));
        if columns.is_some() { Ok(()) } else { Err(input.malformed(at, problem)) }
    })?;
    steps.finish(&mut columns.map_or(Vec::new(), |columns| columns.extras), &mut rows);
    let place = beside(input, settings, &mut rows);
    let found = Found {
        format: (Format::Vadere, String::new()),
        unit: Fact::of_file(Unit::Metres),
        clock: Clock::Seconds,
        place,
    };
    rows.finish(found, input.path(), settings)
}

/// Returns the fields of a line.
fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split([' ', '\t', ';', ',']).filter(|field| !field.is_empty())
}

impl Steps {
    fn add(&mut self, line: &str, columns: &Columns, rows: &mut Rows, number: u64) {
        let Columns { start, end, from, to, .. } = columns;
        let meant = [*start, *end, from[0], from[1], to[0], to[1]];
        let mut values = [f64::NAN; 6];
        let (mut id, text) = ("", self.text.len());
        for (index, field) in fields(line).enumerate() {
            if index == columns.id {
                id = field;
            } else if let Some(value) = meant.iter().position(|column| *column == index) {
                values[value] = field.parse().unwrap_or(f64::NAN);
            } else {
                self.text.push_str(field);
                self.text.push(' ');
            }
        }
        if id.is_empty() || values.iter().any(|value| !value.is_finite()) {
            let at = Some(Location::Line(number));
            rows.leave_out("steps without an id or a number as time or position were left out", at);
            return;
        }
        let [start, end, x, y, to_x, to_y] = values;
        self.steps.push(Step {
            agent: rows.agent(id),
            secs: [start, end],
            at: [[x, y], [to_x, to_y]],
            line: number,
            extras: text..self.text.len(),
        });
    }

    /// Adds the steps to the rows: a row where each begins and ends, but one where two join.
    fn finish(mut self, extras: &mut [Extra], rows: &mut Rows) {
        let mut last: Option<&Step> = None;
        self.steps.sort_by(|a, b| {
            a.agent.cmp(&b.agent).then(a.secs[0].total_cmp(&b.secs[0])).then(a.line.cmp(&b.line))
        });
        for step in &self.steps {
            let at = Some(Location::Line(step.line));
            let before = last.filter(|last| last.agent == step.agent);
            let wait = before.map_or(f64::MAX, |before| step.secs[0] - before.secs[1]);
            if step.secs[1] <= step.secs[0] {
                rows.leave_out("steps that end before they begin were left out", at);
                continue;
            }
            if wait < -JOINT_SECS {
                rows.leave_out("steps that begin before the last one ends were left out", at);
                continue;
            }
            if wait > JOINT_SECS {
                if !rows.push(step.agent, step.secs[0], step.at[0], at) {
                    continue;
                }
                self.set_extras(step, extras, rows);
            } else if before.is_some_and(|before| apart(before.at[1], step.at[0]) > JOINT_M) {
                rows.warnings.row("steps begin elsewhere than the last one ended", at);
            }
            if !rows.push(step.agent, step.secs[1], step.at[1], at) {
                continue;
            }
            self.set_extras(step, extras, rows);
            rows.push_step(step.agent, step.secs, step.at);
            last = Some(step);
        }
    }

    fn set_extras(&self, step: &Step, extras: &mut [Extra], rows: &mut Rows) {
        let text = self.text.get(step.extras.clone()).unwrap_or_default();
        for (extra, field) in extras.iter_mut().zip(text.split(' ')) {
            extra.set_text(rows, field);
        }
    }
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Returns the place by the only scenario beside the file, if there is one.
fn beside(input: &Input, settings: &ReadSettings, rows: &mut Rows) -> Place {
    let folder = input.on_disk().and_then(|path| path.parent());
    let (Some(folder), None) = (folder, &settings.geometry) else { return Place::default() };
    // The folder of a file without one in its path is the current one.
    let here = Path::new(".");
    let folder = if folder.as_os_str().is_empty() { here } else { folder };
    let mut left_out = |why: String| {
        rows.warnings.whole(why);
        Place::default()
    };
    let scenarios = match scenarios_in(folder) {
        Ok(scenarios) => scenarios,
        Err(error) => {
            let folder = folder.display();
            return left_out(format!(
                "the folder {folder} was not searched for a scenario: {error}"
            ));
        }
    };
    match &*scenarios {
        [] => Place::default(),
        [scenario] => area::load(scenario).unwrap_or_else(|error| {
            left_out(format!("the scenario beside the file was left out: {error}"))
        }),
        _ => left_out(
            "several scenarios lie beside the file; --geometry FILE names the right one".into(),
        ),
    }
}

/// Returns the scenarios in a folder, by name.
fn scenarios_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)?;
    let mut paths: Vec<_> =
        entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    paths.retain(|path| path.extension().is_some_and(|end| end == "scenario"));
    paths.sort();
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_cannot_be_read_is_a_warning() {
        let input = Input::of_file(Path::new("no_such_folder/postvis.traj"));
        let mut rows = Rows::default();
        beside(&input, &ReadSettings::default(), &mut rows);
        let warnings = rows.warnings.into_vec();
        assert!(warnings[0].text.contains("no_such_folder was not searched"), "{warnings:?}");
    }
}
