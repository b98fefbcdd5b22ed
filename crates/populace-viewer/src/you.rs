//! The member that the keyboard or a gamepad drives, by the calls that drive all walkers.

use std::f32::consts::TAU;

use populace::{Crowd, MemberId};
use populace_locomotion::{Error, GaitSpace, Goal, WalkerSettings, Walkers};

/// Speeds of walking, running and going backwards in m/s.
const WALK: f32 = 1.4;
const RUN: f32 = 3.4;
const BACK: f32 = 0.8;
/// Time for which who stops steps on the spot at most, in seconds.
const SETTLED_SECS: f32 = 3.0;
/// Speed of turning in radians per second.
const TURN: f32 = 2.4;

/// Direction in which keys and stick send the driven member.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Steering {
    /// From -1, backwards, to 1, forwards.
    pub(crate) forward: f32,
    /// From -1, to the right, to 1, to the left.
    pub(crate) left: f32,
    pub(crate) runs: bool,
}

impl Steering {
    /// Returns what both say together.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            forward: (self.forward + other.forward).clamp(-1.0, 1.0),
            left: (self.left + other.left).clamp(-1.0, 1.0),
            runs: self.runs || other.runs,
        }
    }
}

/// A member that is driven.
pub(crate) struct You {
    member: MemberId,
    walkers: Walkers,
    heading_rad: f32,
    /// Where it was taken over.
    began_at: [f32; 3],
    /// True while something else moves it.
    rests: bool,
    /// Seconds since it last moved.
    still_secs: f32,
}

impl You {
    /// Takes over a member. It stands, where it was.
    pub(crate) fn new(crowd: &mut Crowd, member: MemberId) -> Result<Self, Error> {
        let view = crowd.member(member).map_err(Error::Crowd)?;
        let (character, moves) = (view.character(), view.has_root_motion());
        let gaits = GaitSpace::of(crowd, character)?;
        if moves {
            let mut view = crowd.member_mut(member).map_err(Error::Crowd)?;
            view.commit_root_motion().map_err(Error::Crowd)?;
            view.stop_root_motion().map_err(Error::Crowd)?;
        }
        let placement = crowd.member(member).map_err(Error::Crowd)?.placement();
        let (heading_rad, began_at) = (placement.yaw_rad(), placement.position());
        let mut walkers = Walkers::new(WalkerSettings::default())?;
        walkers.add_gaits(gaits);
        walkers.add(crowd, member)?;
        Ok(Self { member, walkers, heading_rad, began_at, rests: false, still_secs: 0.0 })
    }

    /// Returns where it was taken over, in metres.
    pub(crate) fn began_at(&self) -> [f32; 3] {
        self.began_at
    }

    pub(crate) fn member(&self) -> MemberId {
        self.member
    }

    /// Returns true until it stands.
    pub(crate) fn is_moving(&self) -> bool {
        self.rests || self.still_secs < SETTLED_SECS
    }

    /// Leaves it to something else that moves it, such as a fall, until the next step.
    pub(crate) fn rest(&mut self) {
        self.rests = true;
    }

    /// Goes on for `secs` as it is steered. Before the crowd's update.
    pub(crate) fn step(
        &mut self,
        crowd: &mut Crowd,
        steering: Steering,
        secs: f32,
    ) -> Result<(), Error> {
        let member = self.member;
        if std::mem::take(&mut self.rests) {
            self.walkers.resume(crowd, member)?;
            self.heading_rad = crowd.member(member).map_err(Error::Crowd)?.placement().yaw_rad();
        }
        self.heading_rad = (self.heading_rad + TURN * steering.left * secs).rem_euclid(TAU);
        let speed = match steering.forward {
            f if f > 0.0 => f * if steering.runs { RUN } else { WALK },
            f => f * BACK,
        };
        let (sine, cosine) = self.heading_rad.sin_cos();
        let goal = Goal::Velocity([speed * sine, speed * cosine]);
        self.walkers.set_goal(member, if speed == 0.0 { Goal::Stand } else { goal })?;
        self.walkers.set_facing(member, Some(self.heading_rad))?;
        let mut left_secs = secs;
        while left_secs > 0.0 {
            let step_secs = left_secs.min(0.1);
            self.walkers.update(crowd, step_secs)?;
            left_secs -= step_secs;
        }
        let is_still = self.walkers.velocities().iter().all(|velocity| *velocity == [0.0; 2]);
        self.still_secs = if is_still { self.still_secs + secs } else { 0.0 };
        Ok(())
    }
}
