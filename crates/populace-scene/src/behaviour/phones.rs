//! Telephoning, and reading messages on the way.

use populace::{ClipPlayback, Crowd};

use super::body::Use;
use super::person::Doing;
use super::world::{UPPER, World};
use crate::Error;

const FADE_SECS: f32 = 0.4;
/// Shares of their pace at which people walk who telephone and who read. Readers walk a
/// third slower (E. M. Lamberg and L. M. Muratori, "Cell phones change the way we walk", Gait &
/// Posture 35 (2012), 688-690: 16 % for talking, 33 % for texting).
const CALL_PACE: f32 = 0.84;
const READ_PACE: f32 = 0.67;

/// Lets somebody who strolls telephone. Returns true for a body that can.
pub(crate) fn call(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<bool, Error> {
    let Some(until) = begin(world, crowd, (who, Use::Phone), [8.0, 20.0], CALL_PACE)? else {
        return Ok(false);
    };
    world.people[who].doing = Doing::Phones { until };
    world.counts.phoned += 1;
    Ok(true)
}

/// Lets somebody who strolls read a message, without heed for others. Returns true for a body that
/// can.
pub(crate) fn read(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<bool, Error> {
    let Some(until) = begin(world, crowd, (who, Use::Text), [6.0, 14.0], READ_PACE)? else {
        return Ok(false);
    };
    let member = world.member(who);
    world.walkers.set_heedless(member, true)?;
    world.people[who].doing = Doing::Texts { until };
    world.counts.texted += 1;
    Ok(true)
}

fn begin(
    world: &mut World,
    crowd: &mut Crowd,
    (who, usage): (usize, Use),
    [least, most]: [f32; 2],
    pace: f32,
) -> Result<Option<f64>, Error> {
    let playback = ClipPlayback::looping().fade_in_secs(FADE_SECS);
    if world.play(crowd, who, usage, (UPPER, playback))?.is_none() {
        return Ok(None);
    }
    let (member, own) = (world.member(who), world.people[who].pace);
    world.walkers.set_speed(member, pace * own)?;
    let secs = world.people[who].random.between_f32(least, most);
    Ok(Some(world.now + f64::from(secs)))
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    match world.people[who].doing {
        Doing::Phones { until } | Doing::Texts { until } if world.now > until => {
            world.end(crowd, who, UPPER, FADE_SECS)?;
            world.go_on(who)
        }
        Doing::Phones { .. } | Doing::Texts { .. } => world.keep_going(who),
        _ => Ok(()),
    }
}
