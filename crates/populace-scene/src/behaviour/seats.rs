//! Sitting down on a bench, and standing up again.

use glam::Vec2;
use populace::{ClipPlayback, Crowd};

use super::body::Use;
use super::person::Doing;
use super::places::PlacePlan;
use super::settling::Settling;
use super::world::{UPPER, WHOLE, World};
use crate::Error;

/// Distance at which a seat is noticed, in metres.
const NOTICED_M: f32 = 10.0;
const PATIENCE_SECS: f64 = 20.0;
const FADE_SECS: f32 = 0.25;
/// Shares of seated people who telephone or read.
const PHONES: f32 = 0.2;
const READS: f32 = 0.35;
/// How long people sit, in seconds.
pub(crate) const SITS_SECS: [f32; 2] = [9.0, 24.0];

/// Lets somebody who strolls walk to a free seat near by. Returns true if there is one.
pub(crate) fn begin(world: &mut World, who: usize) -> Result<bool, Error> {
    if !world.body(who).has(&[Use::SitDown, Use::Sit, Use::StandUp]) {
        return Ok(false);
    }
    let at = world.position(who);
    let footway = &world.footways[world.people[who].footway];
    let is_near = |seat: Vec2| seat.distance(at) < NOTICED_M && footway.distance_m(seat) < 1.0;
    let Some(seat) = world.seats.nearest_free(at, is_near) else { return Ok(false) };
    world.seats.take(seat);
    world.people[who].doing = Doing::NearsSeat { seat, until: world.now + PATIENCE_SECS };
    let to = front(world, seat);
    world.send(who, to)?;
    Ok(true)
}

/// Returns where somebody stands before sitting down on a seat.
fn front(world: &World, seat: usize) -> Vec2 {
    let (sin, cos) = world.seats.yaw_rad(seat).sin_cos();
    world.seats[seat].at() + Vec2::new(sin, cos) * populace_cast::SEAT_BACK_M
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let now = world.now;
    let once = ClipPlayback::once().fade_in_secs(FADE_SECS);
    match world.people[who].doing {
        Doing::NearsSeat { seat, until } => {
            if world.stops_at_goal(who, world.seats.yaw_rad(seat))? {
                world.people[who].doing = Doing::FacesSeat { seat, until: now + 5.0 };
            } else if now > until {
                world.seats.leave(seat);
                world.go_on(who)?;
            }
        }
        Doing::FacesSeat { seat, until } => {
            let yaw_rad = world.seats.yaw_rad(seat);
            if world.faces(crowd, who, yaw_rad)? || now > until {
                let member = world.member(who);
                world.walkers.set_heedless(member, true)?;
                let playing = world.play(crowd, who, Use::SitDown, (WHOLE, once))?;
                let secs = playing.map_or(0.0, |(_, secs)| secs);
                world.people[who].doing = Doing::SitsDown { seat, until: now + secs };
                world.counts.sat += 1;
            }
        }
        Doing::SitsDown { seat, until } if now > until => {
            let secs = world.people[who].random.between_f32(SITS_SECS[0], SITS_SECS[1]);
            let until = now + f64::from(secs);
            sit(world, crowd, who, ClipPlayback::looping().fade_in_secs(FADE_SECS))?;
            world.people[who].doing = Doing::Sits { seat, until };
        }
        Doing::Sits { seat, until } if now > until => {
            world.end(crowd, who, UPPER, FADE_SECS)?;
            let playing = world.play(crowd, who, Use::StandUp, (WHOLE, once))?;
            let secs = playing.map_or(0.0, |(_, secs)| secs);
            world.people[who].doing = Doing::StandsUp { seat, until: now + secs };
        }
        Doing::StandsUp { seat, until } if now > until => {
            world.end(crowd, who, WHOLE, FADE_SECS)?;
            world.seats.leave(seat);
            world.go_on(who)?;
        }
        _ => {}
    }
    Ok(())
}

/// Sits from now on. Some telephone or read meanwhile.
fn sit(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    playback: ClipPlayback,
) -> Result<(), Error> {
    world.play(crowd, who, Use::Sit, (WHOLE, playback))?;
    let chance = world.people[who].random.unit();
    if chance < PHONES {
        world.play(crowd, who, Use::Phone, (UPPER, playback))?;
    } else if chance < PHONES + READS {
        world.play(crowd, who, Use::Text, (UPPER, playback))?;
    }
    Ok(())
}

/// Begins on a free seat beside one of some footways. Returns false without one.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    settling: &mut Settling<'_>,
) -> Result<bool, Error> {
    if !world.body(who).has(&[Use::SitDown, Use::Sit, Use::StandUp]) {
        return Ok(false);
    }
    let part = world.people[who].random.unit();
    let Some((seat, footway)) = settling.free(world, &world.seats, part) else { return Ok(false) };
    world.seats.take(seat);
    let (at, yaw_rad) = (front(world, seat), world.seats.yaw_rad(seat));
    settling.put(world, crowd, who, (at, yaw_rad, 0.0))?;
    world.face(who, Some(yaw_rad))?;
    let member = world.member(who);
    world.walkers.set_heedless(member, true)?;
    let phase = world.people[who].random.unit();
    sit(world, crowd, who, ClipPlayback::looping().phase(phase))?;
    let until = f64::from(world.people[who].random.between_f32(0.5, SITS_SECS[1]));
    let person = &mut world.people[who];
    (person.footway, person.doing) = (footway, Doing::Sits { seat, until });
    Ok(true)
}
