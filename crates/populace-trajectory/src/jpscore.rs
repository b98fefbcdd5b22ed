//! Text of jpscore, the former JuPedSim: rows of ID, FR, X, Y and Z, and in most files the axes A
//! and B of an ellipse, ANGLE and COLOR.

use crate::comment;
use crate::fields::{Separator, Splitter};
use crate::input::Input;
use crate::layout::{Angle, Customs, Layout};
use crate::names::Name;
use crate::rows::{Clock, Found, Rows};
use crate::table::Table;
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Frames per second of files that do not say it, as the program's own viewer assumes.
const ASSUMED_FPS: f64 = 16.0;
/// Columns of files that do not name them.
const NAMES: [&str; 9] = ["ID", "FR", "X", "Y", "Z", "A", "B", "ANGLE", "COLOR"];

const CUSTOMS: Customs = Customs { angle: Angle::Degrees, ..Customs::COMMON };

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut rows = Rows::default();
    let (mut layout, mut fps, mut unit) = (None, None, None);
    let mut table = None;
    let mut splitter = Splitter::new(Separator::Blanks);
    input.for_each_line(|line, number| {
        if let Some(comment) = line.trim_start().strip_prefix('#') {
            fps = fps.or(comment::frame_rate(comment));
            unit = unit.or(comment::unit(comment));
            layout = layout.take().or_else(|| layout_of(comment));
        } else if !line.trim().is_empty() {
            let table = table.get_or_insert_with(|| {
                let columns = splitter.split(line).len().clamp(4, NAMES.len());
                let layout = layout.take().or_else(|| layout_of(&NAMES[..columns].join(" ")));
                Table::new(Separator::Blanks, layout.into_iter().collect(), CUSTOMS)
            });
            table.take(&mut rows, line, Some(Location::Line(number)));
        }
        Ok(())
    })?;
    if let Some(table) = table {
        table.finish(&mut rows);
    }
    let fps = fps.map_or_else(|| Fact::assumed(ASSUMED_FPS), Fact::of_file);
    let unit = Fact::of_file(unit.unwrap_or(Unit::Metres));
    let format = (Format::Jpscore, String::new());
    let found = Found { format, unit, clock: Clock::Frames(fps), place: Place::default() };
    rows.finish(found, input.path(), settings)
}

/// Returns the layout that a comment names, if it names columns.
fn layout_of(comment: &str) -> Option<Layout> {
    let names: Vec<_> = comment.split_ascii_whitespace().map(Name::of).collect();
    Layout::of(&names, CUSTOMS).ok()
}

/// Returns true if a comment names the columns of such a file.
pub(crate) fn names_columns(comment: &str) -> bool {
    let mut words = comment.trim_start_matches('#').split_ascii_whitespace();
    let is = |word: Option<&str>, name| word.is_some_and(|word| word.eq_ignore_ascii_case(name));
    is(words.next(), "id") && is(words.next(), "fr") && is(words.next(), "x")
}
