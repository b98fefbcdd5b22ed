//! The beginning of a scene: people who stroll are in the middle of what they do.

use populace::Crowd;

use super::footways::Place;
use super::settling::Settling;
use super::world::{Counts, World};
use super::{crossings, groups, leans, phones, seats, talks, windows};
use crate::Error;
use crate::plan::StrollPlan;

/// Distance of people who begin on their way, in metres.
const APART_M: f32 = 0.8;
/// Seconds that activities take with the way to them, and that one looks, sits, leans, talks,
/// telephones and reads. Crossings take a wait and the way across.
const LOOKS_SECS: f32 = 7.5;
const CROSSES_SECS: f32 = 13.0;
const SITS_SECS: f32 = 16.5;
/// Includes the time of the people who were met.
const TALKS_SECS: f32 = 2.4 * 15.0;
const LEANS_SECS: f32 = 15.0;
const PHONES_SECS: f32 = 14.0;
const READS_SECS: f32 = 10.0;

/// Something that people begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Activity {
    Looks,
    Crosses,
    Sits,
    Talks,
    Leans,
    Phones,
    Reads,
}

/// Brings people who stroll to where they begin: some look into windows, sit, talk, telephone, read
/// or cross, in the shares that their habits have in the long run.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    (mut settling, habits): (Settling<'_>, &StrollPlan),
    people: &[usize],
) -> Result<(), Error> {
    crossings::hold(world, crowd)?;
    let (mut walk, mut talk) = (Vec::new(), Vec::new());
    for who in people.iter().copied() {
        let activity = choose(habits, world.people[who].random.unit());
        let needs_hands = !matches!(activity, Some(Activity::Looks | Activity::Crosses));
        let activity = activity.filter(|_| !(needs_hands && world.people[who].carries));
        let has_begun = match activity {
            Some(Activity::Looks) => windows::settle(world, crowd, who, &mut settling)?,
            Some(Activity::Sits) => seats::settle(world, crowd, who, &mut settling)?,
            Some(Activity::Crosses) => crossings::settle(world, crowd, who, &mut settling)?,
            Some(Activity::Leans) => leans::settle(world, crowd, who, &mut settling)?,
            Some(Activity::Talks) => {
                talk.push(who);
                true
            }
            _ => false,
        };
        if !has_begun {
            walk.push((who, activity));
        }
    }
    let mut talk = &talk[..];
    while let Some(first) = talk.first() {
        let count = if world.people[*first].random.chance(0.4) { 3 } else { 2 };
        let (group, others) = talk.split_at(count.min(talk.len()));
        if !talks::settle(world, crowd, group, &mut settling)? {
            walk.extend(group.iter().map(|who| (*who, None)));
        }
        talk = others;
    }
    let joins = |(who, activity): &(usize, Option<Activity>)| {
        let person = &mut world.people[*who];
        activity.is_none() && !person.carries && person.random.chance(habits.together)
    };
    let (join, mut walk): (Vec<_>, Vec<_>) = walk.into_iter().partition(joins);
    let join: Vec<usize> = join.into_iter().map(|(who, _)| who).collect();
    let alone = groups::settle(world, crowd, &mut settling, &join)?;
    walk.extend(alone.into_iter().map(|who| (who, None)));
    for (who, activity) in walk {
        set_off(&mut settling, world, crowd, who)?;
        match activity {
            Some(Activity::Phones) => phones::call(world, crowd, who)?,
            Some(Activity::Reads) => phones::read(world, crowd, who)?,
            _ => false,
        };
    }
    // What people began with has not happened in the scene.
    let Counts { carried, together, .. } = world.counts;
    world.counts = Counts { carried, together, ..Counts::default() };
    Ok(())
}

/// Chooses what somebody begins with, by a number from 0 to 1; `None` to be on its way.
fn choose(habits: &StrollPlan, part: f32) -> Option<Activity> {
    let secs = [
        (Activity::Looks, habits.look_in * LOOKS_SECS),
        (Activity::Crosses, habits.cross * CROSSES_SECS),
        (Activity::Sits, habits.sit * SITS_SECS),
        (Activity::Talks, habits.talk * TALKS_SECS),
        (Activity::Leans, habits.lean * LEANS_SECS),
        (Activity::Phones, habits.phone * PHONES_SECS),
        (Activity::Reads, habits.text * READS_SECS),
    ];
    // For each minute of walking, a person spends these seconds on each.
    let all: f32 = 60.0 + secs.iter().map(|(_, secs)| secs).sum::<f32>();
    let mut left = part * all;
    secs.into_iter().find_map(|(activity, secs)| {
        left -= secs;
        (left < 0.0).then_some(activity)
    })
}

/// Puts somebody on a footway, on its way.
fn set_off(
    settling: &mut Settling<'_>,
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
) -> Result<(), Error> {
    // Closer together where there is no more room, and then anywhere out of walls.
    let apart_m = [APART_M, 0.5 * APART_M, 0.0];
    let found = apart_m.into_iter().find_map(|apart_m| settling.place(world, who, 0.0, apart_m));
    let first = settling.footways.first().copied().unwrap_or(0);
    let (footway, at, line) = found.unwrap_or_else(|| {
        let along_m = world.people[who].random.unit() * world.footways[first].length_m();
        let (at, line) = world.footways[first].at(Place { along_m, aside_m: 0.0 });
        (first, at, line)
    });
    let strip = &world.footways[footway];
    let aside = strip.place(at).aside_m / strip.half_m;
    let person = &mut world.people[who];
    person.footway = footway;
    // On the right side of the line in its direction.
    person.direction = if aside > 0.0 { -1.0 } else { 1.0 };
    person.lane = aside.abs().clamp(0.05, 0.95);
    let (ahead, pace) = (line * person.direction, person.pace);
    settling.put(world, crowd, who, (at, ahead.x.atan2(ahead.y), pace))?;
    world.go_on(who)
}
