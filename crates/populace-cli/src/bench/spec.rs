//! Subjects of a benchmark, and the measurements made of them.

use std::fmt;
use std::str::FromStr;

use populace::clip::TICKS_PER_SEC;
use populace::{Devices, Schedule};

use super::baked::TableSizes;
use super::scene::{DeviceSetup, Load, Scene};

/// Length of a measured frame.
pub(crate) const FRAME_SECS: f32 = 1.0 / 60.0;
/// Clock ticks of a measured frame.
pub(crate) const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;

/// A method of producing palettes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// A crowd evaluates them.
    Crowd(Schedule),
    /// They are looked up in tables; see `baked.rs`.
    Baked,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let schedule = |error: populace::TablesError| format!("{error}; or baked");
        if name == "baked" {
            Ok(Self::Baked)
        } else {
            name.parse().map(Self::Crowd).map_err(schedule)
        }
    }
}

impl Method {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Crowd(schedule) => schedule.name(),
            Self::Baked => "baked",
        }
    }
}

/// A scene to be measured with one method on one setup of devices.
#[derive(Clone, Copy)]
pub(crate) struct Subject<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) on: &'a DeviceSetup,
    pub(crate) method: Method,
}

/// A measurement: one line of the table. `populace bench --help` describes most fields.
pub(crate) struct Measurement {
    pub(crate) device: Devices,
    pub(crate) schedule: String,
    pub(crate) stage: String,
    pub(crate) load: String,
    pub(crate) members: usize,
    /// Number of joints of all members.
    pub(crate) joints: usize,
    pub(crate) slots: usize,
    pub(crate) ms_median: f64,
    pub(crate) ms_min: f64,
    pub(crate) wall_ms_median: Option<f64>,
    pub(crate) host_ms_median: Option<f64>,
    pub(crate) change_ms_median: Option<f64>,
    /// Bytes of per-member data that the stage reads and writes, per joint. Computed, not measured.
    pub(crate) bytes_per_joint: f64,
    pub(crate) memory_bytes: usize,
    /// Sizes of baked tables.
    pub(crate) tables: Option<TableSizes>,
    pub(crate) bytes_per_member: Option<f64>,
    pub(crate) error_m: Option<f64>,
    /// The allowed error; `None` if the error is not checked.
    pub(crate) allowed_m: Option<f64>,
}

impl Measurement {
    pub(crate) fn is_plain(&self) -> bool {
        self.load == Load::Plain.to_string()
    }

    pub(crate) fn ns_per_joint(&self) -> f64 {
        self.ms_median * 1e6 / self.joints as f64
    }
}
