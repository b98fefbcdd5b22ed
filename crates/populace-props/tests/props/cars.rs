//! Cars: their plan, doors, wheels and clips.

use glam::{DQuat, DVec3};
use populace_cast::{
    CAR_SEAT_M, STEERING_WHEEL_M, STEERING_WHEEL_RADIUS_M, STEERING_WHEEL_TILT_RAD,
};
use populace_model::Property;
use populace_props::{Car, CarKind, DOOR_TURN_RAD, DRIVER_SEAT, car};

use crate::rays::{height, hits};

const KINDS: [CarKind; 3] = [CarKind::Hatchback, CarKind::Saloon, CarKind::Van];

fn cars() -> impl Iterator<Item = (String, Car)> {
    KINDS.into_iter().map(|kind| (format!("{kind:?}"), car(kind, 1).unwrap()))
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Returns the points at rest that a joint moves.
fn moved_by(car: &Car, joint: &str) -> Vec<DVec3> {
    let character = &car.character;
    let joint = character.skeleton.find(joint).expect("a joint");
    let mut points = Vec::new();
    for (index, part) in character.parts.iter().enumerate() {
        let places = character.rest_positions(index);
        for (vertex, place) in places.into_iter().enumerate() {
            let entry = usize::from(part.mesh.influences.entries[4 * vertex]);
            if character.palette[entry].joint == joint {
                points.push(wide(place));
            }
        }
    }
    points
}

fn place_of(car: &Car, joint: &str) -> DVec3 {
    let joint = car.character.skeleton.find(joint).expect("a joint");
    wide(car.character.skeleton.rest_model(joint).origin())
}

#[test]
fn wheels_stand_on_the_ground_and_turn_about_their_hubs() {
    for (name, car) in cars() {
        for (joint, side, axle) in [
            ("WheelFrontLeft", 1.0, car.plan.front_axle_m),
            ("WheelFrontRight", -1.0, car.plan.front_axle_m),
            ("WheelBackLeft", 1.0, car.plan.back_axle_m),
            ("WheelBackRight", -1.0, car.plan.back_axle_m),
        ] {
            let hub = place_of(&car, joint);
            let radius = f64::from(car.plan.wheel_radius_m);
            assert!((hub.z - f64::from(axle)).abs() < 1e-6 && hub.x * side > 0.5, "{name} {joint}");
            let points = moved_by(&car, joint);
            let low = points.iter().map(|p| p.y).fold(f64::MAX, f64::min);
            assert!(low.abs() < 0.006, "{name}: {joint} is at {low}");
            let far = points.iter().map(|p| (*p - hub).with_x(0.0).length()).fold(0.0, f64::max);
            assert!((far - radius).abs() < 1e-3, "{name}: {joint} has a radius of {far}");
        }
        let low = car.character.rest_bounds().expect("meshes").low[1];
        assert!(low > -1e-3, "{name}: {low}");
    }
}

#[test]
fn a_car_fills_its_plan() {
    for (name, car) in cars() {
        let bounds = car.character.rest_bounds().expect("meshes");
        let plan = &car.plan;
        // Lamps stand out, and the soft shadow reaches beyond.
        assert!((bounds.high[2] - plan.front_m).abs() < 0.25, "{name}: {bounds:?}");
        assert!((bounds.low[2] - plan.back_m).abs() < 0.25, "{name}: {bounds:?}");
        assert!((bounds.high[1] - plan.height_m).abs() < 1e-6);
        assert!((3.8..5.2).contains(&plan.length_m()), "{name}: {}", plan.length_m());
        assert!((1.7..1.9).contains(&plan.width_m));
        assert!((1.4..1.95).contains(&plan.height_m), "{name}: {}", plan.height_m);
    }
}

#[test]
fn seats_and_wheel_are_where_people_reach_them() {
    for (name, car) in cars() {
        let plan = &car.plan;
        assert_eq!(plan.seat, DRIVER_SEAT);
        let [x, y, z] = plan.seat;
        let seat = height(&car.character, x, z, f64::from(y) + 0.1).expect("a seat");
        assert!((seat - f64::from(y)).abs() < 0.03, "{name}: the seat is at {seat}");
        // Over the seat there is room for a head, under the roof.
        let up = hits(&car.character, wide(plan.seat) + DVec3::Y * 0.1, DVec3::Y);
        assert!(up[0].away > 0.85, "{name}: only {} m over the seat", up[0].away);
        let wheel = place_of(&car, "SteeringWheel");
        assert!(wheel.distance(wide(plan.steering_wheel)) < 1e-6);
        // The wheel is where the hands of `Drive` are.
        let held = wide(STEERING_WHEEL_M) - DVec3::Y * f64::from(CAR_SEAT_M[1]);
        assert!(wheel.distance(wide(plan.seat) + held) < 1e-6, "{name}: {wheel}");
        assert_eq!(plan.steering_radius_m, STEERING_WHEEL_RADIUS_M);
        let axis = wide(plan.steering_axis);
        let tilt = axis.angle_between(-DVec3::Z) - f64::from(STEERING_WHEEL_TILT_RAD);
        assert!(axis.y > 0.0 && tilt.abs() < 0.01, "{name}: {tilt}");
        for point in moved_by(&car, "SteeringWheel") {
            let out = point - wheel;
            let across = (out - axis * out.dot(axis)).length();
            assert!(across < f64::from(plan.steering_radius_m) + 0.005, "{name}: {across}");
        }
        // The floor.
        let feet = height(&car.character, x, z + 0.5, 0.33).expect("a floor");
        assert!((feet - f64::from(plan.floor_m)).abs() < 0.01, "{name}: the floor is at {feet}");
        // Nothing stands where a person gets in.
        let [x, _, z] = plan.entry;
        for (dx, dz) in [(0.0, 0.0), (0.25, 0.0), (-0.25, 0.0), (0.0, 0.3), (0.0, -0.3)] {
            let top = DVec3::new(f64::from(x + dx), 2.0, f64::from(z + dz));
            let found = hits(&car.character, top, -DVec3::Y);
            assert!(found.iter().all(|hit| hit.material == "Shadow"), "{name}: {found:?}");
        }
    }
}

#[test]
fn the_roof_edge_is_over_the_door_at_its_height() {
    for (name, car) in cars() {
        let side = DVec3::new(3.0, 0.0, 0.05);
        let over = f64::from(car.plan.roof_edge_m);
        let see = |y: f64| hits(&car.character, side + DVec3::Y * y, -DVec3::X);
        assert!(see(over - 0.01).iter().any(|hit| hit.away < 3.0), "{name}");
        let first = see(over + 0.012);
        assert!(first.first().is_none_or(|hit| hit.away > 2.27), "{name}: {:?}", first.first());
    }
}

#[test]
fn the_driver_is_seen_through_the_side_window() {
    for (name, car) in cars() {
        let eye = DVec3::new(3.0, 1.25, -0.05);
        let seen = hits(&car.character, eye, -DVec3::X);
        assert_eq!(seen[0].material, "Car glass", "{name}");
        assert!(seen.iter().take_while(|hit| hit.away < 2.62).count() == 1, "{name}: {seen:?}");
        let glass = car.character.materials.iter().find(|m| m.name == "Car glass").expect("glass");
        assert!(glass.base_color[3] < 0.4);
    }
}

/// Returns the rotation of a joint in a key of a clip.
fn rotation(car: &Car, clip: &str, joint: &str, last: bool) -> (f32, DQuat) {
    let clip = car.character.clips.iter().find(|c| c.name() == clip).expect("a clip");
    let tracks = &clip.source().tracks;
    let of = |t: &&populace_model::Track| t.joint == joint && t.property == Property::Rotation;
    let track = tracks.iter().find(of).expect("a track");
    let key = if last { track.times.len() - 1 } else { 0 };
    let value: Vec<f64> = track.value(key).iter().map(|v| f64::from(*v)).collect();
    (track.times[key], DQuat::from_slice(&value))
}

#[test]
fn the_door_opens_outwards_with_its_handle() {
    for (name, car) in cars() {
        let hinge = wide(car.plan.door_hinge);
        assert!(hinge.distance(place_of(&car, "Door")) < 1e-6);
        let (secs, open) = rotation(&car, "Door_Open", "Door", true);
        assert!((secs - 0.8).abs() < 1e-6);
        assert!(open.angle_between(DQuat::from_rotation_y(f64::from(DOOR_TURN_RAD))) < 1e-4);
        let points = moved_by(&car, "Door");
        let free = points.iter().copied().min_by(|a, b| a.z.total_cmp(&b.z)).expect("points");
        let opened = hinge + open * (free - hinge);
        assert!(opened.x > free.x + 0.8, "{name}: {free} goes to {opened}");
        // No part of the open door enters the body behind the hinge's line.
        for point in &points {
            let opened = hinge + open * (*point - hinge);
            assert!(opened.x > 0.25, "{name}: {point} goes to {opened}");
        }
        let handle = wide(car.plan.door_handle);
        let near = points.iter().map(|p| p.distance(handle)).fold(f64::MAX, f64::min);
        assert!(near < 0.1, "{name}: the handle is {near} m off");
        let out = hits(&car.character, handle + DVec3::X, -DVec3::X);
        assert_eq!(out[0].material, "Chrome", "{name}");
        let paint = out.iter().find(|hit| hit.material == "Top paint").expect("a door");
        assert!(paint.away < 1.06, "{name}: the handle is {} m off the door", paint.away - 1.0);
        let (_, closed) = rotation(&car, "Door_Close", "Door", true);
        assert!(closed.angle_between(DQuat::IDENTITY) < 1e-4);
        let (_, start) = rotation(&car, "Door_Close", "Door", false);
        assert!(start.angle_between(open) < 1e-4);
    }
}

#[test]
fn wheels_roll_forwards() {
    for (name, car) in cars() {
        let clip = car.character.clips.iter().find(|c| c.name() == "Roll").expect("a clip");
        assert!((clip.duration_secs() - 1.0).abs() < 1e-6);
        assert_eq!(clip.source().tracks.len(), 4);
        let track = &clip.source().tracks[0];
        let value: Vec<f64> = track.value(1).iter().map(|v| f64::from(*v)).collect();
        let top = DQuat::from_slice(&value) * DVec3::Y;
        assert!(top.z > 0.5, "{name}: the top of a wheel goes to {top}");
        let (_, end) = rotation(&car, "Roll", "WheelBackRight", true);
        // A whole turn.
        assert!((end * DVec3::Y).distance(DVec3::Y) < 1e-5);
    }
}
