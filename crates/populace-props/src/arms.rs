//! Things that people hold or wear: shields, spears, helmets, parcels and phones.

mod helmet;
mod shield;

use glam::DVec3;
use populace_character::{Character, Error};

use crate::build::{
    Builder, Solid, bevelled, glow, lathe, linear, matt, metal, pane, plate, satin,
};

pub use helmet::helmet;
pub use shield::shield;

/// Length in metres of [`spear`].
pub const SPEAR_M: f32 = 2.2;
/// Height in metres of a spear's grip over its lower end.
pub const SPEAR_GRIP_M: f32 = 0.95;

/// Returns a spear along +Y, its point up, [`SPEAR_M`] long. The origin is its grip,
/// [`SPEAR_GRIP_M`] over its lower end.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn spear() -> Result<Character, Error> {
    let mut b = Builder::new("spear");
    let wood = b.finish(matt("Top shaft", 0x8A_6440));
    let iron = b.finish(metal("Iron", 0xA9_A9A6, 0.35));
    let leather = b.finish(matt("Leather", 0x4A_3222));
    let low = -f64::from(SPEAR_GRIP_M);
    let high = low + f64::from(SPEAR_M);
    b.on(wood).add(&lathe(&[[0.015, low + 0.1], [0.016, 0.2], [0.013, high - 0.3]], 8), 60.0);
    b.on(leather).add(&lathe(&[[0.0185, -0.09], [0.0185, 0.09]], 8), 60.0);
    b.on(iron);
    b.add(&lathe(&[[0.003, low], [0.017, low + 0.08], [0.018, low + 0.16]], 6), 40.0);
    b.add(&lathe(&[[0.019, high - 0.38], [0.017, high - 0.24], [0.01, high - 0.22]], 8), 40.0);
    let blade = [[0.011, -0.23], [0.042, -0.17], [0.03, -0.08], [0.0, 0.0]];
    let thick = [0.01, 0.008, 0.006, 0.0];
    let mut solid = Solid::default();
    for k in 1..blade.len() {
        let ([w0, y0], [w1, y1]) = (blade[k - 1], blade[k]);
        let (y0, y1, t0, t1) = (high + y0, high + y1, thick[k - 1], thick[k]);
        for side in [1.0, -1.0] {
            let (l0, r0, m0) = (
                DVec3::new(-w0 * side, y0, 0.0),
                DVec3::new(w0 * side, y0, 0.0),
                DVec3::new(0.0, y0, t0 * side),
            );
            let (l1, r1, m1) = (
                DVec3::new(-w1 * side, y1, 0.0),
                DVec3::new(w1 * side, y1, 0.0),
                DVec3::new(0.0, y1, t1 * side),
            );
            solid.face(&[l0, m0, m1, l1]);
            solid.face(&[m0, r0, r1, m1]);
        }
    }
    b.flat(&solid);
    b.build(Vec::new())
}

/// Width in metres of [`box_parcel`].
pub const PARCEL_WIDTH_M: f32 = 0.42;

/// Returns a parcel of 0.42 by 0.3 by 0.3 m with tape around it. The origin is the middle of its
/// underside.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn box_parcel() -> Result<Character, Error> {
    let mut b = Builder::new("parcel");
    let card = b.finish(matt("Top card", 0xB8_9468));
    let tape = b.finish(satin("Tape", 0x8C_6640));
    let label = b.finish(matt("Label", 0xF0_EDE4));
    b.on(card).flat(&bevelled([-0.21, 0.0, -0.15], [0.21, 0.3, 0.15], 0.006));
    b.on(tape);
    b.block([-0.2105, -0.0005, -0.03], [0.2105, 0.3005, 0.03]);
    b.on(label);
    b.flat(&plate(&[
        [0.03, 0.12, 0.1512],
        [0.16, 0.12, 0.1512],
        [0.16, 0.22, 0.1512],
        [0.03, 0.22, 0.1512],
    ]));
    b.on(tape).tinted(linear(0x40_3020));
    for row in 0..3 {
        let y = 0.145 + 0.024 * f64::from(row);
        let z = 0.152;
        b.flat(&plate(&[[0.05, y, z], [0.14, y, z], [0.14, y + 0.008, z], [0.05, y + 0.008, z]]));
    }
    b.build(Vec::new())
}

/// Returns a phone, upright, with its lit screen to +Z. The origin is its middle.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn phone() -> Result<Character, Error> {
    let mut b = Builder::new("phone");
    let case = b.finish(satin("Top case", 0x26_282C));
    let screen = b.finish(glow("Screen", 0xA9_C4E0, 0.4));
    let lens = b.finish(pane("Lens", 0x10_1214));
    b.on(case).flat(&bevelled([-0.036, -0.075, -0.004], [0.036, 0.075, 0.004], 0.0025));
    let z = 0.0045;
    b.on(screen);
    b.flat(&plate(&[
        [-0.032, -0.069, z],
        [0.032, -0.069, z],
        [0.032, 0.069, z],
        [-0.032, 0.069, z],
    ]));
    b.on(lens).block([0.01, 0.045, -0.0055], [0.03, 0.067, -0.003]);
    b.build(Vec::new())
}
