//! Props: their meshes, sizes, and the points that they promise.

#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod cars;
mod meshes;
mod rays;
mod streets;

use populace_character::Character;
use populace_props::{
    CarKind, Crossing, CrossingKind, GroundKind, RoadPlan, bench, bin, bollard, box_parcel,
    cafe_table, car, ground, helmet, phone, planter, road, shield, shopfront, spear, stand,
    street_lamp, traffic_light, tree, walk_light,
};

/// Seeds that are tried of each thing.
const SEEDS: std::ops::Range<u64> = 0..12;

/// A road with both kinds of crossings.
fn plan() -> RoadPlan {
    let crossing = |x_m, kind| Crossing { x_m, width_m: 4.0, kind };
    RoadPlan {
        crossings: vec![crossing(-8.0, CrossingKind::Zebra), crossing(12.0, CrossingKind::Signals)],
        ..RoadPlan::default()
    }
}

/// Returns all props: a name, the character, and most triangles that it may have.
fn all() -> Vec<(String, Character, usize)> {
    let mut all = vec![
        ("road".into(), road(&plan()).unwrap().character, 1500),
        ("traffic light".into(), traffic_light().unwrap(), 1000),
        ("walk light".into(), walk_light().unwrap(), 1000),
        ("bench".into(), bench().unwrap().character, 600),
        ("street lamp".into(), street_lamp().unwrap(), 600),
        ("bollard".into(), bollard().unwrap(), 300),
        ("bin".into(), bin().unwrap(), 1100),
        ("cafe table".into(), cafe_table().unwrap().character, 1300),
        ("spear".into(), spear().unwrap(), 200),
        ("parcel".into(), box_parcel().unwrap(), 100),
        ("phone".into(), phone().unwrap(), 100),
        ("stand".into(), stand(14, 20).unwrap().character, 280 * 14),
        ("lawn".into(), ground(GroundKind::Lawn, 60.0).unwrap(), 100),
        ("meadow".into(), ground(GroundKind::Meadow, 60.0).unwrap(), 100),
        ("earth".into(), ground(GroundKind::Earth, 60.0).unwrap(), 100),
    ];
    for seed in SEEDS {
        let width = [5.0, 6.5, 8.0, 9.5, 12.0][usize::try_from(seed % 5).unwrap()];
        let most = if width <= 8.0 { 4500 } else { 6500 };
        let house = shopfront(seed, width).unwrap();
        all.push((format!("shopfront {seed}"), house.character, most));
        all.push((format!("tree {seed}"), tree(seed).unwrap(), 3000));
        all.push((format!("planter {seed}"), planter(seed).unwrap(), 900));
        all.push((format!("shield {seed}"), shield(seed).unwrap(), 600));
        all.push((format!("helmet {seed}"), helmet(seed).unwrap(), 600));
        for kind in [CarKind::Hatchback, CarKind::Saloon, CarKind::Van] {
            all.push((format!("{kind:?} {seed}"), car(kind, seed).unwrap().character, 4000));
        }
    }
    all
}
