//! Getting into a parked vehicle and driving off, and parking and getting out.

use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};
use populace::{ClipPlayback, Crowd, JointIndex, Placement, Reach, Target, Trs, Weight};
use populace_locomotion::{Goal, Path};

use super::body::Use;
use super::footways::Place;
use super::person::{Doing, Kind};
use super::traffic::Drive;
use super::world::{WHOLE, World};
use crate::Error;

/// Distance at which a parked vehicle is noticed, in metres.
const NOTICED_M: f32 = 16.0;
const PATIENCE_SECS: f64 = 40.0;
/// The least height of drivers, in metres: children do not drive.
const ADULT_M: f32 = 1.5;
const FADE_SECS: f32 = 0.25;
/// Seconds after which the hand has the handle, after which the door begins to open, after which the
/// hand lets the handle go and the door swings on, and after which the door is open.
const HANDLE_SECS: f32 = 0.6;
const OPENS_AFTER_SECS: f32 = 0.75;
const LETS_GO_SECS: f64 = 1.1;
const IS_OPEN_SECS: f64 = 1.6;
/// Seconds in which `Door_Open` opens a door, which starts and stops softly.
const SWING_SECS: f32 = 0.8;
/// Where somebody stands who opens a door, behind its swing: metres towards the vehicle and towards
/// its rear from where somebody gets in; and the turn to its front in radians.
const BESIDE_M: [f32; 2] = [0.10, 0.55];
const BESIDE_RAD: f32 = 1.19;
/// Seconds after which somebody gets in who has not come to the seat.
const STEPS_SECS: f64 = 4.0;
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
/// The layer of a vehicle that moves its door.
const DOOR: usize = 1;
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

fn middle(world: &World, car: usize) -> Vec2 {
    let [x, _, z] = world.traffic.placement_of(car).position();
    Vec2::new(x, z)
}

/// Returns the way from the footway around the rear of a vehicle to its driver's door.
fn around(world: &World, car: usize) -> Vec<Vec2> {
    let model = &world.traffic.models[world.traffic.vehicles[car].model];
    let [x, z] = model.entry;
    let rear = -0.5 * model.length_m - 1.0;
    [[-1.9, rear], [x, rear], [x, z]]
        .map(|[x, z]| {
            let [x, _, z] = world.traffic.world_point(car, [x, 0.0, z]);
            Vec2::new(x, z)
        })
        .to_vec()
}

/// Returns where somebody stands who opens the door of a vehicle, out of its swing.
fn beside(world: &World, car: usize) -> Vec2 {
    let [x, z] = world.traffic.models[world.traffic.vehicles[car].model].entry;
    let [nearer, behind] = BESIDE_M;
    let [x, _, z] = world.traffic.world_point(car, [x - nearer, 0.0, z - behind]);
    Vec2::new(x, z)
}

/// Returns where somebody faces who opens the door of a vehicle.
fn beside_yaw_rad(world: &World, car: usize) -> f32 {
    world.traffic.entry_yaw_rad(car) + BESIDE_RAD
}

fn go(world: &mut World, who: usize, way: &[Vec2]) -> Result<(), Error> {
    let points: Vec<[f32; 2]> = way.iter().map(Vec2::to_array).collect();
    let path = Path::new(&points)?;
    world.people[who].goal = way.last().copied().unwrap_or_default();
    let member = world.member(who);
    Ok(world.walkers.set_goal(member, Goal::Path(Arc::new(path)))?)
}

/// Goes on with it.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    let now = world.now;
    match world.people[who].doing {
        Doing::NearsCar { car, until } => {
            if world.has_arrived(who) {
                world.halt(who)?;
                let yaw_rad = beside_yaw_rad(world, car);
                world.face(who, Some(yaw_rad))?;
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

/// Opens the door once somebody faces it.
fn open_door(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    (car, until): (usize, f64),
) -> Result<(), Error> {
    let now = world.now;
    if !world.faces(crowd, who, beside_yaw_rad(world, car))? && now <= until {
        return Ok(());
    }
    let member = world.member(who);
    world.walkers.set_heedless(member, true)?;
    let once = ClipPlayback::once().fade_in_secs(FADE_SECS);
    world.play(crowd, who, Use::OpenDoor, (WHOLE, once))?;
    let weight = Weight::FULL.over_secs(HANDLE_SECS);
    reach_for_handle(world, crowd, who, (car, 0.0, weight))?;
    move_door(world, crowd, (car, 0), OPENS_AFTER_SECS)?;
    world.people[who].doing = Doing::OpensDoor { car, since: now };
    Ok(())
}

/// Pulls the door by its handle, lets it go, and steps to the seat once the door is open.
fn pull_door(
    world: &mut World,
    crowd: &mut Crowd,
    who: usize,
    (car, since): (usize, f64),
) -> Result<(), Error> {
    let (secs, step_secs) = (world.now - since, world.step_secs);
    let lets_go = (secs - step_secs..secs).contains(&LETS_GO_SECS);
    if let Some(hand) = world.body(who).right_hand.filter(|_| lets_go) {
        crowd.member_mut(world.member(who))?.clear_reach(hand, 0.3)?;
    } else if secs < LETS_GO_SECS && secs > f64::from(OPENS_AFTER_SECS) {
        #[expect(clippy::cast_possible_truncation, reason = "below a second")]
        let part = (secs as f32 - OPENS_AFTER_SECS) / SWING_SECS;
        let eased = part * part * part * (part * (6.0 * part - 15.0) + 10.0);
        let turn_rad = populace_props::DOOR_TURN_RAD * eased;
        reach_for_handle(world, crowd, who, (car, turn_rad, Weight::FULL))?;
    }
    if secs < IS_OPEN_SECS {
        return Ok(());
    }
    world.end(crowd, who, WHOLE, 0.35)?;
    let [x, z] = world.traffic.models[world.traffic.vehicles[car].model].entry;
    let [x, _, z] = world.traffic.world_point(car, [x, 0.0, z]);
    world.send(who, Vec2::new(x, z))?;
    let yaw_rad = world.traffic.entry_yaw_rad(car);
    world.face(who, Some(yaw_rad))?;
    world.people[who].doing = Doing::StepsIn { car, until: world.now + STEPS_SECS };
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

/// Sends somebody who has just got out around the vehicle to the footway.
fn walk_home(world: &mut World, who: usize, car: usize) -> Result<(), Error> {
    let mut way = around(world, car);
    way.reverse();
    let edge = way.last().copied().unwrap_or_default();
    let nearest = (0..world.footways.len()).min_by(|a, b| {
        let [a, b] = [a, b].map(|footway| world.footways[*footway].distance_m(edge));
        a.total_cmp(&b)
    });
    let footway = nearest.unwrap_or(0);
    world.people[who].footway = footway;
    let strip = &world.footways[footway];
    let place = strip.place(edge);
    let room = 0.8 * strip.half_m;
    let aside_m = place.aside_m.clamp(-room, room);
    way.push(strip.at(Place { aside_m, ..place }).0);
    let (member, pace) = (world.member(who), world.people[who].pace);
    world.walkers.set_speed(member, pace)?;
    go(world, who, &way)
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

/// Puts a hand on the handle of a vehicle's door, which is turned by an angle in radians.
fn reach_for_handle(
    world: &World,
    crowd: &mut Crowd,
    who: usize,
    (car, turn_rad, weight): (usize, f32, Weight),
) -> Result<(), Error> {
    let model = &world.traffic.models[world.traffic.vehicles[car].model];
    let [handle, hinge] = [model.handle, model.hinge].map(Vec3::from);
    let swung = hinge + Quat::from_rotation_y(turn_rad) * (handle - hinge);
    let at = world.traffic.world_point(car, swung.to_array());
    if let Some(hand) = world.body(who).right_hand {
        let mut member = crowd.member_mut(world.member(who))?;
        member.reach(Reach::with(hand), Target::Point(at), weight)?;
    }
    Ok(())
}

/// Opens (0) or closes (1) the door of a vehicle after some seconds.
fn move_door(
    world: &World,
    crowd: &mut Crowd,
    (car, motion): (usize, usize),
    after_secs: f32,
) -> Result<(), Error> {
    let vehicle = &world.traffic.vehicles[car];
    if let Some(doors) = world.traffic.models[vehicle.model].doors {
        let playback = ClipPlayback::once().after_secs(after_secs).on_layer(DOOR);
        crowd.member_mut(vehicle.member)?.play(doors[motion], playback)?;
    }
    Ok(())
}
