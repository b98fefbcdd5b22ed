//! Houses, roads, lights, furniture, stands and arms.

use glam::DVec3;
use populace_character::Character;
use populace_props::{
    Crossing, CrossingKind, GroundKind, HOUSE_DEPTH_M, KERB_M, Lamp, RoadPlan, SEAT_M,
    SPEAR_GRIP_M, SPEAR_M, STEP_M, STEP_RISE_M, SeatPoint, bench, cafe_table, ground, helmet, road,
    shield, shopfront, spear, stand, traffic_light, walk_light,
};

use crate::rays::{height, hits, triangles};
use crate::{SEEDS, plan};

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

#[test]
fn houses_have_their_width_and_leave_the_sidewalk_free() {
    for seed in SEEDS {
        let house = shopfront(seed, 7.5).unwrap();
        let bounds = house.character.rest_bounds().expect("meshes");
        assert!(bounds.low[0] > -3.95 && bounds.high[0] < 3.95, "{seed}: {bounds:?}");
        assert!((bounds.low[2] + HOUSE_DEPTH_M).abs() < 0.05, "{seed}: {bounds:?}");
        assert!((9.5..20.0).contains(&bounds.high[1]), "{seed}: {bounds:?}");
        for ([a, b, c], _, material) in triangles(&house.character) {
            let low = a.y.min(b.y).min(c.y);
            let out = a.z.max(b.z).max(c.z);
            assert!(low > 2.05 || out < 0.1, "{seed}: {material} stands out by {out} at {low}");
        }
    }
}

#[test]
fn shop_windows_show_goods_behind_their_glass() {
    for seed in SEEDS {
        let house = shopfront(seed, 7.5).unwrap();
        assert!(house.windows.len() >= 4, "{seed}: {} windows", house.windows.len());
        for window in &house.windows {
            let eye = wide(window.stand) + DVec3::Y * 1.6;
            let towards = wide(window.look_at) - eye;
            let seen = hits(&house.character, eye, towards.normalize());
            assert_eq!(seen[0].material, "Shop glass", "{seed}");
            let in_front = DVec3::new(eye.x, 1.3, eye.z);
            let glass = hits(&house.character, in_front, -DVec3::Z);
            assert!((glass[0].away - 0.7).abs() < 1e-3, "{seed}: {}", glass[0].away);
            // The recess is deep.
            let wall = glass.iter().find(|hit| hit.material == "Room").expect("a wall");
            assert!(wall.away > 1.3, "{seed}: {wall:?}");
        }
        let spots: Vec<f32> = house.windows.iter().map(|window| window.stand[0]).collect();
        assert!(spots.windows(2).all(|pair| pair[1] - pair[0] > 0.55), "{seed}: {spots:?}");
    }
}

#[test]
fn doors_of_shops_have_handles_and_open_inwards() {
    for seed in SEEDS {
        let house = shopfront(seed, 7.5).unwrap();
        let handle = wide(house.door_handle);
        let near = hits(&house.character, handle + DVec3::Z * 0.5, -DVec3::Z);
        assert_eq!(near[0].material, "Gilding", "{seed}");
        assert!((f64::from(house.door[0]) - handle.x).abs() < 0.6);
        let clip = house.character.clips.iter().find(|c| c.name() == "Door_Open").expect("a clip");
        assert!((clip.duration_secs() - 0.8).abs() < 1e-6);
        let track = &clip.source().tracks[0];
        let value: Vec<f64> =
            track.value(track.times.len() - 1).iter().map(|v| f64::from(*v)).collect();
        let door = house.character.skeleton.find("Door").expect("a joint");
        let hinge = wide(house.character.skeleton.rest_model(door).origin());
        let opened = hinge + glam::DQuat::from_slice(&value) * (handle - hinge);
        assert!(opened.z < handle.z - 0.5, "{seed}: {handle} goes to {opened}");
    }
}

#[test]
fn the_height_of_a_road_is_that_of_its_mesh() {
    let road = road(&plan()).unwrap();
    let mut ramps = 0;
    for i in 0..240_i16 {
        for j in 0..61_i16 {
            let (x, z) = (-29.0 + 0.241 * f32::from(i), -7.1 + 0.2367 * f32::from(j));
            let mesh = height(&road.character, x, z, 1.0).expect("a surface");
            let told = f64::from(road.height_m(x, z));
            // Paint and drains lie on the asphalt; the kerb's edge is cut off.
            let on_asphalt = z.abs() < 3.25;
            let at_edge = (3.25..3.28).contains(&z.abs());
            let tolerance = if on_asphalt {
                0.011
            } else if at_edge {
                0.026
            } else {
                0.001
            };
            assert!((mesh - told).abs() < tolerance, "at {x}, {z}: {mesh} for {told}");
            assert!((-KERB_M..=0.0).contains(&road.height_m(x, z)));
            ramps += i32::from(!on_asphalt && told < -0.01);
        }
    }
    assert!(ramps > 100, "only {ramps} points on ramps");
    // At a crossing the kerb is 1.5 cm high, and elsewhere all of it.
    assert!((road.height_m(-8.0, 3.2501) + 0.105).abs() < 1e-3);
    assert_eq!(road.height_m(0.0, -3.3), 0.0);
    assert_eq!(road.height_m(0.0, 0.0), -KERB_M);
}

/// Returns the ends along the road of all triangles of a material whose corners are at most
/// `aside_m` from its middle.
fn marks(plan: &RoadPlan, material: &str, aside_m: f64) -> Vec<[f64; 2]> {
    let road = road(plan).unwrap();
    let of = triangles(&road.character).into_iter().filter(|(_, _, name)| *name == material);
    let near = of.filter(|(corners, ..)| corners.iter().all(|corner| corner.z.abs() <= aside_m));
    near.map(|([a, b, c], ..)| [a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x)]).collect()
}

#[test]
fn markings_end_with_the_road() {
    for (length, kind) in [(4.0, CrossingKind::Signals), (8.0, CrossingKind::Zebra)] {
        let crossings = vec![Crossing { x_m: 0.0, width_m: 2.0, kind }];
        let plan = RoadPlan { length_m: length, crossings, ..RoadPlan::default() };
        let half = 0.5 * f64::from(length);
        for [from, to] in marks(&plan, "Road paint", f64::MAX) {
            assert!(from >= -half && to <= half, "{length} m: from {from} to {to}");
        }
    }
}

#[test]
fn lines_and_lids_leave_crossings_free() {
    for (apart, width_m) in [(3.0, 1.5), (6.0, 4.0), (7.5, 4.0), (9.0, 4.0), (40.0, 4.0)] {
        let crossing = |x_m| Crossing { x_m, width_m, kind: CrossingKind::Zebra };
        let middles = [-apart, 0.0, apart];
        let crossings = middles.map(crossing).to_vec();
        let plan = RoadPlan { length_m: 100.0, crossings, ..RoadPlan::default() };
        for (material, aside_m) in [("Road paint", 0.07), ("Iron", 2.0), ("Kerb", 2.0)] {
            let marks = marks(&plan, material, aside_m);
            assert!(!marks.is_empty(), "{apart} m apart: no {material}");
            for [from, to] in marks {
                let half = f64::from(0.5 * width_m);
                let clears = |m: f32| to < f64::from(m) - half || from > f64::from(m) + half;
                let is_free = middles.into_iter().all(clears);
                assert!(is_free, "{apart} m apart: {material} from {from} to {to}");
            }
        }
    }
}

#[test]
fn shutters_of_neighbouring_windows_do_not_meet() {
    let mut shutters = 0;
    for seed in 0..20 {
        for width in [5.0, 7.0, 7.5] {
            let house = shopfront(seed, width).unwrap();
            let fronts: Vec<_> = triangles(&house.character)
                .into_iter()
                .filter(|([a, b, c], _, material)| {
                    *material == "Trousers joinery"
                        && [a, b, c].iter().all(|p| (p.z - 0.045).abs() < 1e-4)
                })
                .map(|([a, b, c], ..)| ([a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x)], a.y))
                .filter(|(_, y)| *y > 4.0)
                .collect();
            shutters += fronts.len();
            for ([from, to], _) in &fronts {
                for ([other_from, other_to], _) in &fronts {
                    let is_same = (from - other_from).abs() < 1e-4;
                    let is_apart = other_from - to > 0.01 || from - other_to > 0.01;
                    assert!(is_same || is_apart, "{seed}, {width} m: {to} and {other_from}");
                }
            }
        }
    }
    assert!(shutters > 100, "{shutters}");
}

#[test]
fn plans_of_roads_that_make_no_sense_give_roads() {
    let crossing = |x_m, width_m| Crossing { x_m, width_m, kind: CrossingKind::Zebra };
    let bad = [f32::NAN, f32::INFINITY, -5.0, 1e30];
    for length_m in bad {
        for x_m in bad {
            let crossings = vec![crossing(x_m, f32::NAN), crossing(0.0, x_m), crossing(1.0, 4.0)];
            let road =
                road(&RoadPlan { length_m, sidewalk_m: x_m, parking_m: 0.5 * x_m, crossings })
                    .unwrap();
            assert!(road.height_m(x_m, length_m).is_finite());
            assert!((4.0..=1000.0).contains(&road.length_m()));
        }
    }
    for size in bad {
        assert!(shopfront(1, size).is_ok() && ground(GroundKind::Lawn, size).is_ok());
    }
}

fn check_seats(character: &Character, seats: &[SeatPoint], name: &str) {
    for seat in seats {
        let [x, y, z] = seat.position;
        let found = height(character, x, z, f64::from(y) + 0.1).expect("a seat");
        assert!((found - f64::from(y)).abs() < 0.012, "{name}: {found} for {y}");
        // A back is behind it, and nothing in front of it.
        let (sin, cos) = f64::from(seat.yaw_rad).sin_cos();
        let front = DVec3::new(sin, 0.0, cos);
        let chest = wide(seat.position) + DVec3::Y * 0.28;
        let behind = hits(character, chest, -front);
        assert!(behind.first().is_some_and(|hit| hit.away < 0.45), "{name}: no back");
        let before = hits(character, chest, front);
        assert!(before.first().is_none_or(|hit| hit.away > 0.25), "{name}: {before:?}");
    }
}

#[test]
fn seats_are_surfaces_with_a_back() {
    let bench = bench().unwrap();
    assert_eq!(bench.seats.len(), 3);
    check_seats(&bench.character, &bench.seats, "bench");
    let table = cafe_table().unwrap();
    assert_eq!(table.seats.len(), 2);
    check_seats(&table.character, &table.seats, "cafe table");
}

#[test]
fn stands_have_their_seats_and_steps() {
    let stand = stand(10, 24).unwrap();
    let seats = stand.seats();
    assert_eq!(seats.len(), 240);
    check_seats(&stand.character, &seats[..48], "stand");
    for (index, seat) in (0_u16..).zip(&seats) {
        let row = f32::from(index / 24);
        let step = STEP_RISE_M * (row + 1.0);
        assert!((seat.position[1] - step - SEAT_M).abs() < 1e-5);
        assert!(seat.position[2] < -STEP_M * row && seat.position[2] > -STEP_M * (row + 1.0));
    }
    // Feet stand before the seat on the step.
    let [x, y, z] = seats[30].position;
    let feet = height(&stand.character, x, z + 0.35, f64::from(y)).expect("a step");
    assert!((feet - f64::from(y - SEAT_M)).abs() < 1e-4, "{feet}");
    let bounds = stand.character.rest_bounds().expect("meshes");
    assert!((bounds.high[0] - bounds.low[0] - stand.width_m).abs() < 0.05);
    assert!((stand.depth_m() - 8.0).abs() < 1e-5 && (stand.top_m() - 4.0).abs() < 1e-5);
    assert_eq!(populace_props::stand(0, u32::MAX).unwrap().seats().len(), 512);
    assert!(populace_props::stand(u32::MAX, 50).unwrap().seats().len() <= 512);
}

#[test]
fn lamps_are_options_with_light() {
    for (light, lamps) in [
        (traffic_light().unwrap(), &Lamp::OF_CARS[..]),
        (walk_light().unwrap(), &Lamp::OF_PEOPLE[..]),
    ] {
        assert_eq!(light.options().len(), lamps.len());
        for lamp in lamps {
            let option = lamp.option_in(&light).expect("an option");
            let lit = (0..light.parts.len()).filter(|part| light.option_of(*part) == Some(option));
            let mut count = 0;
            for part in lit {
                let part = &light.parts[part];
                assert_eq!(part.node_name, lamp.node_name());
                let material = &light.materials[part.material.expect("a material")];
                assert!(material.emissive.iter().sum::<f32>() > 0.5);
                count += 1;
            }
            assert_eq!(count, 1, "{lamp:?}");
        }
        let other = if lamps.contains(&Lamp::Red) { Lamp::Walk } else { Lamp::Red };
        assert_eq!(other.option_in(&light), None);
    }
}

#[test]
fn arms_have_their_sizes() {
    let spear = spear().unwrap().rest_bounds().expect("meshes");
    assert!((spear.low[1] + SPEAR_GRIP_M).abs() < 1e-4);
    assert!((spear.high[1] - spear.low[1] - SPEAR_M).abs() < 1e-4);
    for seed in SEEDS {
        let bounds = shield(seed).unwrap().rest_bounds().expect("meshes");
        assert!(bounds.high[2] > 0.1 && bounds.low[2] > -0.06, "{seed}: {bounds:?}");
        assert!((0.6..0.9).contains(&(bounds.high[0] - bounds.low[0])), "{seed}: {bounds:?}");
        // A head of 0.16 by 0.24 by 0.20 m has room, and its face is free.
        let helmet = helmet(seed).unwrap();
        let radii = DVec3::new(0.08, 0.12, 0.1);
        for ([a, b, c], _, material) in triangles(&helmet) {
            for point in [a, b, c, (a + b + c) / 3.0] {
                let near = (point / radii).length();
                assert!(near > 1.0, "{seed}: {material} is in the head at {point}");
            }
        }
        let face = hits(&helmet, DVec3::new(0.035, -0.06, 0.5), -DVec3::Z);
        assert!(face.first().is_none_or(|hit| hit.away > 0.5), "{seed}: {face:?}");
    }
}
