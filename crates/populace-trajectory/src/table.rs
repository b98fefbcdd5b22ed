//! Rows of text in columns.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::fields::{
    Fields, Separator, Splitter, is_missing, number, seconds, shortened, whole_id,
};
use crate::layout::{Angle, Customs, Layout, Role};
use crate::names::{NamedUnit, named_unit};
use crate::recording::Kind;
use crate::rows::{Rows, is_clock, is_coordinate};
use crate::{Location, Unit};

/// Words for vehicles in a column of kinds.
const VEHICLES: [&str; 10] =
    ["veh", "vehicle", "car", "van", "bus", "truck", "tram", "bicycle", "bike", "motorcycle"];

/// Reads rows of text in columns.
pub(crate) struct Table {
    splitter: Splitter,
    decimal_comma: bool,
    layouts: Vec<Layout>,
    has_absent_rows: bool,
    /// The largest angles of headings and views whose unit is not told.
    largest: [f64; 2],
    id: String,
}

impl Table {
    /// A table whose rows hold agents by each of the layouts.
    pub(crate) fn new(separator: Separator, layouts: Vec<Layout>, customs: Customs) -> Self {
        Self {
            splitter: Splitter::new(separator),
            // A comma may be a decimal point only where it does not separate fields.
            decimal_comma: separator != Separator::Sign(b','),
            layouts,
            has_absent_rows: customs.has_absent_rows,
            largest: [0.0; 2],
            id: String::new(),
        }
    }

    /// Adds a line to the rows.
    pub(crate) fn take(&mut self, rows: &mut Rows, line: &str, place: Option<Location>) {
        let fields = self.splitter.split(line);
        let mut is_broken = false;
        let mut values = Values { fields, decimal_comma: self.decimal_comma };
        for layout in &mut self.layouts {
            let at = layout.at.map(|column| values.number(column));
            let clock = values.clock(layout);
            let is_absent = layout.at.iter().all(|column| is_missing(fields.get(*column)));
            let id = fields.get(layout.id);
            if is_missing(id) {
                // Only a time: a moment without anybody.
                let is_fault = !is_absent || clock.is_nan();
                if is_fault && !std::mem::replace(&mut is_broken, true) {
                    rows.leave_out("rows without an id were left out", place);
                    rows.explain(|| fault(fields, layout, [clock, at[0], at[1]]));
                }
                continue;
            }
            let is_hidden = layout.active.is_some_and(|column| is_no(fields.get(column)));
            let is_written = fields.len() > layout.at[0].max(layout.at[1]);
            if is_hidden || (is_absent && is_written && self.has_absent_rows) {
                continue;
            }
            let agent = rows.agent_of(layout.kind, whole_id(id, &mut self.id));
            if !rows.push(agent, clock, at, place) {
                rows.explain(|| fault(fields, layout, [clock, at[0], at[1]]));
                continue;
            }
            for (column, role) in &mut layout.roles {
                values.give(rows, agent, *column, role, &mut self.largest);
            }
        }
    }

    /// Takes a line that holds units rather than values, and returns the unit of x. Returns nothing
    /// for other lines.
    pub(crate) fn take_units(&mut self, line: &str) -> Option<Unit> {
        let fields = self.splitter.split(line);
        let layout = self.layouts.first_mut()?;
        let unit = |column| named_unit(&fields.get(column).to_lowercase());
        let Some(NamedUnit::Length(unit_of_x)) = unit(layout.at[0]) else { return None };
        if let (Some(secs), Some(NamedUnit::Time(told))) = (&mut layout.secs, unit(layout.clock)) {
            *secs = told;
        }
        Some(unit_of_x)
    }

    /// Ends the table: decides the unit of angles.
    pub(crate) fn finish(self, rows: &mut Rows) {
        // An angle of 0 is the same in any unit.
        if self.largest[0] > 0.0 {
            rows.guess_headings();
        }
        let [headings, views] = self.largest.map(|largest| largest > TAU + 0.01);
        if headings {
            rows.headings_from_degrees();
        }
        if views {
            rows.views_from_degrees();
        }
    }
}

/// The values of one row.
struct Values<'a> {
    fields: Fields<'a>,
    decimal_comma: bool,
}

impl Values<'_> {
    fn number(&self, column: usize) -> f64 {
        number(self.fields.get(column), self.decimal_comma)
    }

    /// Returns the seconds or the frame of a row, or NaN. Times may be of a clock.
    fn clock(&self, layout: &Layout) -> f64 {
        let field = self.fields.get(layout.clock);
        match layout.secs {
            Some(_) if field.contains(':') => seconds(field, self.decimal_comma),
            secs => self.number(layout.clock) * secs.unwrap_or(1.0),
        }
    }

    /// Gives the value of a column to the last row.
    fn give(
        &mut self,
        rows: &mut Rows,
        agent: u32,
        column: usize,
        role: &mut Role,
        largest: &mut [f64; 2],
    ) {
        let field = self.fields.get(column);
        let value = self.number(column);
        // Infinity is no word, and as good as no number.
        if is_missing(field) || value.is_infinite() {
            return;
        }
        match role {
            Role::Elevation(unit) => rows.set_elevation_in(*unit, value),
            Role::BodyHeight(None) => rows.raise_height(agent, value),
            Role::BodyHeight(Some(unit)) => rows.raise_height_m(agent, value * unit.in_metres()),
            Role::HeadingAngle(angle) => rows.set_heading(radians(value, *angle, &mut largest[0])),
            Role::Heading(y) => rows.set_heading_vector([value, self.number(*y)]),
            Role::ViewAngle(angle) => rows.set_view(radians(value, *angle, &mut largest[1])),
            Role::View(y) => {
                let y = self.number(*y);
                if value != 0.0 || y != 0.0 {
                    rows.set_view(y.atan2(value));
                }
            }
            Role::Kind if VEHICLES.iter().any(|word| field.eq_ignore_ascii_case(word)) => {
                rows.set_kind(agent, Kind::Vehicle);
            }
            Role::Kind => {}
            Role::Extra(extra) => extra.set(rows, field, value),
        }
    }
}

/// Returns why a row is broken: its first column of id, clock, x and y that is, with its value. The
/// numbers are those of clock, x and y.
fn fault(fields: Fields<'_>, layout: &Layout, [clock, x, y]: [f64; 3]) -> String {
    let columns = [layout.id, layout.clock, layout.at[0], layout.at[1]];
    let values = columns.map(|column| fields.get(column));
    let is_whole = [!is_missing(values[0]), is_clock(clock), is_coordinate(x), is_coordinate(y)];
    let nth = is_whole.iter().position(|whole| !whole).unwrap_or_default();
    let name = shortened(&layout.names[nth]);
    if values[nth].is_empty() {
        return format!("nothing in the column \"{name}\"");
    }
    let value = shortened(values[nth]);
    let hint = match layout.secs {
        Some(_) if nth == 1 && !is_missing(values[nth]) => {
            " (times are read as seconds, as hours:minutes:seconds, or as milliseconds in a \
             column t_ms)"
        }
        _ => "",
    };
    format!("\"{value}\" in the column \"{name}\"{hint}")
}

/// Returns an angle in radians, counter-clockwise from +x.
fn radians(value: f64, angle: Angle, largest: &mut f64) -> f64 {
    match angle {
        Angle::Untold => {
            *largest = largest.max(value.abs());
            value
        }
        Angle::Radians => value,
        Angle::Degrees => value.to_radians(),
        Angle::ClockwiseFromNorth => FRAC_PI_2 - value.to_radians(),
    }
}

fn is_no(field: &str) -> bool {
    field.eq_ignore_ascii_case("false")
        || field.eq_ignore_ascii_case("no")
        || number(field, true) == 0.0
}
