//! The filming of a crowd: outputs, crowd, renderer, frames and the report.

use std::path::{Path, PathBuf};

use populace::{Crowd, CrowdBuilder};
use populace_film::FilmSettings;
use populace_render::{Drawn, Preset, Renderer, Scene};
use serde_json::{Value, json};

use crate::camera::Cameras;
use crate::cli::{PictureArgs, build};
use crate::crowd_renderer::{CrowdRenderer, builder_for};
use crate::failure::Failure;
use crate::frame_loop::{Action, FrameLoop, FrameTimes};
use crate::frames::Frames;
use crate::names::hint;
use crate::output::{Outputs, check_inputs, check_writable};
use crate::report::{self, counted, message};
use crate::roles::CrowdRole;
use crate::sinks::Sink;
use crate::unfinished;

/// A film, or pictures, that are about to be made.
pub(crate) struct Filming<'a> {
    args: &'a PictureArgs,
    frames: Frames,
    outputs: Outputs,
}

/// A film, or pictures, that are made.
pub(crate) struct Filmed {
    frames: Frames,
    skipped: usize,
    times: FrameTimes,
    drawn: Drawn,
    out: PathBuf,
}

impl<'a> Filming<'a> {
    /// Checks that the outputs can be written and destroy none of the `given` inputs. Frames are a
    /// series unless they are one picture.
    pub(crate) fn new(
        args: &'a PictureArgs,
        out: &Path,
        (frames, is_series): (Frames, bool),
        given: &[&Path],
    ) -> Result<Self, Failure> {
        let range = frames.first..=frames.last;
        let outputs = Outputs::new(out, range, is_series, &args.film.images)?;
        check_inputs(outputs.paths(), given)?;
        check_writable(&outputs.first())?;
        Ok(Self { args, frames, outputs })
    }

    /// Begins to write. A film that cannot be encoded fails here.
    pub(crate) fn sink(&self) -> Result<Sink<'_>, Failure> {
        let (film, frames) = (&self.args.film, self.frames);
        let settings = FilmSettings::new(self.args.size(), frames.rate);
        let settings = FilmSettings { encoder: film.encoder, ..settings };
        let sink = Sink::open(&self.outputs, &settings, film.skip_existing)?;
        let skipped = u32::try_from(sink.skipped()).unwrap_or_default();
        unfinished::expect_frames(frames.count() - skipped);
        Ok(sink)
    }

    /// Returns a renderer. A missing OpenGL is reported last: errors in the inputs are more useful.
    pub(crate) fn renderer(&self) -> Result<Renderer, populace_render::Error> {
        Renderer::headless(self.args.size())
    }

    /// Builds a crowd whose palettes a renderer can take.
    pub(crate) fn crowd(
        &self,
        renderer: &Result<Renderer, populace_render::Error>,
        [capacity, slots]: [usize; 2],
    ) -> Result<Crowd, Failure> {
        let builder = self.args.device.crowd().capacity(capacity).slots_per_member(slots);
        build_crowd(builder_for(builder, renderer))
    }

    /// Returns the light and the surroundings.
    pub(crate) fn scene(&self) -> Scene {
        scene(self.args)
    }

    /// Checks that no output destroys a file that characters refer to.
    pub(crate) fn check(&self, files: &[PathBuf]) -> Result<(), Failure> {
        check_inputs(self.outputs.paths(), files)
    }

    /// Evaluates, draws and writes all frames of a scene.
    pub(crate) fn shoot(
        &self,
        crowd: &mut Crowd,
        (action, scene): (&mut dyn Action, &Scene),
        renderer: Result<CrowdRenderer, Failure>,
        mut sink: Sink<'_>,
    ) -> Result<Filmed, Failure> {
        let (args, frames) = (self.args, self.frames);
        let scene = &in_clear_air(*scene, action);
        warn_of_sunken_camera(action, scene, frames.times());
        let frame_loop = FrameLoop { frames, size: args.size(), scene, detail: args.detail_px() };
        let skipped = sink.skipped();
        let (times, drawn) = frame_loop.play(crowd, action, renderer, &mut sink)?;
        Ok(Filmed { frames, skipped, times, drawn, out: sink.finish()? })
    }
}

impl Filmed {
    /// Says how long frames of a played crowd took, and prints the path of the result or, with
    /// --json, a document with `more` fields.
    pub(crate) fn report(
        &self,
        (crowd, action): (&Crowd, &dyn Action),
        json: bool,
        more: Value,
    ) -> Result<(), Failure> {
        let Self { frames, skipped, times, drawn, out } = self;
        let count = frames.count();
        let [total, behave, animate, view_ms, draw] = times.medians();
        // A place, vehicles and what people hold are members too.
        let people = crowd.view_statistics_of(|member| action.person(member).is_some());
        let in_view = people.levels.iter().sum::<usize>();
        let members = in_view + people.shadow_only + people.hidden;
        // None are drawn if all frames existed.
        let drawn_members = in_view.min(drawn.members.instances);
        message!(
            "{drawn_members} of {} drawn, {}",
            counted(members, "member"),
            counted(drawn.members.triangles, "triangle")
        );
        let median = if count == 1 { "" } else { ", median" };
        let mut text = counted(count as usize, "frame");
        if *skipped > 0 {
            text += &format!(" ({skipped} existed)");
        }
        if frames.shutter.samples > 1 {
            text += &format!(" of {} pictures each", frames.shutter.samples);
        }
        message!("{text}{median}: {total:.2} ms, {animate:.2} to animate, {draw:.2} to draw");
        if !json {
            return report::path(out);
        }
        let document = json!({
            "schema": 1,
            "device": crowd.device_info().devices.to_string(),
            "schedule": crowd.device_info().schedule.name(),
            "members": members,
            "frames": count,
            "skipped": skipped,
            "ms_median": {
                "total": total,
                "behave": behave,
                "animate": animate,
                "view": view_ms,
                "draw": draw,
                "shadow": times.pass(|pass| pass.shadow_ms),
                "members": times.pass(|pass| pass.members_ms),
                "surroundings": times.pass(|pass| pass.surroundings_ms),
            },
            "drawn_members": drawn_members,
            "triangles": drawn.members.triangles,
            "shadow": {"members": drawn.shadow.instances, "triangles": drawn.shadow.triangles},
            "draw_calls": {
                "shadow": drawn.shadow.draw_calls,
                "members": drawn.members.draw_calls,
                "surroundings": drawn.surroundings.draw_calls,
            },
            "levels": people.levels,
            "shadow_only": people.shadow_only,
            "hidden": people.hidden,
            "out": out.to_string_lossy(),
        });
        report::json(&report::with_fields(document, more))
    }
}

/// Builds a crowd, and keeps the program's way to end.
pub(crate) fn build_crowd(builder: CrowdBuilder) -> Result<Crowd, Failure> {
    let crowd = build(builder)?;
    // Drivers that were loaded for it may have set a handler of their own.
    #[cfg(unix)]
    crate::aborts::exit_on_abort();
    Ok(crowd)
}

/// Greatest error of shadows, relative to that of surfaces in the picture.
const SHADOW_DETAIL: f32 = 1.5;

/// Returns the light and the surroundings that were asked for.
pub(crate) fn scene(args: &PictureArgs) -> Scene {
    scene_of(args, args.sky.unwrap_or_default())
}

/// Returns the light and the surroundings of a preset.
pub(crate) fn scene_of(args: &PictureArgs, sky: Preset) -> Scene {
    let mut scene = sky.scene();
    scene.sun.error_px = SHADOW_DETAIL * args.detail_px().unwrap_or(0.0);
    if args.full_detail {
        scene.sun.error_texels = 0.0;
    }
    scene
}

/// Returns a scene in air that is clear enough for the cameras of an action.
pub(crate) fn in_clear_air(mut scene: Scene, action: &dyn Action) -> Scene {
    let least_m = action.cameras().map_or(0.0, Cameras::least_visibility_m);
    scene.sky.visibility_m = scene.sky.visibility_m.max(least_m);
    scene
}

/// Says so if the camera of an action is below the ground of a scene at one of some times in seconds
/// since frame 0.
pub(crate) fn warn_of_sunken_camera(
    action: &dyn Action,
    scene: &Scene,
    times: impl Iterator<Item = f64>,
) {
    let (Some(ground), Some(cameras)) = (scene.ground, action.cameras()) else { return };
    let ground_m = |at| action.ground_m(at).unwrap_or(ground.height_m);
    if let Some(warning) = cameras.below_ground(times, &ground_m) {
        message!("warning: {warning}");
    }
}

/// Refuses nodes to hide that have nothing to draw.
pub(crate) fn check_hidden(roles: &[CrowdRole], hide: &[String]) -> Result<(), Failure> {
    let names = || roles.iter().flat_map(|r| &r.character.parts).map(|p| p.node_name.as_str());
    match hide.iter().find(|wanted| !names().any(|n| n == wanted.as_str())) {
        None => Ok(()),
        Some(unknown) => Err(Failure::usage(format!(
            "no node \"{unknown}\" has anything to draw{}",
            hint(unknown, names())
        ))),
    }
}
