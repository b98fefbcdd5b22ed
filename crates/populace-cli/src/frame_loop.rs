//! The loop over frames: move on to a frame, evaluate and draw by its camera, hand the picture on.
//!
//! An [`Action`] moves the crowd and the camera, and a [`FrameSink`] takes the pictures.

mod times;

use std::time::Instant;

use populace::character::Image;
use populace::{Crowd, MemberId};
use populace_render::{Camera, Drawn, Scene};

use crate::camera::Cameras;
use crate::crowd_renderer::CrowdRenderer;
use crate::exposure::Exposure;
use crate::failure::Failure;
use crate::frames::{Frames, single};
use crate::image_files::PixelFacts;
use crate::progress::Progress;
use crate::report::message;
pub(crate) use times::FrameTimes;
use times::{Spent, ms_since};

/// Longest step of feet in seconds: they need several in each contact, at any frame rate.
const FOOT_STEP_SECS: f32 = 0.041;

/// Moves everybody on by `secs` in equal steps that are short enough for feet. Evaluates all but the
/// last for the view that was set before, and returns the seconds of the last.
pub(crate) fn in_foot_steps<A: Action>(
    action: &mut A,
    crowd: &mut Crowd,
    secs: f32,
    step: fn(&mut A, &mut Crowd, f32) -> Result<(), Failure>,
) -> Result<f32, Failure> {
    let steps = (secs / FOOT_STEP_SECS).ceil().max(1.0);
    let step_secs = secs / steps;
    let mut done = 1.0;
    while done < steps {
        step(action, crowd, step_secs)?;
        action.evaluate(crowd, step_secs)?;
        done += 1.0;
    }
    step(action, crowd, step_secs)?;
    Ok(step_secs)
}

/// Moves a crowd through time, and places the camera.
pub(crate) trait Action {
    /// Moves everybody on by `secs`, 0 for frame 0. May do so in several steps and evaluate all but
    /// the last; returns its seconds, which are left to [`evaluate`](Self::evaluate). Called in the
    /// same steps for every frame, drawn or not, from frame 0 on, so that a frame does not depend
    /// on those that are drawn before it.
    fn behave(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f32, Failure>;

    /// Evaluates the crowd by [`Crowd::update`], `secs` after the last evaluation.
    fn evaluate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        Ok(crowd.update(secs)?)
    }

    /// Moves everybody on by `secs` and evaluates the crowd.
    fn advance(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        let left_secs = self.behave(crowd, secs)?;
        self.evaluate(crowd, left_secs)
    }

    /// Returns the milliseconds that behaviours and avoidance have taken since the last call.
    fn take_behave_ms(&mut self) -> f64 {
        0.0
    }

    /// Chooses the cameras of pictures whose width is `aspect` times their height. Called before
    /// the first camera is asked for.
    fn set_aspect(&mut self, aspect: f32) -> Result<(), Failure>;

    /// Returns the camera `secs` after frame 0, the time to which everybody was moved. Called
    /// before the crowd is evaluated, for the view, and after it, for the picture. The two differ
    /// only in how a head moves over the body, or over the vehicle: a camera `follow` or `eye` of a
    /// scene goes with the head, which is known after the evaluation.
    fn camera(&self, secs: f64) -> Result<Camera, Failure>;

    /// Returns the cameras; `None` before [`set_aspect`](Self::set_aspect).
    fn cameras(&self) -> Option<&Cameras>;

    /// Returns the height of the ground at a point `[x, z]` in metres; `None` where it is that of
    /// the scene.
    fn ground_m(&self, _at: [f32; 2]) -> Option<f32> {
        None
    }

    /// Returns true if [`overlay`](Self::overlay) needs the depths of pixels.
    fn needs_depths(&self) -> bool {
        false
    }

    /// Draws over the picture of a frame, which `camera` saw at the time of the frame. `depths_m`
    /// are the distances of its pixels along the view direction in metres; empty if they are not
    /// needed.
    fn overlay(
        &self,
        _picture: &mut Image,
        _camera: &Camera,
        _depths_m: &[f32],
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Returns the number of the person that a member is; `None` for other things.
    fn person(&self, member: MemberId) -> Option<u64>;
}

/// A picture of a frame.
pub(crate) struct Shot {
    pub(crate) picture: Image,
    /// Depth and people of its pixels at the time of the frame, if the sink needs them.
    pub(crate) facts: Option<PixelFacts>,
}

/// Takes the pictures.
pub(crate) trait FrameSink {
    /// Returns true if the picture of a frame is wanted; otherwise it is not drawn.
    fn wants(&self, frame: u32) -> bool;

    /// Returns true if pictures are wanted with what their pixels show.
    fn needs_facts(&self) -> bool;

    /// Takes over the picture of a frame. Called in the order of frames.
    fn take(&mut self, frame: u32, shot: Shot) -> Result<(), Failure>;
}

/// Settings of a loop over frames.
pub(crate) struct FrameLoop<'a> {
    pub(crate) frames: Frames,
    /// Width and height of the pictures in pixels.
    pub(crate) size: [u32; 2],
    pub(crate) scene: &'a Scene,
    /// Error of levels of detail in pixels; `None` evaluates and draws everyone in full detail.
    pub(crate) detail: Option<f32>,
}

impl FrameLoop<'_> {
    /// Evaluates all frames, and draws and hands on those that are wanted. Returns how long they
    /// took, and what the last picture shows. Does nothing if no frame is wanted.
    ///
    /// Without a renderer, the first moment is evaluated and its time is reported before the error
    /// is returned.
    pub(crate) fn play(
        &self,
        crowd: &mut Crowd,
        action: &mut dyn Action,
        renderer: Result<CrowdRenderer, Failure>,
        sink: &mut dyn FrameSink,
    ) -> Result<(FrameTimes, Drawn), Failure> {
        let mut times = FrameTimes::default();
        let wanted = |frame: &u32| sink.wants(*frame);
        let Some(last) = (self.frames.first..=self.frames.last).rev().find(wanted) else {
            return Ok((times, Drawn::default()));
        };
        let mut spent = self.animate(crowd, action, (0.0, 0.0))?;
        let mut renderer = renderer.inspect_err(|_| {
            message!("{:.2} ms to animate a frame, but it cannot be drawn:", spent.animate);
        })?;
        message!("drawn by {}", renderer.driver());
        message!("palettes {}", renderer.palette_transport());
        let mut progress = Progress::new("frames", last as usize + 1);
        let mut exposure = Exposure::new();
        let mut moments = self.frames.moments(last).peekable();
        // Facts and camera at the time of the frame, of the first of its pictures.
        let (mut facts, mut frame_camera) = (None::<PixelFacts>, Camera::default());
        let (mut frame, mut is_drawn, mut start_secs, mut now_secs) = (None, false, 0.0, 0.0);
        while let Some(moment) = moments.next() {
            if moment.sample.is_none_or(|sample| sample == 0) {
                start_secs = moment.secs;
            }
            let within = |cameras: &Cameras| cameras.within_shot(start_secs, moment.secs);
            let camera_secs = action.cameras().map_or(moment.secs, within);
            // The first moment is evaluated already.
            if moment.secs > now_secs {
                let step_secs = single(moment.secs - now_secs);
                spent.add(&self.animate(crowd, action, (step_secs, camera_secs))?);
                now_secs = moment.secs;
            }
            // Once for all pictures of a frame: another process may write its file meanwhile.
            if frame.replace(moment.frame) != Some(moment.frame) {
                is_drawn = moment.frame >= self.frames.first && sink.wants(moment.frame);
            }
            if let Some(sample) = moment.sample.filter(|_| is_drawn) {
                let start = Instant::now();
                let camera = action.camera(camera_secs)?;
                exposure.add(renderer.picture(crowd, &camera, self.scene)?);
                times.passes.push(renderer.pass_times()?);
                if sample == 0 {
                    frame_camera = camera;
                    facts = self.facts(crowd, action, &mut renderer, sink, &camera)?;
                }
                spent.draw += ms_since(start);
            }
            if moments.peek().is_some_and(|next| next.frame == moment.frame) {
                continue;
            }
            let spent = std::mem::take(&mut spent);
            times.add_animated(&spent);
            if let Some(mut picture) = exposure.develop() {
                let start = Instant::now();
                let depths_m = facts.as_ref().map_or(&[][..], |facts| &facts.marks.depths_m[..]);
                action.overlay(&mut picture, &frame_camera, depths_m)?;
                times.draw.push(spent.draw + ms_since(start));
                let facts = facts.take().filter(|_| sink.needs_facts());
                sink.take(moment.frame, Shot { picture, facts })?;
                times.total.push(spent.behave + spent.animate + spent.draw + ms_since(start));
            }
            progress.step();
        }
        Ok((times, renderer.drawn()))
    }

    /// Returns what the pixels of the last picture show, if the sink or the overlay needs it.
    fn facts(
        &self,
        crowd: &Crowd,
        action: &dyn Action,
        renderer: &mut CrowdRenderer,
        sink: &dyn FrameSink,
        camera: &Camera,
    ) -> Result<Option<PixelFacts>, Failure> {
        if !(sink.needs_facts() || action.needs_depths()) {
            return Ok(None);
        }
        let person = |member| action.person(member);
        renderer.pixel_facts(crowd, camera, self.scene, &person).map(Some)
    }

    /// Moves the action on by `secs`, evaluates the crowd for the camera of a time, waits for the
    /// device, and returns the milliseconds that they took.
    fn animate(
        &self,
        crowd: &mut Crowd,
        action: &mut dyn Action,
        (secs, camera_secs): (f32, f64),
    ) -> Result<Spent, Failure> {
        let start = Instant::now();
        let left_secs = action.behave(crowd, secs)?;
        self.look(crowd, action, camera_secs)?;
        action.evaluate(crowd, left_secs)?;
        crowd.finish()?;
        let (all, behave) = (ms_since(start), action.take_behave_ms());
        let view = crowd.frame_times().view_ms;
        Ok(Spent { behave, animate: all - behave, view, draw: 0.0 })
    }

    /// Sets the view that the crowd is evaluated for.
    fn look(&self, crowd: &mut Crowd, action: &dyn Action, secs: f64) -> Result<(), Failure> {
        if let Some(detail) = self.detail {
            crowd.set_view(Some(action.camera(secs)?.view(self.size, self.scene, detail)?))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use glam::{Quat, Vec3};
    use populace::interop::Visibility;
    use populace::{Device, Placement};
    use populace_film::FrameRate;
    use populace_render::Renderer;

    use super::*;
    use crate::frames::Shutter;

    /// A camera that moves by 1 m in a second, and the cameras that were drawn over.
    #[derive(Default)]
    struct Moves(RefCell<Vec<Camera>>);

    impl Action for Moves {
        fn behave(&mut self, _: &mut Crowd, secs: f32) -> Result<f32, Failure> {
            Ok(secs)
        }

        fn set_aspect(&mut self, _aspect: f32) -> Result<(), Failure> {
            Ok(())
        }

        fn camera(&self, secs: f64) -> Result<Camera, Failure> {
            let x = single(secs);
            Ok(Camera { eye: [x, 1.0, 5.0], target: [x, 1.0, 0.0], ..Camera::default() })
        }

        fn cameras(&self) -> Option<&Cameras> {
            None
        }

        fn needs_depths(&self) -> bool {
            true
        }

        fn overlay(&self, _: &mut Image, camera: &Camera, _: &[f32]) -> Result<(), Failure> {
            self.0.borrow_mut().push(*camera);
            Ok(())
        }

        fn person(&self, _member: MemberId) -> Option<u64> {
            None
        }
    }

    /// A camera that has turned to +X from +Z by an angle in radians.
    struct Turns(f32);

    impl Action for Turns {
        fn behave(&mut self, _: &mut Crowd, secs: f32) -> Result<f32, Failure> {
            self.0 += 6.0 * secs;
            Ok(secs)
        }

        fn set_aspect(&mut self, _aspect: f32) -> Result<(), Failure> {
            Ok(())
        }

        fn camera(&self, _secs: f64) -> Result<Camera, Failure> {
            let target = Vec3::Y + Quat::from_rotation_y(self.0) * Vec3::Z;
            Ok(Camera { eye: [0.0, 1.0, 0.0], target: target.to_array(), ..Camera::default() })
        }

        fn cameras(&self) -> Option<&Cameras> {
            None
        }

        fn person(&self, _member: MemberId) -> Option<u64> {
            None
        }
    }

    struct Nowhere;

    impl FrameSink for Nowhere {
        fn wants(&self, _frame: u32) -> bool {
            true
        }

        fn needs_facts(&self) -> bool {
            false
        }

        fn take(&mut self, _frame: u32, _shot: Shot) -> Result<(), Failure> {
            Ok(())
        }
    }

    /// Plays two frames of a crowd, a tenth of a second apart.
    fn play(crowd: &mut Crowd, action: &mut dyn Action, shutter: Shutter, detail: Option<f32>) {
        let renderer = Renderer::headless([16, 16]).expect("a renderer");
        let renderer = CrowdRenderer::new(renderer, crowd, &[], &[]);
        let rate = FrameRate::new(10, 1).expect("a rate");
        let frames = Frames::film(&(0..=1), rate, shutter);
        let scene = &Scene::default();
        let frame_loop = FrameLoop { frames, size: [16, 16], scene, detail };
        frame_loop.play(crowd, action, renderer, &mut Nowhere).expect("frames");
    }

    #[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
    #[test]
    fn members_are_hidden_by_the_camera_of_their_frame() {
        let mut crowd = Crowd::builder().device(Device::native()).build().expect("a crowd");
        let man = populace_cast::person(&populace_cast::Look::man()).expect("a person");
        let man = crowd.add_character(man).expect("a character");
        // In the middle of the picture of the last frame, and of that of the first.
        let [seen, passed] = [0.6, 0.0].map(|turn_rad| {
            let at = Quat::from_rotation_y(turn_rad) * Vec3::new(0.0, 0.0, 20.0);
            crowd.spawn(man, Placement::at(at.to_array())).expect("room for a member")
        });
        play(&mut crowd, &mut Turns(0.0), Shutter::INSTANT, Some(1.0));
        let visibility = |member| crowd.member(member).expect("a member").instance().visibility;
        assert_eq!(visibility(seen), Visibility::InView);
        assert_ne!(visibility(passed), Visibility::InView);
    }

    #[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
    #[test]
    fn overlays_have_the_camera_of_their_depths() {
        let mut crowd = Crowd::builder().device(Device::native()).build().expect("a crowd");
        let mut action = Moves::default();
        play(&mut crowd, &mut action, Shutter::degrees(180.0), None);
        let wanted = [0.0, 0.1].map(|secs| action.camera(secs).expect("a camera"));
        assert_eq!(action.0.into_inner(), wanted);
    }
}
