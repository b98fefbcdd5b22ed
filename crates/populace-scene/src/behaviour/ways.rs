//! Ways along footways, and past people who stand there.

use glam::Vec2;

use super::footways::Place;
use super::person::Person;
use super::world::World;
use crate::Error;

/// How far ahead on a footway people are sent, and how near they come before they are sent on.
const SENT_M: f32 = 14.0;
const SENT_ON_M: f32 = 5.0;
/// The ways to each side that are looked at, and the share of half a footway between them.
const SIDES: i8 = 5;
const SIDE: f32 = 0.19;
/// Metres of free way that the change from one edge of a footway to the middle is worth.
const CHANGE_M: f32 = 2.0;
/// A person slower than this, in metres per second, within a distance in metres of somebody who
/// stands is held up. It turns back after a number of turns.
const HELD_UP_M_PER_SEC: f32 = 0.3;
const NEAR_M: f32 = 0.9;
const MOST_TURNS: u8 = 4;

impl World {
    /// Sends a person on along its footway, past people who stand there. At the end of the footway
    /// it turns round, with its group.
    pub(crate) fn send_along(&mut self, who: usize) -> Result<(), Error> {
        let at = self.position(who);
        let person = &self.people[who];
        let footway = &self.footways[person.footway];
        let along = footway.place(at).along_m;
        let left = if person.direction > 0.0 { footway.length_m() - along } else { along };
        if left < SENT_ON_M {
            self.turn_round(who)?;
        }
        self.send_ahead(who)
    }

    /// Sends a person ahead along its footway, past people who stand there.
    pub(crate) fn send_ahead(&mut self, who: usize) -> Result<(), Error> {
        let at = self.position(who);
        let person = &self.people[who];
        let footway = &self.footways[person.footway];
        let along = footway.place(at).along_m;
        let along_m = (along + SENT_M * person.direction).clamp(0.0, footway.length_m());
        let to = self.past_standers(&self.people[who], at, along_m);
        self.send(who, to)
    }

    /// Returns where somebody goes at a length along its footway: in its own lane, or in the one
    /// that is free of people who stand for longer.
    fn past_standers(&self, person: &Person, at: Vec2, along_m: f32) -> Vec2 {
        let footway = &self.footways[person.footway];
        let own = -person.direction * person.lane;
        let to = |side: f32| footway.at(Place { along_m, aside_m: side * footway.half_m }).0;
        let standing = &self.standing;
        if standing.is_empty() || standing.free_m(at, to(own)) >= at.distance(to(own)) {
            return to(own);
        }
        let sides = (-SIDES..=SIDES).map(|nth| f32::from(nth) * SIDE);
        let worth = |side: f32| standing.free_m(at, to(side)) - CHANGE_M * (side - own).abs();
        let best = sides.map(|side| (worth(side), side)).max_by(|a, b| a.0.total_cmp(&b.0));
        to(best.map_or(own, |(_, side)| side))
    }

    /// Keeps a person going along its footway. It turns back if people who stand hold it up.
    pub(crate) fn keep_going(&mut self, who: usize) -> Result<(), Error> {
        if self.is_turn(who) {
            let is_held_up = self.is_held_up(who);
            let person = &mut self.people[who];
            person.held_up = if is_held_up { person.held_up + 1 } else { 0 };
            if person.held_up == MOST_TURNS {
                person.held_up = 0;
                self.turn_round(who)?;
                return self.send_along(who);
            }
        }
        if self.position(who).distance(self.people[who].goal) < SENT_ON_M {
            self.send_along(who)?;
        }
        Ok(())
    }

    fn is_held_up(&self, who: usize) -> bool {
        !self.standing.is_empty()
            && self.velocity(who).length() < HELD_UP_M_PER_SEC
            && self.standing.is_near(self.position(who), NEAR_M)
    }
}
