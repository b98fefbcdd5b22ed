//! Frames, timed on all devices in turn.

use std::collections::VecDeque;
use std::time::Instant;

use populace::Stage;
use populace::clip::TICKS_PER_SEC;
use populace::{BackendError, Error};

use super::baked::Baked;
use super::check::{Found, allowed_m, on_page_borders, sample};
use super::memory;
use super::runs::{Measured, Run, Samples, Way, runs};
use super::scene::{Scene, Setup, Staging};
use crate::progress::Progress;
use crate::studio::devices_and_shares;

/// Frames before anything is measured.
const WARM_UP: u32 = 3;
/// Frames of no time before those, in which several devices find out how to share the members.
const FIRST_SHARING: u32 = 30;
const FRAME_SECS: f32 = 1.0 / 60.0;
/// The crowd's ticks of one such frame.
pub(crate) const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;

/// A scene to be measured in one way.
#[derive(Clone, Copy)]
pub(crate) struct Subject<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) on: &'a Setup,
    pub(crate) way: Way,
}

/// A subject that is ready.
struct Track<'a> {
    subject: Subject<'a>,
    stand: Stand,
    samples: Samples,
}

enum Stand {
    Crowd(Box<Staging>),
    Baked(Baked),
}

/// Measures `frames` frames of each subject, as many of them as memory holds taking turns, so that
/// a noisy machine is noisy to all, and holds the last frame against the oracle. Subjects too large
/// for the memory are left out, and named.
pub(crate) fn measure(subjects: Vec<Subject>, frames: u32) -> Result<Vec<Run>, Error> {
    let mut waiting = VecDeque::from(subjects);
    let mut measured = Vec::new();
    while !waiting.is_empty() {
        measured.extend(measure_together(next_group(&mut waiting), frames)?);
    }
    Ok(runs(&measured))
}

/// The next subjects that there is memory for at once.
fn next_group<'a>(waiting: &mut VecDeque<Subject<'a>>) -> Vec<Subject<'a>> {
    let (mut group, mut free) = (Vec::new(), memory::free_bytes());
    while let Some(subject) = waiting.front() {
        let bytes = subject.bytes();
        if bytes <= free {
            free -= bytes;
            group.extend(waiting.pop_front());
        } else if group.is_empty() {
            subject.leave_out(&format!(
                "it takes about {} MiB, and {} are free",
                bytes >> 20,
                free >> 20
            ));
            waiting.pop_front();
        } else {
            break;
        }
    }
    group
}

fn measure_together<'a>(group: Vec<Subject<'a>>, frames: u32) -> Result<Vec<Measured<'a>>, Error> {
    let mut tracks = Vec::new();
    let mut progress = Progress::new("crowds", group.len());
    for subject in group {
        match subject.stage() {
            Ok(stand) => tracks.push(Track { subject, stand, samples: Samples::default() }),
            Err(Error::Backend(error @ BackendError::OutOfMemory { .. })) => {
                subject.leave_out(&error.to_string());
            }
            Err(error) => return Err(error),
        }
        progress.step();
    }
    drop(progress);
    let mut progress = Progress::new("frames", (WARM_UP + frames) as usize * tracks.len());
    for frame in 0..WARM_UP + frames {
        for track in &mut tracks {
            if frame == WARM_UP {
                track.samples = Samples::default();
            }
            track.frame(frame)?;
            progress.step();
        }
    }
    drop(progress);
    tracks.into_iter().map(|track| track.measured(WARM_UP + frames)).collect()
}

impl Subject<'_> {
    fn bytes(&self) -> usize {
        match self.way {
            Way::Crowd(schedule) => memory::crowd_bytes(self.scene, self.on, schedule),
            Way::Baked => memory::palette_bytes(self.scene),
        }
    }

    fn leave_out(&self, reason: &str) {
        crate::report::talk!(
            "left out: {} of {} members on {}: {reason}",
            self.way,
            self.scene.member_count,
            self.on.devices
        );
    }

    fn stage(&self) -> Result<Stand, Error> {
        Ok(match self.way {
            Way::Crowd(schedule) => {
                let mut staging = self.scene.stage(self.on, schedule)?;
                for _ in 0..if self.on.is_shared() { FIRST_SHARING } else { 0 } {
                    staging.crowd.update(0.0)?;
                    staging.crowd.finish()?;
                }
                Stand::Crowd(Box::new(staging))
            }
            Way::Baked => Stand::Baked(Baked::new(self.scene)?),
        })
    }
}

impl<'a> Track<'a> {
    fn frame(&mut self, frame: u32) -> Result<(), Error> {
        let samples = &mut self.samples;
        match &mut self.stand {
            Stand::Crowd(staging) => crowd_frame(staging, self.subject.scene, frame, samples)?,
            Stand::Baked(baked) => {
                let secs = f64::from(frame + 1) * FRAME_TICKS as f64 / TICKS_PER_SEC as f64;
                let start = Instant::now();
                baked.update(secs);
                let wall_ms = ms_since(start);
                samples.wall.push(wall_ms);
                samples.device.push(wall_ms);
            }
        }
        Ok(())
    }

    fn measured(self, frames: u32) -> Result<Measured<'a>, Error> {
        let Subject { scene, on, .. } = self.subject;
        let found = |members, slots| Found { scene, frames, members, slots };
        let (subject, samples) = (self.subject, self.samples);
        match self.stand {
            Stand::Crowd(mut staging) => {
                let members = [sample(scene), on_page_borders(&staging.crowd)].concat();
                let error_m = found(members, scene.slot_count)
                    .worst_error_m(|member| staging.crowd.palette(staging.members[member]))?;
                let (memory_bytes, schedule) =
                    (staging.crowd.device_memory_bytes(), staging.crowd.schedule());
                if on.is_shared() {
                    let shares = devices_and_shares(&staging.crowd);
                    crate::report::talk!("at the end {shares} share the members ({schedule})");
                }
                drop(staging);
                Ok(Measured {
                    subject,
                    samples,
                    memory_bytes,
                    tables: None,
                    bytes_per_member: memory::bytes_per_member(scene, on, schedule)?,
                    error_m,
                    allowed_m: Some(allowed_m(scene)),
                })
            }
            Stand::Baked(baked) => {
                let tables = baked.table_sizes(scene);
                Ok(Measured {
                    subject,
                    samples,
                    memory_bytes: tables.bytes + baked.member_bytes(),
                    tables: Some(tables),
                    bytes_per_member: None,
                    error_m: found(sample(scene), 1)
                        .worst_error_m(|member| Ok(baked.palette(member).to_vec()))?,
                    allowed_m: None,
                })
            }
        }
    }
}

fn crowd_frame(
    staging: &mut Staging,
    scene: &Scene,
    frame: u32,
    samples: &mut Samples,
) -> Result<(), Error> {
    samples.floor.push(staging.crowd.write_floor()?);
    let start = Instant::now();
    staging.change(scene, frame)?;
    samples.change.push(ms_since(start));
    let start = Instant::now();
    staging.crowd.update(FRAME_SECS)?;
    samples.host.push(ms_since(start));
    staging.crowd.finish()?;
    let wall_ms = ms_since(start);
    samples.wall.push(wall_ms);
    samples.device.push(staging.crowd.frame_time_ms().unwrap_or(wall_ms));
    for (stage, ms) in staging.crowd.stage_times_ms() {
        let at = Stage::ALL.iter().position(|known| *known == stage);
        at.into_iter().for_each(|at| samples.stages[at].push(ms));
    }
    Ok(())
}

/// Milliseconds from `start` until now.
pub(crate) fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
