//! Draws arms, a section of a stand and cars side by side, with people for scale.
//!
//! `cargo run -p populace-props --example lineup [FOLDER [VIEW...]]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::f32::consts::FRAC_PI_4;

use populace_props as props;
use populace_props::{CarKind, GroundKind};
use populace_render::Preset;

use shared::{Result, Stage, View};

const VIEWS: [View; 8] = [
    ("van", [38.5, 1.5, 3.4], [34.4, 0.9, 0.0]),
    ("saloon", [33.6, 1.5, -5.0], [31.4, 0.7, 0.0]),
    ("arms", [0.3, 1.6, 4.4], [0.4, 1.0, 0.0]),
    ("helmets", [-0.9, 1.75, 2.0], [-1.3, 1.55, 0.0]),
    ("hands", [3.1, 1.25, 1.3], [3.1, 1.0, 0.0]),
    ("stand", [-34.0, 4.6, 9.0], [-29.0, 2.4, -4.0]),
    ("seats", [-27.0, 1.9, 3.0], [-30.0, 1.2, -1.5]),
    ("fleet", [26.0, 1.7, 6.8], [30.0, 0.6, 0.0]),
];

fn main() -> Result<()> {
    let mut stage = Stage::new()?;
    let mut people = vec![(([3.9, 0.0, 0.0], -0.3), "Idle")];
    for seed in 0..4_u8 {
        let x = 1.1 * f32::from(seed) - 2.0;
        people.insert(usize::from(seed), (([x, 0.0, 0.0], 0.0), "Idle"));
        stage.put(props::shield(u64::from(seed) + 3)?, &[([x - 0.1, 1.0, 0.42], 0.2)])?;
    }
    // A helmet's origin is the middle of the skull, 0.12 m under the crown.
    for (seed, person) in (0_u8..4).zip(populace_cast::cast()?) {
        let crown = person.rest_bounds().ok_or("no meshes")?.high[1];
        let x = 1.1 * f32::from(seed) - 2.0;
        stage.put(props::helmet(seed.into())?, &[([x, crown - 0.12, 0.02], 0.0)])?;
    }
    stage.put(props::spear()?, &[([-2.4, props::SPEAR_GRIP_M, 0.2], 0.0)])?;
    stage.put(props::box_parcel()?, &[([3.0, 0.9, 0.0], 0.4)])?;
    stage.put(props::phone()?, &[([3.4, 1.05, 0.3], -0.4)])?;
    stage.put(props::ground(GroundKind::Lawn, 60.0)?, &[([-30.0, 0.01, 10.0], 0.0)])?;
    stage.put(props::ground(GroundKind::Meadow, 20.0)?, &[([0.0, 0.01, 0.0], 0.0)])?;
    let stand = props::stand(14, 20)?;
    let width = stand.width_m;
    let seats = stand.seats();
    let sections = [-1.0, 0.0, 1.0].map(|n| ([-30.0 + n * width, 0.01, -2.0], 0.0));
    stage.put(stand.character, &sections)?;
    println!("{} seats in a section", seats.len());
    for seat in seats.iter().step_by(23) {
        let [x, y, z] = seat.position;
        people.push((([x - 30.0, y - props::SEAT_M, z + 0.35 - 2.0], 0.0), "Idle"));
    }
    let kinds = [CarKind::Hatchback, CarKind::Saloon, CarKind::Van];
    for (seed, kind) in (4_u8..).zip(kinds) {
        let x = 25.0 + 3.2 * f32::from(seed - 3);
        stage.put(props::car(kind, seed.into())?.character, &[([x, 0.0, 0.0], -FRAC_PI_4)])?;
    }
    stage.people(&people)?;
    stage.draw(&VIEWS, &Preset::Day.scene())
}
