//! Where and when feet stand while people take the footsteps of a file.

use std::collections::HashMap;
use std::sync::Arc;

use libtest_mimic::Failed;
use populace::character::Character;
use populace::model::{JointIndex, Role, RoleMap, Side};
use populace::{Crowd, Device, MemberId};
use populace_cast::Look;
use populace_locomotion::{FootSkate, GaitSpace, SkateMeter};
use populace_scene::{Motions, Person, Replay};
use populace_trajectory::Recording;

const FRAME_SECS: f32 = 0.04;
/// A foot that moves no further than this between two frames lies flat, in metres.
const FLAT_M: f32 = 0.003;
/// A step shorter than this may be left out: nobody lifts a foot for it.
const SHORT_M: f32 = 0.1;

/// A foot that lies flat on the ground.
#[derive(Clone, Copy, Debug)]
struct Plant {
    agent: usize,
    /// 1 for the left foot, -1 for the right one.
    side: f32,
    secs: [f64; 2],
    /// The middle of the sole on the plan.
    at: [f32; 2],
}

/// How people walked.
pub(crate) struct Walked {
    /// Distances in metres between soles and where they should be.
    off_m: Vec<f32>,
    /// The number of steps with no foot down when the body was over it.
    missed: usize,
    skate: FootSkate,
}

/// The joints of a foot, and how far ahead of the ankle and beside the body its middle is.
struct Foot {
    ankle: JointIndex,
    toes: JointIndex,
    side: f32,
    ahead_m: f32,
    aside_m: f32,
}

impl Walked {
    /// Lets people take the footsteps of a recording.
    pub(crate) fn through(recording: &Recording) -> Result<Self, Failed> {
        let device = Device::Native { threads: 1 };
        let mut crowd = Crowd::builder().device(device).capacity(32).build()?;
        let man = Arc::new(populace_cast::person(&Look::man())?);
        let feet = feet(&man).ok_or("no feet")?;
        let character = crowd.add_character(man)?;
        let gaits = GaitSpace::of(&mut crowd, character)?;
        let people = vec![Person { character, scale: 1.0, look: None }; recording.agents.len()];
        let [from, until] = recording.secs();
        let motions = Motions::new(recording);
        let mut replay = Replay::new(recording, motions, &people, vec![gaits], from)?;
        let (mut meter, mut plants, mut down) = (SkateMeter::new(), Vec::new(), HashMap::new());
        replay.advance(&mut crowd, 0.0)?;
        crowd.update(0.0)?;
        while replay.secs() < until {
            replay.advance(&mut crowd, FRAME_SECS)?;
            crowd.update(FRAME_SECS)?;
            let present: Vec<(usize, MemberId)> = replay.present().collect();
            for (agent, member) in present {
                meter.sample(&mut crowd, member, FRAME_SECS)?;
                let places = places(&mut crowd, member, &feet)?;
                for (foot, place) in feet.iter().zip(places) {
                    let now = (replay.secs(), place);
                    follow(&mut plants, &mut down, (agent, foot), now);
                }
            }
        }
        let skate = meter.skate().ok_or("nobody stood")?;
        let (off_m, missed) = compare(recording, replay.motions(), &plants, feet[0].aside_m);
        Ok(Self { off_m, missed, skate })
    }

    /// Expects distances of soles from where they should be below a median and a 95th percentile in
    /// metres, a share of steps missed, and feet that hold.
    pub(crate) fn expect(&self, most_m: [f32; 2], missed: f32) -> Result<(), Failed> {
        let mut off_m = self.off_m.clone();
        off_m.sort_by(f32::total_cmp);
        let steps = off_m.len() + self.missed;
        let of = |percent: usize| off_m.get(off_m.len() * percent / 100).copied();
        let [median, most] = [of(50), of(95)].map(|at| at.unwrap_or(f32::MAX));
        let found = format!(
            "{steps} steps: median {median:.3} m off, 95 % below {most:.3}, {} missed, {:?}",
            self.missed, self.skate
        );
        let few = self.missed as f32 <= missed * steps as f32;
        let holds = self.skate.mean_m_per_sec < 0.02 && self.skate.p95_m_per_sec < 0.08;
        let near = median < most_m[0] && most < most_m[1];
        if near && few && holds { Ok(()) } else { Err(found.into()) }
    }
}

fn feet(character: &Character) -> Option<[Foot; 2]> {
    let skeleton = &character.skeleton;
    let roles = RoleMap::detect(skeleton)?;
    let foot = |side, sign| {
        let (ankle, toes) = (roles.joint(Role::Foot(side))?, roles.joint(Role::Toes(side))?);
        let points = [ankle, toes].into_iter().flat_map(|joint| skeleton.soles(joint));
        let z: Vec<f32> = points.map(|point| point[2]).collect();
        let middle = 0.5
            * (z.iter().copied().fold(f32::MAX, f32::min)
                + z.iter().copied().fold(f32::MIN, f32::max));
        let [x, _, ankle_z] = skeleton.rest_model(ankle).origin();
        Some(Foot { ankle, toes, side: sign, ahead_m: middle - ankle_z, aside_m: x.abs() })
    };
    Some([foot(Side::Left, 1.0)?, foot(Side::Right, -1.0)?])
}

/// Returns ankle and toes of each foot on the plan.
fn places(
    crowd: &mut Crowd,
    member: MemberId,
    feet: &[Foot; 2],
) -> Result<[[[f32; 2]; 2]; 2], Failed> {
    let world = crowd.member(member)?.placement().world_from_model();
    let models = crowd.member_mut(member)?.model_from_joints()?;
    Ok(feet.each_ref().map(|foot| {
        [foot.ankle, foot.toes].map(|joint| {
            let [x, _, z] = world.transform_point(models[joint.index()].origin());
            [x, -z]
        })
    }))
}

/// Ankle and toes of each foot in the last frame, and since when it lies flat.
type Down = HashMap<(usize, bool), ([[f32; 2]; 2], Option<Plant>)>;

/// Follows a foot from frame to frame, and adds it when it has been flat.
fn follow(
    plants: &mut Vec<Plant>,
    down: &mut Down,
    (agent, foot): (usize, &Foot),
    (secs, now): (f64, [[f32; 2]; 2]),
) {
    let apart = |a: [f32; 2], b: [f32; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
    let key = (agent, foot.side > 0.0);
    let (last, mut plant) = down.remove(&key).unwrap_or((now, None));
    if last.iter().zip(now).all(|(last, now)| apart(*last, now) < FLAT_M) {
        let length = apart(now[0], now[1]).max(1e-6);
        let at = [0, 1].map(|axis: usize| {
            now[0][axis] + (now[1][axis] - now[0][axis]) * foot.ahead_m / length
        });
        let from = plant.map_or(secs, |known| known.secs[0]);
        plant = Some(Plant { agent, side: foot.side, secs: [from, secs], at });
    } else {
        plants.extend(plant.take());
    }
    down.insert(key, (now, plant));
}

/// Compares plants with the footsteps of the recording.
fn compare(
    recording: &Recording,
    motions: &Motions,
    plants: &[Plant],
    aside_m: f32,
) -> (Vec<f32>, usize) {
    let (mut off_m, mut missed) = (Vec::new(), 0);
    for (agent, of) in recording.agents.iter().enumerate() {
        let steps = recording.track(of).steps;
        // The first steps begin, and the last end, where nobody is.
        for step in steps.iter().take(steps.len().saturating_sub(2)).skip(2) {
            let [from, to] = step.at;
            let (secs, length) = (step.secs[1], (to[0] - from[0]).hypot(to[1] - from[1]));
            let Some(body) = motions.agents[agent].at(secs) else { continue };
            let (sin, cos) = body.heading_rad.sin_cos();
            let own = plants.iter().filter(|plant| plant.agent == agent);
            let now = own.filter(|plant| plant.secs[0] <= secs && secs <= plant.secs[1]);
            let off = now.map(|plant| {
                let wanted =
                    [to[0] - sin * plant.side * aside_m, to[1] + cos * plant.side * aside_m];
                (plant.at[0] - wanted[0]).hypot(plant.at[1] - wanted[1])
            });
            match off.min_by(f32::total_cmp) {
                Some(off) => off_m.push(off),
                None if length < SHORT_M => {}
                None => missed += 1,
            }
        }
    }
    (off_m, missed)
}
