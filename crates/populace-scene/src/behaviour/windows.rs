//! Looking into windows.

use glam::Vec2;
use populace::{ClipPlayback, Crowd};

use super::body::Use;
use super::person::Doing;
use super::places::PlacePlan;
use super::settling::Settling;
use super::world::{WHOLE, World};
use crate::Error;

/// How far ahead a window is noticed, and how far somebody walks aside to it, in metres.
const NOTICED_M: f32 = 14.0;
/// Seconds after which somebody who cannot get there goes on.
const PATIENCE_SECS: f64 = 20.0;
const FADE_SECS: f32 = 0.45;
/// How long people look, in seconds.
pub(crate) const LOOKS_SECS: [f32; 2] = [4.0, 11.0];

/// Lets somebody who strolls walk to a free spot ahead. Returns true if there is one.
pub(crate) fn begin(world: &mut World, who: usize) -> Result<bool, Error> {
    if !world.body(who).has(&[Use::LookIn]) {
        return Ok(false);
    }
    let at = world.position(who);
    let person = &world.people[who];
    let footway = &world.footways[person.footway];
    let (_, along) = footway.at(footway.place(at));
    let ahead = along * person.direction;
    let reachable = |spot: Vec2| {
        let off = spot - at;
        off.length() < NOTICED_M && off.dot(ahead) > 1.0 && footway.distance_m(spot) < 1.5
    };
    let Some(spot) = world.spots.nearest_free(at, reachable) else { return Ok(false) };
    world.spots.take(spot);
    world.people[who].doing = Doing::NearsSpot { spot, until: world.now + PATIENCE_SECS };
    let to = world.spots[spot].at();
    world.send(who, to)?;
    Ok(true)
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let now = world.now;
    match world.people[who].doing {
        Doing::NearsSpot { spot, until } => {
            if world.stops_at_goal(who, world.spots.yaw_rad(spot))? {
                world.people[who].doing = Doing::FacesSpot { spot, until: now + 4.0 };
            } else if now > until {
                leave(world, who, spot)?;
            }
        }
        Doing::FacesSpot { spot, until } => {
            let yaw_rad = world.spots.yaw_rad(spot);
            if world.faces(crowd, who, yaw_rad)? || now > until {
                let secs = world.people[who].random.between_f32(LOOKS_SECS[0], LOOKS_SECS[1]);
                look_in(world, crowd, who, (spot, now + f64::from(secs)))?;
                world.counts.looked_in += 1;
            }
        }
        Doing::LooksIn { spot, until } if now > until => {
            world.end(crowd, who, WHOLE, FADE_SECS)?;
            world.look_ahead(crowd, who)?;
            leave(world, who, spot)?;
        }
        _ => {}
    }
    Ok(())
}

fn leave(world: &mut World, who: usize, spot: usize) -> Result<(), Error> {
    world.spots.leave(spot);
    world.go_on(who)
}

/// Looks into the window of a spot until a time.
fn look_in(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    (spot, until): (usize, f64),
) -> Result<(), Error> {
    let playback = ClipPlayback::looping().fade_in_secs(FADE_SECS);
    world.play(crowd, who, Use::LookIn, (WHOLE, playback))?;
    let look_at = world.spots[spot].look_at;
    world.look(crowd, who, look_at)?;
    world.people[who].doing = Doing::LooksIn { spot, until };
    Ok(())
}

/// Begins at a free spot beside one of some footways. Returns false without one.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    settling: &mut Settling<'_>,
) -> Result<bool, Error> {
    if !world.body(who).has(&[Use::LookIn]) {
        return Ok(false);
    }
    let part = world.people[who].random.unit();
    let Some((spot, footway)) = settling.free(world, &world.spots, part) else { return Ok(false) };
    world.spots.take(spot);
    let (at, yaw_rad) = (world.spots[spot].at(), world.spots.yaw_rad(spot));
    settling.put(world, crowd, who, (at, yaw_rad, 0.0))?;
    world.face(who, Some(yaw_rad))?;
    world.people[who].footway = footway;
    let until = f64::from(world.people[who].random.between_f32(0.5, LOOKS_SECS[1]));
    look_in(world, crowd, who, (spot, until))?;
    Ok(true)
}
