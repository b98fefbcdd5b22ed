//! Running into somebody, falling and getting up.

use std::sync::Arc;

use glam::Vec2;
use populace::{ClipPlayback, Crowd};
use populace_physics::State;

use super::body::Use;
use super::person::{Doing, Person};
use super::world::{UPPER, World};
use crate::Error;

/// Distance at which somebody who does not look is chosen, in metres.
const CHOSEN_M: f32 = 14.0;
const HURRY_M_PER_SEC: f32 = 2.9;
const HURRY_SECS: f64 = 9.0;
/// Distance between two middles at which bodies touch, in metres.
const TOUCH_M: f32 = 0.5;
/// The change of speed of who is run into, in metres per second.
const PUSH_M_PER_SEC: f32 = 1.7;
/// Radius in metres of the ground that somebody takes who lies, and the distance of its middle from
/// where the person stood.
const LYING_M: f32 = 0.9;
const LIES_AHEAD_M: f32 = 0.7;
/// Distance in metres that somebody who has run into another one keeps from where that one stood.
const STEPS_BACK_M: f32 = 0.7;
const STEPS_BACK_M_PER_SEC: f32 = 0.9;
/// Seconds after which somebody gets up who has not come to rest.
const LIES_SECS: f64 = 4.5;
const STOP_SECS: f64 = 2.6;

/// Lets somebody who strolls hurry towards somebody who reads. Returns true if there is one.
pub(crate) fn begin(world: &mut World, who: usize) -> Result<bool, Error> {
    let at = world.position(who);
    let footway = world.people[who].footway;
    let victim = (0..world.people.len())
        .filter(|other| {
            let person = &world.people[*other];
            let reads = matches!(person.doing, Doing::Texts { .. });
            reads && person.footway == footway && world.body(*other).chest.is_some()
        })
        .map(|other| (world.position(other).distance(at), other))
        .filter(|(m, _)| (3.0..CHOSEN_M).contains(m))
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let Some((_, victim)) = victim else { return Ok(false) };
    let is_chosen = |person: &Person| match person.doing {
        Doing::Hurries { victim: other, .. } => other == victim,
        _ => false,
    };
    if world.people.iter().any(is_chosen) {
        return Ok(false);
    }
    let member = world.member(who);
    world.walkers.set_speed(member, HURRY_M_PER_SEC)?;
    world.walkers.set_heedless(member, true)?;
    let until = world.now + HURRY_SECS;
    world.people[who].doing = Doing::Hurries { victim, until };
    Ok(true)
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let now = world.now;
    match world.people[who].doing {
        Doing::Hurries { victim, until } => {
            let reads = matches!(world.people[victim].doing, Doing::Texts { .. });
            if !reads || now > until {
                return world.go_on(who);
            }
            let to = world.position(victim) - world.position(who);
            if to.length() < TOUCH_M {
                stumble(world, crowd, who, victim)?;
                return fall(world, crowd, victim, to);
            }
            // Past the other one, so that it does not slow down before.
            let beyond = world.position(victim) + to.normalize_or_zero() * 1.5;
            world.send(who, beyond)?;
        }
        Doing::Stops { until } if now > until => {
            world.end(crowd, who, UPPER, 0.3)?;
            world.look_ahead(crowd, who)?;
            world.go_on(who)?;
        }
        Doing::Falls { until } => {
            let rests = world.ragdolls.state(world.member(who)) == State::Limp { asleep: true };
            if rests || now > until {
                let (member, get_up) = (world.member(who), world.body(who).get_up);
                world.ragdolls.get_up_with(crowd, member, &get_up)?;
                let [x, _, z] = crowd.member(member)?.placement().position();
                world.walkers.rest(member, [x, z], LYING_M)?;
                world.people[who].doing = Doing::GetsUp;
            }
        }
        Doing::GetsUp if world.ragdolls.state(world.member(who)) == State::Animated => {
            let member = world.member(who);
            world.walkers.resume(crowd, member)?;
            world.counts.got_up += 1;
            world.go_on(who)?;
        }
        _ => {}
    }
    Ok(())
}

/// Lets somebody fall who was hit along a direction.
pub(crate) fn fall(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    along: Vec2,
) -> Result<(), Error> {
    let member = world.member(who);
    world.end(crowd, who, UPPER, 0.3)?;
    let middle = world.position(who) + along.normalize_or_zero() * LIES_AHEAD_M;
    world.walkers.rest(member, middle.to_array(), LYING_M)?;
    let body = world.body(who);
    let (plan, chest) = (Arc::clone(&body.ragdoll), body.chest);
    world.ragdolls.go_limp(crowd, member, &plan)?;
    if let Some(chest) = chest {
        let push = along.normalize_or_zero() * PUSH_M_PER_SEC * plan.mass_kg();
        world.ragdolls.push(member, chest, [push.x, 0.0, push.y], None)?;
    }
    world.people[who].doing = Doing::Falls { until: world.now + LIES_SECS };
    world.counts.fell += 1;
    Ok(())
}

/// Returns the direction of a heading in degrees.
pub(crate) fn direction(facing_deg: f32) -> Vec2 {
    let (sin, cos) = facing_deg.to_radians().sin_cos();
    Vec2::new(sin, cos)
}

/// Lets somebody who has run into another one step back and look at it.
fn stumble(world: &mut World, crowd: &mut Crowd, who: usize, victim: usize) -> Result<(), Error> {
    let ahead = (world.position(victim) - world.position(who)).normalize_or_zero();
    let member = world.member(who);
    // The other one takes all of the speed.
    world.walkers.rest(member, world.position(who).to_array(), TOUCH_M)?;
    world.walkers.resume(crowd, member)?;
    world.walkers.set_speed(member, STEPS_BACK_M_PER_SEC)?;
    world.face(who, Some(ahead.x.atan2(ahead.y)))?;
    world.send(who, world.position(victim) - ahead * STEPS_BACK_M)?;
    let once = ClipPlayback::once().fade_in_secs(0.1);
    world.play(crowd, who, Use::Hit, (UPPER, once))?;
    let at = world.above(crowd, victim, 0.2)?;
    world.look(crowd, who, at)?;
    world.people[who].doing = Doing::Stops { until: world.now + STOP_SECS };
    Ok(())
}
