//! Text with named columns: any such table, and those of Pathfinder, Viswalk and crowd:it.

use crate::comment;
use crate::fields::{Fields, Separator, Splitter, shortened};
use crate::input::Input;
use crate::layout::{Angle, Customs, Layout};
use crate::names::{Meaning, Name};
use crate::recording::Kind;
use crate::rows::{Clock, Found, Rows};
use crate::table::Table;
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Frames per second of tables that count frames and do not say it.
const ASSUMED_FPS: f64 = 25.0;
/// Beginnings of names in the tables of SUMO, which hold people and vehicles in one row.
const SUMO_PREFIXES: [(&str, Kind); 2] = [("person_", Kind::Person), ("vehicle_", Kind::Vehicle)];
/// Signs that may separate fields, in the order in which they are tried.
const SEPARATORS: [Separator; 5] = [
    Separator::Sign(b';'),
    Separator::Sign(b'\t'),
    Separator::Sign(b'|'),
    Separator::Sign(b','),
    Separator::Blanks,
];
/// The beginning of the line of Viswalk that names columns.
const VISWALK_NAMES: &str = "$PEDESTRIAN:";

/// The columns of a table, and what its header says.
struct Header {
    table: Table,
    secs: bool,
    unit: Option<Unit>,
}

/// Facts that a table says beside its rows.
struct Reading<'a> {
    input: &'a Input,
    format: Format,
    customs: Customs,
    rows: Rows,
    header: Option<Header>,
    fps: Option<f64>,
    unit: Option<Unit>,
}

/// Reads a table in one of the formats with named columns.
pub(crate) fn read(
    input: &Input,
    format: Format,
    settings: &ReadSettings,
) -> Result<Recording, Error> {
    let (rows, header, fps, unit) = (Rows::default(), None, None, None);
    let customs = Customs {
        has_absent_rows: format == Format::CrowdIt,
        unit_is_told: settings.unit.is_some(),
        ..Customs::COMMON
    };
    let mut reading = Reading { input, format, customs, rows, header, fps, unit };
    input.for_each_line(|line, number| reading.take(line, number))?;
    let Reading { mut rows, header, fps, unit, .. } = reading;
    let Some(Header { table, secs, unit: named }) = header else {
        return Err(input.malformed(None, no_header(format)));
    };
    table.finish(&mut rows);
    // The other formats are in metres unless they say otherwise.
    let is_common = format == Format::Csv;
    let unit = match unit.or(named) {
        Some(unit) => Fact::of_file(unit),
        None if is_common => Fact::assumed(Unit::Metres),
        None => Fact::of_file(Unit::Metres),
    };
    let fps = fps.map_or_else(|| Fact::assumed(ASSUMED_FPS), Fact::of_file);
    let clock = if secs { Clock::Seconds } else { Clock::Frames(fps) };
    let found = Found { format: (format, String::new()), unit, clock, place: Place::default() };
    rows.finish(found, input.path(), settings)
}

fn no_header(format: Format) -> String {
    match format {
        Format::Viswalk => format!("no line begins with {VISWALK_NAMES}, which names the columns"),
        _ => "there is no line with the names of columns".to_owned(),
    }
}

impl Reading<'_> {
    fn take(&mut self, line: &str, number_of_line: u64) -> Result<(), Error> {
        let place = Some(Location::Line(number_of_line));
        let text = line.trim();
        if text.is_empty() {
            return Ok(());
        }
        let Some(header) = &mut self.header else {
            if comment::names_separator(text) {
                return Ok(());
            }
            if self.header_of(text, place)? {
                return Ok(());
            }
            self.take_comment(text);
            return Ok(());
        };
        if self.format == Format::Viswalk && text.starts_with(['*', '$']) {
            return Ok(());
        }
        if text.starts_with('#') {
            self.take_comment(text);
            return Ok(());
        }
        if self.rows.len() == 0
            && let Some(unit) = header.table.take_units(line)
        {
            self.unit = Some(unit);
            return Ok(());
        }
        header.table.take(&mut self.rows, line, place);
        Ok(())
    }

    fn take_comment(&mut self, text: &str) {
        self.fps = self.fps.or(comment::frame_rate(text));
        self.unit = self.unit.or(comment::unit(text));
    }

    /// Takes the header from a line. Returns false if the line is something else.
    fn header_of(&mut self, text: &str, place: Option<Location>) -> Result<bool, Error> {
        let names = match self.format {
            Format::Viswalk => text.strip_prefix(VISWALK_NAMES),
            // A comment may name the columns, or may not.
            _ => Some(text.trim_start_matches('#').trim()),
        };
        let Some(names) = names else { return Ok(false) };
        match header(names, self.customs) {
            Ok(header) => self.header = Some(header),
            Err(_) if text.starts_with('#') => return Ok(false),
            Err(problem) => return Err(self.input.malformed(place, problem)),
        }
        Ok(true)
    }
}

/// Returns the columns that a line names.
fn header(line: &str, customs: Customs) -> Result<Header, String> {
    let mut problem = String::new();
    let mut most = 0;
    for separator in SEPARATORS {
        let joined = line.replace(" [", "[").replace(" (", "(");
        let mut splitter = Splitter::new(separator);
        let fields = splitter.split(if separator == Separator::Blanks { &joined } else { line });
        match layouts(fields, customs) {
            Ok(layouts) => {
                let secs = layouts.iter().any(|layout| layout.secs.is_some());
                let unit = layouts.first().and_then(|layout| layout.unit);
                return Ok(Header { table: Table::new(separator, layouts, customs), secs, unit });
            }
            // The separator that gives most columns is the likeliest.
            Err(why) if fields.len() > most => (most, problem) = (fields.len(), why),
            Err(_) => {}
        }
    }
    Err(format!("the first line that is no comment is \"{}\": {problem}", shortened(line)))
}

/// Returns the layouts of named columns: one, or those of people and of vehicles.
fn layouts(fields: Fields<'_>, customs: Customs) -> Result<Vec<Layout>, String> {
    let mut layouts = Vec::new();
    for (prefix, kind) in SUMO_PREFIXES {
        if !fields.iter().any(|field| field.strip_prefix(prefix) == Some("x")) {
            continue;
        }
        let others = SUMO_PREFIXES.map(|(prefix, _)| prefix).into_iter().filter(|p| *p != prefix);
        let others: Vec<_> = others.collect();
        let names: Vec<_> = (fields.iter())
            .map(|field| match field.strip_prefix(prefix) {
                Some(rest) => Name { text: field, ..Name::of(rest) },
                None if others.iter().any(|other| field.starts_with(other)) => Name::NONE,
                None => Name::of(field),
            })
            .collect();
        let customs = Customs { angle: Angle::ClockwiseFromNorth, ..customs };
        layouts.push(Layout { kind, ..Layout::of(&names, customs)? });
    }
    if layouts.is_empty() {
        let names: Vec<_> = fields.iter().map(Name::of).collect();
        let is_vehicle = |name: &Name<'_>| name.text.eq_ignore_ascii_case("vehicle_id");
        let mut layout = Layout::of(&names, customs)?;
        if is_vehicle(&names[layout.id]) {
            layout.kind = Kind::Vehicle;
        }
        layouts.push(layout);
    }
    Ok(layouts)
}

/// Returns true if a line names the columns of a table that can be read, once its unit is told.
pub(crate) fn is_header(line: &str) -> bool {
    header(line, Customs { unit_is_told: true, ..Customs::COMMON }).is_ok()
}

/// Returns the problem of a line that names some columns but not all that are needed.
pub(crate) fn problem_of_header(line: &str) -> Option<String> {
    let known = [Meaning::X, Meaning::Y, Meaning::Longitude, Meaning::Latitude, Meaning::Time];
    let is_known = |field: &str| Name::of(field).meaning.is_some_and(|m| known.contains(&m));
    let names_some = SEPARATORS
        .iter()
        .any(|separator| Splitter::new(*separator).split(line).iter().any(is_known));
    header(line, Customs::COMMON).err().filter(|_| names_some)
}
