//! Benches, lamps, bins and other things on sidewalks.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DAffine3, DVec3};
use populace_character::{Character, Error};
use populace_model::convert::single;

use crate::build::{
    Builder, Finish, Solid, along_x, bevelled, block, glow, lathe, linear, matt, metal, satin,
    spun, tube,
};
use crate::dice::Dice;
use crate::leaves::sprig;

/// Height in metres of the seats of benches and chairs.
pub const SEAT_M: f32 = 0.45;

/// A place to sit, in the space of the thing that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatPoint {
    /// The middle of the surface on which a person sits, in metres.
    pub position: [f32; 3],
    /// Heading in radians about +Y of who sits there; 0 faces +Z.
    pub yaw_rad: f32,
}

/// Something to sit on.
#[derive(Clone, Debug)]
pub struct Seating {
    /// The thing, of one joint.
    pub character: Character,
    /// The places to sit.
    pub seats: Vec<SeatPoint>,
}

/// Returns a solid moved.
fn at(x: f64, y: f64, z: f64, mut solid: Solid) -> Solid {
    for point in &mut solid.points {
        *point += DVec3::new(x, y, z);
    }
    solid
}

/// Returns a bench of wood and iron, 1.8 m wide, with three seats that face +Z.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn bench() -> Result<Seating, Error> {
    let mut b = Builder::new("bench");
    let wood = b.finish(satin("Top slats", 0xA6_7344));
    let iron = b.finish(satin("Iron", 0x2B_302E));
    let seat = f64::from(SEAT_M);
    b.on(wood);
    for slat in 0..4 {
        let z = -0.19 + 0.115 * f64::from(slat);
        let shade = 1.0 - 0.06 * f64::from(slat % 2);
        b.tinted([shade; 3]);
        b.flat(&bevelled([-0.9, seat - 0.04, z], [0.9, seat, z + 0.095], 0.008));
    }
    for slat in 0..3 {
        let y = seat + 0.12 + 0.13 * f64::from(slat);
        let lean = -0.23 - 0.035 * f64::from(slat);
        b.tinted([1.0 - 0.05 * f64::from(slat % 2); 3]);
        b.flat(&bevelled([-0.9, y, lean - 0.035], [0.9, y + 0.105, lean], 0.008));
    }
    b.on(iron);
    for x in [-0.78, -0.03, 0.72] {
        let (l, r) = (x, x + 0.06);
        let leg = [
            [0.29, 0.0],
            [0.21, 0.0],
            [0.17, seat - 0.12],
            [-0.16, seat - 0.12],
            [-0.24, 0.0],
            [-0.33, 0.0],
            [-0.24, seat - 0.02],
            [-0.34, seat + 0.48],
            [-0.30, seat + 0.5],
            [-0.2, seat - 0.04],
            [0.24, seat - 0.04],
        ];
        b.flat(&along_x(&leg, l, r));
    }
    for x in [-0.79, 0.71] {
        b.flat(&bevelled([x, seat + 0.2, -0.26], [x + 0.08, seat + 0.235, 0.24], 0.01));
        b.block([x + 0.015, seat - 0.04, 0.17], [x + 0.065, seat + 0.2, 0.21]);
    }
    let seats = [-0.56, 0.0, 0.56]
        .map(|x| SeatPoint { position: [single(x), SEAT_M, -0.02], yaw_rad: 0.0 });
    Ok(Seating { character: b.build(Vec::new())?, seats: seats.to_vec() })
}

/// Returns a street lamp 4.6 m high with a lantern, whose glass shines a little.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn street_lamp() -> Result<Character, Error> {
    let mut b = Builder::new("street lamp");
    let iron = b.finish(satin("Top iron", 0x24_3330));
    let light = b.finish(glow("Lamp glass", 0xF6_EAD0, 0.28));
    b.on(iron);
    let base = [[0.19, 0.0], [0.19, 0.08], [0.15, 0.14], [0.13, 0.7], [0.15, 0.76], [0.085, 0.86]];
    b.add(&lathe(&base, 10), 35.0);
    let pole =
        [[0.07, 0.84], [0.062, 2.1], [0.085, 2.14], [0.085, 2.22], [0.055, 2.27], [0.042, 3.62]];
    b.add(&lathe(&pole, 10), 35.0);
    let neck = [[0.042, 3.6], [0.09, 3.66], [0.09, 3.72], [0.05, 3.76], [0.17, 3.86], [0.17, 3.9]];
    b.add(&lathe(&neck, 8), 30.0);
    for side in [-1.0, 1.0] {
        let arm = [
            (DVec3::new(0.0, 3.3, 0.0), 0.018),
            (DVec3::new(0.26 * side, 3.34, 0.0), 0.018),
            (DVec3::new(0.42 * side, 3.31, 0.0), 0.024),
        ];
        b.add(&tube(&arm, 5), 50.0);
    }
    b.on(light).faded([3.85, 4.4], [0.85, 1.05]);
    b.add(&lathe(&[[0.15, 3.9], [0.235, 4.33]], 6), 5.0);
    b.on(iron);
    for corner in 0..6 {
        let (sin, cos) = (TAU * f64::from(corner) / 6.0).sin_cos();
        let rod = [
            (DVec3::new(0.155 * sin, 3.9, 0.155 * cos), 0.013),
            (DVec3::new(0.24 * sin, 4.34, 0.24 * cos), 0.013),
        ];
        b.flat(&tube(&rod, 4));
    }
    let cap = [
        [0.275, 4.32],
        [0.275, 4.35],
        [0.12, 4.5],
        [0.1, 4.55],
        [0.03, 4.58],
        [0.035, 4.63],
        [0.0, 4.68],
    ];
    b.add(&lathe(&cap, 6), 5.0);
    b.build(Vec::new())
}

/// Returns a bollard of iron, 0.95 m high.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn bollard() -> Result<Character, Error> {
    let mut b = Builder::new("bollard");
    let iron = b.finish(satin("Top iron", 0x2A_3036));
    let band = b.finish(matt("Band", 0xE4_E0D6));
    b.on(iron);
    let profile = [
        [0.1, 0.0],
        [0.1, 0.06],
        [0.075, 0.1],
        [0.065, 0.72],
        [0.085, 0.76],
        [0.085, 0.8],
        [0.05, 0.83],
        [0.075, 0.89],
        [0.045, 0.94],
        [0.0, 0.95],
    ];
    b.add(&lathe(&profile, 12), 35.0);
    b.on(band);
    b.add(&lathe(&[[0.0715, 0.6], [0.0695, 0.68]], 12), 35.0);
    b.build(Vec::new())
}

/// Returns a litter bin of slats, 0.98 m high, with a roof.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn bin() -> Result<Character, Error> {
    let mut b = Builder::new("bin");
    let iron = b.finish(satin("Iron", 0x26_2B2A));
    let slats = b.finish(satin("Top slats", 0x3C_5B4A));
    b.on(iron);
    b.add(&lathe(&[[0.24, 0.0], [0.24, 0.05], [0.2, 0.07], [0.2, 0.74], [0.22, 0.76]], 16), 35.0);
    for side in 0..3 {
        let (sin, cos) = (TAU * (f64::from(side) + 0.5) / 3.0).sin_cos();
        b.flat(&at(0.19 * sin, 0.0, 0.19 * cos, block([-0.02, 0.7, -0.02], [0.02, 0.93, 0.02])));
    }
    b.add(&lathe(&[[0.25, 0.91], [0.25, 0.93], [0.12, 0.97], [0.0, 0.98]], 16), 30.0);
    b.on(slats);
    for slat in 0..16 {
        let turn = TAU * f64::from(slat) / 16.0;
        b.at = DAffine3::from_rotation_y(turn);
        let shade = 1.0 - 0.1 * f64::from(slat % 2);
        b.tinted([shade; 3]).flat(&bevelled([-0.034, 0.08, 0.2], [0.034, 0.72, 0.235], 0.008));
    }
    b.home();
    b.build(Vec::new())
}

/// Returns a planter of 1.2 by 0.5 m with plants and flowers, which follow from the seed.
///
/// # Errors
///
/// Those of [`Character::new`]; no seed causes one.
pub fn planter(seed: u64) -> Result<Character, Error> {
    let mut dice = Dice::new(seed, 21);
    let mut b = Builder::new("planter");
    let trough = b.finish(matt("Top trough", dice.pick([0xB9_B2A6, 0x8C_5A44, 0x5B_646A])));
    let soil = b.finish(matt("Soil", 0x4A_3626));
    let plants = b.finish(matt("Leaves", 0xFF_FFFF));
    b.on(trough);
    b.flat(&bevelled([-0.6, 0.06, -0.25], [0.6, 0.5, 0.25], 0.02));
    b.flat(&bevelled([-0.63, 0.44, -0.28], [0.63, 0.53, 0.28], 0.015));
    for x in [-0.5, 0.38] {
        b.block([x, 0.0, -0.2], [x + 0.12, 0.07, 0.2]);
    }
    b.on(soil);
    b.block([-0.57, 0.5, -0.22], [0.57, 0.535, 0.22]);
    let bloom = linear(dice.pick([0xD9_4A4A, 0xE5_B43C, 0xC4_5A9A, 0xF0_EDE2, 0xE0_7A3A]));
    for nth in 0..6 {
        let foot = DVec3::new(-0.47 + 0.188 * f64::from(nth), 0.52, dice.within(-0.06, 0.06));
        b.on(plants);
        bush(&mut b, &mut dice, foot, bloom);
    }
    b.build(Vec::new())
}

/// Adds a plant: a dark body, and leaves and flowers that stand out of it.
fn bush(b: &mut Builder, dice: &mut Dice, foot: DVec3, bloom: [f64; 3]) {
    let green = linear(dice.pick([0x4F_7F38, 0x5E_8F40, 0x41_6E36]));
    let radii = DVec3::new(0.15, dice.within(0.2, 0.3), 0.17);
    let mut body = lathe(&[[0.6, 0.0], [0.8, 0.35], [0.5, 0.8], [0.0, 0.9]], 7);
    for point in &mut body.points {
        *point = foot + *point * radii;
    }
    b.tinted(green.map(|c| 0.4 * c)).add(&body, 60.0);
    b.faded([foot.y, foot.y + radii.y], [0.6, 1.15]);
    let count = 30;
    for nth in 0..count {
        let rise = (f64::from(nth) + 0.5) / f64::from(count);
        let (sin, cos) = (2.4 * f64::from(nth) + foot.x).sin_cos();
        let flat = (1.0 - rise * rise).max(0.0).sqrt();
        let out = DVec3::new(flat * cos, rise, flat * sin);
        let is_bloom = nth % 3 == 2 && rise > 0.3;
        let tone = dice.within(0.9, 1.5);
        let color = if is_bloom { bloom } else { green.map(|c| c * tone) };
        b.tint = [color[0], color[1], color[2], 1.0];
        let near = if is_bloom { 1.05 } else { dice.within(0.7, 0.95) };
        let at = foot + out * radii * near;
        let up = if is_bloom { out + DVec3::Y } else { out };
        let size = if is_bloom { 0.085 } else { 0.13 };
        b.flat(&sprig(at, up, size, dice.within(0.0, TAU)));
    }
}

/// Returns a round table with two chairs, whose seats face each other along X.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn cafe_table() -> Result<Seating, Error> {
    let mut b = Builder::new("cafe table");
    let iron = b.finish(satin("Iron", 0x2A_2D2C));
    let top = b.finish(matt("Table plate", 0xE9_E4DA));
    let wood = b.finish(satin("Top slats", 0xB8_3F3C));
    let china = b.finish(satin("China", 0xF6_F2EA));
    let cups = b.finish(metal("Tray", 0xC8_C8C4, 0.4));
    b.on(iron);
    b.add(&lathe(&[[0.24, 0.0], [0.24, 0.02], [0.05, 0.05], [0.03, 0.1], [0.03, 0.7]], 12), 35.0);
    b.on(top);
    b.add(&lathe(&[[0.33, 0.7], [0.345, 0.71], [0.345, 0.725], [0.335, 0.735]], 20), 25.0);
    for (x, z) in [(-0.16, 0.05), (0.15, -0.08)] {
        b.on(cups)
            .add(&at(x, 0.735, z, lathe(&[[0.05, 0.0], [0.075, 0.008], [0.07, 0.012]], 10)), 30.0);
        b.on(china)
            .add(&at(x, 0.745, z, lathe(&[[0.022, 0.0], [0.038, 0.03], [0.04, 0.055]], 8)), 40.0);
    }
    for side in [-1.0, 1.0] {
        let turn = DAffine3::from_rotation_y(-side * FRAC_PI_2);
        b.at = DAffine3::from_translation(DVec3::X * 0.62 * side) * turn;
        chair(&mut b, iron, wood);
    }
    b.home();
    let seats = [-1.0, 1.0].map(|side: f64| SeatPoint {
        position: [single(0.67 * side), SEAT_M, 0.0],
        yaw_rad: single(-side * FRAC_PI_2),
    });
    Ok(Seating { character: b.build(Vec::new())?, seats: seats.to_vec() })
}

/// Adds a chair at the origin that faces +Z.
fn chair(b: &mut Builder, iron: Finish, wood: Finish) {
    let seat = f64::from(SEAT_M);
    b.on(wood);
    for slat in 0..4 {
        let z = -0.19 + 0.098 * f64::from(slat);
        b.flat(&bevelled([-0.2, seat - 0.02, z], [0.2, seat, z + 0.085], 0.006));
    }
    for slat in 0..2 {
        let y = seat + 0.22 + 0.12 * f64::from(slat);
        let lean = -0.235 - 0.025 * f64::from(slat);
        b.flat(&bevelled([-0.2, y, lean - 0.02], [0.2, y + 0.085, lean], 0.006));
    }
    b.on(iron);
    for side in [-1.0, 1.0] {
        let x = 0.19 * side;
        let back = [
            (DVec3::new(x, 0.0, -0.26), 0.013),
            (DVec3::new(x, seat - 0.03, -0.2), 0.013),
            (DVec3::new(x, seat + 0.44, -0.28), 0.013),
        ];
        b.add(&tube(&back, 5), 60.0);
        let front = [(DVec3::new(x, 0.0, 0.24), 0.013), (DVec3::new(x, seat - 0.02, 0.17), 0.013)];
        b.add(&tube(&front, 5), 60.0);
    }
    b.add(&spun_between(-0.19, 0.19, [seat - 0.03, 0.16]), 60.0);
    b.add(&spun_between(-0.19, 0.19, [seat - 0.03, -0.19]), 60.0);
}

/// Returns a rod along X.
fn spun_between(from: f64, to: f64, [y, z]: [f64; 2]) -> Solid {
    at(0.0, y, z, spun(&[[0.012, from], [0.012, to]], 5))
}
