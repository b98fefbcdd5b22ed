//! Draws the people of a trajectory file: `populace render bottleneck.sqlite`.

mod action;
mod agents;
mod metered;
mod overlays;
mod people;
mod place;

use std::path::{Path, PathBuf};
use std::time::Instant;

use populace::Crowd;
use populace_locomotion::GaitSpace;
use populace_render::{Ground, Scene};
use populace_scene::{Motions, Replay};
use populace_trajectory::Recording;
use serde_json::json;

use crate::built_in;
use crate::built_in::Clothes;
use crate::cli::{FrameRange, ImageKind, OverlayArgs, PictureArgs, build};
use crate::crowd_renderer::{CrowdRenderer, devices_and_shares};
use crate::failure::Failure;
use crate::film_length;
#[cfg(feature = "viewer")]
use crate::filming::{self, build_crowd};
use crate::filming::{Filming, check_hidden};
use crate::frame_loop::Action;
use crate::frames::{Frames, Shutter, single};
use crate::levels::Levels;
use crate::report::{self, message};
use crate::roles::{self, ClipChoice, LoadedRoles};
use crate::trajectory::{self, ReadArgs};
use action::ReplayAction;
use agents::Agents;
use metered::Metered;
use overlays::Overlays;
use people::CastSettings;
use place::{Place, SLAB_M};

/// Clips that a member plays at the same time: idle, walk and run.
const SLOTS: usize = 4;
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
        let last = film_length::frame_count(&action.recording, rate) - 1;
        let [width, height] = self.picture.size();
        action.set_aspect(width as f32 / height as f32)?;
        action.warn_of_moved(Frames::film(&(0..=last), rate, Shutter::INSTANT), [width, height])?;
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
            Clothes {
                options: !args.plain,
                grey_accessories: self.overlay.colour_by.is_some(),
                ..Clothes::default()
            },
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
