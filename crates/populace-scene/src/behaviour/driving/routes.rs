//! Ways of drivers: to the doors of vehicles, and from there to a footway.

use std::sync::Arc;

use glam::Vec2;
use populace_locomotion::{Goal, Path};

use crate::Error;
use crate::behaviour::footways::Place;
use crate::behaviour::world::World;

/// Where somebody stands who opens a door, behind its swing: metres towards the vehicle and towards
/// its rear from where somebody gets in; and the turn to its front in radians.
const BESIDE_M: [f32; 2] = [0.10, 0.55];
const BESIDE_RAD: f32 = 1.19;

pub(super) fn middle(world: &World, car: usize) -> Vec2 {
    let [x, _, z] = world.traffic.placement_of(car).position();
    Vec2::new(x, z)
}

/// Returns the way from the footway around the rear of a vehicle to its driver's door.
pub(super) fn around(world: &World, car: usize) -> Vec<Vec2> {
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
pub(super) fn beside(world: &World, car: usize) -> Vec2 {
    let [x, z] = world.traffic.models[world.traffic.vehicles[car].model].entry;
    let [nearer, behind] = BESIDE_M;
    let [x, _, z] = world.traffic.world_point(car, [x - nearer, 0.0, z - behind]);
    Vec2::new(x, z)
}

/// Returns where somebody faces who opens the door of a vehicle.
pub(super) fn beside_yaw_rad(world: &World, car: usize) -> f32 {
    world.traffic.entry_yaw_rad(car) + BESIDE_RAD
}

pub(super) fn go(world: &mut World, who: usize, way: &[Vec2]) -> Result<(), Error> {
    let points: Vec<[f32; 2]> = way.iter().map(Vec2::to_array).collect();
    let path = Path::new(&points)?;
    world.people[who].goal = way.last().copied().unwrap_or_default();
    let member = world.member(who);
    Ok(world.walkers.set_goal(member, Goal::Path(Arc::new(path)))?)
}

/// Sends somebody who has just got out around the vehicle to the footway.
pub(super) fn walk_home(world: &mut World, who: usize, car: usize) -> Result<(), Error> {
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
