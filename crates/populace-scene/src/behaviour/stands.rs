//! Spectators on a stand: they watch, clap, cheer and do the wave.

use glam::Vec2;
use populace::{ClipPlayback, Crowd};

use super::body::Use;
use super::person::{Doing, Kind};
use super::world::{Stand, UPPER, WHOLE, World, per_turn};
use crate::Error;

const FADE_SECS: f32 = 0.3;
/// Time in seconds that somebody stands in a wave.
const STANDS_SECS: f64 = 0.5;

/// Goes on with what a spectator does.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let Kind::Spectates(stand) = world.people[who].kind else { return Ok(()) };
    let now = world.now;
    let post = world.people[who].post;
    match world.people[who].doing {
        Doing::Watches | Doing::Claps { .. } | Doing::Cheers { .. }
            if passes(&world.stands[stand], post, [now - world.step_secs, now]) =>
        {
            let once = ClipPlayback::once().fade_in_secs(FADE_SECS);
            let playing = world.play(crowd, who, Use::StandUp, (WHOLE, once))?;
            let looping = ClipPlayback::looping().fade_in_secs(FADE_SECS);
            world.play(crowd, who, Use::Cheer, (UPPER, looping))?;
            let secs = playing.map_or(0.0, |(_, secs)| secs);
            world.people[who].doing = Doing::Rises { until: now + secs + STANDS_SECS };
            world.counts.waved += 1;
        }
        Doing::Watches if world.is_turn(who) => {
            let plan = &world.stands[stand].plan;
            let (clap, cheer) = (per_turn(plan.clap), per_turn(plan.cheer));
            if world.people[who].random.chance(clap) {
                let until = begin(world, crowd, (who, Use::Clap), [2.5, 6.0])?;
                world.people[who].doing = Doing::Claps { until };
                world.counts.clapped += 1;
            } else if world.people[who].random.chance(cheer) {
                let until = begin(world, crowd, (who, Use::Cheer), [1.5, 4.0])?;
                world.people[who].doing = Doing::Cheers { until };
                world.counts.cheered += 1;
            }
        }
        Doing::Claps { until } | Doing::Cheers { until } if now > until => {
            world.end(crowd, who, UPPER, FADE_SECS)?;
            world.people[who].doing = Doing::Watches;
        }
        Doing::Rises { until } if now > until => {
            let once = ClipPlayback::once().fade_in_secs(FADE_SECS);
            let playing = world.play(crowd, who, Use::SitDown, (WHOLE, once))?;
            world.end(crowd, who, UPPER, 2.0 * FADE_SECS)?;
            let secs = playing.map_or(0.0, |(_, secs)| secs);
            world.people[who].doing = Doing::Subsides { until: now + secs };
        }
        Doing::Subsides { until } if now > until => {
            world.end(crowd, who, WHOLE, FADE_SECS)?;
            world.people[who].doing = Doing::Watches;
        }
        _ => {}
    }
    Ok(())
}

/// Plays a motion of the upper body, and returns when it ends.
fn begin(
    world: &mut World,
    crowd: &mut Crowd,
    (who, usage): (usize, Use),
    [least, most]: [f32; 2],
) -> Result<f64, Error> {
    let phase = world.people[who].random.unit();
    let playback = ClipPlayback::looping().phase(phase).fade_in_secs(FADE_SECS);
    world.play(crowd, who, usage, (UPPER, playback))?;
    Ok(world.now + f64::from(world.people[who].random.between_f32(least, most)))
}

/// Returns true if a wave passes a seat between two times.
fn passes(stand: &Stand, seat: Vec2, [from, to]: [f64; 2]) -> bool {
    let every = f64::from(stand.plan.wave_every_s);
    if every <= 0.0 || stand.plan.wave_speed <= 0.0 {
        return false;
    }
    let along = (seat - stand.first).dot(stand.along).abs();
    let after = f64::from(along / stand.plan.wave_speed);
    // The first wave begins after one interval.
    let waves = |now: f64| ((now - after) / every).floor();
    waves(to) > waves(from) && waves(to) >= 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::SpectatePlan;

    #[test]
    fn a_wave_passes_each_seat_once_and_later_further_away() {
        let plan = SpectatePlan { wave_every_s: 10.0, wave_speed: 5.0, ..SpectatePlan::default() };
        let stand = Stand { plan, first: Vec2::ZERO, along: Vec2::X };
        let passed = |x: f32| -> Vec<u32> {
            let at = |step: u32| f64::from(step) / 10.0;
            let passes = |step: &u32| passes(&stand, Vec2::new(x, 3.0), [at(*step), at(step + 1)]);
            (0..250).filter(passes).collect()
        };
        assert_eq!(passed(0.0), [99, 199]);
        assert_eq!(passed(10.0), [119, 219]);
    }
}
