//! Draws a crowd into picture files: the common part of `demo` and `render`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use populace::Crowd;
use populace_render::{Camera, Drawn, PassTimes, Renderer, Scene, encode_png};
use serde_json::json;

use crate::cli::{PictureArgs, View, build};
use crate::crowd_renderer::{CrowdRenderer, builder_for, devices_and_shares};
use crate::failure::Failure;
use crate::names::hint;
use crate::output::{self, Pictures, check_inputs, check_writable};
use crate::population::{Population, PopulationSettings};
use crate::progress::Progress;
use crate::report::{self, message};
use crate::roles::{self, ClipChoice, CrowdRole};
use crate::unfinished;

/// Length of each frame before the first picture.
const LEAD_IN_SECS: f32 = 1.0 / 60.0;

/// A job of drawing a crowd.
pub(crate) struct DrawJob<'a> {
    pub(crate) inputs: &'a [PathBuf],
    pub(crate) members: u32,
    pub(crate) out: &'a Path,
    /// Number of frames evaluated and timed before the first picture.
    pub(crate) lead_in: u32,
    pub(crate) args: &'a PictureArgs,
}

/// FrameTimes of frames in milliseconds.
#[derive(Default)]
struct FrameTimes {
    /// From the start of the update to the written file.
    total: Vec<f64>,
    animate: Vec<f64>,
    draw: Vec<f64>,
    passes: Vec<PassTimes>,
}

/// Returns the milliseconds since `start`.
fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// Returns the median, the upper of the two middle values if their number is even; `None` if there
/// are no values.
fn median(ms: &[f64]) -> Option<f64> {
    let mut sorted = ms.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

impl FrameTimes {
    fn animate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f64, Failure> {
        let start = Instant::now();
        crowd.update(secs)?;
        crowd.finish()?;
        let ms = ms_since(start);
        self.animate.push(ms);
        Ok(ms)
    }

    /// Returns the median of one pass.
    fn pass(&self, of: fn(&PassTimes) -> f64) -> f64 {
        median(&self.passes.iter().map(of).collect::<Vec<_>>()).unwrap_or_default()
    }

    /// Returns the medians of `total`, `animate` and `draw`.
    fn medians(&self) -> [f64; 3] {
        [&self.total, &self.animate, &self.draw].map(|ms| median(ms).unwrap_or_default())
    }
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
        let camera = self.camera(&population);
        let scene = self.scene();
        if !args.full_detail {
            crowd.set_view(Some(camera.view(args.size.0, &scene, args.detail)?))?;
        }
        let devices = devices_and_shares(&crowd);
        message!(
            "{} on {devices}, {}",
            counted(crowd.member_count(), "member"),
            crowd.device_info().schedule
        );
        let renderer = renderer.map_err(Failure::from).and_then(|renderer| {
            CrowdRenderer::new(renderer, &mut crowd, &loaded.roles, &args.hide, (camera, scene))
        });
        self.draw_all(&mut crowd, renderer, &pictures)
    }

    /// Evaluates, draws and writes all frames.
    fn draw_all(
        &self,
        crowd: &mut Crowd,
        renderer: Result<CrowdRenderer, Failure>,
        pictures: &Pictures,
    ) -> Result<(), Failure> {
        let mut times = FrameTimes::default();
        let mut animate_ms = self.lead_in(crowd, &mut times)?;
        let mut renderer = renderer.inspect_err(|_| {
            let ms = median(&times.animate).unwrap_or_default();
            message!("{ms:.2} ms to animate a frame, but it cannot be drawn:");
        })?;
        message!("drawn by {}", renderer.driver());
        message!("palettes {}", renderer.palette_transport());
        let mut progress = Progress::new("frames", pictures.count() as usize);
        for index in 0..pictures.count() {
            if index > 0 {
                animate_ms = times.animate(crowd, 1.0 / self.args.fps)?;
            }
            let start = Instant::now();
            let picture = renderer.picture(crowd)?;
            times.draw.push(ms_since(start));
            times.passes.push(renderer.pass_times()?);
            output::write(&pictures.path(index), &encode_png(&picture)?)?;
            times.total.push(animate_ms + ms_since(start));
            progress.step();
        }
        drop(progress);
        self.report(crowd, renderer.drawn(), &times, pictures)
    }

    /// Evaluates the frames up to the first picture, and returns the time of the last of them. The
    /// first evaluation includes all uploads, so it is counted only if it is the only one.
    fn lead_in(&self, crowd: &mut Crowd, times: &mut FrameTimes) -> Result<f64, Failure> {
        let mut ms = times.animate(crowd, 0.0)?;
        if self.lead_in > 0 {
            times.animate.clear();
        }
        let mut progress = Progress::new("evaluating", self.lead_in as usize);
        for _ in 0..self.lead_in {
            ms = times.animate(crowd, LEAD_IN_SECS)?;
            progress.step();
        }
        Ok(ms)
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

    fn camera(&self, population: &Population) -> Camera {
        let [width, height] = self.args.size.0;
        let aspect = width as f32 / height as f32;
        // The view must contain the members in the first and in the last frame.
        let first_secs = self.lead_in as f32 * LEAD_IN_SECS;
        let length_secs =
            self.args.frames.map_or(0.0, |frames| (frames - 1) as f32 / self.args.fps);
        let secs = [first_secs, first_secs + length_secs];
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
