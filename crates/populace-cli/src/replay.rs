//! Draws the people of a trajectory file: `populace render bottleneck.sqlite`.

mod agents;
mod metered;
mod overlays;
mod people;
mod place;

use std::path::{Path, PathBuf};
use std::time::Instant;

use populace::character::Image;
use populace::{Crowd, MemberId};
use populace_locomotion::GaitSpace;
use populace_render::{Camera, Ground, Scene};
use populace_scene::{Motions, Replay};
use populace_trajectory::Recording;
use serde_json::{Value, json};

use crate::built_in;
use crate::built_in::Clothes;
use crate::camera::{Cameras, Subject, View};
use crate::cli::{FrameRange, ImageKind, OverlayArgs, PictureArgs, build};
use crate::crowd_renderer::{CrowdRenderer, devices_and_shares};
use crate::failure::Failure;
use crate::film_length;
#[cfg(feature = "viewer")]
use crate::filming::{self, build_crowd};
use crate::filming::{Filming, check_hidden};
use crate::frame_loop::{Action, in_foot_steps};
use crate::frames::{Frames, Shutter, single};
use crate::levels::Levels;
use crate::report::{self, message};
use crate::roles::{self, ClipChoice, LoadedRoles};
use crate::trajectory::{self, ReadArgs};
use agents::Agents;
use metered::Metered;
use overlays::Overlays;
use people::CastSettings;
use place::{Place, SLAB_M};

/// Clips that a member plays at the same time: idle, walk and run.
const SLOTS: usize = 4;
/// Most pictures of a film in which people are looked for under the legend.
const LEGEND_PICTURES: f64 = 100.0;

/// A job of drawing the people of a trajectory file.
pub(crate) struct ReplayJob<'a> {
    pub(crate) file: &'a Path,
    /// Characters to cast; the built-in people if empty.
    pub(crate) cast: &'a [PathBuf],
    pub(crate) out: Option<&'a Path>,
    pub(crate) read: &'a ReadArgs,
    pub(crate) overlay: &'a OverlayArgs,
    pub(crate) picture: &'a PictureArgs,
}

/// Says so if nobody is there in any of the pictures. Returns whether somebody is.
fn warn_of_absence(recording: &Recording, motions: &Motions, frames: Frames) -> bool {
    let secs = [frames.first, frames.last].map(|frame| frames.rate.secs(frame) + frames.late_secs);
    let warning = people::absence(motions, recording.secs()[0], secs);
    if let Some(warning) = &warning {
        message!("warning: {warning}");
    }
    warning.is_none()
}

impl ReplayJob<'_> {
    /// Runs the job. Checks all arguments and inputs before it evaluates and draws.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let args = self.picture;
        let recording = self.read.load(self.file)?;
        describe(&recording);
        let motions = Motions::new(&recording);
        let frames = self.frames(&recording, &motions)?;
        let is_somebody = warn_of_absence(&recording, &motions, frames);
        let Some(out) = self.out else {
            let capacity = capacity(&motions);
            let mut crowd = build(args.device.crowd_to_read().capacity(capacity))?;
            let (mut action, _) = self.people(&mut crowd, recording, motions, false)?;
            return self.evaluate(&mut crowd, &mut action, frames);
        };
        let filming = Filming::new(args, out, (frames, self.is_film()), &self.given())?;
        let sink = filming.sink()?;
        let renderer = filming.renderer();
        // One more for the place.
        let mut crowd = filming.crowd(&renderer, [capacity(&motions) + 1, SLOTS])?;
        let (mut action, loaded) = self.people(&mut crowd, recording, motions, true)?;
        filming.check(&loaded.files)?;
        let roles = loaded.roles;
        let [width, height] = args.size();
        action.set_aspect(width as f32 / height as f32)?;
        action.place_legend([width, height], (!self.is_film()).then_some(frames))?;
        if is_somebody {
            action.warn_of_moved(frames, [width, height])?;
        }
        let renderer = renderer
            .map_err(Failure::from)
            .and_then(|renderer| CrowdRenderer::new(renderer, &mut crowd, &roles, &args.hide));
        let mut scene = filming.scene();
        self.build_place(&mut crowd, &mut action, &mut scene)?;
        let played = (&mut action as &mut dyn Action, &scene);
        let filmed = filming.shoot(&mut crowd, played, renderer, sink)?;
        let mut more = action.measures();
        if args.film.images.contains(&ImageKind::Id) {
            more = report::with_fields(more, json!({"ids": action.ids()}));
        }
        filmed.report((&crowd, &action), args.json, more)
    }

    /// Brings people and place into a crowd for a window, with room for `slots` clips each.
    #[cfg(feature = "viewer")]
    pub(crate) fn stage(
        &self,
        builder: populace::CrowdBuilder,
        slots: usize,
    ) -> Result<crate::watched::Staged, Failure> {
        let recording = self.read.load(self.file)?;
        describe(&recording);
        let motions = Motions::new(&recording);
        let [from, until] = recording.secs();
        // One more for the place.
        let builder = builder.capacity(capacity(&motions) + 1).slots_per_member(slots);
        let mut crowd = build_crowd(builder)?;
        let (mut action, loaded) = self.people(&mut crowd, recording, motions, true)?;
        let mut scene = filming::scene(self.picture);
        self.build_place(&mut crowd, &mut action, &mut scene)?;
        let rate = film_length::film_rate(self.picture.film.fps)?;
        let (action, roles, floor_m) = (Box::new(action), loaded.roles, scene.floor_m);
        Ok(crate::watched::Staged {
            crowd,
            action,
            roles,
            scene,
            floor_m,
            rate,
            length_secs: Some(until - from),
        })
    }

    /// Brings the place into the crowd, with its floor where people are lowest, and the ground
    /// around it.
    fn build_place(
        &self,
        crowd: &mut Crowd,
        action: &mut ReplayAction,
        scene: &mut Scene,
    ) -> Result<(), Failure> {
        action.place = Place::new(crowd, &action.recording, self.overlay)?;
        scene.floor_m = place::floor_m(&action.recording);
        if scene.floor_m != 0.0 {
            message!("the ground is at {:.2} m, the least elevation", scene.floor_m);
        }
        let slab_m = if action.place.is_known() { SLAB_M } else { 0.0 };
        let height_m = scene.floor_m - slab_m;
        scene.ground = scene.ground.map(|ground| Ground { height_m, ..ground });
        Ok(())
    }

    /// Returns the files that are read, as far as they are known from the command line.
    fn given(&self) -> Vec<&Path> {
        let files = self.cast.iter().chain(&self.picture.clips).chain(&self.read.geometry);
        let files = files.map(PathBuf::as_path).chain([self.file]);
        files.filter(|file| built_in::name_of(file).is_none()).collect()
    }

    /// Brings the people into the crowd, with levels of detail if they are drawn.
    fn people(
        &self,
        crowd: &mut Crowd,
        recording: Recording,
        motions: Motions,
        are_drawn: bool,
    ) -> Result<(ReplayAction, LoadedRoles), Failure> {
        let args = self.picture;
        let everybody = [PathBuf::from("@people")];
        let loaded = roles::load(
            crowd,
            &args.input,
            if self.cast.is_empty() { &everybody } else { self.cast },
            &args.clips,
            ClipChoice::default(),
            args.height,
            if are_drawn { Levels::wanted(args) } else { Levels::None },
            Clothes { options: !args.plain, ..Clothes::default() },
        )?;
        let roles = &loaded.roles;
        if are_drawn {
            check_hidden(roles, &args.hide)?;
        }
        let gaits = crate::people::gaits(crowd, roles, "--clips FILE")?
            .into_iter()
            .collect::<Result<_, _>>();
        let gaits: Vec<GaitSpace> = gaits.map_err(Failure::Input)?;
        let settings = CastSettings { seed: args.seed, plain: args.plain, height_m: args.height };
        let people = people::cast(&recording, roles, &settings);
        let metered = Metered::new(capacity(&motions));
        let heights = people::body_heights(&people, roles);
        let walls_m = self.overlay.walls_m();
        let subject = Agents::new(&recording, motions.clone(), heights.clone(), walls_m);
        let from_secs = recording.secs()[0];
        let replay = Replay::new(&recording, motions, &people, gaits, from_secs)?;
        let floor = populace::Ground::plane(replay.floor_m(), [0.0; 2]);
        crowd.set_ground(&floor.map_err(populace::Error::from)?)?;
        let bodies = (people, heights);
        let overlays = Overlays::new(self.overlay, &recording, replay.motions(), roles, bodies)?;
        message!(
            "{} on {}, {}",
            trajectory::people(&recording),
            devices_and_shares(crowd),
            crowd.device_info().schedule
        );
        let action = ReplayAction {
            recording,
            #[cfg(feature = "viewer")]
            first: replay.clone(),
            replay,
            subject,
            view: args.camera.clone(),
            cameras: None,
            metered,
            overlays,
            place: Place::default(),
            behave_ms: 0.0,
        };
        Ok((action, loaded))
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
        let document = json!({"schema": 1, "frames": frames.count()});
        report::json(&report::with_fields(document, action.measures()))
    }

    /// Returns the frames that are drawn: those asked for, else the whole recording for a film, and
    /// the moment when most people are there for a picture.
    fn frames(&self, recording: &Recording, motions: &Motions) -> Result<Frames, Failure> {
        let film = &self.picture.film;
        let rate = film_length::film_rate(film.fps)?;
        let shutter = Shutter::degrees(film.shutter);
        Ok(match &film.frames {
            Some(FrameRange(range)) => Frames::film(range, rate, shutter),
            None if self.is_film() => {
                let last = film_length::frame_count(recording, rate) - 1;
                Frames::film(&(0..=last), rate, shutter)
            }
            None => {
                let since_start = |secs: f64| secs - recording.secs()[0];
                let busiest = || people::busiest(motions).map_or(0.0, since_start);
                let secs = film.at.unwrap_or_else(busiest);
                Frames { shutter, ..Frames::still(secs, rate) }
            }
        })
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
    motions.peak().max(1)
}

/// People who follow trajectories.
struct ReplayAction {
    recording: Recording,
    replay: Replay,
    /// The replay before frame 0.
    #[cfg(feature = "viewer")]
    first: Replay,
    subject: Agents,
    view: View,
    /// `None` if nothing is drawn.
    cameras: Option<Cameras>,
    metered: Metered,
    overlays: Overlays,
    place: Place,
    behave_ms: f64,
}

impl ReplayAction {
    fn step(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        let start = Instant::now();
        self.replay.advance(crowd, secs)?;
        self.place.change(crowd, self.replay.secs())?;
        self.overlays.dress(crowd, &self.recording, &self.replay)?;
        self.behave_ms += start.elapsed().as_secs_f64() * 1e3;
        self.metered.find(crowd, &self.replay)
    }

    /// Puts the legend where it covers the fewest people in pictures of a size: in a still, or in a
    /// film of the whole recording, so that it is in one place in all parts of a film.
    fn place_legend(&mut self, size: [u32; 2], still: Option<Frames>) -> Result<(), Failure> {
        let [from, until] = self.recording.secs();
        let views = match still {
            Some(frames) => vec![frames.rate.secs(frames.last) + frames.late_secs],
            None => {
                let step_secs = ((until - from) / LEGEND_PICTURES).max(1.0);
                let times = (0_u32..).map(|nth| f64::from(nth) * step_secs);
                times.take_while(|secs| *secs <= until - from).collect()
            }
        };
        let views = views.into_iter().map(|secs| Ok((from + secs, self.camera(secs)?)));
        let views = views.collect::<Result<Vec<_>, Failure>>()?;
        self.overlays.place_legend(size, views, self.replay.motions());
        Ok(())
    }

    /// Says so if a camera with a position of its own sees nobody in any frame, and positions of
    /// the file were moved: the camera's may be one of the file.
    fn warn_of_moved(&self, frames: Frames, size: [u32; 2]) -> Result<(), Failure> {
        let is_placed = matches!(self.view, View::At { .. } | View::Keys(_));
        if !is_placed || self.recording.origin_m == [0.0; 2] {
            return Ok(());
        }
        for frame in frames.first..=frames.last {
            let secs = frames.rate.secs(frame) + frames.late_secs;
            if self.subject.are_seen(&self.camera(secs)?, secs, size) {
                return Ok(());
            }
        }
        let [x, y] = self.recording.origin_m.map(|v| 0.0 - v);
        message!(
            "warning: the camera sees nobody in any frame; positions were moved by {x:.0}, {y:.0} \
             m, and cameras are in moved coordinates: those of the file need {x:+.0} m in X and \
             {:+.0} m in Z",
            0.0 - y
        );
        Ok(())
    }

    /// Returns the ids of the file by the values that stand for them in `.id.png`.
    fn ids(&self) -> Value {
        let agents = self.recording.agents.iter();
        let ids = (1_u64..).zip(agents).map(|(value, agent)| (value.to_string(), json!(agent.id)));
        Value::Object(ids.collect())
    }

    /// Returns foot skate and the error of positions as JSON, by their names.
    fn measures(&self) -> Value {
        let error = self.replay.position_error();
        let skate = self.metered.skate();
        let skate = skate
            .map(|skate| json!({"mean_m_s": skate.mean_m_per_sec, "p95_m_s": skate.p95_m_per_sec}));
        let error = json!({"max_m": error.max_m, "max_raw_m": error.max_raw_m});
        json!({"foot_skate": skate, "position_error": error})
    }
}

impl Action for ReplayAction {
    fn take_behave_ms(&mut self) -> f64 {
        std::mem::take(&mut self.behave_ms)
    }

    fn behave(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f32, Failure> {
        in_foot_steps(self, crowd, secs, Self::step)
    }

    fn evaluate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        crowd.update(secs)?;
        self.metered.sample(crowd, secs)
    }

    fn set_aspect(&mut self, aspect: f32) -> Result<(), Failure> {
        self.cameras = Some(Cameras::new(&self.view, &self.subject, aspect)?);
        Ok(())
    }

    fn needs_depths(&self) -> bool {
        self.overlays.needs_depths()
    }

    fn overlay(
        &self,
        picture: &mut Image,
        camera: &Camera,
        depths_m: &[f32],
    ) -> Result<(), Failure> {
        self.overlays.draw(picture, (camera, depths_m), &self.recording, &self.replay)
    }

    fn person(&self, member: MemberId) -> Option<u64> {
        self.replay.agent_of(member).map(|agent| agent as u64)
    }

    fn cameras(&self) -> Option<&Cameras> {
        self.cameras.as_ref()
    }

    fn camera(&self, secs: f64) -> Result<Camera, Failure> {
        let poses = |id, secs| self.subject.pose(id, secs);
        let cameras = self.cameras.as_ref();
        Ok(cameras.map_or_else(Camera::default, |cameras| cameras.at(&poses, secs)))
    }
}

#[cfg(feature = "viewer")]
impl crate::watched::Watched for ReplayAction {
    fn rewind(&mut self) {
        self.replay = self.first.clone();
        self.place.forget();
        self.metered.rewind();
    }

    fn leads_members(&self) -> bool {
        true
    }

    fn has_overlay(&self) -> bool {
        self.overlays.draw_something()
    }
}

/// Says what was read and what was assumed.
fn describe(recording: &Recording) {
    message!("{}", trajectory::headline(recording));
    if trajectory::vehicles(recording) > 0 {
        message!("vehicles are not drawn");
    }
    for warning in &recording.warnings {
        message!("warning: {warning}");
    }
}
