//! The doors of vehicles: how drivers open them, and how they close.

use glam::{Quat, Vec2, Vec3};
use populace::{ClipPlayback, Crowd, Reach, Target, Weight};

use super::FADE_SECS;
use super::routes::beside_yaw_rad;
use crate::Error;
use crate::behaviour::body::Use;
use crate::behaviour::person::Doing;
use crate::behaviour::world::{WHOLE, World};

/// Seconds after which the hand has the handle, after which the door begins to open, after which the
/// hand lets the handle go and the door swings on, and after which the door is open.
const HANDLE_SECS: f32 = 0.6;
const OPENS_AFTER_SECS: f32 = 0.75;
const LETS_GO_SECS: f64 = 1.1;
const IS_OPEN_SECS: f64 = 1.6;
/// Seconds in which `Door_Open` opens a door, which starts and stops softly.
const SWING_SECS: f32 = 0.8;
/// Seconds after which somebody gets in who has not come to the seat.
const STEPS_SECS: f64 = 4.0;
/// The layer of a vehicle that moves its door.
const DOOR: usize = 1;

/// Opens the door once somebody faces it.
pub(super) fn open_door(
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
pub(super) fn pull_door(
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
pub(super) fn move_door(
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
