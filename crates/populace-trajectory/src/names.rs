//! Names of columns: what they stand for, and units in them.

use crate::Unit;

/// The meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    Id,
    Frame,
    /// A time, in units of [`Name::secs`].
    Time,
    X,
    Y,
    Z,
    BodyHeight,
    /// 0 while an agent is not there.
    Active,
    HeadingAngle,
    HeadingX,
    HeadingY,
    ViewAngle,
    ViewX,
    ViewY,
    /// A word such as `pedestrian` or `car`.
    Kind,
    Longitude,
    Latitude,
}

/// A unit in a name, for example the `cm` of `x/cm`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NamedUnit {
    Length(Unit),
    Pixels,
    /// A unit of time, in seconds.
    Time(f64),
    Degrees,
    Radians,
}

/// A name of a column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Name<'a> {
    /// The name without quotes and blanks around it.
    pub(crate) text: &'a str,
    pub(crate) meaning: Option<Meaning>,
    pub(crate) unit: Option<NamedUnit>,
    /// Rank among names with the same meaning: the lowest has it.
    pub(crate) rank: usize,
}

/// Meanings and their names, in lower case and without signs between words, the surest first.
const MEANINGS: &[(Meaning, &[&str])] = &[
    (
        Meaning::Id,
        &[
            "id",
            "ids",
            "pid",
            "ped",
            "pedid",
            "pedestrian",
            "pedestrianid",
            "agent",
            "agentid",
            "person",
            "personid",
            "persid",
            "track",
            "trackid",
            "particle",
            "particleid",
            "vehicleid",
            "no",
        ],
    ),
    (
        Meaning::Frame,
        &["frame", "frames", "fr", "frameid", "frameno", "framenumber", "framenr", "timestep"],
    ),
    (
        Meaning::Time,
        &[
            "t",
            "time",
            "times",
            "timestamp",
            "simtime",
            "simsec",
            "sec",
            "secs",
            "second",
            "seconds",
            "timesteptime",
        ],
    ),
    (Meaning::X, &["x", "posx", "positionx", "px", "xpos", "coordx", "coordcentx", "xcenter"]),
    (Meaning::Y, &["y", "posy", "positiony", "py", "ypos", "coordy", "coordcenty", "ycenter"]),
    (Meaning::Z, &["z", "posz", "positionz", "pz", "zpos", "coordz", "coordcentz", "elevation"]),
    (Meaning::BodyHeight, &["height", "bodyheight", "personheight"]),
    (Meaning::Active, &["active", "isactive"]),
    (Meaning::HeadingAngle, &["heading", "angle", "yaw", "theta", "orientation", "bodyangle"]),
    (Meaning::HeadingX, &["orix", "ox", "headingx", "dirx", "directionx", "orientationx"]),
    (Meaning::HeadingY, &["oriy", "oy", "headingy", "diry", "directiony", "orientationy"]),
    (Meaning::ViewAngle, &["gaze", "gazeangle", "headangle", "facingangle"]),
    (Meaning::ViewX, &["viewdirx", "viewx", "gazex"]),
    (Meaning::ViewY, &["viewdiry", "viewy", "gazey"]),
    (Meaning::Kind, &["type", "class", "kind", "agenttype", "category"]),
    (Meaning::Longitude, &["lon", "lng", "longitude"]),
    (Meaning::Latitude, &["lat", "latitude"]),
];

/// Units and their names in lower case.
const UNITS: &[(NamedUnit, &[&str])] = &[
    (NamedUnit::Length(Unit::Metres), &["m", "metre", "metres", "meter", "meters"]),
    (NamedUnit::Length(Unit::Centimetres), &["cm"]),
    (NamedUnit::Length(Unit::Millimetres), &["mm"]),
    (NamedUnit::Length(Unit::Feet), &["ft", "feet"]),
    (NamedUnit::Pixels, &["px", "pix", "pixel", "pixels"]),
    (NamedUnit::Time(1.0), &["s", "sec", "secs", "seconds"]),
    (NamedUnit::Time(1e-3), &["ms", "msec"]),
    (NamedUnit::Degrees, &["deg", "degree", "degrees", "°"]),
    (NamedUnit::Radians, &["rad", "radian", "radians"]),
];

impl<'a> Name<'a> {
    /// Returns the meaning and the unit of a name.
    pub(crate) fn of(text: &'a str) -> Self {
        let text = text.trim().trim_matches(['"', '\'']).trim();
        let lower = text.to_lowercase();
        // x [m], x (m), x/m, and x_m where x alone has a meaning.
        let bracketed = lower.strip_suffix([']', ')']).and_then(|name| name.split_once(['[', '(']));
        let split = bracketed.or_else(|| lower.rsplit_once('/'));
        let known = |name, unit| {
            let (meaning, rank) = meaning(name).unzip();
            Self { text, meaning, unit, rank: rank.unwrap_or_default() }
        };
        if let Some((name, unit)) = split
            && let Some(unit) = named_unit(unit)
        {
            return known(name, Some(unit));
        }
        if let Some((name, unit)) = lower.rsplit_once('_')
            && let (Some(unit), Some(_)) = (named_unit(unit), meaning(name))
        {
            return known(name, Some(unit));
        }
        known(&lower, None)
    }

    /// A column that holds nothing.
    pub(crate) const NONE: Self = Self { text: "", meaning: None, unit: None, rank: 0 };

    /// Returns the column with a meaning.
    pub(crate) fn find(names: &[Self], meaning: Meaning) -> Option<usize> {
        let named = |(_, name): &(usize, &Self)| name.meaning == Some(meaning);
        let columns = names.iter().enumerate().filter(named);
        columns.min_by_key(|(_, name)| name.rank).map(|(column, _)| column)
    }

    /// Returns the seconds in 1 of a column of times.
    pub(crate) fn secs(&self) -> f64 {
        match self.unit {
            Some(NamedUnit::Time(secs)) => secs,
            _ => 1.0,
        }
    }
}

/// Returns the meaning of a name, and its rank among the names with this meaning.
fn meaning(name: &str) -> Option<(Meaning, usize)> {
    let plain: String = name.chars().filter(|c| c.is_alphanumeric()).collect();
    MEANINGS.iter().find_map(|(meaning, names)| {
        names.iter().position(|name| *name == plain).map(|rank| (*meaning, rank))
    })
}

/// Returns the unit with a name, for example `cm` or `in m`.
pub(crate) fn named_unit(name: &str) -> Option<NamedUnit> {
    let name = name.trim().trim_start_matches("in ").trim();
    UNITS.iter().find(|(_, names)| names.contains(&name)).map(|(unit, _)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_names_are_read_in_every_spelling() {
        let cm = Some(NamedUnit::Length(Unit::Centimetres));
        for text in ["x/cm", "x_cm", "x [cm]", "X(cm)", "\"pos_x [cm]\"", "posX_cm", "x [in cm]"] {
            let name = Name::of(text);
            assert_eq!((name.meaning, name.unit), (Some(Meaning::X), cm), "{text}");
        }
    }

    #[test]
    fn a_suffix_is_no_unit_where_the_rest_has_no_meaning() {
        let name = Name::of("phase_m");
        assert_eq!((name.text, name.meaning, name.unit), ("phase_m", None, None));
    }

    #[test]
    fn the_surest_name_has_the_meaning() {
        let names = ["no", "px", "id", "x"].map(Name::of);
        assert_eq!(Name::find(&names, Meaning::Id), Some(2));
        assert_eq!(Name::find(&names, Meaning::X), Some(3));
    }

    #[test]
    fn time_in_milliseconds_counts_in_seconds() {
        let name = Name::of("time_ms");
        assert_eq!((name.meaning, name.secs()), (Some(Meaning::Time), 1e-3));
        assert_eq!(Name::of("t [s]").secs(), 1.0);
    }
}
