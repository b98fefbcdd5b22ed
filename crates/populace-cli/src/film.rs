//! From a crowd's members to pictures in files: what `demo` and `render` have in common.

use std::path::{Path, PathBuf};
use std::time::Instant;

use populace::Crowd;
use populace_render::{Camera, Renderer, encode_png};
use serde_json::json;

use crate::bench::{median, ms_since};
use crate::cast::{self, Role, Wanted};
use crate::cli::{PictureArgs, View, build};
use crate::failure::Failure;
use crate::names::hint;
use crate::output::{self, Pictures, check_inputs, check_writable};
use crate::progress::Progress;
use crate::report::{self, talk};
use crate::staging::{Plan, Staging};
use crate::studio::{Studio, devices_and_shares, drawn_with};
use crate::unfinished;

/// Length of the frames before the first picture.
const LEAD_IN_SECS: f32 = 1.0 / 60.0;

/// Pictures to make of a crowd.
pub(crate) struct Film<'a> {
    pub(crate) inputs: &'a [PathBuf],
    pub(crate) members: u32,
    pub(crate) out: &'a Path,
    /// Out of a hundred members, how many walk away from the camera.
    pub(crate) away_percent: usize,
    /// Frames that are evaluated and timed before the first picture.
    pub(crate) lead_in: u32,
    pub(crate) args: &'a PictureArgs,
}

/// Milliseconds of frames.
#[derive(Default)]
struct Times {
    /// From the update to the written file.
    total: Vec<f64>,
    animate: Vec<f64>,
    draw: Vec<f64>,
}

impl Times {
    fn animate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f64, Failure> {
        let start = Instant::now();
        crowd.update(secs)?;
        crowd.finish()?;
        let ms = ms_since(start);
        self.animate.push(ms);
        Ok(ms)
    }

    /// The medians of all frames, of evaluating them, and of drawing them.
    fn medians(&self) -> [f64; 3] {
        [&self.total, &self.animate, &self.draw].map(|ms| median(ms).unwrap_or_default())
    }
}

impl Film<'_> {
    /// Checks everything that is given before it evaluates and draws.
    pub(crate) fn make(&self) -> Result<(), Failure> {
        let args = self.args;
        let pictures = Pictures::new(self.out, args.frames)?;
        let given = self.inputs.iter().chain(&args.clips);
        let given: Vec<_> = given.filter(|input| cast::built_in_name(input).is_none()).collect();
        check_inputs(pictures.paths(), &given)?;
        check_writable(&pictures.path(0))?;
        unfinished::expect_pictures(pictures.count());
        // Without OpenGL the inputs are still checked first: what is wrong with them is of more
        // use.
        let renderer = Renderer::headless(args.size.0);
        let builder = args.device.crowd().capacity(self.members as usize).slots_per_member(1);
        let mut crowd = build(drawn_with(builder, &renderer))?;
        #[cfg(unix)]
        crate::aborts::end_with_a_code();
        let wanted = Wanted { clip: args.clip.as_deref(), root_motion: args.root_motion };
        let cast =
            cast::load(&mut crowd, &args.input, self.inputs, &args.clips, wanted, args.height)?;
        check_inputs(pictures.paths(), &cast.files)?;
        check_hidden(&cast.roles, &args.hide)?;
        let plan = Plan {
            members: self.members,
            seed: args.seed,
            hide: &args.hide,
            away_percent: self.away_percent,
        };
        let staging = Staging::new(&mut crowd, &cast.roles, &plan)?;
        let camera = self.camera(&staging);
        let devices = devices_and_shares(&crowd);
        talk!("{} on {devices}, {}", counted(crowd.member_count(), "member"), crowd.schedule());
        let studio = renderer.map_err(Failure::from).and_then(|renderer| {
            Studio::new(renderer, &mut crowd, &cast.roles, &args.hide, camera)
        });
        self.shoot(&mut crowd, studio, &pictures)
    }

    fn shoot(
        &self,
        crowd: &mut Crowd,
        studio: Result<Studio, Failure>,
        pictures: &Pictures,
    ) -> Result<(), Failure> {
        let mut times = Times::default();
        let mut animate_ms = self.lead_in(crowd, &mut times)?;
        let mut studio = studio.inspect_err(|_| {
            let ms = median(&times.animate).unwrap_or_default();
            talk!("{ms:.2} ms to animate a frame, but there is nothing to draw it with:");
        })?;
        talk!("drawn by {}", studio.driver());
        talk!("palettes {}", studio.palettes());
        let mut progress = Progress::new("frames", pictures.count() as usize);
        for index in 0..pictures.count() {
            if index > 0 {
                animate_ms = times.animate(crowd, 1.0 / self.args.fps)?;
            }
            let start = Instant::now();
            let picture = studio.picture(crowd)?;
            times.draw.push(ms_since(start));
            output::write(&pictures.path(index), &encode_png(&picture)?)?;
            times.total.push(animate_ms + ms_since(start));
            progress.step();
        }
        drop(progress);
        self.report(crowd, &studio, &times, pictures)
    }

    /// Evaluates all that comes before the first picture and gives the time of the last frame of
    /// it. The first evaluation also uploads everything, so it counts only where there is no other.
    fn lead_in(&self, crowd: &mut Crowd, times: &mut Times) -> Result<f64, Failure> {
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
        studio: &Studio,
        times: &Times,
        pictures: &Pictures,
    ) -> Result<(), Failure> {
        let (out, count, drawn) = (pictures.path(0), pictures.count(), studio.drawn());
        let [total, animate, draw] = times.medians();
        talk!(
            "{} drawn, {}",
            counted(drawn.members, "member"),
            counted(drawn.triangles, "triangle")
        );
        let median = if count == 1 { "" } else { ", median" };
        let frames = counted(count as usize, "frame");
        talk!("{frames}{median}: {total:.2} ms, {animate:.2} to animate, {draw:.2} to draw");
        if self.args.json {
            return report::json(&json!({
                "schema": 1,
                "device": crowd.devices().to_string(),
                "schedule": crowd.schedule().name(),
                "members": crowd.member_count(),
                "frames": count,
                "ms_median": {"total": total, "animate": animate, "draw": draw},
                "drawn_members": drawn.members,
                "triangles": drawn.triangles,
                "out": out.to_string_lossy(),
            }));
        }
        report::path(&out)
    }

    fn camera(&self, staging: &Staging) -> Camera {
        let [width, height] = self.args.size.0;
        let aspect = width as f32 / height as f32;
        // The whole film must show what it is about, and walkers walk.
        let first_secs = self.lead_in as f32 * LEAD_IN_SECS;
        let length_secs =
            self.args.frames.map_or(0.0, |frames| (frames - 1) as f32 / self.args.fps);
        let film_secs = [first_secs, first_secs + length_secs];
        match self.args.camera {
            View::Crowd => Camera::framing(staging.framed(film_secs), aspect),
            View::Close => Camera::framing(staging.closest(film_secs), aspect),
            View::At { eye, target } => {
                let framed = Camera::framing(staging.framed(film_secs), aspect);
                Camera { eye, target, near: 0.05, ..framed }
            }
        }
    }
}

fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

fn check_hidden(roles: &[Role], hide: &[String]) -> Result<(), Failure> {
    let names = || roles.iter().flat_map(|r| &r.character.parts).map(|p| p.node_name.as_str());
    match hide.iter().find(|wanted| !names().any(|n| n == wanted.as_str())) {
        None => Ok(()),
        Some(unknown) => Err(Failure::usage(format!(
            "no node \"{unknown}\" draws anything{}",
            hint(unknown, names())
        ))),
    }
}
