//! A scene in a crowd, and the cameras that film it.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use glam::{Quat, Vec3};
use populace::character::Character;
use populace::{Crowd, MemberId};
use populace_render::Camera;
use populace_scene::{Behaviours, Counts, EYES, Person, Stage};

use super::cast::{casts, dress, players, walks};
use super::past::Past;
use super::{SceneSource, clips};
use crate::camera::{Cameras, Pose, Subject, View, figure};
use crate::failure::Failure;
use crate::frame_loop::{Action, in_foot_steps};
use crate::people::eyes;
use crate::roles::LoadedRoles;

/// Half the width of a person in metres, for framing.
const HALF_M: f32 = 0.4;
/// A scene in a crowd.
pub(super) struct LiveScene {
    behaviours: Behaviours,
    stage: Stage,
    people: Vec<MemberId>,
    numbers: HashMap<MemberId, u64>,
    /// Positions, headings and heights of the eyes of people.
    poses: Past,
    eyes_m: Vec<f32>,
    /// The person that the camera goes with.
    filmed: Option<usize>,
    /// Its eyes; `None` before they were evaluated.
    eyes: Option<Eyes>,
    /// Corners of the boxes around things.
    things: Vec<[f32; 3]>,
}

/// The eyes of a person after an evaluation.
#[derive(Clone, Copy)]
struct Eyes {
    /// The person, or the vehicle that carries it.
    on: MemberId,
    /// Where they are from there, in metres along its axes.
    from_there_m: Vec3,
}

impl LiveScene {
    /// Brings the props and people of a scene into a crowd.
    pub(super) fn new(
        crowd: &mut Crowd,
        source: &SceneSource<'_>,
    ) -> Result<(Self, LoadedRoles), Failure> {
        let (plan, args) = (&source.plan, source.picture);
        let (casts, mut files) = casts(crowd, source)?;
        let props = source.prop_files(&mut files)?;
        let levels = !args.full_detail;
        let prepare = |character: Character| {
            let wanted = levels && character.levels().is_empty();
            let character = if wanted { populace_lod::with_levels(character)? } else { character };
            Ok(Arc::new(character))
        };
        let stage = Stage::new(crowd, plan, &props, &prepare)?;
        let things = things(crowd)?;
        let gaits = walks(crowd, plan, &casts)?;
        clips::check(crowd, source, |cast| casts.get(cast).map_or(&[][..], Vec::as_slice))?;
        let players = players(source, &casts);
        let people: Vec<Vec<Person>> = players.iter().map(|of| of.people(&casts)).collect();
        let behaviours = Behaviours::new(crowd, plan, &stage, &people, gaits)?;
        if source.file.is_some() {
            source.warn(behaviours.doubts(plan));
        }
        let people: Vec<MemberId> = behaviours.people().collect();
        dress(crowd, &players, &casts, &people)?;
        let mut eyes_m = Vec::new();
        for member in &people {
            let view = crowd.member(*member)?;
            let height = crowd.character(view.character())?.asset().height_m();
            eyes_m.push(EYES * height * view.placement().scale());
        }
        source.announce(crowd, people.len());
        let roles = casts.into_values().flatten().collect();
        let numbers = people.iter().copied().zip(0..).collect();
        let mut scene = Self {
            numbers,
            behaviours,
            stage,
            people,
            poses: Past::default(),
            eyes_m,
            filmed: None,
            eyes: None,
            things,
        };
        scene.note_poses(crowd, 0.0)?;
        Ok((scene, LoadedRoles { roles, files }))
    }

    /// Notes where people have moved to, `secs` after the last time. Until they are evaluated, the
    /// eyes of the person that the camera goes with have moved with its body or its vehicle.
    fn note_poses(&mut self, crowd: &Crowd, secs: f64) -> Result<(), Failure> {
        let mut poses = Vec::with_capacity(self.people.len());
        for (member, eye_m) in self.people.iter().zip(&self.eyes_m) {
            let placement = crowd.member(*member)?.placement();
            let (position, heading_rad) = (placement.position(), placement.yaw_rad());
            poses.push(Pose { position, heading_rad, eye_m: *eye_m });
        }
        self.poses.pass(secs, poses);
        if let Some(Eyes { on, from_there_m }) = self.eyes {
            let placement = crowd.member(on)?.placement();
            let turn = Quat::from_rotation_y(placement.yaw_rad());
            self.see_from(Vec3::from(placement.position()) + turn * from_there_m);
        }
        Ok(())
    }

    /// Notes where the eyes of the person that the camera goes with are, after an evaluation.
    fn note_eyes(&mut self, crowd: &mut Crowd) -> Result<(), Failure> {
        let Some(member) = self.filmed.and_then(|nth| self.people.get(nth).copied()) else {
            return Ok(());
        };
        if let Some(eyes) = eyes(crowd, member)? {
            self.see_from(eyes);
            let on = crowd.member(member)?.attached_to().map_or(member, |(vehicle, _)| vehicle);
            let placement = crowd.member(on)?.placement();
            let back = Quat::from_rotation_y(-placement.yaw_rad());
            let from_there_m = back * (eyes - Vec3::from(placement.position()));
            self.eyes = Some(Eyes { on, from_there_m });
        }
        Ok(())
    }

    /// Puts the person that the camera goes with below its eyes: who sits, rides or lies sees from
    /// elsewhere than over its placement.
    fn see_from(&mut self, eyes: Vec3) {
        if let Some(pose) = self.filmed.and_then(|nth| self.poses.now.get_mut(nth)) {
            pose.position = (eyes - pose.eye_m * Vec3::Y).to_array();
        }
    }
}

/// Returns the corners of the boxes around all members at rest.
fn things(crowd: &Crowd) -> Result<Vec<[f32; 3]>, Failure> {
    let mut points = Vec::new();
    for member in crowd.members() {
        let Some(around) = crowd.character(member.character())?.asset().rest_bounds() else {
            continue;
        };
        let world_from_model = member.placement().world_from_model();
        let sides = [around.low, around.high];
        points.extend((0..8).map(|corner: usize| {
            let axis = |axis: usize| sides[corner >> axis & 1][axis];
            world_from_model.transform_point([axis(0), axis(1), axis(2)])
        }));
    }
    Ok(points)
}

impl Subject for LiveScene {
    /// The people; without any, the things.
    fn bounds(&self) -> Vec<[f32; 3]> {
        if self.poses.now.is_empty() {
            return self.things.clone();
        }
        let around = |pose: &Pose| figure(pose.position, [pose.eye_m / EYES, HALF_M]);
        self.poses.now.iter().flat_map(around).collect()
    }

    fn elevation_rad(&self) -> Option<f32> {
        Some(0.5)
    }

    fn figure_m(&self) -> [f32; 2] {
        [self.eyes_m.iter().copied().fold(0.0, f32::max) / EYES, HALF_M]
    }

    fn closest(&self) -> Option<u64> {
        (!self.poses.now.is_empty()).then_some(0)
    }

    /// The pose of the last step, whatever the time: nobody knows where people will walk.
    fn pose(&self, id: u64, _secs: f64) -> Option<Pose> {
        self.poses.now.get(usize::try_from(id).ok()?).copied()
    }

    fn describe_ids(&self) -> String {
        format!("people have the numbers from 0 to {}", self.poses.now.len().saturating_sub(1))
    }
}

/// A scene and the cameras that film it.
pub(super) struct FilmedScene {
    live: LiveScene,
    view: View,
    /// `None` before the aspect of pictures is known.
    cameras: Option<Cameras>,
    behave_ms: f64,
    /// The scene before frame 0.
    #[cfg(feature = "viewer")]
    first: (Behaviours, Stage),
}

impl FilmedScene {
    pub(super) fn new(mut live: LiveScene, view: View) -> Self {
        live.filmed = match &view {
            View::Follow { id } | View::Eye { id } => id.parse().ok(),
            _ => None,
        };
        #[cfg(feature = "viewer")]
        let first = (live.behaviours.clone(), live.stage.clone());
        Self {
            live,
            view,
            cameras: None,
            behave_ms: 0.0,
            #[cfg(feature = "viewer")]
            first,
        }
    }

    fn step(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        let start = Instant::now();
        self.live.behaviours.advance(crowd, secs)?;
        self.live.stage.light(crowd, self.live.behaviours.lights())?;
        self.behave_ms += start.elapsed().as_secs_f64() * 1e3;
        self.live.note_poses(crowd, f64::from(secs))
    }

    /// The things that have happened.
    pub(super) fn counts(&self) -> Counts {
        self.live.behaviours.counts()
    }
}

impl Action for FilmedScene {
    fn set_aspect(&mut self, aspect: f32) -> Result<(), Failure> {
        self.cameras = Some(Cameras::new(&self.view, &self.live, aspect)?);
        Ok(())
    }

    fn behave(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f32, Failure> {
        in_foot_steps(self, crowd, secs, Self::step)
    }

    fn evaluate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        crowd.update(secs)?;
        self.live.note_eyes(crowd)
    }

    fn take_behave_ms(&mut self) -> f64 {
        std::mem::take(&mut self.behave_ms)
    }

    fn cameras(&self) -> Option<&Cameras> {
        self.cameras.as_ref()
    }

    fn camera(&self, secs: f64) -> Result<Camera, Failure> {
        let Some(cameras) = &self.cameras else { return Ok(Camera::default()) };
        let way = cameras.person().and_then(|id| self.live.poses.way(id));
        let poses = |at| way.as_ref().map(|way| way.before(secs - at));
        Ok(cameras.at(&poses, secs))
    }

    fn ground_m(&self, [x, z]: [f32; 2]) -> Option<f32> {
        Some(self.live.stage.ground().height_at(x, z))
    }

    fn person(&self, member: MemberId) -> Option<u64> {
        self.live.numbers.get(&member).copied()
    }
}

#[cfg(feature = "viewer")]
impl crate::watched::Watched for FilmedScene {
    fn rewind(&mut self) {
        (self.live.behaviours, self.live.stage) = self.first.clone();
        self.live.poses.forget();
        self.live.eyes = None;
    }

    fn leads_members(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests;
