//! Crowds of files: the common part of `render` and `view`.

use std::path::{Path, PathBuf};

use populace::{Crowd, MemberId};
use populace_film::FrameRate;
use populace_render::Camera;
use serde_json::Value;

use crate::built_in;
use crate::built_in::Clothes;
use crate::camera::{Cameras, Pose, Subject, View};
use crate::cli::{FrameRange, PictureArgs};
use crate::crowd_renderer::{CrowdRenderer, devices_and_shares};
use crate::failure::Failure;
use crate::filming::{Filming, check_hidden};
use crate::frame_loop::Action;
use crate::frames::{Frames, Shutter, single};
use crate::levels::Levels;
use crate::population::{Population, PopulationSettings};
use crate::report::{counted, message};
use crate::roles::{self, ClipChoice, LoadedRoles};

/// Frames per second, if none are given.
const DEFAULT_FPS: u32 = 30;
/// Seconds of walking that the camera of a film has in view.
const FRAMED_SECS: f32 = 3.0;

/// A crowd of characters, as the command line describes it.
pub(crate) struct CrowdPlan<'a> {
    pub(crate) inputs: &'a [PathBuf],
    pub(crate) members: u32,
    pub(crate) args: &'a PictureArgs,
}

impl CrowdPlan<'_> {
    /// Loads the characters and spawns the members. `is_film` is true if the members are seen
    /// walking on.
    pub(crate) fn stage(
        &self,
        crowd: &mut Crowd,
        is_film: bool,
    ) -> Result<(LoadedRoles, FilmedCrowd), Failure> {
        let args = self.args;
        let (name, root_motion) = (args.clip.as_deref(), args.root_motion);
        let choice = ClipChoice::Clips { name, root_motion };
        let plain = args.plain || self.members == 1;
        let loaded = roles::load(
            crowd,
            &args.input,
            self.inputs,
            &args.clips,
            choice,
            args.height,
            Levels::wanted(args),
            Clothes { options: !plain, ..Clothes::default() },
        )?;
        let settings =
            PopulationSettings { members: self.members, seed: args.seed, hide: &args.hide, plain };
        check_hidden(&loaded.roles, &args.hide)?;
        let population = Population::new(crowd, &loaded.roles, &settings)?;
        let action = CrowdAction { population, is_film };
        Ok((loaded, FilmedCrowd { action, view: args.camera.clone(), cameras: None }))
    }
}

/// A job of drawing a crowd.
pub(crate) struct DrawJob<'a> {
    pub(crate) inputs: &'a [PathBuf],
    pub(crate) members: u32,
    pub(crate) out: &'a Path,
    pub(crate) args: &'a PictureArgs,
}

impl DrawJob<'_> {
    /// Runs the job. Checks all arguments and inputs before it evaluates and draws.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let args = self.args;
        let frames = (self.frames()?, args.film.frames.is_some());
        let given = self.inputs.iter().chain(&args.clips).map(PathBuf::as_path);
        let given: Vec<_> = given.filter(|input| built_in::name_of(input).is_none()).collect();
        let filming = Filming::new(args, self.out, frames, &given)?;
        let sink = filming.sink()?;
        let renderer = filming.renderer();
        let mut crowd = filming.crowd(&renderer, [self.members as usize, 1])?;
        let plan = CrowdPlan { inputs: self.inputs, members: self.members, args };
        let (loaded, mut action) = plan.stage(&mut crowd, self.is_film())?;
        filming.check(&loaded.files)?;
        let roles = loaded.roles;
        let [width, height] = args.size();
        action.set_aspect(width as f32 / height as f32)?;
        let devices = devices_and_shares(&crowd);
        message!(
            "{} on {devices}, {}",
            counted(crowd.member_count(), "member"),
            crowd.device_info().schedule
        );
        let renderer = renderer
            .map_err(Failure::from)
            .and_then(|renderer| CrowdRenderer::new(renderer, &mut crowd, &roles, &args.hide));
        let played = (&mut action as &mut dyn Action, &filming.scene());
        let filmed = filming.shoot(&mut crowd, played, renderer, sink)?;
        filmed.report((&crowd, &action), args.json, Value::Null)
    }

    /// Returns the frames that are drawn.
    fn frames(&self) -> Result<Frames, Failure> {
        let film = &self.args.film;
        if film.fps.is_some() && !self.is_film() {
            return Err(Failure::usage("--fps needs --frames or --at: one picture has no rate"));
        }
        let rate = match film.fps {
            Some(rate) => rate,
            None => FrameRate::new(DEFAULT_FPS, 1)?,
        };
        let shutter = Shutter::degrees(film.shutter);
        Ok(match &film.frames {
            Some(FrameRange(range)) => Frames::film(range, rate, shutter),
            None => Frames { shutter, ..Frames::still(film.at.unwrap_or_default(), rate) },
        })
    }

    /// Returns true for frames of a film, true also for a single one by its time.
    fn is_film(&self) -> bool {
        self.args.film.frames.is_some() || self.args.film.at.is_some()
    }
}

/// Members that play their clips.
struct CrowdAction {
    population: Population,
    /// True if the members are seen walking on.
    is_film: bool,
}

impl Subject for CrowdAction {
    /// The members at frame 0 and, in a film, at a little later time. A much later time would frame
    /// the ground between members that have walked apart.
    fn bounds(&self) -> Vec<[f32; 3]> {
        let times = [0.0, FRAMED_SECS];
        self.population.bounding_points(if self.is_film { &times } else { &times[..1] })
    }

    fn figure_m(&self) -> [f32; 2] {
        self.population.figure_m()
    }

    fn closest(&self) -> Option<u64> {
        self.population.closest().map(|number| number as u64)
    }

    fn pose(&self, id: u64, secs: f64) -> Option<Pose> {
        let number = usize::try_from(id).ok()?;
        self.population.pose(number, single(secs))
    }

    fn describe_ids(&self) -> String {
        format!("members have the numbers from 0 to {}", self.population.len().saturating_sub(1))
    }
}

/// An action and the cameras that film it.
pub(crate) struct FilmedCrowd {
    action: CrowdAction,
    view: View,
    /// `None` before the aspect of pictures is known.
    cameras: Option<Cameras>,
}

impl Action for FilmedCrowd {
    fn set_aspect(&mut self, aspect: f32) -> Result<(), Failure> {
        self.cameras = Some(Cameras::new(&self.view, &self.action, aspect)?);
        Ok(())
    }

    fn behave(&mut self, _: &mut Crowd, secs: f32) -> Result<f32, Failure> {
        Ok(secs)
    }

    fn cameras(&self) -> Option<&Cameras> {
        self.cameras.as_ref()
    }

    fn camera(&self, secs: f64) -> Result<Camera, Failure> {
        let Some(cameras) = &self.cameras else { return Ok(Camera::default()) };
        let poses = |secs| self.action.pose(cameras.person()?, secs);
        Ok(cameras.at(&poses, secs))
    }

    fn person(&self, member: MemberId) -> Option<u64> {
        self.action.population.number(member).map(|number| number as u64)
    }
}

#[cfg(feature = "viewer")]
impl crate::watched::Watched for FilmedCrowd {
    fn rewind(&mut self) {}

    fn leads_members(&self) -> bool {
        false
    }
}
