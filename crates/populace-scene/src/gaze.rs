//! Gazes: people look where the data say, or at somebody who passes.

use populace::{Crowd, MemberId, Target, Weight};
use populace_random::{mixed, unit_of};

use crate::Error;
use crate::motion::Moment;
use crate::neighbours::Neighbours;

/// Height of a person's eyes as a share of its own (S. Pheasant, "Bodyspace", 1996).
pub const EYES: f32 = 0.935;

/// Distance in metres at which a direction of view is looked along.
const ALONG_M: f32 = 4.0;
/// Distance in metres within which somebody is noticed.
const NOTICED_M: f32 = 4.0;
/// Cosines of the angles from the heading within which somebody is noticed, and of the headings of
/// two who walk the same way.
const AHEAD: f32 = 0.35;
const SAME_WAY: f32 = 0.5;
/// Seconds of a glance, and from the end of one to the next at the earliest.
const GLANCE_SECS: f64 = 1.3;
const REST_SECS: f64 = 2.5;
/// The share of people who look at somebody who passes.
const LOOKS: f32 = 0.4;
/// Seconds between two looks around. Each time it is the turn of a share of the people.
const AROUND_SECS: f64 = 0.3;
/// Seconds in which heads turn.
const TURN_SECS: f32 = 0.35;

/// Somebody who is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Somebody {
    pub(crate) agent: usize,
    pub(crate) member: MemberId,
    pub(crate) moment: Moment,
    /// Height of the eyes above the ground in metres; 0 for a body that cannot look.
    pub(crate) eye_m: f32,
}

/// The gaze of one agent.
#[derive(Clone, Copy, Debug, Default)]
struct Gaze {
    /// The agent that it looks at, and the time in seconds at which that ends.
    at: Option<(usize, f64)>,
    /// The time in seconds from which it may look at somebody again.
    rests_until: f64,
}

/// The gazes of all agents.
#[derive(Clone, Debug)]
pub(crate) struct Gazes {
    all: Vec<Gaze>,
}

impl Gazes {
    pub(crate) fn new(agents: usize) -> Self {
        Self { all: vec![Gaze::default(); agents] }
    }

    /// Forgets the gaze of an agent who leaves.
    pub(crate) fn forget(&mut self, agent: usize) {
        self.all[agent] = Gaze::default();
    }

    /// Turns heads for a step that ends at a time in seconds. People are in the order of agents.
    pub(crate) fn turn(
        &mut self,
        crowd: &mut Crowd,
        people: &[Somebody],
        (secs, step_secs): (f64, f32),
    ) -> Result<(), Error> {
        let places = people.iter().map(|somebody| somebody.moment.position);
        let neighbours = Neighbours::new(places, NOTICED_M);
        for somebody in people.iter().filter(|somebody| somebody.eye_m > 0.0) {
            if let Some(view_rad) = somebody.moment.view_rad {
                look(crowd, somebody, along(somebody, view_rad))?;
                continue;
            }
            if self.all[somebody.agent].at.is_none() && is_turn(somebody.agent, secs, step_secs) {
                let near = neighbours.around(somebody.moment.position);
                self.notice(somebody, near.map(|index| &people[index]), secs);
            }
            self.glance(crowd, somebody, people, secs)?;
        }
        Ok(())
    }

    /// Decides whether somebody looks at the nearest person who passes, among those who are near.
    fn notice<'a>(
        &mut self,
        somebody: &Somebody,
        near: impl Iterator<Item = &'a Somebody>,
        secs: f64,
    ) {
        let gaze = &mut self.all[somebody.agent];
        if secs < gaze.rests_until {
            return;
        }
        let passes = |other: &&Somebody| somebody.passes(other);
        let distance = |other: &Somebody| somebody.to(other)[0].hypot(somebody.to(other)[1]);
        let nearest = near
            .filter(passes)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.agent.cmp(&b.agent)));
        let Some(nearest) = nearest else { return };
        // Somebody who does not look now does not look at the same person a moment later either.
        gaze.rests_until = secs + GLANCE_SECS + REST_SECS;
        if chance(somebody.agent, nearest.agent) < LOOKS {
            gaze.at = Some((nearest.agent, secs + GLANCE_SECS));
        }
    }

    /// Follows whom somebody looks at, and looks ahead again at the end.
    fn glance(
        &mut self,
        crowd: &mut Crowd,
        somebody: &Somebody,
        people: &[Somebody],
        secs: f64,
    ) -> Result<(), Error> {
        let gaze = &mut self.all[somebody.agent];
        let Some((other, until)) = gaze.at else { return Ok(()) };
        let found = people.binary_search_by_key(&other, |other| other.agent);
        match found.ok().map(|index| &people[index]).filter(|_| secs < until) {
            Some(other) => {
                let Moment { position: [x, y], elevation_m, .. } = other.moment;
                look(crowd, somebody, [x, elevation_m + other.eye_m, -y])
            }
            None => {
                gaze.at = None;
                Ok(crowd.member_mut(somebody.member)?.clear_look_at(2.0 * TURN_SECS)?)
            }
        }
    }
}

impl Somebody {
    /// Returns the way to another on the plan, in metres.
    fn to(&self, other: &Self) -> [f32; 2] {
        let [from, to] = [self.moment.position, other.moment.position];
        [to[0] - from[0], to[1] - from[1]]
    }

    /// Returns whether another is ahead, near, and goes another way.
    fn passes(&self, other: &Self) -> bool {
        let [x, y] = self.to(other);
        let distance = x.hypot(y);
        if self.agent == other.agent || !(1e-3..=NOTICED_M).contains(&distance) {
            return false;
        }
        let [[ax, ay], [bx, by]] = [self, other].map(|of| direction(of.moment.heading_rad));
        (x * ax + y * ay) / distance > AHEAD && ax * bx + ay * by < SAME_WAY
    }
}

fn look(crowd: &mut Crowd, somebody: &Somebody, at: [f32; 3]) -> Result<(), Error> {
    let weight = Weight::FULL.over_secs(TURN_SECS);
    Ok(crowd.member_mut(somebody.member)?.look_at(Target::Point(at), weight)?)
}

/// Returns the point that somebody who looks along a direction of the plan looks at.
fn along(somebody: &Somebody, view_rad: f32) -> [f32; 3] {
    let Moment { position: [x, y], elevation_m, .. } = somebody.moment;
    let [dx, dy] = direction(view_rad);
    [x + ALONG_M * dx, elevation_m + somebody.eye_m, -(y + ALONG_M * dy)]
}

fn direction(heading_rad: f32) -> [f32; 2] {
    let (sin, cos) = heading_rad.sin_cos();
    [cos, sin]
}

/// Returns whether it is an agent's turn to look around, in a step that ends at a time.
fn is_turn(agent: usize, secs: f64, step_secs: f32) -> bool {
    let offset = f64::from(chance(agent, 0)) * AROUND_SECS;
    let turns = |secs: f64| ((secs + offset) / AROUND_SECS).floor();
    turns(secs) > turns(secs - f64::from(step_secs))
}

/// Returns a number from 0 to 1 that two agents always draw.
fn chance(agent: usize, other: usize) -> f32 {
    unit_of(mixed((agent as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (other as u64 + 1)))
}
