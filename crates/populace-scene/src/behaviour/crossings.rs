//! Crossing a road: walking to the kerb, looking left and right, waiting, and crossing.

use std::f32::consts::FRAC_PI_2;

use glam::Vec2;
use populace::Crowd;

use super::person::Doing;
use super::settling::{Settling, index_at};
use super::traffic::Stop;
use super::world::{Crossing, World};
use crate::Error;
use crate::stage::Lights;

/// Distance at which a crossing is noticed, in metres.
const NOTICED_M: f32 = 18.0;
const PATIENCE_SECS: f64 = 25.0;
/// Seconds of a look to one side. People look left, right and left again, as they are taught.
const LOOK_SECS: f64 = 0.7;
/// Distance at which a road is looked along, in metres.
const ALONG_M: f32 = 25.0;
/// Speed across a road, in metres per second.
const CROSS_M_PER_SEC: f32 = 1.5;
/// Seconds that are left when the last vehicle comes.
const SPARE_SECS: f32 = 1.0;
/// The right side of the way across, as shares of the width to its left. People wait and cross
/// there, so that people from both ends pass each other.
const RIGHT: [f32; 2] = [-0.42, -0.04];
/// Distance of people who wait, or begin on a crossing, in metres.
const BESIDE_M: f32 = 0.65;
/// Distance of rows of people who wait, in metres, and the most rows behind the first.
const ROW_M: f32 = 0.7;
const MOST_ROWS: f32 = 3.0;
/// How near to the line of its goal somebody has crossed, in metres. Others may stand at the goal.
const ACROSS_M: f32 = 0.7;
/// How far vehicles stop before a crossing, in metres.
const STOP_M: f32 = 1.2;
/// How far past a line a vehicle is that drives on, in metres.
const PAST_M: f32 = 0.5;

/// Phases of lights, in seconds: people walk, nobody moves, vehicles drive, nobody moves.
const PHASES_SECS: [f64; 4] = [9.0, 6.0, 14.0, 3.0];

/// Returns the lights of a crossing at a time, and the seconds that they last.
pub(crate) fn lights(crossing: &Crossing, now: f64) -> (Lights, f64) {
    let all: f64 = PHASES_SECS.iter().sum();
    let mut at = (now + f64::from(crossing.plan.ahead_s)).rem_euclid(all);
    let phases = [Lights::Walk, Lights::ClearOfPeople, Lights::Drive, Lights::ClearOfVehicles];
    for (lights, secs) in phases.into_iter().zip(PHASES_SECS) {
        if at < secs {
            return (lights, secs - at);
        }
        at -= secs;
    }
    (Lights::ClearOfVehicles, 0.0)
}

/// Lets somebody who strolls walk to a crossing near by. Returns true if there is one.
pub(crate) fn begin(world: &mut World, who: usize) -> Result<bool, Error> {
    let at = world.position(who);
    let own = world.people[who].footway;
    let ends = world.crossings.iter().enumerate().flat_map(|(index, crossing)| {
        let side = [0, 1].into_iter().filter(|side| crossing.footways[*side] == own);
        side.map(move |side| (Vec2::from(crossing.plan.ends[side]).distance(at), index, side))
    });
    let nearest = ends.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(m, ..)| *m < NOTICED_M);
    let Some((_, crossing, side)) = nearest else { return Ok(false) };
    let to = waiting_place(world, crossing, side, who);
    world.people[who].doing =
        Doing::NearsCrossing { crossing, side, until: world.now + PATIENCE_SECS };
    world.send(who, to)?;
    Ok(true)
}

/// Lets the vehicles stand that begin at a crossing on which people begin.
pub(crate) fn hold(world: &mut World, crowd: &mut Crowd) -> Result<(), Error> {
    for index in 0..world.crossings.len() {
        let crossing = &world.crossings[index];
        if is_open(crossing, world.now) {
            let half = 0.5 * crossing.plan.width_m;
            for (lane, along_m) in crossing.lanes.clone() {
                let stretch = [along_m - half - STOP_M, along_m + half];
                world.traffic.hold(crowd, lane, stretch)?;
            }
        }
    }
    Ok(())
}

/// Returns true if people may be on a crossing.
fn is_open(crossing: &Crossing, now: f64) -> bool {
    !crossing.plan.lights || lights(crossing, now).0 == Lights::Walk
}

/// Begins on a crossing, or before one that cannot be crossed now. Returns false without a place.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    settling: &mut Settling<'_>,
) -> Result<bool, Error> {
    let ends = world.crossings.iter().enumerate().flat_map(|(index, crossing)| {
        let side = [0, 1].into_iter();
        let side = side.filter(|side| settling.footways.contains(&crossing.footways[*side]));
        side.map(move |side| (index, side))
    });
    let ends: Vec<(usize, usize)> = ends.collect();
    let random = &mut world.people[who].random;
    let (along, aside) = (random.unit(), random.between_f32(RIGHT[0], RIGHT[1]));
    let Some((crossing, side)) = ends.get(index_at(ends.len(), random.unit())).copied() else {
        return Ok(false);
    };
    let until = PATIENCE_SECS;
    let of = &world.crossings[crossing];
    let [from, to] = [end(of, side, aside), end(of, 1 - side, -aside)];
    let (yaw_rad, footway) = (heading_rad(of, side), of.footways[side]);
    let crosses = is_open(of, world.now);
    let at = if crosses { from.lerp(to, 0.85 * along) } else { from };
    if !settling.is_free(at, BESIDE_M) {
        return Ok(false);
    }
    let speed = if crosses { CROSS_M_PER_SEC } else { 0.0 };
    settling.put(world, crowd, who, (at, yaw_rad, speed))?;
    world.people[who].footway = footway;
    if crosses {
        let member = world.member(who);
        world.walkers.set_speed(member, CROSS_M_PER_SEC)?;
        world.send(who, to)?;
        world.people[who].doing = Doing::Crosses { crossing, side, until };
    } else {
        world.face(who, Some(yaw_rad))?;
        world.people[who].doing = Doing::Waits { crossing, side };
    }
    Ok(true)
}

/// Returns where the next person waits at the end of a crossing: in the first row that is not full.
fn waiting_place(world: &mut World, crossing: usize, side: usize, who: usize) -> Vec2 {
    let waits = |doing: &Doing| match *doing {
        Doing::NearsCrossing { crossing: at, side: of, .. }
        | Doing::LooksBothWays { crossing: at, side: of, .. }
        | Doing::Waits { crossing: at, side: of } => (at, of) == (crossing, side),
        _ => false,
    };
    let waiting = world.people.iter().filter(|person| waits(&person.doing)).count();
    let aside = world.people[who].random.between_f32(RIGHT[0], RIGHT[1]);
    let of = &world.crossings[crossing];
    let row_m = (RIGHT[1] - RIGHT[0]) * of.plan.width_m;
    let back_m = ROW_M * (waiting as f32 * BESIDE_M / row_m).floor().min(MOST_ROWS);
    end(of, side, aside) - direction(of, side) * back_m
}

/// Returns the direction of the way across.
fn direction(crossing: &Crossing, side: usize) -> Vec2 {
    let [from, to] = [side, 1 - side].map(|side| Vec2::from(crossing.plan.ends[side]));
    (to - from).normalize_or_zero()
}

/// Returns a point at the end of a crossing, `aside` of its width to the left of the way across.
fn end(crossing: &Crossing, side: usize, aside: f32) -> Vec2 {
    let across = direction(crossing, side);
    let from = Vec2::from(crossing.plan.ends[side]);
    from + Vec2::new(across.y, -across.x) * aside * crossing.plan.width_m
}

/// Returns the heading of the way across.
fn heading_rad(crossing: &Crossing, side: usize) -> f32 {
    let across = direction(crossing, side);
    across.x.atan2(across.y)
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let now = world.now;
    match world.people[who].doing {
        Doing::NearsCrossing { crossing, side, until } => {
            let near = world.position(who).distance(world.people[who].goal) < 0.35;
            if near || world.has_arrived(who) {
                world.halt(who)?;
                let heading = heading_rad(&world.crossings[crossing], side);
                world.face(who, Some(heading))?;
                world.people[who].doing = Doing::LooksBothWays { crossing, side, since: now };
            } else if now > until {
                world.go_on(who)?;
            }
        }
        Doing::LooksBothWays { crossing, side, since } => {
            let [before, after] = [now - world.step_secs, now].map(|at| (at - since) / LOOK_SECS);
            if after >= 3.0 {
                world.look_ahead(crowd, who)?;
                world.people[who].doing = Doing::Waits { crossing, side };
                world.counts.looked_both_ways += 1;
            } else if before < 0.0 || before.floor() < after.floor() {
                let right = if (1.0..2.0).contains(&after) { -1.0 } else { 1.0 };
                let heading = heading_rad(&world.crossings[crossing], side) + right * FRAC_PI_2;
                let [x, y, z] = world.above(crowd, who, 0.6)?;
                let (sin, cos) = heading.sin_cos();
                world.look(crowd, who, [x + sin * ALONG_M, y, z + cos * ALONG_M])?;
            }
        }
        Doing::Waits { crossing, side } if may_cross(world, crossing) => {
            let aside = world.people[who].random.between_f32(RIGHT[0], RIGHT[1]);
            let to = end(&world.crossings[crossing], 1 - side, -aside);
            let member = world.member(who);
            world.face(who, None)?;
            world.walkers.set_speed(member, CROSS_M_PER_SEC)?;
            world.send(who, to)?;
            let until = now + PATIENCE_SECS;
            world.people[who].doing = Doing::Crosses { crossing, side, until };
        }
        Doing::Crosses { crossing, side, until } => {
            let ahead = direction(&world.crossings[crossing], side);
            let left_m = (world.people[who].goal - world.position(who)).dot(ahead);
            if left_m < ACROSS_M || now > until {
                world.people[who].footway = world.crossings[crossing].footways[1 - side];
                let forth = world.people[who].random.chance(0.5);
                world.people[who].direction = if forth { 1.0 } else { -1.0 };
                world.counts.crossed += 1;
                world.go_on(who)?;
            }
        }
        _ => {}
    }
    Ok(())
}

fn may_cross(world: &World, crossing: usize) -> bool {
    let crossing = &world.crossings[crossing];
    let [from, to] = crossing.plan.ends.map(Vec2::from);
    let secs = from.distance(to) / CROSS_M_PER_SEC + SPARE_SECS;
    if crossing.plan.lights {
        let (lights, left) = lights(crossing, world.now);
        // Those who begin to walk at the end of the phase still get across in the next one.
        if lights != Lights::Walk || left < 2.0 {
            return false;
        }
        let is_clear =
            |(lane, along_m): &(usize, f32)| world.traffic.is_clear(*lane, *along_m, 1.0);
        return crossing.lanes.iter().all(is_clear);
    }
    crossing.lanes.iter().all(|(lane, along_m)| world.traffic.is_clear(*lane, *along_m, secs))
}

/// Writes where vehicles must stop for lights and people.
pub(crate) fn stops(world: &World, stops: &mut Vec<Stop>) {
    stops.clear();
    let mut wanted = vec![(false, false); world.crossings.len()];
    for person in &world.people {
        match person.doing {
            Doing::Crosses { crossing, .. } => wanted[crossing].0 = true,
            Doing::Waits { crossing, .. } => wanted[crossing].1 = true,
            _ => {}
        }
    }
    for (crossing, (is_taken, is_awaited)) in world.crossings.iter().zip(wanted) {
        let is_red = crossing.plan.lights && lights(crossing, world.now).0 != Lights::Drive;
        let is_polite = !is_taken;
        if is_taken || is_red || is_awaited && !crossing.plan.lights {
            let before = 0.5 * crossing.plan.width_m + STOP_M;
            stops.extend(crossing.lanes.iter().map(|(lane, along_m)| Stop {
                lane: *lane,
                along_m: along_m - before,
                past_m: PAST_M,
                is_polite,
            }));
        }
    }
    // Nobody drives past an open door.
    for vehicle in world.traffic.vehicles.iter().filter(|vehicle| vehicle.is_open) {
        let along_m = vehicle.along_m - 3.4;
        stops.push(Stop { lane: vehicle.lane, along_m, past_m: PAST_M, is_polite: false });
    }
}
