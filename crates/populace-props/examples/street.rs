//! Draws a street of props, with people beside them for scale.
//!
//! `cargo run -p populace-props --example street [FOLDER [VIEW...]]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::f32::consts::{FRAC_PI_2, PI};

use populace::{ClipPlayback, Placement};
use populace_props as props;
use populace_props::{Crossing, CrossingKind, Lamp, RoadPlan};
use populace_render::Preset;

use shared::{Result, Stage, View};

const VIEWS: [View; 14] = [
    ("street", [-23.0, 2.2, 2.6], [10.0, 2.8, -2.5]),
    ("shops", [-21.0, 1.7, -0.6], [-17.0, 2.2, -7.6]),
    ("window", [-18.0, 1.6, -5.6], [-21.0, 1.3, -8.2]),
    ("across", [-10.0, 1.7, 6.4], [-6.0, 3.6, -8.0]),
    ("crossing", [-6.5, 2.1, 3.0], [1.0, 0.8, -3.5]),
    ("bench", [9.8, 1.6, -0.9], [11.6, 0.9, -5.0]),
    ("tree", [-3.0, 1.7, 0.4], [-8.0, 3.2, -4.2]),
    ("lights", [-0.5, 1.9, -1.0], [2.6, 2.2, -4.2]),
    ("top", [-18.0, 12.0, 6.0], [4.0, 0.0, -2.0]),
    ("side", [12.0, 1.8, 3.6], [2.0, 2.0, 7.5]),
    ("car", [-5.0, 1.5, 3.2], [-8.6, 0.7, 1.5]),
    ("rear", [-15.0, 1.8, 5.2], [-9.4, 0.5, 1.7]),
    ("door", [-17.5, 1.7, 2.2], [-16.0, 0.6, -2.3]),
    ("cars", [5.0, 2.4, 2.5], [13.0, 0.6, 0.0]),
];

fn houses(stage: &mut Stage, front: f32) -> Result<()> {
    for (side, first, yaw) in [(-1.0, 0, 0.0), (1.0, 40, PI)] {
        let mut x = -30.0;
        for seed in first.. {
            if x > 30.0 {
                break;
            }
            let width = [6.0, 6.9, 7.8, 8.7][usize::try_from(seed % 4)?];
            let shop = props::shopfront(seed, width)?;
            stage.put(shop.character, &[([x + 0.5 * width, 0.0, side * front], yaw)])?;
            x += width;
        }
    }
    Ok(())
}

fn furniture(stage: &mut Stage) -> Result<()> {
    let on_curb =
        |xs: &[f32], z: f32| -> Vec<_> { xs.iter().map(|x| ([*x, 0.0, z], 0.0)).collect() };
    stage.put(props::bench()?.character, &[([11.5, 0.0, -4.6], 0.0), ([-10.0, 0.0, 4.6], PI)])?;
    for (seed, x) in [(0, -8.0), (1, 7.5), (2, 17.0), (3, -18.0)] {
        stage.put(props::tree(seed)?, &[([x, 0.0, -4.4], 0.0), ([x + 3.0, 0.0, 4.4], 1.0)])?;
    }
    stage.put(props::street_lamp()?, &on_curb(&[-23.0, -12.5, 4.6, 14.5], -3.8))?;
    stage.put(props::bollard()?, &on_curb(&[-4.2, -5.4, -6.6, 4.2, 5.6], -3.7))?;
    stage.put(props::bin()?, &[([9.6, 0.0, -4.4], 0.0), ([-14.0, 0.0, 4.2], 0.0)])?;
    stage.put(props::planter(1)?, &[([-2.0, 0.0, -6.6], 0.0)])?;
    stage.put(props::planter(2)?, &[([14.0, 0.0, -4.5], 0.0)])?;
    let table = props::cafe_table()?.character;
    stage.put(table, &[([9.0, 0.0, -6.2], 0.3), ([6.8, 0.0, -6.1], -0.2)])?;
    Ok(())
}

fn cars(stage: &mut Stage) -> Result<()> {
    use props::CarKind::{Hatchback, Saloon, Van};
    let places = [
        (Hatchback, 0, -9.0, 1.7, FRAC_PI_2),
        (Saloon, 1, 7.0, -1.7, -FRAC_PI_2),
        (Van, 2, 16.0, 1.7, FRAC_PI_2),
        (Saloon, 3, -16.0, -2.3, -FRAC_PI_2),
    ];
    for (kind, seed, x, z, yaw) in places {
        let car = props::car(kind, seed)?.character;
        let id = stage.put(car, &[])?;
        let at = Placement::at([x, -props::KERB_M, z]).facing(yaw);
        let member = stage.crowd.spawn(id, at)?;
        if seed == 3 {
            let clip = stage.crowd.clip(id, "Door_Open")?;
            stage.crowd.member_mut(member)?.play(clip, ClipPlayback::once())?;
        }
    }
    Ok(())
}

fn lights(stage: &mut Stage) -> Result<()> {
    let (cars, people) = (Lamp::OF_CARS, Lamp::OF_PEOPLE);
    let east = ([-3.4, 0.0, 3.6], -FRAC_PI_2);
    stage.light(props::traffic_light()?, Lamp::Red, &cars, east)?;
    stage.light(props::traffic_light()?, Lamp::Green, &cars, ([3.4, 0.0, -3.6], FRAC_PI_2))?;
    stage.light(props::walk_light()?, Lamp::Walk, &people, ([2.4, 0.0, -4.7], 0.0))?;
    stage.light(props::walk_light()?, Lamp::Stop, &people, ([-2.4, 0.0, 4.7], PI))
}

fn main() -> Result<()> {
    let mut stage = Stage::new()?;
    let crossing = |x_m, kind| Crossing { x_m, width_m: 4.0, kind };
    let plan = RoadPlan {
        crossings: vec![crossing(0.0, CrossingKind::Signals), crossing(22.0, CrossingKind::Zebra)],
        length_m: 64.0,
        ..RoadPlan::default()
    };
    let road = props::road(&plan)?;
    let front = road.front_m();
    cars(&mut stage)?;
    furniture(&mut stage)?;
    lights(&mut stage)?;
    stage.put(road.character, &[([0.0; 3], 0.0)])?;
    houses(&mut stage, front)?;
    let (idle, walk, low) = ("Idle", "Walk", -props::KERB_M);
    stage.people(&[
        (([-16.9, 0.0, -6.55], PI), idle),
        (([-13.0, 0.0, -6.5], 2.8), idle),
        (([-9.0, 0.0, -6.3], 2.6), idle),
        (([-4.0, 0.0, -5.3], 1.5), walk),
        (([0.4, low, -2.2], 0.2), walk),
        (([-0.8, low, 1.0], PI), walk),
        (([12.9, 0.0, -4.5], 0.6), idle),
        (([3.2, 0.0, -4.9], 0.0), idle),
    ])?;
    let mut scene = Preset::Day.scene();
    // The plane of the ground lies under the road.
    if let Some(ground) = &mut scene.ground {
        ground.height_m = -0.4;
    }
    stage.draw(&VIEWS, &scene)
}
