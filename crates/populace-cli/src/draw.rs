//! Draws a crowd into picture files: the common part of `demo` and `render`.

use std::path::{Path, PathBuf};

use populace::Crowd;
use populace::character::Image;
use populace_render::{Camera, Drawn, Renderer, Scene, encode_png};
use serde_json::json;

use crate::cli::{PictureArgs, View, build};
use crate::crowd_renderer::{CrowdRenderer, builder_for, devices_and_shares};
use crate::failure::Failure;
use crate::frame_loop::{Action, FrameLoop, FrameSink, FrameTimes, LEAD_IN_SECS};
use crate::frames::{Frames, single};
use crate::names::hint;
use crate::output::{self, Pictures, check_inputs, check_writable};
use crate::population::{Population, PopulationSettings};
use crate::report::{self, message};
use crate::roles::{self, ClipChoice, CrowdRole};
use crate::unfinished;

/// A job of drawing a crowd.
pub(crate) struct DrawJob<'a> {
    pub(crate) inputs: &'a [PathBuf],
    pub(crate) members: u32,
    pub(crate) out: &'a Path,
    /// Number of frames evaluated and timed before the first picture.
    pub(crate) lead_in: u32,
    pub(crate) args: &'a PictureArgs,
}

impl DrawJob<'_> {
    /// Runs the job. Checks all arguments and inputs before it evaluates and draws.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let args = self.args;
        let pictures = Pictures::new(self.out, args.frames)?;
        let given = self.inputs.iter().chain(&args.clips);
        let given: Vec<_> = given.filter(|input| roles::built_in_name(input).is_none()).collect();
        check_inputs(pictures.paths(), &given)?;
        check_writable(&pictures.path(0))?;
        unfinished::expect_pictures(pictures.count());
        // A missing OpenGL is reported later: errors in the inputs are more useful.
        let renderer = Renderer::headless(args.size.0);
        let builder = args.device.crowd().capacity(self.members as usize).slots_per_member(1);
        let mut crowd = build(builder_for(builder, &renderer))?;
        #[cfg(unix)]
        crate::aborts::exit_on_abort();
        let choice = ClipChoice { clip: args.clip.as_deref(), root_motion: args.root_motion };
        let loaded = roles::load(
            &mut crowd,
            &args.input,
            self.inputs,
            &args.clips,
            choice,
            args.height,
            !args.full_detail,
            !(args.plain || self.members == 1),
        )?;
        check_inputs(pictures.paths(), &loaded.files)?;
        check_hidden(&loaded.roles, &args.hide)?;
        let plain = args.plain || self.members == 1;
        let settings =
            PopulationSettings { members: self.members, seed: args.seed, hide: &args.hide, plain };
        let population = Population::new(&mut crowd, &loaded.roles, &settings)?;
        let devices = devices_and_shares(&crowd);
        message!(
            "{} on {devices}, {}",
            counted(crowd.member_count(), "member"),
            crowd.device_info().schedule
        );
        let renderer = renderer.map_err(Failure::from).and_then(|renderer| {
            CrowdRenderer::new(renderer, &mut crowd, &loaded.roles, &args.hide)
        });
        let frames = self.frames();
        let frame_loop = FrameLoop {
            frames,
            lead_in: self.lead_in,
            size: args.size.0,
            scene: &self.scene(),
            detail: (!args.full_detail).then_some(args.detail),
        };
        let mut action = CrowdAction { camera: self.camera(&population, frames) };
        let mut sink = &pictures;
        let (times, drawn) = frame_loop.play(&mut crowd, &mut action, renderer, &mut sink)?;
        self.report(&crowd, drawn, &times, &pictures)
    }

    fn frames(&self) -> Frames {
        let last = self.args.frames.map_or(0, |count| count - 1);
        Frames { first: 0, last, fps: self.args.fps.into() }
    }

    fn report(
        &self,
        crowd: &Crowd,
        drawn: Drawn,
        times: &FrameTimes,
        pictures: &Pictures,
    ) -> Result<(), Failure> {
        let (out, count) = (pictures.path(0), pictures.count());
        let [total, animate, draw] = times.medians();
        message!(
            "{} drawn, {}",
            counted(drawn.instances, "member"),
            counted(drawn.triangles, "triangle")
        );
        let median = if count == 1 { "" } else { ", median" };
        let frames = counted(count as usize, "frame");
        message!("{frames}{median}: {total:.2} ms, {animate:.2} to animate, {draw:.2} to draw");
        if self.args.json {
            let view = crowd.view_statistics();
            return report::json(&json!({
                "schema": 1,
                "device": crowd.device_info().devices.to_string(),
                "schedule": crowd.device_info().schedule.name(),
                "members": crowd.member_count(),
                "frames": count,
                "ms_median": {
                    "total": total,
                    "animate": animate,
                    "draw": draw,
                    "shadow": times.pass(|pass| pass.shadow_ms),
                    "members": times.pass(|pass| pass.members_ms),
                    "surroundings": times.pass(|pass| pass.surroundings_ms),
                },
                "drawn_members": drawn.instances,
                "triangles": drawn.triangles,
                "shadow": {"members": drawn.shadow_instances, "triangles": drawn.shadow_triangles},
                "draw_calls": drawn.draw_calls,
                "levels": view.levels,
                "shadow_only": view.shadow_only,
                "hidden": view.hidden,
                "out": out.to_string_lossy(),
            }));
        }
        report::path(&out)
    }

    fn scene(&self) -> Scene {
        let mut scene = self.args.sky.scene();
        if self.args.full_detail {
            scene.sun.error_texels = 0.0;
        }
        scene
    }

    fn camera(&self, population: &Population, frames: Frames) -> Camera {
        let [width, height] = self.args.size.0;
        let aspect = width as f32 / height as f32;
        // The view must contain the members in the first and in the last frame.
        let first_secs = self.lead_in as f32 * LEAD_IN_SECS;
        let secs = [0, frames.last].map(|frame| first_secs + single(frames.secs(frame)));
        match self.args.camera {
            View::Crowd => Camera::framing(population.bounding_points(secs), aspect),
            View::Close => Camera::framing(population.closest_bounding_points(secs), aspect),
            View::At { eye, target } => {
                let framed = Camera::framing(population.bounding_points(secs), aspect);
                Camera { eye, target, near: 0.05, ..framed }
            }
        }
    }
}

/// Members that play their clips before a camera that stays.
struct CrowdAction {
    camera: Camera,
}

impl Action for CrowdAction {
    fn advance(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        Ok(crowd.update(secs)?)
    }

    fn camera(&self, _secs: f64) -> Result<Camera, Failure> {
        Ok(self.camera)
    }
}

impl FrameSink for &Pictures {
    fn take(&mut self, frame: u32, picture: Image) -> Result<(), Failure> {
        output::write(&self.path(frame), &encode_png(&picture)?)
    }
}

fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

fn check_hidden(roles: &[CrowdRole], hide: &[String]) -> Result<(), Failure> {
    let names = || roles.iter().flat_map(|r| &r.character.parts).map(|p| p.node_name.as_str());
    match hide.iter().find(|wanted| !names().any(|n| n == wanted.as_str())) {
        None => Ok(()),
        Some(unknown) => Err(Failure::usage(format!(
            "no node \"{unknown}\" has anything to draw{}",
            hint(unknown, names())
        ))),
    }
}
