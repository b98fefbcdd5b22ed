//! Agents of a recording, as cameras see them.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;

use populace_render::Camera;
use populace_scene::{EYES, Moment, Motion, Motions};
use populace_trajectory::Recording;

use super::place::floor_m;
use crate::camera::{Pose, Subject, figure, rectangle};
use crate::failure::Failure;
use crate::frames::single;

/// Seconds between positions that the camera frames.
const FRAMED_SECS: f64 = 1.0;
/// Places whose longer side is greater are framed where most people are: the side of a square, in
/// metres.
const LARGEST_M: f32 = 120.0;
const SQUARE_M: f32 = 40.0;
/// Height and half the width of a person in metres, for framing.
const FIGURE_M: [f32; 2] = [1.8, 0.3];
/// The agents of a recording.
pub(super) struct Agents {
    motions: Motions,
    ids: Vec<String>,
    /// Heights of bodies in metres.
    heights: Vec<f32>,
    from_secs: f64,
    /// Corners of the walkable area, at the feet and the tops of its walls.
    place: Vec<[f32; 3]>,
}

impl Agents {
    /// Returns the agents in a place whose walls have a height in metres.
    pub(super) fn new(
        recording: &Recording,
        motions: Motions,
        heights: Vec<f32>,
        walls_m: f64,
    ) -> Self {
        let ids = recording.agents.iter().map(|agent| agent.id.clone()).collect();
        let place = corners(recording, single(walls_m));
        Self { motions, ids, heights, from_secs: recording.secs()[0], place }
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

impl Agents {
    /// Returns the pose of an agent at a time, for a camera at another time that averages its way,
    /// both in seconds since frame 0. The camera cuts where the agent jumps.
    pub(super) fn pose_around(&self, id: u64, secs: f64, now_secs: f64) -> Option<Pose> {
        let agent = usize::try_from(id).ok()?;
        let motion = self.motions.agents.get(agent)?;
        let Some([from, until]) = motion.unbroken(self.from_secs + now_secs) else {
            return self.pose(id, secs);
        };
        let at = (self.from_secs + secs).min(until.next_down()).max(from);
        Some(self.pose_of(agent, motion.at(at)?))
    }

    fn pose_of(&self, agent: usize, at: Moment) -> Pose {
        let Moment { position: [x, y], elevation_m, heading_rad, .. } = at;
        let (position, heading_rad) = ([x, elevation_m, -y], heading_rad + FRAC_PI_2);
        Pose { position, heading_rad, eye_m: EYES * self.heights[agent] }
    }

    /// Returns whether somebody is seen in one of the pictures of a size that cameras take at times
    /// in seconds since frame 0, in order.
    pub(super) fn are_seen(
        &self,
        cameras: impl IntoIterator<Item = Result<(f64, Camera), Failure>>,
        size: [u32; 2],
    ) -> Result<bool, Failure> {
        let mut present = Present::new(&self.motions);
        for camera in cameras {
            let (secs, camera) = camera?;
            let secs = self.from_secs + secs;
            if present.at(secs).any(|agent| self.is_seen(agent, secs, &camera, size)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns whether a camera sees an agent at a time in seconds, in a picture of a size.
    fn is_seen(&self, agent: usize, secs: f64, camera: &Camera, size: [u32; 2]) -> bool {
        let [width, height] = size.map(f64::from);
        let is_within = |[from, to]: [[f64; 2]; 2]| {
            from[0] < width && to[0] > 0.0 && from[1] < height && to[1] > 0.0
        };
        let now = self.motions.agents[agent].at(secs);
        now.is_some_and(|Moment { position: [x, y], elevation_m, .. }| {
            let points = figure([x, elevation_m, -y], [self.heights[agent], FIGURE_M[1]]);
            rectangle(camera, &points, size).is_some_and(is_within)
        })
    }
}

/// The agents that are there at times in order. All others are passed over, since long recordings
/// have many more agents than are there together.
struct Present {
    /// Times in seconds from when and until when agents are there, and the agents. Who comes first
    /// is last.
    to_come: Vec<([f64; 2], usize)>,
    /// The times until which agents stay, and the agents.
    there: Vec<(f64, usize)>,
}

impl Present {
    fn new(motions: &Motions) -> Self {
        let motions = motions.agents.iter().enumerate();
        let spans =
            motions.flat_map(|(agent, motion)| motion.secs().map(move |secs| (secs, agent)));
        let mut to_come: Vec<_> = spans.collect();
        to_come.sort_by(|(a, _), (b, _)| b[0].total_cmp(&a[0]));
        Self { to_come, there: Vec::new() }
    }

    /// Goes on to a time in seconds. Returns the agents that are there.
    fn at(&mut self, secs: f64) -> impl Iterator<Item = usize> {
        let first_later = self.to_come.partition_point(|([from, _], _)| *from > secs);
        let come = self.to_come.drain(first_later..).map(|([_, until], agent)| (until, agent));
        self.there.extend(come);
        self.there.retain(|(until, _)| secs <= until + Motion::PAST_SECS);
        self.there.iter().map(|(_, agent)| *agent)
    }
}

impl Subject for Agents {
    fn bounds(&self) -> Vec<[f32; 3]> {
        let height_m = self.heights.iter().copied().reduce(f32::max).unwrap_or(FIGURE_M[0]);
        let around = |Moment { position: [x, y], elevation_m, .. }: Moment| {
            figure([x, elevation_m, -y], [height_m, FIGURE_M[1]])
        };
        let ways = self.motions.agents.iter().flat_map(|motion| {
            motion.secs().flat_map(move |[from, until]| {
                let times = (0_u32..).map(move |nth| from + f64::from(nth) * FRAMED_SECS);
                let times = times.take_while(move |secs| *secs < until).chain([until]);
                times.filter_map(|secs| motion.at(secs))
            })
        });
        busiest(ways.collect()).into_iter().flat_map(around).collect()
    }

    fn place(&self) -> Vec<[f32; 3]> {
        self.place.clone()
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
        Some(self.pose_of(agent, self.moment(agent, secs)?))
    }

    fn describe_ids(&self) -> String {
        let some: Vec<_> = self.ids.iter().take(5).map(String::as_str).collect();
        format!("the file has {} agents, such as {}", self.ids.len(), some.join(", "))
    }
}

/// Returns the corners of the outlines of the walkable areas of all times, at the floor and at a height
/// above it. The place is one that can be built.
fn corners(recording: &Recording, walls_m: f32) -> Vec<[f32; 3]> {
    let floor_m = floor_m(recording);
    let areas = recording.place.changes.iter().flat_map(|change| &change.walkable);
    let corners = areas.flat_map(|area| &area.outline).map(|at| at.map(single));
    corners.flat_map(|[x, y]| [[x, floor_m, -y], [x, floor_m + walls_m, -y]]).collect()
}

/// Returns the moments in the busiest square of a place that is too large to see people in it; all of
/// them elsewhere.
fn busiest(moments: Vec<Moment>) -> Vec<Moment> {
    let side = |axis: usize| {
        let along = moments.iter().map(|moment| moment.position[axis]);
        along.clone().fold(f32::MIN, f32::max) - along.fold(f32::MAX, f32::min)
    };
    if side(0).max(side(1)) <= LARGEST_M {
        return moments;
    }
    #[expect(clippy::cast_possible_truncation, reason = "within some kilometres")]
    let square = |moment: &Moment| moment.position.map(|v| (v / SQUARE_M).floor() as i32);
    let mut counts: BTreeMap<[i32; 2], usize> = BTreeMap::new();
    for moment in &moments {
        *counts.entry(square(moment)).or_default() += 1;
    }
    let most = counts.iter().max_by_key(|(_, count)| **count).map(|(square, _)| *square);
    moments.into_iter().filter(|moment| Some(square(moment)) == most).collect()
}

#[cfg(test)]
mod tests {
    use populace_trajectory::{PlaceChange, Polygon};

    use super::*;

    fn at(x: f32, y: f32) -> Moment {
        let (velocity, heading_rad, elevation_m) = ([0.0; 2], 0.0, 0.0);
        Moment {
            position: [x, y],
            velocity,
            heading_rad,
            elevation_m,
            view_rad: None,
            stands: false,
        }
    }

    #[test]
    fn the_place_has_the_corners_of_areas_and_walls() {
        let text = "id,t,x,y,z\n1,0,0,0,2\n1,1,1,0,2\n";
        let settings = populace_trajectory::ReadSettings::default();
        let mut recording =
            populace_trajectory::parse("rows.csv".as_ref(), text.into(), &settings).expect("rows");
        assert_eq!(corners(&recording, 0.5), [[0.0; 3]; 0]);
        let polygon = |outline: [[f64; 2]; 3]| Polygon { outline: outline.into(), holes: vec![] };
        let walkable = vec![
            polygon([[-3.0, 0.0], [9.0, 0.0], [9.0, 5.0]]),
            polygon([[0.0, 0.0], [1e9, 0.0], [0.0, f64::NAN]]),
        ];
        recording.place.changes = vec![PlaceChange { from_secs: 0.0, walkable }];
        recording.place = populace_scene::PlaceModel::buildable(&recording.place).0;
        let wanted = [[-3.0, 2.0, 0.0], [-3.0, 2.5, 0.0], [9.0, 2.0, 0.0], [9.0, 2.5, 0.0]];
        let found = corners(&recording, 0.5);
        assert_eq!((found.len(), &found[..4]), (6, &wanted[..]));
        assert_eq!(found[5], [9.0, 2.5, -5.0]);
    }

    #[test]
    fn cameras_cut_where_people_jump() {
        let mut text = "id,t,x/m,y/m\n".to_owned();
        for tenth in 0_u8..40 {
            let (x, y) = if tenth < 20 { (0.0, 0.0) } else { (30.0, 9.0) };
            text += &format!("1,{},{},{y}\n", f32::from(tenth) / 10.0, x + f32::from(tenth) / 10.0);
        }
        let settings = populace_trajectory::ReadSettings::default();
        let recording =
            populace_trajectory::parse("rows.csv".as_ref(), text.into(), &settings).expect("rows");
        let agents = Agents::new(&recording, Motions::new(&recording), vec![1.8], 0.6);
        let view = crate::camera::View::Follow { id: "1".into() };
        let cameras = crate::camera::Cameras::new(&view, &agents, 1.5).expect("a camera");
        let eye_x = |secs: f64| {
            let poses = |at| agents.pose_around(0, at, secs);
            cameras.at(&poses, secs).eye[0]
        };
        for (secs, wanted) in [(1.3, -2.4), (1.9, -1.8), (2.0, 28.3), (2.6, 28.9)] {
            assert!((eye_x(secs) - wanted).abs() < 0.6, "{secs}: {}, not {wanted}", eye_x(secs));
        }
    }

    #[test]
    fn only_agents_that_are_there_are_looked_for() {
        let row = |agent: u32, secs: u32| format!("{agent},{secs},{secs},{agent}\n");
        let stay = |agent: u32| [0, 1, 2, 30, 31].map(|after| row(agent, agent + after)).concat();
        let rows: String = (0..40).map(stay).collect();
        let text = format!("id,t,x,y\n{rows}");
        let settings = populace_trajectory::ReadSettings::default();
        let recording =
            populace_trajectory::parse("rows.csv".as_ref(), text.into(), &settings).expect("rows");
        let motions = Motions::new(&recording);
        let mut present = Present::new(&motions);
        let mut most = 0;
        for secs in (0..160_u32).map(|half| f64::from(half) / 2.0) {
            let mut found: Vec<usize> = present.at(secs).collect();
            found.sort_unstable();
            let are_there = (0..40).filter(|agent| motions.agents[*agent].at(secs).is_some());
            assert_eq!(found, are_there.collect::<Vec<_>>(), "{secs} s");
            most = most.max(found.len());
        }
        assert!((4..9).contains(&most), "{most} at a time");
    }

    #[test]
    fn large_places_are_framed_where_most_people_are() {
        let near = vec![at(0.0, 0.0), at(60.0, 40.0)];
        assert_eq!(busiest(near.clone()), near);
        let far = vec![at(5.0, 5.0), at(905.0, 410.0), at(910.0, 415.0), at(-300.0, 0.0)];
        assert_eq!(busiest(far.clone()), far[1..3]);
        assert_eq!(busiest(Vec::new()), []);
    }
}
