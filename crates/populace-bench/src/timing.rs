//! Times frames of all subjects in turn.

use std::collections::VecDeque;
use std::time::Instant;

use populace::Stage;
use populace::clip::TICKS_PER_SEC;
use populace::{BackendError, Error};

use crate::baked::Baked;
use crate::check::{OracleCheck, allowed_m, at_page_boundaries, sample};
use crate::measurements::{Samples, SubjectResult, measurements};
use crate::memory;
use crate::observer::Observer;
use crate::scene::{Scene, Staging};
use crate::spec::{FRAME_SECS, FRAME_TICKS, Measurement, Method, Subject};

/// Number of frames before the first measured frame.
const WARM_UP_FRAMES: u32 = 3;
/// Number of frames of zero length before those, in which several devices balance their shares.
const BALANCING_FRAMES: u32 = 30;

/// A subject that is set up.
struct Session<'a> {
    subject: Subject<'a>,
    evaluator: Evaluator,
    samples: Samples,
}

/// The source of palettes.
enum Evaluator {
    Crowd(Box<Staging>),
    Baked(Baked),
}

/// Measures `frames` frames of each subject, and compares the last frame with the oracle.
///
/// As many subjects as fit in memory take turns frame by frame, so that noise of the machine
/// affects all of them. Subjects that do not fit in memory are skipped, and `observer` hears of
/// them.
///
/// # Errors
///
/// If a crowd cannot be built or updated for another reason than memory.
pub fn measure(
    subjects: Vec<Subject>,
    frames: u32,
    observer: &mut dyn Observer,
) -> Result<Vec<Measurement>, Error> {
    let mut pending = VecDeque::from(subjects);
    let mut results = Vec::new();
    while !pending.is_empty() {
        let group = next_group(&mut pending, observer);
        results.extend(measure_group(group, frames, observer)?);
    }
    Ok(measurements(&results))
}

/// Removes and returns the next subjects that fit in memory together.
fn next_group<'a>(
    pending: &mut VecDeque<Subject<'a>>,
    observer: &mut dyn Observer,
) -> Vec<Subject<'a>> {
    let (mut group, mut free) = (Vec::new(), memory::free_bytes());
    while let Some(subject) = pending.front() {
        let bytes = subject.bytes();
        if bytes <= free {
            free -= bytes;
            group.extend(pending.pop_front());
        } else if group.is_empty() {
            let (needed, free) = (bytes >> 20, free >> 20);
            let reason = format!("it needs about {needed} MiB, {free} are free");
            observer.skipped(&subject.to_string(), &reason);
            pending.pop_front();
        } else {
            break;
        }
    }
    group
}

fn measure_group<'a>(
    group: Vec<Subject<'a>>,
    frames: u32,
    observer: &mut dyn Observer,
) -> Result<Vec<SubjectResult<'a>>, Error> {
    let mut sessions = Vec::new();
    observer.work_started("crowds", group.len());
    for subject in group {
        match subject.set_up(observer) {
            Ok(evaluator) => {
                sessions.push(Session { subject, evaluator, samples: Samples::default() });
            }
            Err(Error::Backend(error @ BackendError::OutOfMemory { .. })) => {
                observer.skipped(&subject.to_string(), &error.to_string());
            }
            Err(error) => return Err(error),
        }
        observer.step_done();
    }
    observer.work_started("frames", (WARM_UP_FRAMES + frames) as usize * sessions.len());
    for frame in 0..WARM_UP_FRAMES + frames {
        for session in &mut sessions {
            if frame == WARM_UP_FRAMES {
                session.samples = Samples::default();
            }
            session.frame(frame)?;
            observer.step_done();
        }
        observer.frame_done(frame >= WARM_UP_FRAMES);
    }
    observer.work_done();
    let results = sessions.into_iter();
    results.map(|session| session.finish(WARM_UP_FRAMES + frames, observer)).collect()
}

impl Subject<'_> {
    fn bytes(&self) -> usize {
        match self.method {
            Method::Crowd(schedule) => memory::crowd_bytes(self.scene, self.on, schedule),
            Method::Baked => memory::palette_bytes(self.scene),
        }
    }

    fn set_up(&self, observer: &mut dyn Observer) -> Result<Evaluator, Error> {
        Ok(match self.method {
            Method::Crowd(schedule) => {
                let mut staging = self.scene.set_up(self.on, schedule, observer)?;
                for _ in 0..if self.on.is_shared() { BALANCING_FRAMES } else { 0 } {
                    staging.crowd.update(0.0)?;
                    staging.crowd.finish()?;
                }
                Evaluator::Crowd(Box::new(staging))
            }
            Method::Baked => Evaluator::Baked(Baked::new(self.scene)?),
        })
    }
}

impl<'a> Session<'a> {
    fn frame(&mut self, frame: u32) -> Result<(), Error> {
        let samples = &mut self.samples;
        match &mut self.evaluator {
            Evaluator::Crowd(staging) => crowd_frame(staging, self.subject.scene, frame, samples)?,
            Evaluator::Baked(baked) => {
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

    /// Compares the last frame with the oracle and returns the result.
    fn finish(self, frames: u32, observer: &mut dyn Observer) -> Result<SubjectResult<'a>, Error> {
        let Subject { scene, on, .. } = self.subject;
        let check = |members, slots| OracleCheck { scene, frames, members, slots };
        let (subject, samples) = (self.subject, self.samples);
        match self.evaluator {
            Evaluator::Crowd(mut staging) => {
                let members = [sample(scene), at_page_boundaries(&staging.crowd)].concat();
                let error_m = check(members, scene.slot_count).worst_error_m(|member| {
                    staging.crowd.member_mut(staging.members[member]).and_then(|mut m| m.palette())
                })?;
                let info = staging.crowd.device_info();
                let (memory_bytes, schedule) = (info.memory_bytes, info.schedule);
                observer.crowd_measured(&staging.crowd);
                drop(staging);
                Ok(SubjectResult {
                    subject,
                    samples,
                    memory_bytes,
                    tables: None,
                    bytes_per_member: memory::bytes_per_member(scene, on, schedule, observer)?,
                    error_m,
                    allowed_m: Some(allowed_m(scene)),
                })
            }
            Evaluator::Baked(baked) => {
                let tables = baked.table_sizes(scene);
                Ok(SubjectResult {
                    subject,
                    samples,
                    memory_bytes: tables.bytes + baked.member_bytes(),
                    tables: Some(tables),
                    bytes_per_member: None,
                    error_m: check(sample(scene), 1)
                        .worst_error_m(|member| Ok::<_, Error>(baked.palette(member).to_vec()))?,
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
    samples.device.push(staging.crowd.frame_times().frame_ms.unwrap_or(wall_ms));
    for (stage, ms) in staging.crowd.frame_times().stages_ms {
        let at = Stage::ALL.iter().position(|known| *known == stage);
        at.into_iter().for_each(|at| samples.stages[at].push(ms));
    }
    Ok(())
}

/// Returns the milliseconds since `start`.
fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
