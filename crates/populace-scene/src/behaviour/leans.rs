//! Leaning against a wall.

use glam::Vec2;
use populace::{ClipPlayback, Crowd};

use super::body::Use;
use super::person::Doing;
use super::places::PlacePlan;
use super::settling::Settling;
use super::world::{UPPER, WHOLE, World};
use crate::Error;

/// Distance at which a wall is noticed, in metres.
const NOTICED_M: f32 = 12.0;
const PATIENCE_SECS: f64 = 20.0;
/// Seconds from standing to leaning, and back.
const FADE_SECS: f32 = 0.9;
/// How long people lean, in seconds.
const LEANS_SECS: [f32; 2] = [8.0, 22.0];
/// The part of those who lean that read messages meanwhile.
const READS: f32 = 0.4;

/// Lets somebody who strolls walk to a free wall near by. Returns true if there is one.
pub(crate) fn begin(world: &mut World, who: usize) -> Result<bool, Error> {
    if !world.body(who).has(&[Use::Lean]) {
        return Ok(false);
    }
    let at = world.position(who);
    let footway = &world.footways[world.people[who].footway];
    let is_near = |wall: Vec2| wall.distance(at) < NOTICED_M && footway.distance_m(wall) < 1.5;
    let Some(lean) = world.leans.nearest_free(at, is_near) else { return Ok(false) };
    world.leans.take(lean);
    world.people[who].doing = Doing::NearsWall { lean, until: world.now + PATIENCE_SECS };
    let to = world.leans[lean].at();
    world.send(who, to)?;
    Ok(true)
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let now = world.now;
    match world.people[who].doing {
        Doing::NearsWall { lean, until } => {
            if world.stops_at_goal(who, world.leans.yaw_rad(lean))? {
                world.people[who].doing = Doing::FacesAway { lean, until: now + 5.0 };
            } else if now > until {
                world.leans.leave(lean);
                world.go_on(who)?;
            }
        }
        Doing::FacesAway { lean, until } => {
            let yaw_rad = world.leans.yaw_rad(lean);
            if world.faces(crowd, who, yaw_rad)? || now > until {
                let secs = world.people[who].random.between_f32(LEANS_SECS[0], LEANS_SECS[1]);
                world.counts.leaned += 1;
                stand_against(world, crowd, who, (lean, now + f64::from(secs)))?;
            }
        }
        Doing::Leans { lean, until } if now > until => {
            world.end(crowd, who, UPPER, FADE_SECS)?;
            world.end(crowd, who, WHOLE, FADE_SECS)?;
            let until = now + f64::from(FADE_SECS);
            world.people[who].doing = Doing::Straightens { lean, until };
        }
        Doing::Straightens { lean, until } if now > until => {
            world.leans.leave(lean);
            world.go_on(who)?;
        }
        _ => {}
    }
    Ok(())
}

/// Leans until a time. Some read messages meanwhile.
fn stand_against(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    (lean, until): (usize, f64),
) -> Result<(), Error> {
    let member = world.member(who);
    world.walkers.set_heedless(member, true)?;
    let phase = world.people[who].random.unit();
    let looping = ClipPlayback::looping().phase(phase).fade_in_secs(FADE_SECS);
    world.play(crowd, who, Use::Lean, (WHOLE, looping))?;
    if world.people[who].random.chance(READS) {
        world.play(crowd, who, Use::Text, (UPPER, looping))?;
    }
    world.people[who].doing = Doing::Leans { lean, until };
    Ok(())
}

/// Begins at a free wall beside one of some footways. Returns false without one.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    settling: &mut Settling<'_>,
) -> Result<bool, Error> {
    if !world.body(who).has(&[Use::Lean]) {
        return Ok(false);
    }
    let part = world.people[who].random.unit();
    let Some((lean, footway)) = settling.free(world, &world.leans, part) else { return Ok(false) };
    world.leans.take(lean);
    let (at, yaw_rad) = (world.leans[lean].at(), world.leans.yaw_rad(lean));
    settling.put(world, crowd, who, (at, yaw_rad, 0.0))?;
    world.face(who, Some(yaw_rad))?;
    world.people[who].footway = footway;
    let until = f64::from(world.people[who].random.between_f32(0.5, LEANS_SECS[1]));
    stand_against(world, crowd, who, (lean, until))?;
    Ok(true)
}
