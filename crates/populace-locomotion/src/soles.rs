//! The soles of a body while it plays clips, sampled through one cycle.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use populace::character::Character;
use populace::clip::Clip;
use populace::{
    Affine, CharacterId, ClipId, ClipPlayback, Crowd, Device, Error, MemberId, Placement,
};

use crate::feet::{Carried, Feet, Leg};
use crate::mix::{MixedClip, cycle_secs};

/// Samples in a second of a cycle.
const SAMPLES_PER_SEC: f32 = 120.0;
/// The fewest and the most samples of a cycle.
const SAMPLES: (f32, f32) = (8.0, 4000.0);
/// Steps of a cycle that are evaluated at once.
const AT_ONCE: usize = 64;
/// Points up to this fraction of the body's height above the lowest stand with it.
const STANDING: f32 = 0.01;

/// One foot at one time. Places are in model space, and move back with the body's travel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SoleSample {
    /// Height of the lowest point of the sole in metres.
    pub(crate) height: f32,
    /// Horizontal velocity of the points that would stand, relative to the body, in metres per
    /// second.
    pub(crate) velocity: Vec2,
    /// Where the points of the sole are along Z relative to where the body would be, and the index
    /// of the lowest.
    pub(crate) points_z: Vec<f32>,
    pub(crate) lowest: usize,
    /// Horizontal place of the ankle relative to where the body would be.
    pub(crate) ankle: Vec2,
    /// Horizontal place of the hip, alike; that of the ankle if it is not known.
    pub(crate) hip: Vec2,
}

/// Heights of the hips in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hips {
    pub(crate) rest_m: f32,
    /// Over the cycle.
    pub(crate) mean_m: f32,
}

/// Both soles through one cycle.
#[derive(Clone, Debug)]
pub(crate) struct Soles {
    pub(crate) duration_secs: f32,
    /// The height of the body at rest, in metres.
    pub(crate) body_height_m: f32,
    /// The horizontal velocity at which the clips carry the body along, in metres per second.
    pub(crate) travel: Vec2,
    /// `None` if the hips are not known, or not above the ground at rest.
    pub(crate) hips: Option<Hips>,
    /// The speed forwards that the clips have on their own skeletons, in metres per second; 0 if it
    /// is not known.
    pub(crate) own_speed: f32,
    /// Evenly spaced samples, left and right.
    pub(crate) feet: [Vec<SoleSample>; 2],
    /// The legs of both feet, if they are known.
    pub(crate) legs: [Option<Leg>; 2],
    /// How far ahead of each point of a sole at rest the middle of the sole is, in metres, left and
    /// right.
    pub(crate) middles_z: [Vec<f32>; 2],
}

/// Where the feet are in one pose, in model space.
struct Pose {
    hips: Option<Vec3>,
    /// Where each leg begins.
    legs: [Option<Vec3>; 2],
    ankles: [Vec3; 2],
    soles: [Vec<Vec3>; 2],
}

/// A body on a treadmill: a crowd of its own, in which each member holds one step of a cycle.
pub(crate) struct Treadmill {
    character: Arc<Character>,
    feet: Feet,
    /// The joints at rest, in model space.
    rest: Vec<Affine>,
    crowd: Crowd,
    id: CharacterId,
    members: Vec<MemberId>,
    /// The clips that it has played.
    clips: Vec<(Arc<Clip>, ClipId)>,
}

impl Soles {
    /// Plays clips on a body and follows its soles. `None` for a body without two feet, and for
    /// clips of which none has a length.
    pub(crate) fn sample(
        character: &Arc<Character>,
        clips: &[MixedClip],
    ) -> Result<Option<Self>, Error> {
        if cycle_secs(clips).is_none() {
            return Ok(None);
        }
        let Some(mut treadmill) = Treadmill::new(character, clips.len())? else { return Ok(None) };
        treadmill.sample(clips)
    }
}

/// Returns the weighted mean speed of clips on their own skeletons.
fn own_speed(clips: &[MixedClip]) -> f32 {
    let weights: f32 = clips.iter().map(|mixed| mixed.weight).sum();
    let speed = |mixed: &MixedClip| mixed.clip.stats().ground_speed_m_per_sec.unwrap_or(0.0);
    clips.iter().map(|mixed| mixed.weight * speed(mixed)).sum::<f32>() / weights
}

impl Treadmill {
    /// Puts a body on a treadmill, where it can play a number of clips at the same time. `None` for
    /// a body without two feet.
    pub(crate) fn new(character: &Arc<Character>, clips: usize) -> Result<Option<Self>, Error> {
        let Some(feet) = Feet::find(character) else { return Ok(None) };
        let mut crowd = Crowd::builder()
            .device(Device::Native { threads: 1 })
            .capacity(AT_ONCE)
            .slots_per_member(clips)
            .build()?;
        let id = crowd.add_character(Arc::clone(character))?;
        let members = crowd.spawn_many(id, &[Placement::at([0.0; 3]); AT_ONCE])?;
        let skeleton = character.skeleton.in_bind_pose();
        let rest = skeleton.joints().map(|joint| skeleton.rest_model(joint)).collect();
        let (character, clips) = (Arc::clone(character), Vec::new());
        Ok(Some(Self { character, feet, rest, crowd, id, members, clips }))
    }

    /// The body.
    pub(crate) fn character(&self) -> &Arc<Character> {
        &self.character
    }

    /// Plays clips and follows the soles. `None` for clips of which none has a length.
    pub(crate) fn sample(&mut self, clips: &[MixedClip]) -> Result<Option<Soles>, Error> {
        let Some(duration_secs) = cycle_secs(clips) else { return Ok(None) };
        let count = (duration_secs * SAMPLES_PER_SEC).ceil().clamp(SAMPLES.0, SAMPLES.1);
        let poses = self.poses(clips, count)?;
        let feet = &self.feet;
        let body_height_m = self.character.height_m();
        let step_secs = duration_secs / count;
        let travel = travel(&poses, duration_secs);
        let hips = feet.hips.as_ref().and_then(|hips| {
            let rest_m =
                self.character.skeleton.in_bind_pose().rest_model(hips.joint()).origin()[1];
            let heights = poses.iter().filter_map(|pose| Some(pose.hips?.y));
            let mean_m = heights.sum::<f32>() / poses.len() as f32;
            (rest_m > 0.0).then_some(Hips { rest_m, mean_m })
        });
        let legs = feet.feet.each_ref().map(|foot| foot.leg);
        let middles_z = feet.feet.each_ref().map(|foot| self.middles_z(&foot.sole));
        let feet = [0, 1].map(|foot| follow(&poses, foot, travel, step_secs, body_height_m));
        let own_speed = own_speed(clips);
        Ok(Some(Soles {
            duration_secs,
            body_height_m,
            travel,
            hips,
            own_speed,
            feet,
            legs,
            middles_z,
        }))
    }

    /// Returns the feet at `count` even steps through the cycle, and at its end.
    fn poses(&mut self, clips: &[MixedClip], count: f32) -> Result<Vec<Pose>, Error> {
        let ids = clips.iter().map(|mixed| self.id_of(&mixed.clip));
        let ids = ids.collect::<Result<Vec<_>, _>>()?;
        let steps: Vec<f32> = (0u16..).map(f32::from).take_while(|step| *step <= count).collect();
        let mut poses = Vec::with_capacity(steps.len());
        for steps in steps.chunks(self.members.len()) {
            for (step, member) in steps.iter().zip(&self.members) {
                let mut member = self.crowd.member_mut(*member)?;
                for (nth, (mixed, clip)) in clips.iter().zip(&ids).enumerate() {
                    let held = ClipPlayback::held_at_secs(mixed.secs_at(step / count));
                    let held = held.weight(mixed.weight);
                    // The first takes the place of those of the step before.
                    if nth == 0 {
                        member.play(*clip, held)?
                    } else {
                        member.blend(*clip, held)?
                    };
                }
            }
            self.crowd.update(0.0)?;
            for member in &self.members[..steps.len()] {
                let models = self.crowd.member_mut(*member)?.model_from_joints()?;
                poses.push(pose(&self.feet, &models));
            }
        }
        Ok(poses)
    }

    /// Returns how far ahead of points at rest the middle between them is, in metres.
    fn middles_z(&self, points: &[Carried]) -> Vec<f32> {
        let at_rest = |point: &Carried| point.place(&self.rest).z;
        let low = points.iter().map(at_rest).fold(f32::INFINITY, f32::min);
        let high = points.iter().map(at_rest).fold(f32::NEG_INFINITY, f32::max);
        points.iter().map(|point| 0.5 * (low + high) - at_rest(point)).collect()
    }

    fn id_of(&mut self, clip: &Arc<Clip>) -> Result<ClipId, Error> {
        let known = self.clips.iter().find(|(known, _)| Arc::ptr_eq(known, clip));
        if let Some((_, id)) = known {
            return Ok(*id);
        }
        let id = self.crowd.character_mut(self.id)?.add_clip(clip)?;
        self.clips.push((Arc::clone(clip), id));
        Ok(id)
    }
}

fn pose(feet: &Feet, model_from_joints: &[Affine]) -> Pose {
    let place = |point: &Carried| point.place(model_from_joints);
    Pose {
        hips: feet.hips.as_ref().map(place),
        legs: feet.feet.each_ref().map(|foot| foot.leg.map(|leg| place(&leg.hip))),
        ankles: feet.feet.each_ref().map(|foot| place(&foot.ankle)),
        soles: feet.feet.each_ref().map(|foot| foot.sole.iter().map(place).collect()),
    }
}

/// Returns the horizontal velocity at which the cycle carries the body along: that of the hips or
/// an ankle from start to end, whichever moves least. A cycle that does not close moves a foot, and
/// one that ends seated moves the hips, but only one that travels moves all.
fn travel(poses: &[Pose], duration_secs: f32) -> Vec2 {
    let (Some(first), Some(last)) = (poses.first(), poses.last()) else { return Vec2::ZERO };
    let ankles = [0, 1].map(|foot| last.ankles[foot] - first.ankles[foot]);
    let hips = last.hips.zip(first.hips).map(|(last, first)| last - first);
    let moved = hips.into_iter().chain(ankles).map(|moved| Vec2::new(moved.x, moved.z));
    let least = moved.min_by(|a, b| a.length().total_cmp(&b.length()));
    least.unwrap_or_default() / duration_secs
}

/// Follows one foot through all poses; the last pose only ends the last step.
fn follow(
    poses: &[Pose],
    foot: usize,
    travel: Vec2,
    step_secs: f32,
    body_height_m: f32,
) -> Vec<SoleSample> {
    let sample = |(nth, pair): (u16, &[Pose])| {
        let now = &pair[0].soles[foot];
        let height = now.iter().map(|at| at.y).fold(f32::INFINITY, f32::min);
        let stands = |at: &Vec3| at.y <= height + STANDING * body_height_m;
        let (mut moved, mut standing) = (Vec3::ZERO, 0.0);
        for (now, then) in now.iter().zip(&pair[1].soles[foot]).filter(|(now, _)| stands(now)) {
            moved += *then - *now;
            standing += 1.0;
        }
        let velocity = Vec2::new(moved.x, moved.z) / (standing * step_secs) - travel;
        let lowest = (0..now.len()).min_by(|a, b| now[*a].y.total_cmp(&now[*b].y)).unwrap_or(0);
        let place = |at: Vec3| Vec2::new(at.x, at.z) - travel * step_secs * f32::from(nth);
        let points_z = now.iter().map(|at| place(*at).y).collect();
        let ankle = place(pair[0].ankles[foot]);
        let hip = pair[0].legs[foot].map_or(ankle, place);
        SoleSample { height, velocity, points_z, lowest, ankle, hip }
    };
    (0u16..).zip(poses.windows(2)).map(sample).collect()
}
