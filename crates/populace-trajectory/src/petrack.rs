//! Text of PeTrack and of the Jülich archive: rows of id, frame, x, y and z.

use crate::comment;
use crate::extra::Extra;
use crate::fields::{Separator, Splitter, number};
use crate::input::Input;
use crate::layout::{Customs, Layout, Role};
use crate::names::{Meaning, Name};
use crate::recording::Kind;
use crate::rows::{Clock, Found, Rows};
use crate::table::Table;
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Frames per second of files that do not say it: those of the archive's experiments.
const ASSUMED_FPS: f64 = 25.0;
/// The same for files without any comment: those of the archive's first experiments.
const UNCOMMENTED_FPS: f64 = 16.0;
/// No body is higher in metres, and none lower in centimetres.
const BETWEEN_UNITS: f64 = 20.0;

const CUSTOMS: Customs = Customs { z_is_body_height: true, ..Customs::COMMON };

/// Facts that the comments say.
#[derive(Default)]
struct Said {
    anything: bool,
    unit: Option<Unit>,
    fps: Option<f64>,
    /// The first comment that names columns, or else one that might.
    names: Option<String>,
}

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let (mut rows, mut said) = (Rows::default(), Said::default());
    let mut table = None;
    let mut highest: f64 = 0.0;
    let mut splitter = Splitter::new(Separator::Blanks);
    input.for_each_line(|line, number_of_line| {
        if let Some(comment) = line.trim_start().strip_prefix('#') {
            said.take(comment);
        } else if !line.trim().is_empty() {
            let fields = splitter.split(line);
            let table = table.get_or_insert_with(|| {
                let layout = layout(said.names.as_deref(), fields.len());
                Table::new(Separator::Blanks, vec![layout], CUSTOMS)
            });
            // NaN, where there is no z, is not the greater.
            highest = highest.max(number(fields.get(4), true));
            table.take(&mut rows, line, Some(Location::Line(number_of_line)));
        }
        Ok(())
    })?;
    if let Some(table) = table {
        table.finish(&mut rows);
    }
    let unit = said.unit.map_or_else(
        || {
            let is_cm = highest > BETWEEN_UNITS;
            Fact::assumed(if is_cm { Unit::Centimetres } else { Unit::Metres })
        },
        Fact::of_file,
    );
    let assumed = if said.anything { ASSUMED_FPS } else { UNCOMMENTED_FPS };
    let fps = said.fps.map_or_else(|| Fact::assumed(assumed), Fact::of_file);
    let format = (Format::PeTrack, String::new());
    let found = Found { format, unit, clock: Clock::Frames(fps), place: Place::default() };
    rows.finish(found, input.path(), settings)
}

impl Said {
    fn take(&mut self, comment: &str) {
        self.anything = true;
        self.unit = self.unit.or(comment::unit(comment));
        self.fps = self.fps.or(comment::frame_rate(comment));
        let second = comment.split_ascii_whitespace().nth(1).unwrap_or_default();
        let is_surer = || {
            self.names.as_ref().is_none_or(|names| !names_columns(names) && names_columns(comment))
        };
        if second.to_lowercase().contains("frame") && is_surer() {
            self.names = Some(comment.to_owned());
        }
    }
}

/// Returns the layout: id, frame, x and y come first, the others by their names.
fn layout(names: Option<&str>, columns: usize) -> Layout {
    let names = names.map(|names| names.split_ascii_whitespace().map(Name::of).collect::<Vec<_>>());
    if let Some(names) = &names
        && let Ok(layout) = Layout::of(names, CUSTOMS)
        && [layout.id, layout.clock, layout.at[0], layout.at[1]] == [0, 1, 2, 3]
    {
        return layout;
    }
    let extra = |column: usize| {
        let name = names.as_ref().and_then(|names| names.get(column)).map(|name| name.text);
        // Names with units as words of their own have more words than there are columns.
        let name = name.filter(|_| names.as_ref().is_some_and(|names| names.len() == columns));
        let name = name.map_or_else(|| format!("column {}", column + 1), str::to_owned);
        (column, Role::Extra(Extra::new(&name)))
    };
    let height = (columns > 4).then_some((4, Role::BodyHeight(None)));
    Layout {
        id: 0,
        clock: 1,
        secs: None,
        at: [2, 3],
        active: None,
        kind: Kind::Person,
        roles: height.into_iter().chain((5..columns).map(extra)).collect(),
        unit: None,
        names: ["id", "frame", "x", "y"].map(str::to_owned),
    }
}

/// Returns true if a comment names the columns of such a file.
pub(crate) fn names_columns(comment: &str) -> bool {
    let mut words = comment.trim_start_matches('#').split_ascii_whitespace().map(str::to_lowercase);
    let second = words.nth(1).unwrap_or_default();
    let third = words.next().unwrap_or_default();
    second.trim_matches(['<', '>']) == "frame"
        && Name::of(third.trim_matches(['<', '>'])).meaning == Some(Meaning::X)
}
