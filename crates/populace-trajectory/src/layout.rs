//! Columns of a table: which holds what.

use crate::Unit;
use crate::extra::Extra;
use crate::fields::shortened;
use crate::names::{Meaning, Name, NamedUnit};
use crate::recording::Kind;

/// How angles are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Angle {
    /// Counter-clockwise from +x, in radians or in degrees: the values tell.
    Untold,
    /// Counter-clockwise from +x.
    Degrees,
    /// Counter-clockwise from +x.
    Radians,
    /// In degrees, from +y.
    ClockwiseFromNorth,
}

/// Customs of a format.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Customs {
    /// True if z is the height of the head or the body, false if it is that of the ground.
    pub(crate) z_is_body_height: bool,
    pub(crate) angle: Angle,
    /// True if rows without a position are those of absent agents rather than faults.
    pub(crate) has_absent_rows: bool,
    /// True if the unit of positions is told, also of those that are in pixels.
    pub(crate) unit_is_told: bool,
}

impl Customs {
    /// Customs of tables of unknown origin.
    pub(crate) const COMMON: Self = Self {
        z_is_body_height: false,
        angle: Angle::Untold,
        has_absent_rows: false,
        unit_is_told: false,
    };
}

/// The problem of positions in pixels.
const PIXELS: &str = "positions are in pixels; for a view from straight above, give the metres of \
                      a pixel by --unit, such as --unit 0.02; turn those of other views into \
                      metres by their homography, and name the columns x and y";

/// The value that a column gives to a row, beside id, clock and position.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Role {
    /// With its unit, if that is not the one of positions.
    Elevation(Option<Unit>),
    /// With its unit, if that is not the one of positions.
    BodyHeight(Option<Unit>),
    HeadingAngle(Angle),
    /// With the index of the column of y.
    Heading(usize),
    ViewAngle(Angle),
    /// With the index of the column of y.
    View(usize),
    Kind,
    Extra(Extra),
}

/// The columns of the values of a row.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub(crate) id: usize,
    pub(crate) clock: usize,
    /// Seconds in 1 of the clock; `None` if it counts frames.
    pub(crate) secs: Option<f64>,
    pub(crate) at: [usize; 2],
    pub(crate) active: Option<usize>,
    /// The kind of all agents of the layout.
    pub(crate) kind: Kind,
    pub(crate) roles: Vec<(usize, Role)>,
    /// The unit in the names of x and y.
    pub(crate) unit: Option<Unit>,
    /// The names of the columns of id, clock, x and y.
    pub(crate) names: [String; 4],
}

impl Layout {
    /// Returns the layout of columns with names.
    ///
    /// # Errors
    ///
    /// The problem, if a column is missing or in a unit that cannot be read.
    pub(crate) fn of(names: &[Name<'_>], customs: Customs) -> Result<Self, String> {
        let find = |meaning| Name::find(names, meaning);
        let (time, frame) = (find(Meaning::Time), find(Meaning::Frame));
        let (x, y) = (find(Meaning::X), find(Meaning::Y));
        let (Some(id), Some(clock), Some(x), Some(y)) = (find(Meaning::Id), time.or(frame), x, y)
        else {
            return Err(missing(names));
        };
        let is_in_pixels = [x, y].iter().any(|at| names[*at].unit == Some(NamedUnit::Pixels));
        if is_in_pixels && !customs.unit_is_told {
            return Err(PIXELS.to_owned());
        }
        let [unit, unit_of_y] = [x, y].map(|column| match names[column].unit {
            Some(NamedUnit::Length(unit)) => Some(unit),
            _ => None,
        });
        if unit != unit_of_y {
            return Err("the columns of x and y have different units".to_owned());
        }
        let mut layout = Self {
            id,
            clock,
            secs: time.map(|time| names[time].secs()),
            at: [x, y],
            active: find(Meaning::Active),
            kind: Kind::Person,
            roles: Vec::new(),
            unit,
            names: [id, clock, x, y].map(|column| names[column].text.to_owned()),
        };
        layout.add_roles(names, customs);
        Ok(layout)
    }

    fn add_roles(&mut self, names: &[Name<'_>], customs: Customs) {
        let find = |meaning| Name::find(names, meaning);
        let pair = |x, y| find(x).zip(find(y));
        let heading = pair(Meaning::HeadingX, Meaning::HeadingY);
        let view = pair(Meaning::ViewX, Meaning::ViewY);
        // Columns that are read with another or not at all.
        let taken = [heading, view].map(|pair| pair.map(|(_, y)| y));
        for (column, name) in names.iter().enumerate() {
            let is_first = name.meaning.is_none_or(|meaning| find(meaning) == Some(column));
            let is_basic = [self.id, self.clock, self.at[0], self.at[1]].contains(&column);
            // Columns without a name count the rows.
            if name.text.is_empty()
                || is_basic
                || self.active == Some(column)
                || taken.contains(&Some(column))
            {
                continue;
            }
            let angle = match name.unit {
                Some(NamedUnit::Degrees) if customs.angle == Angle::Untold => Angle::Degrees,
                Some(NamedUnit::Radians) if customs.angle == Angle::Untold => Angle::Radians,
                _ => customs.angle,
            };
            let unit = match name.unit {
                Some(NamedUnit::Length(unit)) => Some(unit).filter(|_| self.unit != Some(unit)),
                _ => None,
            };
            let extra = || Role::Extra(Extra::new(name.text));
            let role = match name.meaning.filter(|_| is_first) {
                Some(Meaning::Z) if customs.z_is_body_height => Role::BodyHeight(unit),
                Some(Meaning::Z) => Role::Elevation(unit),
                Some(Meaning::BodyHeight) => Role::BodyHeight(unit),
                Some(Meaning::HeadingAngle) if heading.is_none() => Role::HeadingAngle(angle),
                Some(Meaning::ViewAngle) if view.is_none() => Role::ViewAngle(angle),
                Some(Meaning::HeadingX) => heading.map_or_else(extra, |(_, y)| Role::Heading(y)),
                Some(Meaning::ViewX) => view.map_or_else(extra, |(_, y)| Role::View(y)),
                _ => extra(),
            };
            if name.meaning == Some(Meaning::Kind) && is_first {
                self.roles.push((column, Role::Kind));
            }
            self.roles.push((column, role));
        }
    }
}

/// Returns the problem of names that lack a column.
fn missing(names: &[Name<'_>]) -> String {
    let has = |meaning| names.iter().any(|name| name.meaning == Some(meaning));
    if has(Meaning::Longitude) && has(Meaning::Latitude) {
        return "positions are longitudes and latitudes; project them to metres first".to_owned();
    }
    let needed = [
        ("an id (id, agent, ped, …)", has(Meaning::Id)),
        ("a time or a frame (t, time, frame, …)", has(Meaning::Time) || has(Meaning::Frame)),
        ("x (x, pos_x, …)", has(Meaning::X)),
        ("y (y, pos_y, …)", has(Meaning::Y)),
    ];
    let lacks: Vec<_> = needed.iter().filter(|(_, has)| !has).map(|(name, _)| *name).collect();
    let seen: Vec<_> = names.iter().take(20).map(|name| shortened(name.text)).collect();
    format!("no column has {}; the columns are {}", lacks.join(", nor "), seen.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(names: &str) -> Result<Layout, String> {
        let names: Vec<_> = names.split(',').map(Name::of).collect();
        Layout::of(&names, Customs::COMMON)
    }

    #[test]
    fn each_missing_column_is_named() {
        let problem = layout("t,x,speed").expect_err("columns are missing");
        assert!(problem.contains("an id") && problem.contains("nor y"), "{problem}");
        assert!(!problem.contains("a time"), "{problem}");
        assert!(problem.ends_with("the columns are t, x, speed"), "{problem}");
    }

    #[test]
    fn longitudes_and_pixels_are_refused_with_a_hint() {
        assert!(layout("id,t,lon,lat").expect_err("lon").contains("project"));
        assert!(layout("id,t,x_px,y_px").expect_err("px").contains("--unit 0.02"));
        assert!(layout("id,t,x_cm,y_m").expect_err("mixed").contains("different"));
    }

    #[test]
    fn a_vector_is_preferred_to_an_angle() {
        let roles = layout("id,frame,x,y,heading,ori_x,ori_y").expect("a layout").roles;
        let angle = Role::Extra(Extra::new("heading"));
        assert_eq!(roles, [(4, angle), (5, Role::Heading(6))]);
    }
}
