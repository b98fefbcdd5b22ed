//! The loop over frames: advance to the frame's time, draw from its camera, hand the picture on.
//!
//! What happens before the camera is an [`Action`], and where pictures go is a [`FrameSink`].

use std::time::Instant;

use populace::Crowd;
use populace::character::Image;
use populace_render::{Camera, Drawn, PassTimes, Scene};

use crate::crowd_renderer::CrowdRenderer;
use crate::failure::Failure;
use crate::frames::{Frames, single};
use crate::progress::Progress;
use crate::report::message;

/// Length of each frame before the first picture.
pub(crate) const LEAD_IN_SECS: f32 = 1.0 / 60.0;

/// What happens before the camera: moves a crowd through time, and says where the camera is.
pub(crate) trait Action {
    /// Advances the crowd by `secs`, 0 for frame 0, and evaluates it by [`Crowd::update`]. Called in
    /// the same steps for every frame, drawn or not, from frame 0 on, so that a frame does not
    /// depend on those that are drawn before it.
    fn advance(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure>;

    /// Returns the camera `secs` after frame 0. Called before the crowd is advanced to this time.
    fn camera(&self, secs: f64) -> Result<Camera, Failure>;
}

/// Where the pictures go.
pub(crate) trait FrameSink {
    /// Takes over the picture of a frame.
    fn take(&mut self, frame: u32, picture: Image) -> Result<(), Failure>;
}

/// Settings of a loop over frames.
pub(crate) struct FrameLoop<'a> {
    pub(crate) frames: Frames,
    /// Number of frames evaluated and timed before frame 0.
    pub(crate) lead_in: u32,
    /// Width and height of the pictures in pixels.
    pub(crate) size: [u32; 2],
    pub(crate) scene: &'a Scene,
    /// Error of levels of detail in pixels; `None` evaluates and draws everyone in full detail.
    pub(crate) detail: Option<f32>,
}

impl FrameLoop<'_> {
    /// Evaluates all frames, and draws and hands on those that are wanted. Returns how long they
    /// took, and what the last picture shows.
    ///
    /// Without a renderer, the frames up to the first picture are evaluated and their time is
    /// reported before the error is returned.
    pub(crate) fn play(
        &self,
        crowd: &mut Crowd,
        action: &mut dyn Action,
        renderer: Result<CrowdRenderer, Failure>,
        sink: &mut dyn FrameSink,
    ) -> Result<(FrameTimes, Drawn), Failure> {
        let mut times = FrameTimes::default();
        let mut animate_ms = self.lead_in(crowd, action, &mut times)?;
        let mut renderer = renderer.inspect_err(|_| {
            let ms = median(&times.animate).unwrap_or_default();
            message!("{ms:.2} ms to animate a frame, but it cannot be drawn:");
        })?;
        message!("drawn by {}", renderer.driver());
        message!("palettes {}", renderer.palette_transport());
        let mut progress = Progress::new("frames", self.frames.last as usize + 1);
        for frame in 0..=self.frames.last {
            if frame > 0 {
                animate_ms = self.advance(crowd, action, frame, &mut times)?;
            }
            if frame >= self.frames.first {
                let start = Instant::now();
                let camera = action.camera(self.frames.secs(frame))?;
                let picture = renderer.picture(crowd, &camera, self.scene)?;
                times.draw.push(ms_since(start));
                times.passes.push(renderer.pass_times()?);
                sink.take(frame, picture)?;
                times.total.push(animate_ms + ms_since(start));
            }
            progress.step();
        }
        Ok((times, renderer.drawn()))
    }

    /// Evaluates the frames up to frame 0, and returns the time of the last of them. The first
    /// evaluation includes all uploads, so it is counted only if it is the only one.
    fn lead_in(
        &self,
        crowd: &mut Crowd,
        action: &mut dyn Action,
        times: &mut FrameTimes,
    ) -> Result<f64, Failure> {
        self.look(crowd, action, 0.0)?;
        let mut ms = times.animate(crowd, action, 0.0)?;
        if self.lead_in > 0 {
            times.animate.clear();
        }
        let mut progress = Progress::new("evaluating", self.lead_in as usize);
        for _ in 0..self.lead_in {
            ms = times.animate(crowd, action, LEAD_IN_SECS)?;
            progress.step();
        }
        Ok(ms)
    }

    /// Advances from the frame before to `frame`, and returns the time that it took.
    fn advance(
        &self,
        crowd: &mut Crowd,
        action: &mut dyn Action,
        frame: u32,
        times: &mut FrameTimes,
    ) -> Result<f64, Failure> {
        let secs = self.frames.secs(frame);
        self.look(crowd, action, secs)?;
        times.animate(crowd, action, single(secs - self.frames.secs(frame - 1)))
    }

    /// Sets the view that the crowd is evaluated for.
    fn look(&self, crowd: &mut Crowd, action: &dyn Action, secs: f64) -> Result<(), Failure> {
        if let Some(detail) = self.detail {
            crowd.set_view(Some(action.camera(secs)?.view(self.size, self.scene, detail)?))?;
        }
        Ok(())
    }
}

/// Times of frames in milliseconds.
#[derive(Default)]
pub(crate) struct FrameTimes {
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
    fn animate(
        &mut self,
        crowd: &mut Crowd,
        action: &mut dyn Action,
        secs: f32,
    ) -> Result<f64, Failure> {
        let start = Instant::now();
        action.advance(crowd, secs)?;
        crowd.finish()?;
        let ms = ms_since(start);
        self.animate.push(ms);
        Ok(ms)
    }

    /// Returns the median of one pass.
    pub(crate) fn pass(&self, of: fn(&PassTimes) -> f64) -> f64 {
        median(&self.passes.iter().map(of).collect::<Vec<_>>()).unwrap_or_default()
    }

    /// Returns the medians of `total`, `animate` and `draw`.
    pub(crate) fn medians(&self) -> [f64; 3] {
        [&self.total, &self.animate, &self.draw].map(|ms| median(ms).unwrap_or_default())
    }
}
