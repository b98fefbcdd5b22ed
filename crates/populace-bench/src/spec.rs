//! Subjects of a benchmark, and the measurements made of them.

use std::fmt;
use std::str::FromStr;

use populace::clip::TICKS_PER_SEC;
use populace::{Devices, Schedule};

use crate::baked::TableSizes;
use crate::scene::{DeviceSetup, Load, Scene};

/// Length of a measured frame.
pub(crate) const FRAME_SECS: f32 = 1.0 / 60.0;
/// Clock ticks of a measured frame.
pub(crate) const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;

/// A method of producing palettes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
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
    /// Returns the name of the schedule, or `baked`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Crowd(schedule) => schedule.name(),
            Self::Baked => "baked",
        }
    }
}

/// A scene to be measured with one method on one setup of devices.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) on: &'a DeviceSetup,
    pub(crate) method: Method,
}

impl<'a> Subject<'a> {
    /// Returns all subjects, with the loads of each schedule side by side. Baked palettes are
    /// subjects only of plain scenes on one native device.
    #[must_use]
    pub fn all(scenes: &'a [Scene], setups: &'a [DeviceSetup], methods: &[Method]) -> Vec<Self> {
        let mut subjects = Vec::new();
        for on in setups {
            for &method in methods {
                let measured = |scene: &&Scene| match method {
                    Method::Crowd(_) => true,
                    Method::Baked => scene.load == Load::Plain && on.is_native() && !on.is_shared(),
                };
                let scenes = scenes.iter().filter(measured);
                subjects.extend(scenes.map(|scene| Self { scene, on, method }));
            }
        }
        subjects
    }
}

impl fmt::Display for Subject<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (members, devices) = (self.scene.member_count, &self.on.devices);
        write!(f, "{} of {members} members on {devices}", self.method)
    }
}

/// A measurement: one line of the table.
///
/// Times by the device's clock come from profiling events if the device has them, and from the
/// host's clock otherwise.
pub struct Measurement {
    /// The devices that evaluated the frames.
    pub device: Devices,
    /// The schedule, `floor` or `baked`.
    pub schedule: String,
    /// One stage, or `all`.
    pub stage: String,
    /// The load of the scene.
    pub load: String,
    /// Number of members.
    pub members: usize,
    /// Number of joints of all members.
    pub joints: usize,
    /// Slots of each member.
    pub slots: usize,
    /// Median of the frame's milliseconds by the device's clock.
    pub ms_median: f64,
    /// Least of the frame's milliseconds by the device's clock.
    pub ms_min: f64,
    /// Median of milliseconds from the call to the end of the frame, by the host's clock.
    pub wall_ms_median: Option<f64>,
    /// Median of milliseconds in the call alone, by the host's clock.
    pub host_ms_median: Option<f64>,
    /// Median of milliseconds in the preceding calls that change clips, by the host's clock.
    pub change_ms_median: Option<f64>,
    /// Bytes of per-member data that the stage reads and writes, per joint. Computed, not measured.
    pub bytes_per_joint: f64,
    /// Bytes on the device.
    pub memory_bytes: usize,
    /// Sizes of baked tables.
    pub tables: Option<TableSizes>,
    /// Bytes of device memory per further member, without its palette.
    pub bytes_per_member: Option<f64>,
    /// The largest distance of a joint from the oracle's result, in metres.
    pub error_m: Option<f64>,
    /// The allowed error; `None` if the error is not checked.
    pub allowed_m: Option<f64>,
}

impl Measurement {
    pub(crate) fn is_plain(&self) -> bool {
        self.load == Load::Plain.to_string()
    }

    /// Returns the median in nanoseconds per joint.
    #[must_use]
    pub fn ns_per_joint(&self) -> f64 {
        self.ms_median * 1e6 / self.joints as f64
    }

    /// Says what is wrong if the error is larger than allowed.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        let (error, allowed) = self.error_m.zip(self.allowed_m)?;
        let wrong = error.is_nan() || error > allowed;
        wrong.then(|| {
            format!(
                "{} ({}, {}) is wrong: a joint is {error:.6} m away from the oracle's result, and \
                 {allowed:.6} m are allowed",
                self.device, self.schedule, self.load
            )
        })
    }
}
