//! Soldiers in lines of battle: they advance to their posts, thrust, are hit, fall and get up.

use populace::{ClipPlayback, Crowd};
use populace_locomotion::Goal;

use super::body::Use;
use super::falls;
use super::person::{Doing, Kind};
use super::world::{UPPER, World, per_turn};
use crate::Error;

const FADE_SECS: f32 = 0.25;
/// Distance from a post at which somebody has reached it, in metres.
const REACHED_M: f32 = 0.15;
/// The share of those hit who fall.
const FALLS: f32 = 0.25;

/// Goes on with what a soldier does.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let Kind::Fights(army) = world.people[who].kind else { return Ok(()) };
    let now = world.now;
    match world.people[who].doing {
        Doing::Advances if world.position(who).distance(world.people[who].post) < REACHED_M => {
            let member = world.member(who);
            world.walkers.set_goal(member, Goal::Stand)?;
            let facing = world.armies[army].facing_deg.to_radians();
            world.walkers.set_facing(member, Some(facing))?;
            world.people[who].doing = Doing::Guards;
        }
        Doing::Guards if world.people[who].is_in_front && world.is_turn(who) => {
            let plan = &world.armies[army];
            let (thrust, hit) = (per_turn(plan.thrust), per_turn(plan.hit));
            if world.people[who].random.chance(thrust) {
                let until = begin(world, crowd, who, Use::Thrust)?;
                world.people[who].doing = Doing::Thrusts { until };
                world.counts.thrust += 1;
            } else if world.people[who].random.chance(hit) {
                world.counts.hit += 1;
                if world.people[who].random.chance(FALLS) && world.body(who).chest.is_some() {
                    let back = -falls::direction(world.armies[army].facing_deg);
                    return falls::fall(world, crowd, who, back);
                }
                let until = begin(world, crowd, who, Use::Hit)?;
                world.people[who].doing = Doing::Flinches { until };
            }
        }
        Doing::Thrusts { until } | Doing::Flinches { until } if now > until => {
            hold_spear(world, crowd, who)?;
            world.people[who].doing = Doing::Guards;
        }
        _ => {}
    }
    Ok(())
}

/// Plays a motion once, and returns when it ends.
fn begin(world: &mut World, crowd: &mut Crowd, who: usize, usage: Use) -> Result<f64, Error> {
    let once = ClipPlayback::once().fade_in_secs(FADE_SECS);
    let playing = world.play(crowd, who, usage, (UPPER, once))?;
    Ok(world.now + playing.map_or(0.0, |(_, secs)| secs))
}

/// Lets a soldier hold its spear, if it has the motion.
pub(crate) fn hold_spear(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let phase = world.people[who].random.unit();
    let playback = ClipPlayback::looping().phase(phase).fade_in_secs(FADE_SECS);
    world.play(crowd, who, Use::Spear, (UPPER, playback))?;
    Ok(())
}
