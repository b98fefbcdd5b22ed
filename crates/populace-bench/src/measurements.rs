//! Turns frame times into measurements.

use populace::Schedule;
use populace::Stage;
use populace_device::layout::{LAYERS_PER_MEMBER, Layer, Member, Slot, SlotSample};

use crate::baked::TableSizes;
use crate::memory::{ENTRY_BYTES, palette_bytes};
use crate::scene::Load;
use crate::spec::{Measurement, Method, Subject};

/// Times of each frame in milliseconds, by the device's clock unless stated otherwise.
#[derive(Clone, Default)]
pub(crate) struct Samples {
    pub(crate) floor: Vec<f64>,
    pub(crate) device: Vec<f64>,
    /// From the call to the end of the frame, by the host's clock.
    pub(crate) wall: Vec<f64>,
    /// In the call alone, by the host's clock.
    pub(crate) host: Vec<f64>,
    /// In the preceding calls that change clips, by the host's clock.
    pub(crate) change: Vec<f64>,
    pub(crate) stages: [Vec<f64>; Stage::ALL.len()],
}

/// A subject with its frame times, memory and error.
pub(crate) struct SubjectResult<'a> {
    pub(crate) subject: Subject<'a>,
    pub(crate) samples: Samples,
    pub(crate) memory_bytes: usize,
    /// Sizes of baked tables.
    pub(crate) tables: Option<TableSizes>,
    /// Bytes of device memory per further member, without its palette.
    pub(crate) bytes_per_member: Option<f64>,
    pub(crate) error_m: f64,
    /// The allowed error; `None` if the error is not checked.
    pub(crate) allowed_m: Option<f64>,
}

/// Returns the measurements of all results: the floor of each device, then each schedule and its
/// stages.
pub(crate) fn measurements(results: &[SubjectResult]) -> Vec<Measurement> {
    let mut all: Vec<Measurement> = Vec::new();
    for one in results {
        let device = &one.subject.on.devices;
        if one.subject.method != Method::Baked
            && !all.iter().any(|r| r.schedule == "floor" && r.device == *device)
        {
            let same = results.iter().filter(|other| other.subject.on.devices == *device);
            let floor: Vec<f64> =
                same.flat_map(|other| other.samples.floor.iter().copied()).collect();
            all.extend(one.floor(&floor));
        }
        all.extend(one.whole());
        let stages = Stage::ALL.into_iter().zip(&one.samples.stages);
        all.extend(stages.filter_map(|(stage, ms)| {
            one.line(one.subject.method.name(), stage.name(), ms, stage_bytes(&one.subject, stage))
        }));
    }
    all
}

impl SubjectResult<'_> {
    /// Returns `None` if there are no times.
    fn line(
        &self,
        schedule: &str,
        stage: &str,
        ms: &[f64],
        bytes_per_joint: f64,
    ) -> Option<Measurement> {
        let Subject { scene, on, method } = self.subject;
        Some(Measurement {
            device: on.devices.clone(),
            schedule: schedule.to_owned(),
            stage: stage.to_owned(),
            load: scene.load.to_string(),
            members: scene.member_count,
            joints: scene.joint_count(),
            slots: if method == Method::Baked { 1 } else { scene.slot_count },
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

    fn floor(&self, ms: &[f64]) -> Option<Measurement> {
        let line = self.line("floor", "all", ms, ENTRY_BYTES as f64)?;
        Some(Measurement {
            load: Load::Plain.to_string(),
            memory_bytes: palette_bytes(self.subject.scene),
            ..line
        })
    }

    fn whole(&self) -> Option<Measurement> {
        let samples = &self.samples;
        let native = self.subject.on.is_native();
        let changes = matches!(self.subject.scene.load, Load::Changing { .. });
        let bytes = frame_bytes(&self.subject);
        let line = self.line(self.subject.method.name(), "all", &samples.device, bytes)?;
        Some(Measurement {
            wall_ms_median: median(&samples.wall),
            host_ms_median: median(&samples.host).filter(|_| !native),
            change_ms_median: median(&samples.change).filter(|_| changes),
            tables: self.tables,
            bytes_per_member: self.bytes_per_member,
            error_m: Some(self.error_m),
            allowed_m: self.allowed_m,
            ..line
        })
    }
}

/// Returns the median, the upper of the two middle values if their number is even; `None` if there
/// are no values.
pub(crate) fn median(ms: &[f64]) -> Option<f64> {
    let mut sorted = ms.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

fn frame_bytes(subject: &Subject) -> f64 {
    let playing = playing_bytes(subject);
    match subject.method {
        Method::Crowd(Schedule::Staged) => {
            Stage::ALL.iter().map(|&stage| stage_bytes(subject, stage)).sum()
        }
        Method::Crowd(_) => playing + ENTRY_BYTES as f64,
        Method::Baked => ENTRY_BYTES as f64,
    }
}

/// Returns the bytes of a member's row, slots and layers, per joint.
fn playing_bytes(subject: &Subject) -> f64 {
    let slots = subject.scene.slot_count * size_of::<Slot>();
    let member = size_of::<Member>() + slots + LAYERS_PER_MEMBER as usize * size_of::<Layer>();
    per_joint(subject, member)
}

/// Returns the bytes that a stage of the staged schedule reads and writes, per joint. Each buffer
/// counts once.
fn stage_bytes(subject: &Subject, stage: Stage) -> f64 {
    /// Bytes of a local transform.
    const LOCAL: f64 = 48.0;
    /// Bytes of a model transform.
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
