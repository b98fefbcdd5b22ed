//! People who follow the trajectories of a recording.

mod floor;

use std::f32::consts::FRAC_PI_2;

use populace::MemberLook;
use populace::model::{Role, RoleMap};
use populace::{CharacterId, Crowd, MemberId, Placement};
use populace_locomotion::{GaitSpace, Lead, WalkerSettings, Walkers};
use populace_trajectory::Recording;

use crate::Error;
use crate::footsteps::led_step;
use crate::gaze::{EYES, Gazes, Somebody};
use crate::motion::{Moment, Motion, Motions};

/// The part of a cycle by which neighbouring agents step apart: the golden ratio spreads them
/// evenly.
const PHASES: f64 = 0.618_033_988_749_895;

/// The part of a step for which feet of people who come have been down when the body is over them,
/// until it is known.
const FROM_TOUCH_DOWN: f32 = 0.5;

/// Seconds in which people fade in and out.
const FADE_SECS: f64 = 0.4;

/// The body of an agent.
#[derive(Clone, Copy, Debug)]
pub struct Person {
    /// Its character in the crowd, which has gaits.
    pub character: CharacterId,
    /// Its scale.
    pub scale: f32,
    /// Its look, unless that of its character.
    pub look: Option<MemberLook>,
}

/// Distances of people from the data in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionError {
    /// The largest distance from the filtered data, in all frames so far. Heights count.
    pub max_m: f32,
    /// The largest distance from the rows at their own times. Heights count.
    pub max_raw_m: f32,
}

/// People who follow the trajectories of a recording. The plan's x is the world's X, and its y is
/// -Z.
///
/// All its state depends on the times of its updates alone: frames that are reached by equal steps
/// are equal.
#[derive(Clone, Debug)]
pub struct Replay {
    motions: Motions,
    people: Vec<Person>,
    walkers: Walkers,
    /// The agents of the walkers, in their order.
    agents: Vec<usize>,
    /// Where those agents are now.
    moments: Vec<Moment>,
    /// The opacities that their members have.
    opacities: Vec<f32>,
    /// The weights at which their feet are planted, in steps.
    planted: Vec<u8>,
    /// The elevation of the floor on which feet are planted, in metres.
    floor_m: f32,
    /// The times in seconds at which agents come or jump, in order, and how many of them are past.
    arrivals: Vec<(f64, usize)>,
    arrived: usize,
    present: Vec<bool>,
    leads: Vec<Lead>,
    gazes: Gazes,
    /// The people present, in the order of agents.
    somebodies: Vec<Somebody>,
    /// Heights of the eyes above the ground in metres, by agent; 0 for bodies that cannot look.
    eyes_m: Vec<f32>,
    /// The same at the scale of 1, of the characters that have come.
    eyes_of: Vec<(CharacterId, f32)>,
    /// When the recording begins and ends.
    all_secs: [f64; 2],
    secs: f64,
    error: PositionError,
}

impl Replay {
    /// Leads one person through the motion of each agent. The replay stands at a time in seconds,
    /// with nobody there. [`advance`](Self::advance) by 0 brings the people
    /// of that time.
    ///
    /// # Errors
    ///
    /// [`Error::UnequalLengths`] unless there are as many people as agents.
    pub fn new(
        recording: &Recording,
        motions: Motions,
        people: &[Person],
        gaits: Vec<GaitSpace>,
        secs: f64,
    ) -> Result<Self, Error> {
        let agents = recording.agents.len();
        if people.len() != agents {
            return Err(Error::UnequalLengths { people: people.len(), agents });
        }
        let mut walkers = Walkers::new(WalkerSettings::default())?;
        gaits.into_iter().for_each(|gaits| walkers.add_gaits(gaits));
        let max_raw_m = max_raw_m(recording, &motions);
        let spans = motions.agents.iter().enumerate();
        let mut arrivals: Vec<(f64, usize)> =
            spans.flat_map(|(agent, of)| of.begins().map(move |from| (from, agent))).collect();
        arrivals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        Ok(Self {
            motions,
            people: people.to_vec(),
            walkers,
            agents: Vec::new(),
            moments: Vec::new(),
            opacities: Vec::new(),
            planted: Vec::new(),
            floor_m: floor::floor_m(recording),
            arrivals,
            arrived: 0,
            present: vec![false; agents],
            leads: Vec::new(),
            gazes: Gazes::new(agents),
            somebodies: Vec::new(),
            eyes_m: vec![0.0; agents],
            eyes_of: Vec::new(),
            all_secs: recording.secs(),
            secs,
            error: PositionError { max_m: 0.0, max_raw_m },
        })
    }

    /// Moves on by `secs`: people appear, walk and leave. Call [`Crowd::update`] with the same time
    /// afterwards.
    ///
    /// # Errors
    ///
    /// Errors of the crowd, such as one without capacity for all people who are there at the same
    /// time.
    pub fn advance(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Error> {
        let before_secs = self.secs;
        self.secs += f64::from(secs);
        self.leave(crowd, before_secs)?;
        // Before the walkers set strides, which hold while feet are planted.
        self.plant(crowd)?;
        self.leads.clear();
        let people = self.agents.iter().zip(&self.moments).zip(self.walkers.members());
        for ((agent, moment), member) in people {
            let motion = &self.motions.agents[*agent];
            let step = match motion.steps() {
                [] => None,
                _ => led_step(motion, self.secs, self.walkers.steps_from_touch_down(*member)?),
            };
            self.leads.push(Lead { step, ..lead(motion, moment, self.secs) });
        }
        self.walkers.follow(crowd, &self.leads, secs)?;
        self.appear(crowd)?;
        self.plant(crowd)?;
        self.gaze(crowd, secs)?;
        self.fade(crowd)?;
        self.measure(crowd)
    }

    /// The time in seconds, as the recording counts it.
    #[must_use]
    pub fn secs(&self) -> f64 {
        self.secs
    }

    /// The smoothed motions.
    #[must_use]
    pub fn motions(&self) -> &Motions {
        &self.motions
    }

    /// The people who are there: agents and members.
    pub fn present(&self) -> impl Iterator<Item = (usize, MemberId)> + '_ {
        self.agents.iter().copied().zip(self.walkers.members().iter().copied())
    }

    /// Returns the agent whose person is a member; `None` for a member that is no person who is
    /// there.
    #[must_use]
    pub fn agent_of(&self, member: MemberId) -> Option<usize> {
        self.agents.get(self.walkers.index(member)?).copied()
    }

    /// Returns the part of an agent's person that is seen, from 0 to 1: people fade in when they
    /// come and out before they leave.
    #[must_use]
    pub fn opacity(&self, agent: usize) -> f32 {
        let Some(motion) = self.motions.agents.get(agent) else { return 0.0 };
        let Some([from, until]) = motion.secs_around(self.secs) else { return 0.0 };
        // Somebody who is gone before having faded in would hardly be seen.
        if until - from < FADE_SECS {
            return 1.0;
        }
        // Nobody comes when the recording begins, or leaves when it ends.
        let [first, last] = self.all_secs;
        let since = if from > first { self.secs - from + FADE_SECS / 8.0 } else { FADE_SECS };
        let left = if until < last { until - self.secs } else { FADE_SECS };
        #[expect(clippy::cast_possible_truncation, reason = "from 0 to 1")]
        let part = (since.min(left) / FADE_SECS).clamp(0.0, 1.0) as f32;
        part
    }

    /// The elevation at which most rows of people are, in metres: that of the level ground which
    /// the crowd needs ([`Crowd::set_ground`]). Feet are planted on it. Feet of people who are more
    /// than 2 centimetres above or below are planted with less weight, and from 10 centimetres on
    /// they follow their clips, at the height of their person.
    #[must_use]
    pub fn floor_m(&self) -> f32 {
        self.floor_m
    }

    /// Returns the distances of people from the data.
    #[must_use]
    pub fn position_error(&self) -> PositionError {
        self.error
    }

    /// Measures how far people are from the filtered data.
    fn measure(&mut self, crowd: &Crowd) -> Result<(), Error> {
        let people = self.agents.iter().zip(&self.moments).zip(self.walkers.members());
        for ((agent, moment), member) in people {
            let Some([x, y]) = self.motions.agents[*agent].filtered_at(self.secs) else { continue };
            let at = crowd.member(*member)?.placement().position();
            let off = distance([at[0] - x, at[2] + y, at[1] - moment.elevation_m]);
            self.error.max_m = self.error.max_m.max(off);
        }
        Ok(())
    }

    /// Finds where agents are, and takes people from the crowd whose agents have left since a time.
    /// People who jump leave too, and [appear](Self::appear) at the new place: no foot stays at the
    /// old one.
    fn leave(&mut self, crowd: &mut Crowd, since_secs: f64) -> Result<(), Error> {
        let mut index = 0;
        while let Some(agent) = self.agents.get(index).copied() {
            let motion = &self.motions.agents[agent];
            let has_stayed = motion.unbroken(self.secs).is_some_and(|[from, _]| from <= since_secs);
            if let Some(moment) = motion.at(self.secs).filter(|_| has_stayed) {
                self.moments[index] = moment;
                index += 1;
                continue;
            }
            let member = self.walkers.members()[index];
            self.walkers.remove(member)?;
            crowd.despawn(member)?;
            self.agents.swap_remove(index);
            self.moments.swap_remove(index);
            self.opacities.swap_remove(index);
            self.planted.swap_remove(index);
            self.present[agent] = false;
            self.gazes.forget(agent);
        }
        Ok(())
    }

    /// Brings people into the crowd whose agents have come.
    fn appear(&mut self, crowd: &mut Crowd) -> Result<(), Error> {
        let past = self.arrivals.partition_point(|(from, _)| *from <= self.secs);
        let mut come: Vec<usize> =
            self.arrivals[self.arrived..past].iter().map(|(_, agent)| *agent).collect();
        self.arrived = past;
        come.sort_unstable();
        for agent in come {
            // Somebody may come and jump within one step.
            if self.present[agent] {
                continue;
            }
            let (motion, person) = (&self.motions.agents[agent], self.people[agent]);
            let Some(moment) = motion.at(self.secs) else { continue };
            let step = led_step(motion, self.secs, FROM_TOUCH_DOWN);
            let lead = Lead { step, ..lead(motion, &moment, self.secs) };
            let [x, z] = lead.position;
            let placement =
                Placement::at([x, lead.height_m, z]).facing(lead.yaw_rad).scaled(person.scale);
            let member = crowd.spawn(person.character, placement)?;
            #[expect(clippy::cast_possible_truncation, reason = "below 1")]
            let phase = (agent as f64 * PHASES).fract() as f32;
            self.walkers.add_led(crowd, member, &lead, phase)?;
            self.agents.push(agent);
            self.moments.push(moment);
            self.opacities.push(f32::NAN);
            self.planted.push(floor::STEPS);
            self.present[agent] = true;
            self.eyes_m[agent] = person.scale * self.eye_m(crowd, person.character)?;
        }
        Ok(())
    }

    /// Plants the feet of people who are on the floor, and frees those of others: one plane is the
    /// ground of all, and legs would reach for it.
    fn plant(&mut self, crowd: &mut Crowd) -> Result<(), Error> {
        let people = self.moments.iter().zip(self.walkers.members());
        for ((moment, member), planted) in people.zip(&mut self.planted) {
            let weight = floor::weight(moment.elevation_m - self.floor_m);
            if *planted != weight {
                *planted = weight;
                let part = f32::from(weight) / f32::from(floor::STEPS);
                crowd.member_mut(*member)?.plant_feet(part)?;
            }
        }
        Ok(())
    }

    /// Returns the height of a character's eyes above the ground in metres, at the scale of 1; 0
    /// for a body without a head that turns.
    fn eye_m(&mut self, crowd: &Crowd, id: CharacterId) -> Result<f32, Error> {
        let known = self.eyes_of.iter().find(|(known, _)| *known == id);
        if let Some((_, eye_m)) = known {
            return Ok(*eye_m);
        }
        let asset = crowd.character(id)?.asset();
        let roles = RoleMap::detect(&asset.skeleton);
        let can_look = roles.is_some_and(|roles| roles.joint(Role::Head).is_some());
        let eye_m = if can_look { EYES * asset.height_m() } else { 0.0 };
        self.eyes_of.push((id, eye_m));
        Ok(eye_m)
    }

    /// Fades people in and out.
    fn fade(&mut self, crowd: &mut Crowd) -> Result<(), Error> {
        for (index, agent) in self.agents.iter().enumerate() {
            let opacity = self.opacity(*agent);
            if self.opacities[index] != opacity {
                self.opacities[index] = opacity;
                let look = self.people[*agent].look.unwrap_or_default().with_opacity(opacity);
                crowd.member_mut(self.walkers.members()[index])?.set_look(look);
            }
        }
        Ok(())
    }

    /// Turns the heads of people.
    fn gaze(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Error> {
        self.somebodies.clear();
        let people = self.agents.iter().zip(&self.moments).zip(self.walkers.members());
        self.somebodies.extend(people.map(|((agent, moment), member)| {
            let eye_m = self.eyes_m[*agent];
            Somebody { agent: *agent, member: *member, moment: *moment, eye_m }
        }));
        self.somebodies.sort_unstable_by_key(|somebody| somebody.agent);
        self.gazes.turn(crowd, &self.somebodies, (self.secs, secs))
    }
}

/// Returns how an agent is led that is somewhere at a time.
fn lead(motion: &Motion, now: &Moment, secs: f64) -> Lead {
    let Moment { position: [x, y], velocity, heading_rad, elevation_m, stands, .. } = *now;
    let soon = motion.at(secs + f64::from(Lead::SOON_SECS)).filter(|soon| !soon.stands);
    let [vx, vy] = if stands { [0.0; 2] } else { velocity };
    Lead {
        position: [x, -y],
        velocity: [vx, -vy],
        soon_m_per_sec: soon.map_or(0.0, |soon| soon.velocity[0].hypot(soon.velocity[1])),
        yaw_rad: heading_rad + FRAC_PI_2,
        height_m: elevation_m,
        step: None,
    }
}

/// Returns the largest distance of a motion from the rows of its agent.
fn max_raw_m(recording: &Recording, motions: &Motions) -> f32 {
    let mut most = 0.0_f32;
    for (agent, motion) in recording.agents.iter().zip(motions.agents.iter()) {
        let track = recording.track(agent);
        for (row, (secs, raw)) in track.times.iter().zip(track.positions).enumerate() {
            let Some(at) = motion.at(*secs) else { continue };
            let [x, y] = at.position;
            let elevation_m = track.elevations.get(row).copied().unwrap_or(at.elevation_m);
            most = most.max(distance([x - raw[0], y - raw[1], at.elevation_m - elevation_m]));
        }
    }
    most
}

fn distance([x, y, z]: [f32; 3]) -> f32 {
    x.hypot(y).hypot(z)
}
