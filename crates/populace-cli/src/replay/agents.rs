//! Agents of a recording, as cameras see them.

use std::f32::consts::FRAC_PI_2;

use populace_scene::{Moment, Motions};
use populace_trajectory::Recording;

use crate::camera::{Pose, Subject};

/// Seconds between positions that the camera frames.
const FRAMED_SECS: f64 = 1.0;
/// Height and half the width of a person in metres, for framing.
const FIGURE_M: [f32; 2] = [1.8, 0.3];
/// Height of the eyes as a fraction of that of the body, and the height of bodies that have none.
const EYES: f32 = 0.93;
const BODY_M: f32 = 1.72;

/// The agents of a recording.
pub(super) struct Agents {
    motions: Motions,
    ids: Vec<String>,
    heights: Vec<f32>,
    from_secs: f64,
}

impl Agents {
    pub(super) fn new(recording: &Recording, motions: Motions) -> Self {
        let agents = recording.agents.iter();
        let (ids, heights) =
            agents.map(|agent| (agent.id.clone(), agent.height_m.unwrap_or(BODY_M))).unzip();
        Self { motions, ids, heights, from_secs: recording.secs()[0] }
    }

    /// Returns where an agent is, or was last, or comes first.
    fn moment(&self, agent: usize, secs: f64) -> Option<Moment> {
        let motion = self.motions.agents.get(agent)?;
        let secs = self.from_secs + secs;
        // The end of the nearest time in which it is there.
        let spans = motion.secs().map(|[from, until]| secs.clamp(from, until));
        let nearest = spans.min_by(|a, b| (a - secs).abs().total_cmp(&(b - secs).abs()));
        motion.at(nearest?)
    }
}

impl Subject for Agents {
    fn bounds(&self) -> Vec<[f32; 3]> {
        let around = |Moment { position: [x, y], elevation_m, .. }: Moment| {
            [[x, elevation_m, -y], [x, elevation_m + FIGURE_M[0], -y]]
        };
        let ways = self.motions.agents.iter().flat_map(|motion| {
            motion.secs().flat_map(move |[from, until]| {
                let times = (0_u32..).map(move |nth| from + f64::from(nth) * FRAMED_SECS);
                let times = times.take_while(move |secs| *secs < until).chain([until]);
                times.filter_map(|secs| motion.at(secs))
            })
        });
        ways.flat_map(around).collect()
    }

    fn elevation_rad(&self) -> Option<f32> {
        Some(0.6)
    }

    fn figure_m(&self) -> [f32; 2] {
        FIGURE_M
    }

    fn closest(&self) -> Option<u64> {
        let z = |agent: usize| self.moment(agent, 0.0).map_or(f32::MIN, |at| -at.position[1]);
        let nearest = (0..self.ids.len()).max_by(|a, b| z(*a).total_cmp(&z(*b)));
        nearest.map(|agent| agent as u64)
    }

    fn find(&self, id: &str) -> Option<u64> {
        self.ids.iter().position(|known| known == id).map(|agent| agent as u64)
    }

    fn pose(&self, id: u64, secs: f64) -> Option<Pose> {
        let agent = usize::try_from(id).ok()?;
        let Moment { position: [x, y], elevation_m, heading_rad, .. } = self.moment(agent, secs)?;
        let position = [x, elevation_m, -y];
        Some(Pose {
            position,
            heading_rad: heading_rad + FRAC_PI_2,
            eye_m: EYES * self.heights[agent],
        })
    }

    fn describe_ids(&self) -> String {
        let some: Vec<_> = self.ids.iter().take(5).map(String::as_str).collect();
        format!("the file has {} agents, such as {}", self.ids.len(), some.join(", "))
    }
}
