//! People who follow trajectories, and the cameras that film them.

use std::time::Instant;

use populace::character::Image;
use populace::{Crowd, MemberId};
use populace_render::Camera;
use populace_scene::Replay;
use populace_trajectory::Recording;
use serde_json::{Value, json};

use super::agents::Agents;
use super::metered::Metered;
use super::overlays::Overlays;
use super::place::Place;
use crate::camera::{Cameras, View};
use crate::failure::Failure;
use crate::frame_loop::{Action, in_foot_steps};
use crate::frames::Frames;
use crate::report::message;

/// Most pictures of a film in which people are looked for under the legend.
const LEGEND_PICTURES: f64 = 100.0;

/// People who follow trajectories.
pub(super) struct ReplayAction {
    pub(super) recording: Recording,
    pub(super) replay: Replay,
    /// The replay before frame 0.
    #[cfg(feature = "viewer")]
    pub(super) first: Replay,
    pub(super) subject: Agents,
    pub(super) view: View,
    /// `None` if nothing is drawn.
    pub(super) cameras: Option<Cameras>,
    pub(super) metered: Metered,
    pub(super) overlays: Overlays,
    pub(super) place: Place,
    pub(super) behave_ms: f64,
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
    pub(super) fn place_legend(
        &mut self,
        size: [u32; 2],
        still: Option<Frames>,
    ) -> Result<(), Failure> {
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
    pub(super) fn warn_of_moved(&self, frames: Frames, size: [u32; 2]) -> Result<(), Failure> {
        let is_placed = self.cameras.as_ref().is_some_and(Cameras::is_placed);
        if !is_placed || self.recording.origin_m == [0.0; 2] {
            return Ok(());
        }
        let cameras = frames.times().map(|secs| Ok((secs, self.camera(secs)?)));
        if self.subject.are_seen(cameras, size)? {
            return Ok(());
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
    pub(super) fn ids(&self) -> Value {
        let agents = self.recording.agents.iter();
        let ids = (1_u64..).zip(agents).map(|(value, agent)| (value.to_string(), json!(agent.id)));
        Value::Object(ids.collect())
    }

    /// Returns foot skate and the error of positions as JSON, by their names.
    pub(super) fn measures(&self) -> Value {
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
        let Some(cameras) = &self.cameras else { return Ok(Camera::default()) };
        let poses = |at| self.subject.pose_around(cameras.person()?, at, secs);
        Ok(cameras.at(&poses, secs))
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
