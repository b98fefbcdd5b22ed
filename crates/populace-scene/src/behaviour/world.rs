//! All that the activities of people share: who they are, where, and what they can be told.

use glam::Vec2;
use populace::{ClipPlayback, Crowd, LayerSettings, MemberId, PlaybackId, Target, Weight};
use populace_locomotion::{Goal, Walkers};
use populace_physics::Ragdolls;

use crate::Error;
use crate::gaze::EYES;
use crate::plan::{
    CrossingPlan, FightPlan, LeanPlan, SeatPlan, SpectatePlan, SpotPlan, StrollPlan,
};

use super::body::{Body, Use};
use super::footways::Footway;
use super::hands::{self, Phones};
use super::person::{Doing, Kind, Person};
use super::places::Places;
use super::taken::Taken;
use super::traffic::Traffic;

/// The layer of motions of the whole body.
pub(crate) const WHOLE: usize = 1;
/// The layer of motions of the upper body.
pub(crate) const UPPER: usize = 2;
/// Distance from a goal at which somebody has arrived, and speed below which somebody stands.
const ARRIVED_M: f32 = 0.12;
const STANDS_M_PER_SEC: f32 = 0.05;
/// Seconds in which heads turn.
const LOOK_SECS: f32 = 0.35;
/// Cosine of the angle within which somebody faces a direction: 0.06 rad.
const FACES: f32 = 0.9982;

/// Seconds between two decisions of a person.
const DECIDES_SECS: f64 = 0.5;

/// Things of a scene that have happened, by kind.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Looks into windows.
    pub looked_in: u32,
    /// Looks left and right before a road.
    pub looked_both_ways: u32,
    /// Roads crossed.
    pub crossed: u32,
    /// Talks of two or more.
    pub talked: u32,
    /// Times that somebody sat down on a seat.
    pub sat: u32,
    /// Times that somebody got into a vehicle and drove off.
    pub drove_off: u32,
    /// Times that somebody got out of a vehicle.
    pub got_out: u32,
    /// Times that somebody was run into or struck down, and fell.
    pub fell: u32,
    /// Times that somebody got up again.
    pub got_up: u32,
    /// Telephone calls.
    pub phoned: u32,
    /// Messages read.
    pub texted: u32,
    /// Times that somebody leant against a wall.
    pub leaned: u32,
    /// Times that somebody who talks pointed at a window.
    pub pointed: u32,
    /// Parcels carried along the street.
    pub carried: u32,
    /// People who walk in groups.
    pub together: u32,
    /// Times that somebody clapped.
    pub clapped: u32,
    /// Times that somebody cheered.
    pub cheered: u32,
    /// Times that somebody rose for a wave.
    pub waved: u32,
    /// Thrusts of spears.
    pub thrust: u32,
    /// Hits taken.
    pub hit: u32,
}

/// A talk of two or three.
#[derive(Clone, Debug)]
pub(crate) struct Talk {
    pub(crate) people: Vec<usize>,
    pub(crate) middle: Vec2,
    /// When it ends.
    pub(crate) until: f64,
    /// The index among the people of the one who talks, and the end of its turn.
    pub(crate) speaker: usize,
    pub(crate) turn_until: f64,
    pub(crate) has_begun: bool,
    /// The spot that the speaker shows the others.
    pub(crate) shows: Option<usize>,
}

/// A group that walks together.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub(crate) people: Vec<usize>,
    /// The index among the people of the one whose turn it is, and the end of the turn.
    pub(crate) speaker: usize,
    pub(crate) turn_until: f64,
    /// When those who look at each other look ahead again.
    pub(crate) glance_until: Option<f64>,
    /// True while the speaker's hands move.
    pub(crate) gestures: bool,
}

/// People on seats.
#[derive(Clone, Debug)]
pub(crate) struct Stand {
    pub(crate) plan: SpectatePlan,
    /// The first seat, and the direction of its row.
    pub(crate) first: Vec2,
    pub(crate) along: Vec2,
}

/// A crossing between two footways.
#[derive(Clone, Debug)]
pub(crate) struct Crossing {
    pub(crate) plan: CrossingPlan,
    /// The footways of its ends.
    pub(crate) footways: [usize; 2],
    /// The lanes that it crosses, and the length along each.
    pub(crate) lanes: Vec<(usize, f32)>,
}

/// The people of a scene, and what they meet.
#[derive(Clone)]
pub(crate) struct World {
    pub(crate) now: f64,
    /// Length of this step in seconds.
    pub(crate) step_secs: f64,
    pub(crate) walkers: Walkers,
    pub(crate) ragdolls: Ragdolls,
    pub(crate) bodies: Vec<Body>,
    pub(crate) strolls: Vec<StrollPlan>,
    pub(crate) stands: Vec<Stand>,
    pub(crate) armies: Vec<FightPlan>,
    pub(crate) people: Vec<Person>,
    pub(crate) footways: Vec<Footway>,
    pub(crate) standing: Taken,
    pub(crate) spots: Places<SpotPlan>,
    pub(crate) leans: Places<LeanPlan>,
    pub(crate) seats: Places<SeatPlan>,
    pub(crate) crossings: Vec<Crossing>,
    pub(crate) traffic: Traffic,
    pub(crate) talks: Vec<Option<Talk>>,
    pub(crate) groups: Vec<Group>,
    pub(crate) phones: Phones,
    pub(crate) counts: Counts,
}

impl World {
    /// Returns the position of a person who walks or rests.
    pub(crate) fn position(&self, who: usize) -> Vec2 {
        let walker = self.walkers.index(self.people[who].member);
        walker.map_or(self.people[who].goal, |at| self.walkers.positions()[at].into())
    }

    /// Returns true if it is a person's turn to decide in this step: two times a second.
    pub(crate) fn is_turn(&self, who: usize) -> bool {
        // Golden ratio steps spread the turns evenly.
        let turns = |now: f64| (now / DECIDES_SECS + who as f64 * 0.618_034).floor();
        turns(self.now - self.step_secs) < turns(self.now)
    }

    /// Returns false before the first step: people are in the middle of what they do then, and
    /// nothing fades in.
    fn has_begun(&self) -> bool {
        self.now > 0.0
    }

    pub(crate) fn velocity(&self, who: usize) -> Vec2 {
        let walker = self.walkers.index(self.people[who].member);
        walker.map_or(Vec2::ZERO, |at| self.walkers.velocities()[at].into())
    }

    pub(crate) fn body(&self, who: usize) -> &Body {
        &self.bodies[self.people[who].body]
    }

    /// Returns the height of a person in metres.
    pub(crate) fn height_m(&self, who: usize) -> f32 {
        self.body(who).height_m * self.people[who].scale
    }

    pub(crate) fn member(&self, who: usize) -> MemberId {
        self.people[who].member
    }

    /// Returns a point above somebody's feet, at a share of the height of the eyes.
    pub(crate) fn above(&self, crowd: &Crowd, who: usize, share: f32) -> Result<[f32; 3], Error> {
        let at = self.position(who);
        let [_, feet_m, _] = crowd.member(self.member(who))?.placement().position();
        Ok([at.x, feet_m + share * EYES * self.height_m(who), at.y])
    }

    /// Sends a person to a point.
    pub(crate) fn send(&mut self, who: usize, to: Vec2) -> Result<(), Error> {
        self.people[who].goal = to;
        Ok(self.walkers.set_goal(self.people[who].member, Goal::Point(to.to_array()))?)
    }

    /// Lets a person stand.
    pub(crate) fn halt(&mut self, who: usize) -> Result<(), Error> {
        self.people[who].goal = self.position(who);
        Ok(self.walkers.set_goal(self.people[who].member, Goal::Stand)?)
    }

    pub(crate) fn face(&mut self, who: usize, yaw_rad: Option<f32>) -> Result<(), Error> {
        Ok(self.walkers.set_facing(self.people[who].member, yaw_rad)?)
    }

    /// Returns true for somebody who stands at the goal.
    pub(crate) fn has_arrived(&self, who: usize) -> bool {
        self.position(who).distance(self.people[who].goal) < ARRIVED_M
            && self.velocity(who).length() < STANDS_M_PER_SEC
    }

    /// Stops a person at its goal and turns it to a heading. Returns false until it has arrived.
    pub(crate) fn stops_at_goal(&mut self, who: usize, yaw_rad: f32) -> Result<bool, Error> {
        let has_arrived = self.has_arrived(who);
        if has_arrived {
            self.halt(who)?;
            self.face(who, Some(yaw_rad))?;
        }
        Ok(has_arrived)
    }

    /// Returns true for somebody who stands and faces a heading.
    pub(crate) fn faces(&self, crowd: &Crowd, who: usize, yaw_rad: f32) -> Result<bool, Error> {
        let off = crowd.member(self.member(who))?.placement().yaw_rad() - yaw_rad;
        let stands = self.velocity(who).length() < STANDS_M_PER_SEC;
        let (_, cos) = off.sin_cos();
        Ok(stands && cos > FACES)
    }

    /// Lets a person go on with what it usually does, from where it is.
    pub(crate) fn go_on(&mut self, who: usize) -> Result<(), Error> {
        let Person { member, pace, kind, post, .. } = self.people[who];
        if let Kind::Fights(_) = kind {
            self.people[who].doing = Doing::Advances;
            self.walkers.set_heedless(member, true)?;
            return self.send(who, post);
        }
        self.people[who].doing = Doing::Strolls;
        self.walkers.set_heedless(member, false)?;
        self.walkers.set_facing(member, None)?;
        self.walkers.set_speed(member, pace)?;
        self.send_along(who)
    }

    /// Plays a motion on a layer for as long as it is or until it is ended, and returns its length
    /// in seconds; `None` if the body has none.
    pub(crate) fn play(
        &mut self,
        crowd: &mut Crowd,
        who: usize,
        usage: Use,
        (layer, playback): (usize, ClipPlayback),
    ) -> Result<Option<(PlaybackId, f64)>, Error> {
        let Some(clip) = self.body(who).clip(usage) else { return Ok(None) };
        if layer == UPPER {
            let place = hands::place(self.body(who), usage);
            self.phones.change(crowd, self.people[who].member, place, self.now)?;
        }
        let mut member = crowd.member_mut(self.member(who))?;
        let begins = if self.has_begun() { playback } else { playback.fade_in_secs(0.0) };
        let playing = member.play(clip.id, begins.on_layer(layer))?;
        Ok(Some((playing, f64::from(clip.secs))))
    }

    /// Ends what a layer plays.
    pub(crate) fn end(
        &mut self,
        crowd: &mut Crowd,
        who: usize,
        layer: usize,
        secs: f32,
    ) -> Result<(), Error> {
        if layer == UPPER {
            self.phones.change(crowd, self.people[who].member, None, self.now)?;
        }
        Ok(crowd.member_mut(self.member(who))?.stop(layer, secs)?)
    }

    /// Turns a person's head to a point.
    pub(crate) fn look(&self, crowd: &mut Crowd, who: usize, at: [f32; 3]) -> Result<(), Error> {
        self.look_with(crowd, who, at, Weight::FULL.over_secs(LOOK_SECS).easing_over())
    }

    /// Turns a person's head to a point that moves. Call it in each step.
    pub(crate) fn follow(&self, crowd: &mut Crowd, who: usize, at: [f32; 3]) -> Result<(), Error> {
        self.look_with(crowd, who, at, Weight::FULL.over_secs(LOOK_SECS))
    }

    fn look_with(
        &self,
        crowd: &mut Crowd,
        who: usize,
        at: [f32; 3],
        weight: Weight,
    ) -> Result<(), Error> {
        if self.body(who).can_look {
            let weight = if self.has_begun() { weight } else { Weight::FULL };
            crowd.member_mut(self.member(who))?.look_at(Target::Point(at), weight)?;
        }
        Ok(())
    }

    /// Lets a person look ahead again.
    pub(crate) fn look_ahead(&self, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
        if self.body(who).can_look {
            crowd.member_mut(self.member(who))?.clear_look_at(0.4)?;
        }
        Ok(())
    }

    /// Sets the layers of a person that has just been brought into the crowd.
    pub(crate) fn set_layers(&self, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
        let Body { upper, left_arm, .. } = *self.body(who);
        let mut member = crowd.member_mut(self.member(who))?;
        let [whole, arms] = match self.people[who].kind {
            Kind::Fights(_) => [left_arm, upper],
            _ => [None, upper],
        };
        member.set_layer(WHOLE, LayerSettings::default(), whole)?;
        Ok(member.set_layer(UPPER, LayerSettings::default(), arms)?)
    }
}

/// Returns the chance of something in one turn that happens a number of times in a minute.
pub(crate) fn per_turn(rate: f32) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "a half")]
    let part = DECIDES_SECS as f32 / 60.0;
    rate * part
}
