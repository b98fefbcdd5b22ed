//! Getting into a parked vehicle and driving off, and parking and getting out.

mod doors;
mod routes;

use glam::Vec2;
use populace::{ClipPlayback, Crowd, JointIndex, Placement, Trs};

use super::body::Use;
use super::person::{Doing, Kind};
use super::traffic::Drive;
use super::world::{WHOLE, World};
use crate::Error;
use doors::{move_door, open_door, pull_door};
use routes::{around, beside, beside_yaw_rad, go, middle, walk_home};

/// Distance at which a parked vehicle is noticed, in metres.
const NOTICED_M: f32 = 16.0;
const PATIENCE_SECS: f64 = 40.0;
/// The least height of drivers, in metres: children do not drive.
const ADULT_M: f32 = 1.5;
const FADE_SECS: f32 = 0.25;
/// Seconds after which the door of somebody who walks away closes.
const CLOSES_AFTER_SECS: f32 = 1.1;
/// The least time in seconds that a driver drives, and that a vehicle stands between two drivers.
const LEAST_DRIVE_SECS: f64 = 4.0;
const LEAST_STAND_SECS: f64 = 5.0;
/// Seconds from a stop to an open door, and from a closed door to setting off.
const BEFORE_OUT_SECS: f64 = 1.4;
const BEFORE_OFF_SECS: f64 = 1.8;
/// The height of the seat at which the clips sit, in metres.
const CLIP_SEAT_M: f32 = populace_cast::CAR_SEAT_M[1];
/// The joint of a vehicle to which drivers are attached.
const BODY: JointIndex = JointIndex(0);

/// Lets somebody who strolls walk to a free parked vehicle near by. Returns true if there is one.
pub(crate) fn begin(world: &mut World, who: usize) -> Result<bool, Error> {
    if !may_drive(world, who) {
        return Ok(false);
    }
    let at = world.position(who);
    let footway = &world.footways[world.people[who].footway];
    let is_free = |car: usize| {
        let vehicle = &world.traffic.vehicles[car];
        let Drive::Stands { since, .. } = vehicle.drive else { return false };
        let is_empty = vehicle.driver.is_none() && vehicle.claimed.is_none();
        is_empty && world.now - since > LEAST_STAND_SECS
    };
    let distance = |car: usize| middle(world, car).distance(at);
    let near = (0..world.traffic.vehicles.len())
        .filter(|car| is_free(*car) && distance(*car) < NOTICED_M)
        .filter(|car| footway.distance_m(middle(world, *car)) < 4.0)
        .min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    let Some(car) = near else { return Ok(false) };
    world.traffic.vehicles[car].claimed = u32::try_from(who).ok();
    world.people[who].doing = Doing::NearsCar { car, until: world.now + PATIENCE_SECS };
    // Around the rear of the vehicle to its door.
    let mut way = around(world, car);
    way.insert(0, at);
    way.pop();
    way.push(beside(world, car));
    go(world, who, &way)?;
    Ok(true)
}

/// Returns true for adults whose bodies have the motions.
pub(crate) fn may_drive(world: &World, who: usize) -> bool {
    let uses = [Use::OpenDoor, Use::GetIn, Use::Drive, Use::GetOut];
    world.height_m(who) >= ADULT_M && world.body(who).has(&uses)
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let now = world.now;
    match world.people[who].doing {
        Doing::NearsCar { car, until } => {
            if world.stops_at_goal(who, beside_yaw_rad(world, car))? {
                world.traffic.vehicles[car].is_open = true;
                world.people[who].doing = Doing::FacesCar { car, until: now + 4.0 };
            } else if now > until {
                world.traffic.vehicles[car].claimed = None;
                world.go_on(who)?;
            }
        }
        Doing::FacesCar { car, until } => open_door(world, crowd, who, (car, until))?,
        Doing::OpensDoor { car, since } => pull_door(world, crowd, who, (car, since))?,
        Doing::StepsIn { car, until } => get_in(world, crowd, who, (car, until))?,
        Doing::GetsIn { car, until } if now > until => {
            let member = world.member(who);
            world.walkers.remove(member)?;
            board(world, crowd, who, car)?;
            move_door(world, crowd, (car, 1), 0.3)?;
            world.people[who].doing = Doing::Drives { car, since: now };
            world.counts.drove_off += 1;
        }
        Doing::Drives { car, since } => drive(world, crowd, who, (car, since))?,
        Doing::GetsOut { car, until } if now > until => leave_car(world, crowd, who, car)?,
        Doing::WalksFromCar { until } => {
            let is_there = world.position(who).distance(world.people[who].goal) < 0.5;
            if is_there || now > until {
                world.go_on(who)?;
            }
        }
        _ => {}
    }
    Ok(())
}

/// Gets in from beside the seat.
fn get_in(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    (car, until): (usize, f64),
) -> Result<(), Error> {
    let (now, member) = (world.now, world.member(who));
    let is_there =
        world.has_arrived(who) && world.faces(crowd, who, world.traffic.entry_yaw_rad(car))?;
    if !is_there && now <= until {
        return Ok(());
    }
    let once = ClipPlayback::once().fade_in_secs(FADE_SECS);
    let playing = world.play(crowd, who, Use::GetIn, (WHOLE, once))?;
    let secs = playing.map_or(0.0, |(_, secs)| secs);
    crowd.member_mut(member)?.plant_feet(0.0)?;
    let at = world.position(who);
    world.walkers.rest(member, at.to_array(), 0.4)?;
    world.people[who].doing = Doing::GetsIn { car, until: now + secs };
    Ok(())
}

/// Lets somebody who has got out walk away, and closes the door.
fn leave_car(world: &mut World, crowd: &mut Crowd, who: usize, car: usize) -> Result<(), Error> {
    let now = world.now;
    world.end(crowd, who, WHOLE, 0.35)?;
    let member = world.member(who);
    world.walkers.add(crowd, member)?;
    world.set_layers(crowd, who)?;
    move_door(world, crowd, (car, 1), CLOSES_AFTER_SECS)?;
    let vehicle = &mut world.traffic.vehicles[car];
    (vehicle.driver, vehicle.claimed, vehicle.is_open) = (None, None, false);
    if let Drive::Stands { since, .. } = &mut vehicle.drive {
        *since = now;
    }
    world.counts.got_out += 1;
    world.people[who].doing = Doing::WalksFromCar { until: now + PATIENCE_SECS };
    walk_home(world, who, car)
}

/// Drives on; stops at a bay and gets out.
fn drive(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    (car, since): (usize, f64),
) -> Result<(), Error> {
    let now = world.now;
    let Kind::Strolls(habits) = world.people[who].kind else { return Ok(()) };
    let rate = world.strolls[habits].drive;
    match world.traffic.vehicles[car].drive {
        Drive::Stands { since: parked, .. } => {
            let has_parked = parked > since;
            if !has_parked && now - since > BEFORE_OFF_SECS {
                world.traffic.vehicles[car].is_open = false;
                world.traffic.set_off(car);
            } else if has_parked && now - parked > BEFORE_OUT_SECS {
                alight(world, crowd, who, car)?;
            } else if has_parked && !world.traffic.vehicles[car].is_open && now - parked > 0.6 {
                world.traffic.vehicles[car].is_open = true;
                move_door(world, crowd, (car, 0), 0.0)?;
            }
        }
        Drive::Cruises if now - since > LEAST_DRIVE_SECS && world.is_turn(who) => {
            // As often as others get in, or the bays would fill.
            let parks = rate > 0.0 && world.people[who].random.chance(0.5);
            if parks {
                world.traffic.park(car);
            }
        }
        _ => {}
    }
    Ok(())
}

/// Puts a person into the driver's seat.
pub(crate) fn board(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    car: usize,
) -> Result<(), Error> {
    let vehicle = &world.traffic.vehicles[car];
    let [x, y, z] = world.traffic.models[vehicle.model].seat;
    let parent = vehicle.member;
    let offset = Trs { translation: [x, y - CLIP_SEAT_M, z], ..Trs::IDENTITY };
    let phase = world.people[who].random.unit();
    let looping = ClipPlayback::looping();
    // Those who have just got in are in the first pose of the loop.
    let is_new = matches!(world.people[who].doing, Doing::GetsIn { .. });
    let playback = if is_new { looping } else { looping.phase(phase) };
    world.play(crowd, who, Use::Drive, (WHOLE, playback))?;
    let mut member = crowd.member_mut(world.member(who))?;
    member.plant_feet(0.0)?;
    member.attach_to(parent, BODY, offset)?;
    world.traffic.vehicles[car].driver = u32::try_from(who).ok();
    Ok(())
}

/// Fades vehicles out and in at the ends of their lanes, with their drivers.
pub(crate) fn fade(world: &World, crowd: &mut Crowd) -> Result<(), Error> {
    for vehicle in &world.traffic.vehicles {
        let opacity = world.traffic.lanes[vehicle.lane].opacity_at(vehicle.along_m);
        let driver = vehicle.driver.map(|who| world.member(who as usize));
        for member in [Some(vehicle.member), driver].into_iter().flatten() {
            let mut member = crowd.member_mut(member)?;
            let look = member.look().with_opacity(opacity);
            member.set_look(look);
        }
    }
    Ok(())
}

/// Lets a driver get out.
fn alight(world: &mut World, crowd: &mut Crowd, who: usize, car: usize) -> Result<(), Error> {
    let model = &world.traffic.models[world.traffic.vehicles[car].model];
    let [x, z] = model.entry;
    let [x, y, z] = world.traffic.world_point(car, [x, 0.0, z]);
    let yaw_rad = world.traffic.entry_yaw_rad(car);
    let placement = Placement::at([x, y, z]).facing(yaw_rad).scaled(world.people[who].scale);
    let playing = world.play(crowd, who, Use::GetOut, (WHOLE, ClipPlayback::once()))?;
    let mut member = crowd.member_mut(world.member(who))?;
    member.detach()?;
    member.set_placement(placement)?;
    let secs = playing.map_or(0.0, |(_, secs)| secs);
    world.people[who].goal = Vec2::new(x, z);
    world.people[who].doing = Doing::GetsOut { car, until: world.now + secs };
    Ok(())
}
