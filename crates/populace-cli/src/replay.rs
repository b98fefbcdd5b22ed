//! Draws the people of a trajectory file: `populace render bottleneck.sqlite`.

mod agents;
mod people;

use std::path::{Path, PathBuf};
use std::time::Instant;

use populace::Crowd;
use populace_film::FilmSettings;
use populace_locomotion::SkateMeter;
use populace_render::{Camera, Renderer};
use populace_scene::{Motions, Replay};
use populace_trajectory::{Origin, Recording};
use serde_json::{Value, json};

use crate::camera::Cameras;
use crate::cli::{FrameRange, PictureArgs, TrajectoryArgs, build};
use crate::crowd_renderer::{CrowdRenderer, builder_for, devices_and_shares};
use crate::failure::Failure;
use crate::frame_loop::{Action, FrameLoop};
use crate::frames::{Frames, Shutter, single};
use crate::outcome::{Outcome, counted};
use crate::output::{Outputs, check_inputs, check_writable};
use crate::report::{self, message};
use crate::roles::{self, ClipChoice, CrowdRole};
use crate::sinks::Sink;
use crate::trajectory;
use crate::unfinished;
use agents::Agents;
use people::CastSettings;

/// People whose feet are measured when most are there.
const METERED: usize = 16;
/// Longest step in seconds. Feet need several in each contact, whatever the frame rate.
const STEP_SECS: f32 = 0.041;

/// A job of drawing the people of a trajectory file.
pub(crate) struct ReplayJob<'a> {
    pub(crate) file: &'a Path,
    /// Characters to cast; the built-in people if empty.
    pub(crate) cast: &'a [PathBuf],
    pub(crate) out: Option<&'a Path>,
    pub(crate) trajectory: &'a TrajectoryArgs,
    pub(crate) picture: &'a PictureArgs,
}

impl ReplayJob<'_> {
    /// Runs the job. Checks all arguments and inputs before it evaluates and draws.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let args = self.picture;
        let recording = trajectory::load(self.file, self.trajectory)?;
        describe(&recording);
        let motions = Motions::new(&recording);
        let frames = self.frames(&recording, &motions)?;
        let Some(out) = self.out else {
            let mut crowd = build(args.device.crowd().capacity(capacity(&motions)))?;
            let (mut action, _) = self.people(&mut crowd, &recording, motions)?;
            return self.evaluate(&mut crowd, &mut action, frames);
        };
        let film = &args.film;
        let outputs = Outputs::new(out, frames.first..=frames.last, self.is_film(), &film.images)?;
        check_inputs(outputs.paths(), &[self.file])?;
        check_writable(&outputs.first())?;
        let settings =
            FilmSettings { encoder: film.encoder, ..FilmSettings::new(args.size.0, frames.rate) };
        let mut sink = Sink::open(&outputs, &settings, film.skip_existing)?;
        let skipped = sink.skipped();
        unfinished::expect_frames(frames.count() - u32::try_from(skipped).unwrap_or_default());
        let renderer = Renderer::headless(args.size.0);
        let builder = args.device.crowd().capacity(capacity(&motions));
        let mut crowd = build(builder_for(builder, &renderer))?;
        #[cfg(unix)]
        crate::aborts::exit_on_abort();
        let (mut action, roles) = self.people(&mut crowd, &recording, motions)?;
        let [width, height] = args.size.0;
        action.cameras =
            Some(Cameras::new(&args.camera, &action.subject, width as f32 / height as f32)?);
        let renderer = renderer
            .map_err(Failure::from)
            .and_then(|renderer| CrowdRenderer::new(renderer, &mut crowd, &roles, &args.hide));
        let scene = args.sky.scene();
        let frame_loop = FrameLoop {
            frames,
            lead_in: 0,
            size: args.size.0,
            scene: &scene,
            detail: (!args.full_detail).then_some(args.detail),
        };
        let (times, drawn) = frame_loop.play(&mut crowd, &mut action, renderer, &mut sink)?;
        let out = sink.finish()?;
        let outcome = Outcome { crowd: &crowd, drawn, times: &times, frames, skipped, out: &out };
        outcome.describe();
        if args.json {
            let mut document = outcome.as_json();
            for (name, value) in action.measures() {
                document[name] = value;
            }
            return report::json(&document);
        }
        report::path(&out)
    }

    /// Brings the people into the crowd.
    fn people(
        &self,
        crowd: &mut Crowd,
        recording: &Recording,
        motions: Motions,
    ) -> Result<(ReplayAction, Vec<CrowdRole>), Failure> {
        let args = self.picture;
        let everybody = [PathBuf::from("@people")];
        let roles = roles::load(
            crowd,
            &args.input,
            if self.cast.is_empty() { &everybody } else { self.cast },
            &args.clips,
            ClipChoice::default(),
            args.height,
            !args.full_detail,
            !args.plain,
        )?
        .roles;
        let gaits = people::gaits(crowd, &roles)?;
        let settings = CastSettings { seed: args.seed, plain: args.plain, height_m: args.height };
        let people = people::cast(recording, &roles, &settings);
        let every = capacity(&motions).div_ceil(METERED);
        let subject = Agents::new(recording, motions.clone());
        let replay = Replay::new(recording, motions, &people, gaits, recording.secs()[0])?;
        message!(
            "{} on {}, {}",
            counted(recording.agents.len(), "agent"),
            devices_and_shares(crowd),
            crowd.device_info().schedule
        );
        let action =
            ReplayAction { replay, subject, cameras: None, meter: SkateMeter::new(), every };
        Ok((action, roles))
    }

    /// Evaluates all frames without drawing them.
    fn evaluate(
        &self,
        crowd: &mut Crowd,
        action: &mut ReplayAction,
        frames: Frames,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let mut last_secs = 0.0;
        for moment in frames.moments(frames.last) {
            action.advance(crowd, single(moment.secs - last_secs))?;
            last_secs = moment.secs;
        }
        crowd.finish()?;
        let took_secs = start.elapsed().as_secs_f64();
        let film_secs = frames.rate.secs(frames.last);
        message!(
            "{film_secs:.1} s in {took_secs:.1} s, {:.1} times real time",
            film_secs / took_secs
        );
        report::json(&Value::from_iter(action.measures()))
    }

    /// Returns the frames that are drawn: those asked for, else the whole recording for a film, and
    /// the moment when most people are there for a picture.
    fn frames(&self, recording: &Recording, motions: &Motions) -> Result<Frames, Failure> {
        let film = &self.picture.film;
        let rate = trajectory::film_rate(film.fps)?;
        let shutter = Shutter::degrees(film.shutter);
        let range = match &film.frames {
            Some(FrameRange(range)) => range.clone(),
            None if self.is_film() => 0..=trajectory::frame_count(recording, rate) - 1,
            None => {
                let secs =
                    film.at.unwrap_or_else(|| people::busiest(motions) - recording.secs()[0]);
                return Ok(Frames { shutter, ..Frames::still(secs, rate) });
            }
        };
        Ok(Frames { first: *range.start(), last: *range.end(), rate, shutter, late_secs: 0.0 })
    }

    /// Returns true unless one picture is drawn.
    fn is_film(&self) -> bool {
        let film = &self.picture.film;
        let is_film = |out: &Path| populace_film::Format::of(out).is_some();
        film.frames.is_some() || film.at.is_none() && self.out.is_none_or(is_film)
    }
}

/// Returns the number of people who are there at the same time.
fn capacity(motions: &Motions) -> usize {
    people::peak(motions).max(1)
}

/// People who follow trajectories.
struct ReplayAction {
    replay: Replay,
    subject: Agents,
    /// `None` if nothing is drawn.
    cameras: Option<Cameras>,
    meter: SkateMeter,
    /// The feet of every so many agents are measured.
    every: usize,
}

impl ReplayAction {
    fn step(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        self.replay.advance(crowd, secs)?;
        crowd.update(secs)?;
        let metered = self.replay.present().filter(|(agent, _)| agent % self.every == 0);
        for (_, member) in metered {
            self.meter.sample(crowd, member, secs)?;
        }
        Ok(())
    }

    /// Returns foot skate and the error of positions as JSON, by their names.
    fn measures(&self) -> [(&'static str, Value); 2] {
        let error = self.replay.position_error();
        let skate = self.meter.skate();
        let skate = skate
            .map(|skate| json!({"mean_m_s": skate.mean_m_per_sec, "p95_m_s": skate.p95_m_per_sec}));
        let error = json!({"max_m": error.max_m, "max_raw_m": error.max_raw_m});
        [("foot_skate", skate.into()), ("position_error", error)]
    }
}

impl Action for ReplayAction {
    fn advance(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        let steps = (secs / STEP_SECS).ceil().max(1.0);
        let mut done = 0.0;
        while done < steps {
            self.step(crowd, secs / steps)?;
            done += 1.0;
        }
        Ok(())
    }

    fn camera(&self, secs: f64) -> Result<Camera, Failure> {
        let cameras = self.cameras.as_ref();
        Ok(cameras.map_or_else(Camera::default, |cameras| cameras.at(&self.subject, secs)))
    }
}

/// Says what was read and what was assumed.
fn describe(recording: &Recording) {
    let source = &recording.source;
    let origin = |origin: Origin| match origin {
        Origin::File => "",
        Origin::Settings => " (as told)",
        Origin::Assumed => " (assumed)",
    };
    let [from, until] = recording.secs();
    message!(
        "{}: {}, {:.1} s, {:.4} rows a second{}, positions in {}{}, headings from {}",
        source.format,
        counted(recording.agents.len(), "agent"),
        until - from,
        source.fps.value,
        origin(source.fps.origin),
        source.unit.value,
        origin(source.unit.origin),
        source.heading.value,
    );
    for warning in &recording.warnings {
        message!("warning: {warning}");
    }
}
