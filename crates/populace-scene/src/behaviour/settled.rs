//! The beginning of a scene: people who stroll are in the middle of what they do.

use std::collections::HashMap;

use glam::Vec2;
use populace::{Crowd, Ground, Placement};
use populace_locomotion::Lead;

use super::footways::Place;
use super::world::{Counts, World};
use super::{crossings, leans, phones, seats, talks, windows};
use crate::Error;
use crate::plan::StrollPlan;

/// Distance of people who begin on their way, in metres.
const APART_M: f32 = 0.8;
/// Tries to find a free place.
const TRIES: usize = 24;
/// Side of a cell of taken places in metres: the largest distance that is kept.
const CELL_M: f32 = 2.0;
/// Seconds that activities take with the way to them, and that one looks, sits, leans, talks,
/// telephones and reads. Crossings take a wait and the way across.
const LOOKS_SECS: f32 = 7.5;
const CROSSES_SECS: f32 = 13.0;
const SITS_SECS: f32 = 16.5;
/// A talk is that of those who were met, too.
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

/// Places for people who begin.
pub(crate) struct Settling<'a> {
    /// The footways on which they stroll.
    pub(crate) footways: &'a [usize],
    ground: &'a Ground,
    taken: HashMap<[i32; 2], Vec<Vec2>>,
}

/// Brings people who stroll to where they begin: some look into windows, sit, talk, telephone, read
/// or cross, in the shares that their habits have in the long run.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    (footways, habits, ground): (&[usize], &StrollPlan, &Ground),
    people: &[usize],
) -> Result<(), Error> {
    let mut settling = Settling { footways, ground, taken: HashMap::new() };
    crossings::hold(world, crowd)?;
    let (mut walk, mut talk) = (Vec::new(), Vec::new());
    for who in people.iter().copied() {
        let activity = choose(habits, world.people[who].random.part());
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
    while let Some(first) = talk.first() {
        let count = if world.people[*first].random.chance(0.4) { 3 } else { 2 };
        let group: Vec<usize> = talk.drain(..count.min(talk.len())).collect();
        if !talks::settle(world, crowd, &group, &mut settling)? {
            walk.extend(group.into_iter().map(|who| (who, None)));
        }
    }
    for (who, activity) in walk {
        settling.set_off(world, crowd, who)?;
        match activity {
            Some(Activity::Phones) => phones::call(world, crowd, who)?,
            Some(Activity::Reads) => phones::read(world, crowd, who)?,
            _ => false,
        };
    }
    // What people began with has not happened in the scene.
    let carried = world.counts.carried;
    world.counts = Counts { carried, ..Counts::default() };
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
    // Each minute on the way is followed by so many seconds of each.
    let all: f32 = 60.0 + secs.iter().map(|(_, secs)| secs).sum::<f32>();
    let mut left = part * all;
    secs.into_iter().find_map(|(activity, secs)| {
        left -= secs;
        (left < 0.0).then_some(activity)
    })
}

impl Settling<'_> {
    /// Returns the first free place from a part of all on that is beside one of the footways, and
    /// the footway.
    pub(crate) fn free(
        &self,
        world: &World,
        places: &[Option<Vec2>],
        part: f32,
    ) -> Option<(usize, usize)> {
        let first = index_at(places.len(), part);
        let turned = (first..places.len()).chain(0..first);
        let beside = |nth: usize| {
            let at = places[nth]?;
            let own = self.footways.iter().copied();
            let footway = own.min_by(|a, b| {
                let [a, b] = [a, b].map(|footway| world.footways[*footway].distance_m(at));
                a.total_cmp(&b)
            })?;
            (world.footways[footway].distance_m(at) < 1.5).then_some((nth, footway))
        };
        turned.into_iter().find_map(beside)
    }

    /// Finds a place on one of the footways, `edge_m` from its edge and `apart_m` from others.
    /// Returns the footway, the point, and the direction of the footway there.
    pub(crate) fn place(
        &self,
        world: &mut World,
        who: usize,
        edge_m: f32,
        apart_m: f32,
    ) -> Option<(usize, Vec2, Vec2)> {
        let all: f32 = self.footways.iter().map(|nth| world.footways[*nth].length_m()).sum();
        for _ in 0..TRIES {
            let random = &mut world.people[who].random;
            let (mut along_m, aside) = (random.part() * all, random.between(-1.0, 1.0));
            for footway in self.footways.iter().copied() {
                let strip = &world.footways[footway];
                if along_m > strip.length_m() {
                    along_m -= strip.length_m();
                    continue;
                }
                let aside_m = aside * (strip.half_m - edge_m).max(0.0);
                let (at, line) = strip.at(Place { along_m, aside_m });
                if self.is_free(at, apart_m) {
                    return Some((footway, at, line));
                }
                break;
            }
        }
        None
    }

    /// Returns true if nobody is within a distance of a point.
    pub(crate) fn is_free(&self, at: Vec2, apart_m: f32) -> bool {
        let [x, z] = cell(at);
        let around = (x - 1..=x + 1).flat_map(|x| (z - 1..=z + 1).map(move |z| [x, z]));
        around
            .filter_map(|cell| self.taken.get(&cell))
            .flatten()
            .all(|other| other.distance_squared(at) > apart_m * apart_m)
    }

    /// Puts somebody who is on foot to a point, with a heading and a speed ahead in metres per
    /// second.
    pub(crate) fn put(
        &mut self,
        world: &mut World,
        crowd: &mut Crowd,
        who: usize,
        (at, yaw_rad, speed): (Vec2, f32, f32),
    ) -> Result<(), Error> {
        let (member, scale) = (world.member(who), world.people[who].scale);
        let height_m = self.ground.height_at(at.x, at.y);
        let placement = Placement::at([at.x, height_m, at.y]).facing(yaw_rad).scaled(scale);
        crowd.member_mut(member)?.set_placement(placement)?;
        let (sin, cos) = yaw_rad.sin_cos();
        if speed > 0.0 {
            let phase = world.people[who].random.part();
            let lead = Lead {
                position: at.to_array(),
                velocity: [sin * speed, cos * speed],
                soon_m_per_sec: speed,
                yaw_rad,
                height_m,
                step: None,
            };
            world.walkers.add_led(crowd, member, &lead, phase)?;
        } else {
            world.walkers.add(crowd, member)?;
        }
        world.people[who].goal = at;
        self.taken.entry(cell(at)).or_default().push(at);
        Ok(())
    }

    /// Puts somebody on a footway, on its way.
    fn set_off(&mut self, world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
        let found = (0..2).find_map(|nth| {
            // Closer together where there is no more room.
            let apart_m = if nth == 0 { APART_M } else { 0.5 * APART_M };
            self.place(world, who, 0.0, apart_m)
        });
        let first = self.footways.first().copied().unwrap_or(0);
        let (footway, at, line) = found.unwrap_or_else(|| {
            let along_m = world.people[who].random.part() * world.footways[first].length_m();
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
        self.put(world, crowd, who, (at, ahead.x.atan2(ahead.y), pace))?;
        world.go_on(who)
    }
}

fn cell(at: Vec2) -> [i32; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "floats saturate")]
    (at / CELL_M).floor().to_array().map(|value| value as i32)
}

/// Returns the index at a part, 0 to 1, of a list.
pub(crate) fn index_at(count: usize, part: f32) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let nth = (part * count as f32) as usize;
    nth.min(count.saturating_sub(1))
}
