//! People who follow the trajectories of a recording.

use std::f32::consts::FRAC_PI_2;

use populace::MemberLook;
use populace::model::{Role, RoleMap};
use populace::{CharacterId, Crowd, MemberId, Placement};
use populace_locomotion::{GaitSpace, Lead, WalkerSettings, Walkers};
use populace_trajectory::Recording;

use crate::Error;
use crate::gaze::{Gazes, Somebody};
use crate::motion::{Moment, Motions};

/// The part of a cycle by which neighbouring agents step apart: the golden ratio spreads them
/// evenly.
const PHASES: f64 = 0.618_033_988_749_895;

/// Seconds in which people fade in and out.
const FADE_SECS: f64 = 0.4;
/// Height of the eyes as a fraction of that of the body.
const EYES: f32 = 0.93;

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
    /// The largest distance from the filtered data, in all frames so far.
    pub max_m: f32,
    /// The largest distance from the rows at their own times.
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
    present: Vec<bool>,
    leads: Vec<Lead>,
    gazes: Gazes,
    /// The people present, in the order of agents.
    somebodies: Vec<Somebody>,
    /// Heights of the eyes above the ground in metres, by agent; 0 for bodies that cannot look.
    eyes_m: Vec<f32>,
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
        Ok(Self {
            motions,
            people: people.to_vec(),
            walkers,
            agents: Vec::new(),
            present: vec![false; agents],
            leads: Vec::new(),
            gazes: Gazes::new(agents),
            somebodies: Vec::new(),
            eyes_m: vec![0.0; agents],
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
        self.secs += f64::from(secs);
        self.leave(crowd)?;
        self.leads.clear();
        for agent in &self.agents {
            // Agents that are gone have left above.
            self.leads.extend(lead(&self.motions, *agent, self.secs));
        }
        self.walkers.follow(crowd, &self.leads, secs)?;
        self.appear(crowd)?;
        self.gaze(crowd, secs)?;
        self.fade(crowd)?;
        for (agent, at) in self.agents.iter().zip(self.walkers.positions()) {
            let filtered = self.motions.agents[*agent].filtered_at(self.secs);
            let off = filtered.map_or(0.0, |[x, y]| (at[0] - x).hypot(at[1] + y));
            self.error.max_m = self.error.max_m.max(off);
        }
        Ok(())
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

    /// Returns the part of an agent's person that is seen, from 0 to 1: people fade in when they
    /// come and out before they leave.
    #[must_use]
    pub fn opacity(&self, agent: usize) -> f32 {
        let Some(motion) = self.motions.agents.get(agent) else { return 0.0 };
        let span = motion.secs().find(|[from, until]| (*from..=*until).contains(&self.secs));
        let Some([from, until]) = span else { return 0.0 };
        // Nobody comes when the recording begins, or leaves when it ends.
        let [first, last] = self.all_secs;
        let since = if from > first { self.secs - from + FADE_SECS / 8.0 } else { FADE_SECS };
        let left = if until < last { until - self.secs } else { FADE_SECS };
        #[expect(clippy::cast_possible_truncation, reason = "from 0 to 1")]
        let part = (since.min(left) / FADE_SECS).clamp(0.0, 1.0) as f32;
        part
    }

    /// Returns the distances of people from the data.
    #[must_use]
    pub fn position_error(&self) -> PositionError {
        self.error
    }

    /// Takes people from the crowd whose agents have left.
    fn leave(&mut self, crowd: &mut Crowd) -> Result<(), Error> {
        let mut index = 0;
        while let Some(agent) = self.agents.get(index).copied() {
            if self.motions.agents[agent].at(self.secs).is_some() {
                index += 1;
                continue;
            }
            let member = self.walkers.members()[index];
            self.walkers.remove(member)?;
            crowd.despawn(member)?;
            self.agents.swap_remove(index);
            self.present[agent] = false;
            self.gazes.forget(agent);
        }
        Ok(())
    }

    /// Brings people into the crowd whose agents have come.
    fn appear(&mut self, crowd: &mut Crowd) -> Result<(), Error> {
        for (agent, &person) in self.people.iter().enumerate() {
            if self.present[agent] {
                continue;
            }
            let Some(lead) = lead(&self.motions, agent, self.secs) else { continue };
            let [x, z] = lead.position;
            let placement =
                Placement::at([x, lead.height_m, z]).facing(lead.yaw_rad).scaled(person.scale);
            let member = crowd.spawn(person.character, placement)?;
            #[expect(clippy::cast_possible_truncation, reason = "below 1")]
            let phase = (agent as f64 * PHASES).fract() as f32;
            self.walkers.add_led(crowd, member, &lead, phase)?;
            self.agents.push(agent);
            self.present[agent] = true;
            self.eyes_m[agent] = eye_m(crowd, person)?;
        }
        Ok(())
    }

    /// Fades people in and out.
    fn fade(&mut self, crowd: &mut Crowd) -> Result<(), Error> {
        for (agent, member) in self.present() {
            let look =
                self.people[agent].look.unwrap_or_default().with_opacity(self.opacity(agent));
            let mut member = crowd.member_mut(member)?;
            if member.look() != look {
                member.set_look(look);
            }
        }
        Ok(())
    }

    /// Turns the heads of people.
    fn gaze(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Error> {
        self.somebodies.clear();
        let people = self.agents.iter().zip(self.walkers.members());
        self.somebodies.extend(people.filter_map(|(agent, member)| {
            let moment = self.motions.agents[*agent].at(self.secs)?;
            Some(Somebody { agent: *agent, member: *member, moment, eye_m: self.eyes_m[*agent] })
        }));
        self.somebodies.sort_unstable_by_key(|somebody| somebody.agent);
        self.gazes.turn(crowd, &self.somebodies, (self.secs, secs))
    }
}

/// Returns the height of a person's eyes above the ground in metres; 0 for a body without a head
/// that turns.
fn eye_m(crowd: &Crowd, person: Person) -> Result<f32, Error> {
    let character = crowd.character(person.character)?;
    let asset = character.asset();
    let roles = RoleMap::detect(&asset.skeleton);
    let can_look = roles.is_some_and(|roles| roles.joint(Role::Head).is_some());
    Ok(if can_look { EYES * asset.height_m() * person.scale } else { 0.0 })
}

/// Returns how an agent is led at a time; `None` while it is not there.
fn lead(motions: &Motions, agent: usize, secs: f64) -> Option<Lead> {
    let motion = &motions.agents[agent];
    let Moment { position: [x, y], velocity, heading_rad, elevation_m, stands, .. } =
        motion.at(secs)?;
    let soon = motion.at(secs + f64::from(Lead::SOON_SECS)).filter(|soon| !soon.stands);
    let [vx, vy] = if stands { [0.0; 2] } else { velocity };
    Some(Lead {
        position: [x, -y],
        velocity: [vx, -vy],
        soon_m_per_sec: soon.map_or(0.0, |soon| soon.velocity[0].hypot(soon.velocity[1])),
        yaw_rad: heading_rad + FRAC_PI_2,
        height_m: elevation_m,
    })
}

/// Returns the largest distance of a motion from the rows of its agent.
fn max_raw_m(recording: &Recording, motions: &Motions) -> f32 {
    let mut most = 0.0_f32;
    for (agent, motion) in recording.agents.iter().zip(motions.agents.iter()) {
        let track = recording.track(agent);
        for (secs, raw) in track.times.iter().zip(track.positions) {
            let off =
                motion.at(*secs).map(|at| (at.position[0] - raw[0]).hypot(at.position[1] - raw[1]));
            most = most.max(off.unwrap_or(0.0));
        }
    }
    most
}
