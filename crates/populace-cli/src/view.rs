//! Shows of `populace view`: the crowds of `populace render`, for the window to play.

use std::path::{Path, PathBuf};

use populace::character::Image;
use populace::{Crowd, CrowdBuilder, MemberId};
use populace_film::FrameRate;
use populace_render::{Camera, Renderer, Scene};
use populace_viewer::{Opened, Opener, Show, ShowError, Wish};

use crate::cli::ViewArgs;
use crate::crowd_renderer::{connect, devices_and_shares};
use crate::draw::CrowdPlan;
use crate::failure::Failure;
use crate::filming::{self, build_crowd};
use crate::given::{Given, check_for_street};
use crate::output;
use crate::replay::ReplayJob;
use crate::report::{counted, message};
use crate::scene::{self, SceneSource};
use crate::trajectory;
use crate::watched::{Staged, Watched};

/// Members of a crowd unless set.
const MEMBERS: u32 = 200;
/// The input that names the street.
const STREET: &str = "@street";
/// People who count as one empty street. Software rendering draws more of them in that time.
const PEOPLE_PER_STREET: f64 = 100.0;
/// The longest pleasant frame in milliseconds.
const PLEASANT_MS: f64 = 50.0;
/// Frames per second of a crowd unless set.
const FPS: u32 = 30;
/// Width of pictures in heights, before the window is there.
const ASPECT: f32 = 16.0 / 9.0;
/// Clips that a member can play at the same time.
const SLOTS: usize = 6;

/// Opens what the command line names, and files that are dropped on the window.
pub(crate) struct CommandLine<'a> {
    args: &'a ViewArgs,
    /// The number of people that this machine draws well, once it has been measured.
    pleasant: u32,
}

impl<'a> CommandLine<'a> {
    pub(crate) fn new(args: &'a ViewArgs) -> Self {
        Self { args, pleasant: 0 }
    }

    /// Measures the number of people in the street that this machine draws well: at 20 frames a
    /// second. Frames of the street without people say how long one with people takes, since nobody
    /// has to be dressed for them.
    fn measure(&mut self, renderer: &mut Renderer) -> Result<(), Failure> {
        let is_street = |input: &PathBuf| input.as_os_str() == STREET;
        let is_asked = self.args.members.is_none() && self.args.inputs.iter().any(is_street);
        if !is_asked || self.pleasant > 0 {
            return Ok(());
        }
        let mut plan = scene::street(0, self.args.picture.seed);
        plan.casts.clear();
        plan.crowds.clear();
        let source = SceneSource { plan, file: None, cast: &[], picture: &self.args.picture };
        let staged = source.stage(self.builder(&Wish::default(), renderer))?;
        let Staged { mut crowd, mut action, roles, scene, .. } = staged;
        connect(renderer, &mut crowd, &roles, &self.args.picture.hide)?;
        action.set_aspect(ASPECT)?;
        let camera = action.camera(0.0)?;
        let mut least_ms = f64::INFINITY;
        for _ in 0..3 {
            action.advance(&mut crowd, 1.0 / 30.0)?;
            let start = std::time::Instant::now();
            renderer.draw(&mut crowd, &camera, &scene)?;
            renderer.read_image()?;
            least_ms = least_ms.min(start.elapsed().as_secs_f64() * 1e3);
        }
        let share = (PLEASANT_MS / least_ms - 1.0) * PEOPLE_PER_STREET;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "40 to 2000")]
        let pleasant = share.clamp(40.0, 2000.0) as u32;
        self.pleasant = pleasant;
        message!("the empty street takes {least_ms:.0} ms a frame here: {pleasant} people");
        Ok(())
    }

    fn builder(&self, wish: &Wish, renderer: &Renderer) -> CrowdBuilder {
        let args = &self.args.picture.device;
        let devices = wish.devices.clone().or_else(|| args.device.clone());
        let builder = Crowd::builder()
            .split(args.split.clone())
            .schedule(wish.schedule.unwrap_or(args.schedule))
            .for_gl(renderer.gl_context());
        devices.into_iter().fold(builder, CrowdBuilder::devices)
    }

    fn stage(&self, wish: &Wish, renderer: &Renderer) -> Result<(Staged, String), Failure> {
        let args = self.args;
        let people = || vec![PathBuf::from("@people")];
        let mut inputs = match &wish.dropped {
            Some(file) => vec![file.clone()],
            None => args.inputs.clone(),
        };
        let given = Given {
            inputs: &inputs.clone(),
            cast: &args.cast,
            members: args.members.filter(|_| wish.dropped.is_none()),
            trajectory: &args.trajectory,
            picture: &args.picture,
        };
        let builder = self.builder(wish, renderer);
        let is_dropped = wish.dropped.is_some();
        if inputs.iter().any(|input| input.as_os_str() == STREET) {
            given.check_without_recording()?;
            check_for_street(&args.picture)?;
            let members = wish.members.or(args.members).unwrap_or(self.pleasant);
            let (plan, cast) = (scene::street(members, args.picture.seed), args.cast.as_slice());
            let source = SceneSource { plan, file: None, cast, picture: &args.picture };
            return Ok((source.stage(builder)?, "street".into()));
        }
        if let Some(file) = inputs.iter().find(|input| scene::is_scene(input)) {
            if !is_dropped {
                given.check_for_scene(file)?;
            }
            let plan = scene::read(file)?;
            let source = SceneSource { plan, file: Some(file), cast: &[], picture: &args.picture };
            return Ok((source.stage(builder)?, name_of(file)));
        }
        if let Some(file) = inputs.iter().find(|input| trajectory::is_trajectory(input)) {
            let cast = if is_dropped { Vec::new() } else { given.cast_for_recording(file)? };
            return Ok((self.replay(file, cast, builder)?, name_of(file)));
        }
        if !is_dropped {
            given.check_without_recording()?;
            inputs.extend(args.cast.iter().cloned());
        }
        let inputs = if inputs.is_empty() { people() } else { inputs };
        let title = inputs.iter().map(|input| name_of(input)).collect::<Vec<_>>().join(", ");
        let members = wish.members.or(args.members).unwrap_or(MEMBERS);
        Ok((self.crowd(&inputs, members, builder)?, title))
    }

    fn replay(
        &self,
        file: &PathBuf,
        mut cast: Vec<PathBuf>,
        builder: CrowdBuilder,
    ) -> Result<Staged, Failure> {
        let args = self.args;
        cast.extend(args.cast.iter().cloned());
        let job = ReplayJob {
            file,
            cast: &cast,
            out: None,
            read: &args.trajectory.read,
            overlay: &args.trajectory.overlay,
            picture: &args.picture,
        };
        job.stage(builder, SLOTS)
    }

    fn crowd(
        &self,
        inputs: &[PathBuf],
        members: u32,
        builder: CrowdBuilder,
    ) -> Result<Staged, Failure> {
        let args = &self.args.picture;
        let mut crowd = build_crowd(builder.capacity(members as usize).slots_per_member(SLOTS))?;
        let plan = CrowdPlan { inputs, members, args };
        let (loaded, action) = plan.stage(&mut crowd, true)?;
        let devices = devices_and_shares(&crowd);
        let schedule = crowd.device_info().schedule;
        message!("{} on {devices}, {schedule}", counted(crowd.member_count(), "member"));
        let rate = args.film.fps.map_or_else(|| FrameRate::new(FPS, 1), Ok)?;
        Ok(Staged {
            crowd,
            action: Box::new(action),
            roles: loaded.roles,
            scene: filming::scene(args),
            floor_m: 0.0,
            rate,
            length_secs: None,
        })
    }
}

impl Opener for CommandLine<'_> {
    fn open(&mut self, wish: &Wish, renderer: &mut Renderer) -> Result<Opened, ShowError> {
        self.measure(renderer)?;
        let (staged, title) = self.stage(wish, renderer)?;
        let Staged { mut crowd, mut action, roles, scene, floor_m, rate, length_secs } = staged;
        action.set_aspect(ASPECT)?;
        let times = (0_u32..).map(|frame| rate.secs(frame));
        let times = times.take_while(|secs| length_secs.is_none_or(|end_secs| *secs <= end_secs));
        filming::warn_of_sunken_camera(&*action, &scene, times);
        let hide = &self.args.picture.hide;
        connect(renderer, &mut crowd, &roles, hide)?;
        let detail_px = self.args.picture.detail_px();
        let show = ActionShow { action, title, scene, floor_m, rate, length_secs, detail_px };
        Ok(Opened { crowd, show: Box::new(show) })
    }

    fn write(&mut self, path: &Path, bytes: &[u8]) -> Result<(), ShowError> {
        Ok(output::write(path, bytes)?)
    }
}

/// Returns the name of an input without its folder.
fn name_of(input: &Path) -> String {
    input.file_name().unwrap_or(input.as_os_str()).to_string_lossy().into_owned()
}

/// An action as the window plays it.
struct ActionShow {
    action: Box<dyn Watched>,
    title: String,
    scene: Scene,
    floor_m: f32,
    rate: FrameRate,
    length_secs: Option<f64>,
    detail_px: Option<f32>,
}

impl Show for ActionShow {
    fn title(&self) -> String {
        self.title.clone()
    }

    fn rate(&self) -> FrameRate {
        self.rate
    }

    fn length_secs(&self) -> Option<f64> {
        self.length_secs
    }

    fn scene(&self) -> Scene {
        filming::in_clear_air(self.scene, &*self.action)
    }

    fn floor_m(&self) -> f32 {
        self.floor_m
    }

    fn detail_px(&self) -> Option<f32> {
        self.detail_px
    }

    fn set_aspect(&mut self, aspect: f32) -> Result<(), ShowError> {
        Ok(self.action.set_aspect(aspect)?)
    }

    fn camera(&self, secs: f64) -> Result<Camera, ShowError> {
        Ok(self.action.camera(secs)?)
    }

    fn behave(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f32, ShowError> {
        Ok(self.action.behave(crowd, secs)?)
    }

    fn evaluate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), ShowError> {
        Ok(self.action.evaluate(crowd, secs)?)
    }

    fn rewind(&mut self) {
        self.action.rewind();
    }

    fn has_overlay(&self) -> bool {
        self.action.has_overlay()
    }

    fn overlay(&self, picture: &mut Image, camera: &Camera) -> Result<(), ShowError> {
        Ok(self.action.overlay(picture, camera, &[])?)
    }

    fn person(&self, member: MemberId) -> Option<u64> {
        self.action.person(member)
    }

    fn leads_members(&self) -> bool {
        self.action.leads_members()
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args, FromArgMatches};
    use populace::Device;
    use populace_scene::plan::ScenePlan;

    use super::*;

    #[test]
    fn people_of_scenes_stand_above_the_ground_that_is_drawn() {
        let matches = ViewArgs::augment_args(clap::Command::new("view"))
            .try_get_matches_from(["view"])
            .expect("arguments");
        let args = ViewArgs::from_arg_matches(&matches).expect("arguments");
        let text = "schema = 1\n[ground]\nheight_m = -3.0\n\
                    [[prop]]\nkind = \"road\"\nat = [0.0, -3.0, 0.0]\n";
        let plan = ScenePlan::parse(text).expect("a scene");
        let source = SceneSource { plan, file: None, cast: &[], picture: &args.picture };
        let staged = source.stage(Crowd::builder().device(Device::native())).expect("a crowd");
        assert_eq!(staged.floor_m, -3.0);
        assert_eq!(staged.scene.ground.map(|ground| ground.height_m), Some(-3.4));
    }
}
