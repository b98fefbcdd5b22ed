//! Orders to walkers: goals, speeds, headings and groups.

use std::sync::Arc;

use glam::Vec2;
use populace::MemberId;

use super::Walkers;
use crate::Error;
use crate::error::within;
use crate::path::{Path, Target, check_coordinate};

/// The walking speed unless set, in metres per second: that of free walkers (U. Weidmann,
/// "Transporttechnik der Fussgaenger", ETH Zurich 1993).
const FREE_SPEED: f32 = 1.34;
/// The highest speed of walkers in metres per second.
const MOST_SPEED: f32 = 20.0;

/// Where a walker goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Goal {
    /// It stands.
    #[default]
    Stand,
    /// It moves at a velocity `[x, z]` in metres per second, of a length of at most 20.
    Velocity([f32; 2]),
    /// It walks straight to a point `[x, z]` in metres and stops there. It evades others and slides
    /// along walls, but finds no way around a wall across its way: there it stands for ever.
    /// [`Walkers::has_arrived`] tells.
    Point([f32; 2]),
    /// It follows a path, from its first point on, and walks straight to each.
    Path(Arc<Path>),
}

/// The orders of one walker.
#[derive(Clone, Debug)]
pub(super) struct Orders {
    goal: Goal,
    /// Where it goes now, and the index of that point in a path.
    target: Target,
    next: u32,
    speed: f32,
    pub(super) facing_rad: Option<f32>,
    pub(super) manner: Manner,
    /// Index of its gaits.
    pub(super) gaits: u32,
}

/// How a walker takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Manner {
    /// It steers around others.
    Heeds,
    /// It goes straight to its goal, and others steer around it.
    Heedless,
    /// Something else moves its member, and others steer around it.
    Rests,
}

impl Orders {
    /// To stand.
    pub(super) fn to_stand(gaits: u32) -> Self {
        let target = Target { point: Vec2::ZERO, is_end: true };
        let (goal, manner) = (Goal::Stand, Manner::Heeds);
        Self { goal, target, next: 0, speed: FREE_SPEED, facing_rad: None, manner, gaits }
    }

    /// Stands and heeds others again.
    pub(super) fn resume(&mut self) {
        self.set_goal(Goal::Stand);
        (self.facing_rad, self.manner) = (None, Manner::Heeds);
    }

    fn set_goal(&mut self, goal: Goal) {
        self.next = 0;
        match &goal {
            Goal::Point(point) => self.target = Target { point: (*point).into(), is_end: true },
            Goal::Path(path) => self.target = path.target(0),
            Goal::Stand | Goal::Velocity(_) => {}
        }
        self.goal = goal;
    }

    fn has_arrived(&self, at: Vec2) -> bool {
        match &self.goal {
            Goal::Stand => true,
            Goal::Velocity(_) => false,
            Goal::Point(_) | Goal::Path(_) => self.target.is_end && self.target.is_reached(at),
        }
    }

    /// Returns the velocity that leads to the goal, for a step of `secs`.
    pub(super) fn velocity(&mut self, at: Vec2, slows: f32, secs: f32) -> Vec2 {
        if self.manner == Manner::Rests {
            return Vec2::ZERO;
        }
        match &self.goal {
            Goal::Stand => return Vec2::ZERO,
            Goal::Velocity(velocity) => return (*velocity).into(),
            Goal::Path(path) if self.target.is_passed(at, self.speed) => {
                self.next = path.after(self.next);
                self.target = path.target(self.next);
            }
            Goal::Point(_) | Goal::Path(_) => {}
        }
        self.target.velocity(at, self.speed, slows, secs)
    }
}

/// Refuses a speed that is not finite or too high.
fn check_speed(speed: f32) -> Result<(), Error> {
    within("the speed of a walker", speed, 0.0..=MOST_SPEED, "from 0 to 20 metres per second")
}

fn check_velocity(velocity: [f32; 2]) -> Result<(), Error> {
    check_speed(Vec2::from(velocity).length())
}

impl Walkers {
    /// Sends a walker to a goal.
    ///
    /// # Errors
    ///
    /// A member that is no walker, a velocity of a length that is not from 0 to 20, or a coordinate
    /// that is not from -1e6 to 1e6.
    pub fn set_goal(&mut self, member: MemberId, goal: Goal) -> Result<(), Error> {
        let index = self.index_of(member)?;
        match &goal {
            Goal::Velocity(velocity) => check_velocity(*velocity)?,
            Goal::Point(point) => point.iter().try_for_each(|value| check_coordinate(*value))?,
            Goal::Stand | Goal::Path(_) => {}
        }
        self.orders[index].set_goal(goal);
        Ok(())
    }

    /// Returns whether a walker is where its goal ends: within 5 cm of its point, or of the last
    /// point of a path that is not closed. True for [`Goal::Stand`], false for [`Goal::Velocity`].
    /// A walker that has not arrived and hardly moves for seconds is stuck, at a wall or in a
    /// crowd.
    ///
    /// # Errors
    ///
    /// A member that is no walker.
    pub fn has_arrived(&self, member: MemberId) -> Result<bool, Error> {
        let index = self.index_of(member)?;
        Ok(self.orders[index].has_arrived(self.positions[index].into()))
    }

    /// Sets the velocities `[x, z]` of all walkers, in metres per second, in the order of
    /// [`members`](Self::members).
    ///
    /// # Errors
    ///
    /// A slice of another length, or a velocity of a length that is not from 0 to 20. Nothing is
    /// changed then.
    pub fn set_velocities(&mut self, velocities: &[[f32; 2]]) -> Result<(), Error> {
        if velocities.len() != self.members.len() {
            let (found, walkers) = (velocities.len(), self.members.len());
            return Err(Error::UnequalLengths { found, walkers });
        }
        velocities.iter().try_for_each(|velocity| check_velocity(*velocity))?;
        for (orders, velocity) in self.orders.iter_mut().zip(velocities) {
            orders.goal = Goal::Velocity(*velocity);
        }
        Ok(())
    }

    /// Sets the speed at which a walker goes to points and along paths, in metres per second.
    ///
    /// # Errors
    ///
    /// A member that is no walker, or a speed that is not from 0 to 20.
    pub fn set_speed(&mut self, member: MemberId, speed: f32) -> Result<(), Error> {
        check_speed(speed)?;
        let index = self.index_of(member)?;
        self.orders[index].speed = speed;
        Ok(())
    }

    /// Keeps a heading while the walker moves, about +Y from +Z towards +X in radians: it steps
    /// sideways and backwards. `None` faces the way it goes.
    ///
    /// # Errors
    ///
    /// A member that is no walker, or an angle that is not from -1e6 to 1e6.
    pub fn set_facing(&mut self, member: MemberId, yaw_rad: Option<f32>) -> Result<(), Error> {
        let heading = yaw_rad.unwrap_or(0.0);
        within("the heading of a walker", heading, -1e6..=1e6, "from -1e6 to 1e6 radians")?;
        let index = self.index_of(member)?;
        self.orders[index].facing_rad = yaw_rad;
        Ok(())
    }

    /// Puts a walker into a group that walks together: equal numbers are one group, 0 is none.
    ///
    /// # Errors
    ///
    /// A member that is no walker.
    pub fn set_group(&mut self, member: MemberId, group: u32) -> Result<(), Error> {
        let index = self.index_of(member)?;
        self.groups[index] = group;
        Ok(())
    }

    /// Makes a walker go straight to its goal, like somebody who reads a message. It steers around
    /// nobody, and others steer around it. Walls still stop it, and it slides along bystanders.
    /// `false` ends this. A walker that [rests](Self::rest) goes on resting, and heeds others once
    /// it resumes.
    ///
    /// # Errors
    ///
    /// A member that is no walker.
    pub fn set_heedless(&mut self, member: MemberId, is_heedless: bool) -> Result<(), Error> {
        let index = self.index_of(member)?;
        let manner = &mut self.orders[index].manner;
        if *manner != Manner::Rests {
            *manner = if is_heedless { Manner::Heedless } else { Manner::Heeds };
        }
        Ok(())
    }

    /// Leaves a member to something else that moves it, such as a ragdoll: its placement, clips and
    /// strides are no longer set. The next update lets the member stand, if it still plays a blend
    /// space then, so that it does not tread on the spot. Others walk around a disc of `radius_m`
    /// at a point `[x, z]` in metres. Only [`resume`](Self::resume) and [`add`](Self::add) make the
    /// member walk again.
    ///
    /// # Errors
    ///
    /// A member that is no walker, a coordinate that is not from -1e6 to 1e6, or a radius that is
    /// not from 0.01 to 3.
    pub fn rest(&mut self, member: MemberId, at: [f32; 2], radius_m: f32) -> Result<(), Error> {
        let index = self.index_of(member)?;
        at.iter().try_for_each(|value| check_coordinate(*value))?;
        within("the radius of a walker that rests", radius_m, 0.01..=3.0, "from 0.01 to 3 metres")?;
        self.orders[index].set_goal(Goal::Stand);
        self.orders[index].manner = Manner::Rests;
        (self.positions[index], self.velocities[index]) = (at, [0.0; 2]);
        self.walkers[index].stand_at(at.into());
        self.radii_m[index] = radius_m;
        Ok(())
    }
}
