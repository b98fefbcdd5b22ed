//! Formats, units, and the origin of each fact about a file.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A family of trajectory files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Text of PeTrack and of the Jülich archive: id, frame, x, y, z.
    PeTrack,
    /// Text of jpscore, the former JuPedSim: with ellipses, angles and colours.
    Jpscore,
    /// SQLite of JuPedSim, versions 1 to 3.
    JuPedSim,
    /// HDF5 of JuPedSim, PeTrack and the Jülich archive.
    Hdf5,
    /// Footsteps of Vadere, `postvis.traj`.
    Vadere,
    /// Floating car data of SUMO, XML.
    Sumo,
    /// CSV of Pathfinder.
    PathfinderCsv,
    /// JSON of Pathfinder.
    PathfinderJson,
    /// `.pp` of Viswalk and Vissim.
    Viswalk,
    /// CSV of crowd:it.
    CrowdIt,
    /// `obsmat.txt` of the ETH and UCY data sets.
    Obsmat,
    /// Text of TrajNet: frame, id, x, y.
    TrajNet,
    /// Lines of JSON of TrajNet++.
    TrajNetPlusPlus,
    /// `.scb` of Menge.
    Menge,
    /// Text with named columns.
    Csv,
}

impl Format {
    /// All formats with the names that flags and documents use.
    pub const ALL: [(Self, &'static str, &'static str); 15] = [
        (Self::PeTrack, "petrack", "PeTrack text"),
        (Self::Jpscore, "jpscore", "jpscore text"),
        (Self::JuPedSim, "jupedsim", "JuPedSim SQLite"),
        (Self::Hdf5, "hdf5", "HDF5"),
        (Self::Vadere, "vadere", "Vadere footsteps"),
        (Self::Sumo, "sumo", "SUMO floating car data"),
        (Self::PathfinderCsv, "pathfinder-csv", "Pathfinder CSV"),
        (Self::PathfinderJson, "pathfinder-json", "Pathfinder JSON"),
        (Self::Viswalk, "viswalk", "Viswalk"),
        (Self::CrowdIt, "crowdit", "crowd:it CSV"),
        (Self::Obsmat, "obsmat", "ETH/UCY obsmat"),
        (Self::TrajNet, "trajnet", "TrajNet text"),
        (Self::TrajNetPlusPlus, "trajnet++", "TrajNet++ lines"),
        (Self::Menge, "menge", "Menge SCB"),
        (Self::Csv, "csv", "text with named columns"),
    ];

    /// The name in flags and in JSON, for example `jupedsim`.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(format, ..)| *format == self).map_or("", |(_, name, _)| name)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let title = Self::ALL.iter().find(|(format, ..)| format == self).map(|(.., title)| *title);
        f.write_str(title.unwrap_or_default())
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|(_, name, _)| *name == text);
        found.map(|(format, ..)| *format).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|(_, name, _)| *name).collect();
            format!("\"{text}\" is not a format; the formats are {}", names.join(", "))
        })
    }
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    /// Metres.
    Metres,
    /// Centimetres.
    Centimetres,
    /// Millimetres.
    Millimetres,
    /// International feet, 0.3048 m.
    Feet,
    /// The metres in one unit, from 0.000001 to 1,000,000: of a pixel that is seen from above.
    OfMetres(f64),
}

impl Unit {
    const ALL: [(Self, &'static str, f64); 4] = [
        (Self::Metres, "m", 1.0),
        (Self::Centimetres, "cm", 0.01),
        (Self::Millimetres, "mm", 0.001),
        (Self::Feet, "ft", 0.3048),
    ];

    /// Sizes of units in metres that files are read in.
    pub(crate) const SIZES_M: RangeInclusive<f64> = 1e-6..=1e6;

    /// Metres in one unit.
    #[must_use]
    pub fn in_metres(self) -> f64 {
        if let Self::OfMetres(metres) = self {
            return metres;
        }
        Self::ALL.iter().find(|(unit, ..)| *unit == self).map_or(1.0, |(.., metres)| *metres)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Self::OfMetres(metres) = self {
            return write!(f, "{metres} m");
        }
        f.write_str(
            Self::ALL.iter().find(|(unit, ..)| unit == self).map_or("", |(_, name, _)| name),
        )
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((unit, ..)) = Self::ALL.iter().find(|(_, name, _)| *name == text) {
            return Ok(*unit);
        }
        let metres = text.parse().ok().filter(|metres| Self::SIZES_M.contains(metres));
        metres.map(Self::OfMetres).ok_or_else(|| {
            format!(
                "\"{text}\" is not a unit; write m, cm, mm or ft, or the metres in one unit, from \
                 0.000001 to 1000000"
            )
        })
    }
}

/// The source of headings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeadingSource {
    /// The file, where it has one; motion elsewhere.
    Data,
    /// The direction of motion, held while standing.
    Motion,
}

impl fmt::Display for HeadingSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Data => "data",
            Self::Motion => "motion",
        })
    }
}

impl FromStr for HeadingSource {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "data" => Ok(Self::Data),
            "motion" => Ok(Self::Motion),
            _ => Err(format!("\"{text}\" is no source of headings; write data or motion")),
        }
    }
}

/// The origin of a fact about a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The file says it, or its format does.
    File,
    /// The reader was told.
    Settings,
    /// Nothing says it.
    Assumed,
}

/// A fact about a file, with its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fact<T> {
    /// The fact.
    pub value: T,
    /// Its origin.
    pub origin: Origin,
}

impl<T> Fact<T> {
    /// Returns a fact that the file says.
    pub const fn of_file(value: T) -> Self {
        Self { value, origin: Origin::File }
    }

    /// Returns a fact that is assumed.
    pub const fn assumed(value: T) -> Self {
        Self { value, origin: Origin::Assumed }
    }

    /// Returns the fact that settings give, or this one.
    #[must_use]
    pub fn unless_set(self, set: Option<T>) -> Self {
        set.map_or(self, |value| Self { value, origin: Origin::Settings })
    }
}

/// Facts about the file that a recording comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Its format.
    pub format: Format,
    /// Further words on the format, for example "version 2"; may be empty.
    pub version: String,
    /// The unit of positions in the file.
    pub unit: Fact<Unit>,
    /// Rows of each agent in a second.
    pub fps: Fact<f64>,
    /// The source of headings. Headings from the data are assumed if nothing but the size of their
    /// angles tells whether those are radians or degrees.
    pub heading: Fact<HeadingSource>,
}
