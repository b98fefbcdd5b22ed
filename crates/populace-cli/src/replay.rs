//! Draws the people of a trajectory file: `populace render bottleneck.sqlite`.

mod people;

use std::path::{Path, PathBuf};
use std::time::Instant;

use populace::Crowd;
use populace_locomotion::SkateMeter;
use populace_render::{Camera, Renderer};
use populace_scene::{Motion, Motions, Replay};
use populace_trajectory::{Origin, ReadSettings, Recording};
use serde_json::{Value, json};

use crate::cli::{PictureArgs, TrajectoryArgs, build};
use crate::crowd_renderer::{CrowdRenderer, builder_for, devices_and_shares};
use crate::failure::Failure;
use crate::frame_loop::{Action, FrameLoop};
use crate::frames::{Frames, single};
use crate::output::Pictures;
use crate::report::{self, message};
use crate::roles::{self, ClipChoice};
use people::CastSettings;

/// People whose feet are measured when most are there.
const METERED: usize = 16;
/// Longest step in seconds. Feet need several in each contact, whatever the frame rate.
const STEP_SECS: f32 = 0.041;
/// Seconds between positions that the camera frames.
const FRAMED_SECS: f64 = 1.0;
/// Height of a body for the camera in metres.
const BODY_M: f32 = 1.8;

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
        let recording = self.recording()?;
        describe(&recording);
        let motions = Motions::new(&recording);
        let start_secs = recording.secs()[0];
        let frames = self.frames(&recording);
        let renderer = self.out.map(|_| Renderer::headless(args.size.0));
        let spans = motions.agents.iter().flat_map(Motion::secs);
        let capacity = people::peak(spans).max(1);
        let builder = args.device.crowd().capacity(capacity);
        let builder = match &renderer {
            Some(renderer) => builder_for(builder, renderer),
            None => builder,
        };
        let mut crowd = build(builder)?;
        let inputs = if self.cast.is_empty() { vec!["@people".into()] } else { self.cast.to_vec() };
        let loaded = roles::load(
            &mut crowd,
            &args.input,
            &inputs,
            &args.clips,
            ClipChoice::default(),
            args.height,
            !args.full_detail,
            !args.plain,
        )?;
        let gaits = people::gaits(&mut crowd, &loaded.roles)?;
        let settings = CastSettings { seed: args.seed, plain: args.plain, height_m: args.height };
        let people = people::cast(&recording, &loaded.roles, &settings);
        let mut action = ReplayAction {
            replay: Replay::new(&recording, motions, &people, gaits, start_secs)?,
            camera: self.camera(&recording),
            meter: SkateMeter::new(),
            every: capacity.div_ceil(METERED),
        };
        message!(
            "{} on {}, {}",
            counted(recording.agents.len(), "agent"),
            devices_and_shares(&crowd),
            crowd.device_info().schedule
        );
        let Some((out, renderer)) = self.out.zip(renderer) else {
            return self.evaluate(&mut crowd, &mut action, frames);
        };
        let pictures = Pictures::new(out, args.frames)?;
        let renderer = renderer.map_err(Failure::from).and_then(|renderer| {
            CrowdRenderer::new(renderer, &mut crowd, &loaded.roles, &args.hide)
        });
        let scene = args.sky.scene();
        let frame_loop = FrameLoop {
            frames,
            lead_in: 0,
            size: args.size.0,
            scene: &scene,
            detail: (!args.full_detail).then_some(args.detail),
        };
        let mut sink = &pictures;
        frame_loop.play(&mut crowd, &mut action, renderer, &mut sink)?;
        report::path(&pictures.path(0))
    }

    /// Evaluates all frames without drawing them.
    fn evaluate(
        &self,
        crowd: &mut Crowd,
        action: &mut ReplayAction,
        frames: Frames,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        action.advance(crowd, 0.0)?;
        for frame in 1..=frames.last {
            action.advance(crowd, single(frames.secs(frame) - frames.secs(frame - 1)))?;
        }
        crowd.finish()?;
        let took_secs = start.elapsed().as_secs_f64();
        let film_secs = frames.secs(frames.last);
        message!(
            "{film_secs:.1} s in {took_secs:.1} s, {:.1} times real time",
            film_secs / took_secs
        );
        report::json(&action.measures())
    }

    fn recording(&self) -> Result<Recording, Failure> {
        let args = self.trajectory;
        let settings = ReadSettings {
            format: args.format,
            unit: args.unit,
            fps: args.data_fps,
            heading: args.heading,
            geometry: args.geometry.clone(),
            strict: args.strict,
        };
        Ok(populace_trajectory::load(self.file, &settings)?)
    }

    fn frames(&self, recording: &Recording) -> Frames {
        let fps = f64::from(self.picture.fps);
        let [from, until] = recording.secs();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let all = ((until - from) * fps).floor() as u32;
        let last = self.picture.frames.map_or(all, |count| count - 1);
        Frames { first: 0, last, fps }
    }

    fn camera(&self, recording: &Recording) -> Camera {
        let [width, height] = self.picture.size.0;
        let points = recording.agents.iter().flat_map(|agent| {
            let track = recording.track(agent);
            let mut next = f64::MIN;
            let rows = track.times.iter().zip(track.positions).filter(move |(secs, _)| {
                let framed = **secs >= next;
                if framed {
                    next = **secs + FRAMED_SECS;
                }
                framed
            });
            rows.flat_map(|(_, [x, y])| [[*x, 0.0, -y], [*x, BODY_M, -y]]).collect::<Vec<_>>()
        });
        Camera::framing(points, width as f32 / height as f32)
    }
}

/// People who follow trajectories.
struct ReplayAction {
    replay: Replay,
    camera: Camera,
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

    /// Returns foot skate and the error of positions as JSON.
    fn measures(&self) -> Value {
        let error = self.replay.position_error();
        let skate = self.meter.skate();
        json!({
            "foot_skate": skate.map(|skate| json!({
                "mean_m_s": skate.mean_m_per_sec,
                "p95_m_s": skate.p95_m_per_sec,
            })),
            "position_error": {"max_m": error.max_m, "max_raw_m": error.max_raw_m},
        })
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

    fn camera(&self, _secs: f64) -> Result<Camera, Failure> {
        Ok(self.camera)
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

fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}
