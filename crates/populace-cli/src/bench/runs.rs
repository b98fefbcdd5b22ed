//! What was measured, as lines of a table.

use std::fmt;
use std::str::FromStr;

use populace::Stage;
use populace::{Devices, Schedule};
use populace_device::layout::{LAYERS_PER_MEMBER, Layer, Member, Slot, SlotSample};

use super::baked::TableSizes;
use super::memory::{ENTRY_BYTES, palette_bytes};
use super::scene::Load;
use super::timing::Subject;

/// How palettes are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// By a crowd.
    Crowd(Schedule),
    /// Looked up; see `baked.rs`.
    Baked,
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Way {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let schedule = |error: populace_device::Error| format!("{error}; or baked");
        if name == "baked" {
            Ok(Self::Baked)
        } else {
            name.parse().map(Self::Crowd).map_err(schedule)
        }
    }
}

impl Way {
    fn name(self) -> &'static str {
        match self {
            Self::Crowd(schedule) => schedule.name(),
            Self::Baked => "baked",
        }
    }
}

/// Milliseconds of each frame; of the device's clock but for those that are named otherwise.
#[derive(Clone, Default)]
pub(crate) struct Samples {
    pub(crate) floor: Vec<f64>,
    pub(crate) device: Vec<f64>,
    /// From the call to the end, on the host's clock.
    pub(crate) wall: Vec<f64>,
    /// In the call alone.
    pub(crate) host: Vec<f64>,
    /// In the calls that change clips, before it.
    pub(crate) change: Vec<f64>,
    pub(crate) stages: [Vec<f64>; Stage::ALL.len()],
}

/// A subject and what was found out about it.
pub(crate) struct Measured<'a> {
    pub(crate) subject: Subject<'a>,
    pub(crate) samples: Samples,
    pub(crate) memory_bytes: usize,
    /// Of baked palettes.
    pub(crate) tables: Option<TableSizes>,
    /// What each further member takes on the device beyond its palette.
    pub(crate) bytes_per_member: Option<f64>,
    pub(crate) error_m: f64,
    /// `None` where it is not judged.
    pub(crate) allowed_m: Option<f64>,
}

/// One line of the table; most of it is told in `populace bench --help`.
pub(crate) struct Run {
    pub(crate) device: Devices,
    pub(crate) schedule: String,
    pub(crate) stage: String,
    pub(crate) load: String,
    pub(crate) members: usize,
    /// Of all members.
    pub(crate) joints: usize,
    pub(crate) slots: usize,
    pub(crate) ms_median: f64,
    pub(crate) ms_min: f64,
    pub(crate) wall_ms_median: Option<f64>,
    pub(crate) host_ms_median: Option<f64>,
    pub(crate) change_ms_median: Option<f64>,
    /// Bytes of what is a member's own that a joint's share of the stage reads and writes: counted,
    /// not measured.
    pub(crate) bytes_per_joint: f64,
    pub(crate) memory_bytes: usize,
    pub(crate) tables: Option<TableSizes>,
    pub(crate) bytes_per_member: Option<f64>,
    pub(crate) error_m: Option<f64>,
    pub(crate) allowed_m: Option<f64>,
}

impl Run {
    pub(crate) fn is_plain(&self) -> bool {
        self.load == Load::Plain.to_string()
    }

    pub(crate) fn ns_per_joint(&self) -> f64 {
        self.ms_median * 1e6 / self.joints as f64
    }
}

/// The lines of all that was measured: the floor of each device, then each schedule and its stages.
pub(crate) fn runs(measured: &[Measured]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for one in measured {
        let device = &one.subject.on.devices;
        if one.subject.way != Way::Baked
            && !runs.iter().any(|r| r.schedule == "floor" && r.device == *device)
        {
            let same = measured.iter().filter(|other| other.subject.on.devices == *device);
            let floor: Vec<f64> =
                same.flat_map(|other| other.samples.floor.iter().copied()).collect();
            runs.extend(one.floor(&floor));
        }
        runs.extend(one.whole());
        let stages = Stage::ALL.into_iter().zip(&one.samples.stages);
        runs.extend(stages.filter_map(|(stage, ms)| {
            one.line(one.subject.way.name(), stage.name(), ms, stage_bytes(&one.subject, stage))
        }));
    }
    runs
}

impl Measured<'_> {
    /// Nothing where there are no times.
    fn line(&self, schedule: &str, stage: &str, ms: &[f64], bytes_per_joint: f64) -> Option<Run> {
        let Subject { scene, on, way } = self.subject;
        Some(Run {
            device: on.devices.clone(),
            schedule: schedule.to_owned(),
            stage: stage.to_owned(),
            load: scene.load.to_string(),
            members: scene.member_count,
            joints: scene.joint_count(),
            slots: if way == Way::Baked { 1 } else { scene.slot_count },
            ms_median: median(ms)?,
            ms_min: ms.iter().copied().reduce(f64::min)?,
            wall_ms_median: None,
            host_ms_median: None,
            change_ms_median: None,
            bytes_per_joint,
            memory_bytes: self.memory_bytes,
            tables: None,
            bytes_per_member: None,
            error_m: None,
            allowed_m: None,
        })
    }

    fn floor(&self, ms: &[f64]) -> Option<Run> {
        let run = self.line("floor", "all", ms, ENTRY_BYTES as f64)?;
        Some(Run {
            load: Load::Plain.to_string(),
            memory_bytes: palette_bytes(self.subject.scene),
            ..run
        })
    }

    fn whole(&self) -> Option<Run> {
        let samples = &self.samples;
        let native = self.subject.on.is_native();
        let changes = matches!(self.subject.scene.load, Load::Changing { .. });
        let run =
            self.line(self.subject.way.name(), "all", &samples.device, frame_bytes(&self.subject))?;
        Some(Run {
            wall_ms_median: median(&samples.wall),
            host_ms_median: median(&samples.host).filter(|_| !native),
            change_ms_median: median(&samples.change).filter(|_| changes),
            tables: self.tables,
            bytes_per_member: self.bytes_per_member,
            error_m: Some(self.error_m),
            allowed_m: self.allowed_m,
            ..run
        })
    }
}

/// The middle of the values in order; the upper of two. None of none.
pub(crate) fn median(ms: &[f64]) -> Option<f64> {
    let mut sorted = ms.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

fn frame_bytes(subject: &Subject) -> f64 {
    let playing = playing_bytes(subject);
    match subject.way {
        Way::Crowd(Schedule::Staged) => {
            Stage::ALL.iter().map(|&stage| stage_bytes(subject, stage)).sum()
        }
        Way::Crowd(_) => playing + ENTRY_BYTES as f64,
        Way::Baked => ENTRY_BYTES as f64,
    }
}

/// A joint's share of its member's row, slots and layers.
fn playing_bytes(subject: &Subject) -> f64 {
    let slots = subject.scene.slot_count * size_of::<Slot>();
    let member = size_of::<Member>() + slots + LAYERS_PER_MEMBER as usize * size_of::<Layer>();
    per_joint(subject, member)
}

/// A joint's share of a stage of the staged schedule: each buffer that it reads or writes, once.
/// Local and model transforms take 48 bytes each.
fn stage_bytes(subject: &Subject, stage: Stage) -> f64 {
    const LOCAL: f64 = 48.0;
    const MODEL: f64 = 48.0;
    let samples = per_joint(subject, subject.scene.slot_count * size_of::<SlotSample>());
    match stage {
        Stage::Evaluate => playing_bytes(subject) + samples,
        Stage::Pose => samples + LOCAL,
        Stage::Transform => LOCAL + MODEL,
        Stage::WriteBack => MODEL + ENTRY_BYTES as f64,
    }
}

fn per_joint(subject: &Subject, member_bytes: usize) -> f64 {
    (member_bytes * subject.scene.member_count) as f64 / subject.scene.joint_count() as f64
}
