//! Twos and threes who walk side by side and talk on the way.
//!
//! Most people in a street are not alone: M. Moussaïd, N. Perozo, S. Garnier, D. Helbing and
//! G. Theraulaz, "The walking behaviour of pedestrian social groups and its impact on crowd
//! dynamics", PLoS ONE 5(4), 2010. Walkers keep groups together; here is where they go.

use glam::Vec2;
use populace::{ClipPlayback, Crowd};

use super::body::Use;
use super::settling::Settling;
use super::world::{Group, UPPER, World};
use crate::Error;

/// Distance of neighbours in a group, in metres.
const BESIDE_M: f32 = 0.72;
/// Distance of a group that begins from others, in metres.
const APART_M: f32 = 0.7;
/// The share of groups of three.
const THREES: f32 = 0.25;
/// The share of turns in which somebody talks, and in which its hands do too.
const TALKS: f32 = 0.7;
const GESTURES: f32 = 0.6;
/// Seconds of a turn, and of the glances at its beginning.
const TURN_SECS: [f32; 2] = [2.5, 6.0];
const GLANCE_SECS: f64 = 1.7;
const FADE_SECS: f32 = 0.4;

/// Forms groups of people who are about to walk, and puts them on footways. Returns those who are
/// left over.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    settling: &mut Settling<'_>,
    mut people: &[usize],
) -> Result<Vec<usize>, Error> {
    let mut alone = Vec::new();
    while let [first, _, ..] = *people {
        let count = if world.people[first].random.chance(THREES) { people.len().min(3) } else { 2 };
        let (group, others) = people.split_at(count);
        if !set_off(world, crowd, settling, group)? {
            alone.extend(group);
        }
        people = others;
    }
    alone.extend(people);
    Ok(alone)
}

/// Returns the distance of the outermost of a group from its middle, in metres.
fn half_width_m(count: usize) -> f32 {
    0.5 * BESIDE_M * (count - 1) as f32
}

/// Puts a group on a footway, side by side. Returns false without a place for it.
fn set_off(
    world: &mut World,
    crowd: &mut Crowd,
    settling: &mut Settling<'_>,
    people: &[usize],
) -> Result<bool, Error> {
    let half_m = half_width_m(people.len());
    let place = settling.place(world, people[0], half_m, half_m + APART_M);
    let Some((footway, middle, line)) = place else { return Ok(false) };
    let strip = &world.footways[footway];
    if strip.half_m < half_m {
        return Ok(false);
    }
    let aside_m = strip.place(middle).aside_m;
    // On the right side of the line in its direction.
    let direction = if aside_m > 0.0 { -1.0 } else { 1.0 };
    let ahead = line * direction;
    let right = Vec2::new(-ahead.y, ahead.x);
    let pace = people.iter().map(|who| world.people[*who].pace).fold(f32::INFINITY, f32::min);
    let index = world.groups.len();
    world.groups.push(Group {
        people: people.to_vec(),
        speaker: 0,
        turn_until: 0.0,
        glance_until: None,
        gestures: false,
    });
    for (nth, who) in people.iter().enumerate() {
        let off_m = nth as f32 * BESIDE_M - half_m;
        let at = middle + right * off_m;
        let half = world.footways[footway].half_m;
        let person = &mut world.people[*who];
        (person.footway, person.direction, person.pace) = (footway, direction, pace);
        person.lane = (aside_m.abs() + off_m) / half;
        person.group = Some(index);
        settling.put(world, crowd, *who, (at, ahead.x.atan2(ahead.y), pace))?;
        world.walkers.set_group(world.people[*who].member, number(index))?;
        world.counts.together += 1;
    }
    people.iter().try_for_each(|who| world.go_on(*who))?;
    let passed = world.people[people[0]].random.unit();
    let mut group = world.groups[index].clone();
    take_turn(world, crowd, &mut group, passed)?;
    glance(world, crowd, &mut group)?;
    world.groups[index] = group;
    Ok(true)
}

/// Returns the number of a group among walkers, of which 0 is no group.
fn number(index: usize) -> u32 {
    u32::try_from(index + 1).unwrap_or(0)
}

/// Goes on with the talk of each group.
pub(crate) fn step_all(world: &mut World, crowd: &mut Crowd) -> Result<(), Error> {
    let mut groups = std::mem::take(&mut world.groups);
    let stepped = groups.iter_mut().try_for_each(|group| step(world, crowd, group));
    world.groups = groups;
    stepped
}

fn step(world: &mut World, crowd: &mut Crowd, group: &mut Group) -> Result<(), Error> {
    if world.now >= group.turn_until {
        take_turn(world, crowd, group, 0.0)?;
    }
    glance(world, crowd, group)
}

/// Begins the turn of the next speaker, who talks or is silent. `passed` is the share of the turn,
/// 0 to 1, that is over.
fn take_turn(
    world: &mut World,
    crowd: &mut Crowd,
    group: &mut Group,
    passed: f32,
) -> Result<(), Error> {
    if group.gestures {
        world.end(crowd, group.people[group.speaker], UPPER, FADE_SECS)?;
        group.gestures = false;
    }
    group.speaker = (group.speaker + 1) % group.people.len();
    let speaker = group.people[group.speaker];
    let random = &mut world.people[speaker].random;
    let secs = f64::from(random.between_f32(TURN_SECS[0], TURN_SECS[1]));
    let began = world.now - f64::from(passed) * secs;
    group.turn_until = began + secs;
    if !random.chance(TALKS) {
        return Ok(());
    }
    group.glance_until = Some(began + GLANCE_SECS);
    if random.chance(GESTURES) {
        let phase = random.unit();
        let playback = ClipPlayback::looping().phase(phase).fade_in_secs(FADE_SECS);
        group.gestures = world.play(crowd, speaker, Use::Talk, (UPPER, playback))?.is_some();
    }
    Ok(())
}

/// Turns heads until `glance_until`: that of the speaker to the next member of the group, the others
/// to the speaker.
fn glance(world: &World, crowd: &mut Crowd, group: &mut Group) -> Result<(), Error> {
    let Some(until) = group.glance_until else { return Ok(()) };
    if world.now > until {
        group.glance_until = None;
        return group.people.iter().try_for_each(|who| world.look_ahead(crowd, *who));
    }
    let speaker = group.people[group.speaker];
    let listener = group.people[(group.speaker + 1) % group.people.len()];
    for who in group.people.iter().copied() {
        let at = world.above(crowd, if who == speaker { listener } else { speaker }, 1.0)?;
        world.follow(crowd, who, at)?;
    }
    Ok(())
}

impl World {
    /// Turns somebody who walks alone round, or a group: on a new lane, where it makes room.
    pub(crate) fn turn_round(&mut self, who: usize) -> Result<(), Error> {
        let person = &mut self.people[who];
        let (group, direction) = (person.group, -person.direction);
        let lane = person.random.between_f32(0.1, 0.95);
        (person.direction, person.lane, person.held_up) = (direction, lane, 0);
        let Some(group) = group else { return Ok(()) };
        for nth in 0..self.groups[group].people.len() {
            let other = self.groups[group].people[nth];
            let person = &mut self.people[other];
            (person.direction, person.lane, person.held_up) = (direction, lane, 0);
            // The caller sends `who`.
            if other != who {
                self.send_ahead(other)?;
            }
        }
        Ok(())
    }
}
