//! Frames, timed on all devices in turn.

use std::time::Instant;

use populace::core::{Stage, TICKS_PER_SEC};
use populace::{Devices, Error, Schedule, Split};

use super::check::worst_error_m;
use super::scene::{Scene, Staging};
use crate::studio::devices_and_shares;

/// Frames before anything is measured.
const WARM_UP: u32 = 3;
/// Frames of no time before those, in which several devices find out how to share the members.
const FIRST_SHARING: u32 = 30;
const FRAME_SECS: f32 = 1.0 / 60.0;
/// The crowd's ticks of one such frame.
const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;
/// A palette entry: one 3x4 float matrix.
const ENTRY_BYTES: f64 = 48.0;

/// One line of the table.
pub(crate) struct Run {
    pub(crate) device: Devices,
    pub(crate) schedule: &'static str,
    pub(crate) stage: &'static str,
    pub(crate) ms_median: f64,
    pub(crate) ms_min: f64,
    /// Bytes of device memory that a joint's share of the stage reads and writes, counted, not measured.
    pub(crate) bytes_per_joint: f64,
    pub(crate) memory_bytes: usize,
    /// In metres, and what is allowed; `None` for the floor and for single stages.
    pub(crate) error_m: Option<(f64, f64)>,
}

struct Track {
    device: Devices,
    staging: Staging,
    schedule: &'static str,
    all_ms: Vec<f64>,
    floor_ms: Vec<f64>,
    stage_ms: Vec<(Stage, Vec<f64>)>,
}

/// Measures `frames` frames on each device, the devices taking turns so that a noisy machine is noisy to all, and
/// checks the last frame against the oracle.
pub(crate) fn measure(
    scene: &Scene,
    devices: &[Devices],
    split: &Split,
    schedules: &[Schedule],
    frames: u32,
) -> Result<Vec<Run>, Error> {
    let mut tracks = Vec::new();
    for (device, &schedule) in devices.iter().flat_map(|d| schedules.iter().map(move |s| (d, s))) {
        let is_shared = device.as_slice().len() > 1;
        let mut staging = scene.stage(device, if is_shared { split } else { &Split::Measured }, schedule)?;
        for _ in 0..if is_shared { FIRST_SHARING } else { 0 } {
            staging.crowd.update(0.0)?;
            staging.crowd.finish()?;
        }
        let schedule = schedule.name();
        tracks.push(Track {
            device: device.clone(),
            staging,
            schedule,
            all_ms: Vec::new(),
            floor_ms: Vec::new(),
            stage_ms: Stage::ALL.map(|stage| (stage, Vec::new())).to_vec(),
        });
    }
    for frame in 0..WARM_UP + frames {
        for track in &mut tracks {
            track.frame(frame >= WARM_UP)?;
        }
    }
    let mut runs = Vec::new();
    for track in &mut tracks {
        let tick = u64::from(WARM_UP + frames) * FRAME_TICKS;
        let error_m = worst_error_m(scene, &mut track.staging, tick)?;
        track.report(scene, error_m, &mut runs);
        if track.device.as_slice().len() > 1 {
            let shares = devices_and_shares(&track.staging.crowd);
            crate::report::talk!("at the end {shares} share the members ({})", track.schedule);
        }
    }
    Ok(runs)
}

impl Track {
    fn frame(&mut self, measured: bool) -> Result<(), Error> {
        let floor_ms = self.staging.crowd.write_floor()?;
        let start = Instant::now();
        self.staging.crowd.update(FRAME_SECS)?;
        self.staging.crowd.finish()?;
        let all_ms = start.elapsed().as_secs_f64() * 1e3;
        if measured {
            self.all_ms.push(all_ms);
            self.floor_ms.push(floor_ms);
            for (stage, ms) in self.staging.crowd.stage_times_ms() {
                if let Some((_, times)) = self.stage_ms.iter_mut().find(|(known, _)| *known == stage) {
                    times.push(ms);
                }
            }
        }
        Ok(())
    }

    fn report(&mut self, scene: &Scene, error_m: (f64, f64), runs: &mut Vec<Run>) {
        let (device, memory_bytes) = (&self.device, self.staging.crowd.device_memory_bytes());
        let mut add = |schedule, stage, times: &mut Vec<f64>, bytes_per_joint, error_m| {
            times.sort_by(f64::total_cmp);
            let (Some(&ms_min), Some(&ms_median)) = (times.first(), times.get(times.len() / 2)) else {
                return;
            };
            runs.push(Run {
                device: device.clone(),
                schedule,
                stage,
                ms_median,
                ms_min,
                bytes_per_joint,
                memory_bytes,
                error_m,
            });
        };
        add("floor", "all", &mut self.floor_ms, ENTRY_BYTES, None);
        let bytes: f64 = Stage::ALL.iter().map(|&stage| stage_bytes(scene, stage)).sum();
        add(self.schedule, "all", &mut self.all_ms, bytes, Some(error_m));
        for (stage, times) in &mut self.stage_ms {
            add(self.schedule, stage.name(), times, stage_bytes(scene, *stage), None);
        }
    }
}

/// Bytes that the staged schedule moves per joint: two rows of 16 bytes of rotation for each slot (translations and
/// scales move in few blocks), 40 of stored pose for each slot and once for the rest, 48 of local transforms written and
/// read again, 48 of model rows written, read by the children, and read again, 64 of palette entry, 48 of palette.
fn stage_bytes(scene: &Scene, stage: Stage) -> f64 {
    let slots = scene.slot_count() as f64;
    match stage {
        Stage::Evaluate => slots * 16.0 * scene.member_count() as f64 / scene.joint_count() as f64,
        Stage::Pose => slots * (2.0 * 16.0 + 40.0 + 4.0) + 40.0 + 48.0,
        Stage::Transform => 48.0 + 48.0 + 48.0,
        Stage::WriteBack => 48.0 + 64.0 + ENTRY_BYTES,
    }
}
