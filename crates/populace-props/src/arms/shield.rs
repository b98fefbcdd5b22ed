//! Shields.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use populace_character::{Character, Error};

use crate::build::{Builder, Finish, Solid, lathe, matt, metal, satin, sheet, tube, turned};
use crate::dice::Dice;

/// Returns a shield, round (0.8 m) or tall (0.65 by 1.1 m) by the seed, with a painted face along
/// +Z. The origin is where a hand holds it; its grip runs along X, for an arm across its back.
///
/// The material `Top shield` is the field of its paint, and `Accessory emblem` the rest; members may
/// tint these regions.
///
/// # Errors
///
/// Those of [`Character::new`]; no seed causes one.
pub fn shield(seed: u64) -> Result<Character, Error> {
    let mut dice = Dice::new(seed, 51);
    let mut b = Builder::new("shield");
    let [field, emblem] = dice.pick([
        [0x9C_2F2B, 0xE3_D9BE],
        [0x2F_4F74, 0xE0_B84E],
        [0xD9_CFB6, 0x7A_2A2A],
        [0x3C_5A3C, 0xE6_DCC0],
        [0x4A_3A5C, 0xD9_B45A],
        [0xC9_9A3A, 0x2C_3440],
    ]);
    let face = b.finish(satin("Top shield", field));
    let paint = b.finish(satin("Accessory emblem", emblem));
    let iron = b.finish(metal("Iron", 0x9C_9A94, 0.45));
    let wood = b.finish(matt("Wood", 0x7A_5A3A));
    let leather = b.finish(matt("Leather", 0x4A_3222));
    let is_round = dice.chance(0.5);
    let forward = |profile: &[[f64; 2]], sides| turned(lathe(profile, sides), DVec3::Y, DVec3::Z);
    if is_round {
        let dish = |z: f64| [[0.4, z], [0.3, z + 0.035], [0.16, z + 0.06], [0.0, z + 0.068]];
        let open = |mut solid: Solid, rings: usize| {
            solid.faces.truncate(rings * 20);
            solid
        };
        b.on(face).add(&open(forward(&dish(0.045), 20), 3), 40.0);
        b.on(wood).add(&open(forward(&dish(0.03), 20), 3).turned(), 40.0);
        b.on(iron);
        let rim = [[0.395, 0.026], [0.415, 0.03], [0.415, 0.055], [0.39, 0.058]];
        b.add(&open(forward(&rim, 20), 3), 30.0);
        b.add(&forward(&[[0.12, 0.1], [0.1, 0.13], [0.06, 0.165], [0.0, 0.175]], 12), 50.0);
    } else {
        curved_board(&mut b, [face, wood], iron);
        b.on(iron)
            .add(&forward(&[[0.11, 0.1], [0.09, 0.135], [0.05, 0.16], [0.0, 0.168]], 12), 50.0);
    }
    let style = dice.below(3);
    b.on(paint);
    emblem_on(&mut b, is_round, style);
    b.on(leather);
    b.add(
        &tube(&[(DVec3::new(-0.09, 0.0, 0.0), 0.016), (DVec3::new(0.09, 0.0, 0.0), 0.016)], 6),
        60.0,
    );
    for side in [-1.0, 1.0] {
        let foot = DVec3::new(0.1 * side, 0.0, 0.09);
        b.add(&tube(&[(DVec3::new(0.085 * side, 0.0, 0.0), 0.015), (foot, 0.015)], 5), 60.0);
    }
    b.build(Vec::new())
}

/// Half the width and half the height of a tall shield, and the depth of its curve, in metres.
const TALL: [f64; 3] = [0.32, 0.55, 0.12];

/// Returns the front's z of a tall shield.
fn curve(x: f64) -> f64 {
    0.1 - TALL[2] * (x / TALL[0]) * (x / TALL[0])
}

fn curved_board(b: &mut Builder, [face, back]: [Finish; 2], iron: Finish) {
    let columns = 6;
    let row = |y: f64, out: f64| -> Vec<DVec3> {
        (0..=columns)
            .map(|k| {
                let x = TALL[0] * (2.0 * f64::from(k) / f64::from(columns) - 1.0);
                DVec3::new(x, y, curve(x) + out)
            })
            .collect()
    };
    let [_, high, _] = TALL;
    let front = [row(-high, 0.0), row(high, 0.0)];
    let rear = [row(-high, -0.018), row(high, -0.018)];
    b.on(face).add(&sheet(&front), 40.0);
    b.on(back).add(&sheet(&rear).turned(), 40.0);
    b.on(iron);
    for y in [-high, high] {
        let path: Vec<(DVec3, f64)> =
            row(y, -0.009).into_iter().map(|point| (point, 0.016)).collect();
        b.add(&tube(&path, 5), 60.0);
    }
    for x in [-TALL[0], TALL[0]] {
        let at = |y: f64| (DVec3::new(x, y, curve(x) - 0.009), 0.016);
        b.add(&tube(&[at(-high), at(high)], 5), 60.0);
    }
}

/// Paints bars, a cross or rays a little over a shield's face.
fn emblem_on(b: &mut Builder, is_round: bool, style: usize) {
    let front = |x: f64, y: f64| {
        let z = if is_round {
            let r = (x * x + y * y).sqrt();
            0.113 - 0.068 * (r / 0.4) * (r / 0.4)
        } else {
            curve(x)
        };
        DVec3::new(x, y, z + 0.009)
    };
    let reach = if is_round { 0.385 } else { 0.5 };
    let mut ray = |turn: f64, near: f64, far: f64, wide: [f64; 2]| {
        let (sin, cos) = turn.sin_cos();
        let at = |along: f64, side: f64| front(along * cos - side * sin, along * sin + side * cos);
        let steps = 4;
        let mut solid = Solid::default();
        for step in 0..steps {
            let edge = |s: u32| {
                let t = f64::from(s) / f64::from(steps);
                (near + (far - near) * t, wide[0] + (wide[1] - wide[0]) * t)
            };
            let ((a, wa), (c, wc)) = (edge(step), edge(step + 1));
            solid.face(&[at(a, -wa), at(c, -wc), at(c, wc), at(a, wa)]);
        }
        b.add(&solid, 40.0);
    };
    match style {
        0 => {
            for arm in 0..4 {
                let far = if arm % 2 == 0 && !is_round { 0.29 } else { reach };
                ray(FRAC_PI_2 * f64::from(arm), 0.08, far, [0.035, 0.05]);
            }
        }
        1 => {
            let count = if is_round { 8 } else { 4 };
            for arm in 0..count {
                let turn = TAU * (f64::from(arm) + 0.5) / f64::from(count);
                ray(turn, 0.1, if is_round { reach } else { 0.36 }, [0.05, 0.006]);
            }
        }
        _ => {
            ray(FRAC_PI_2, 0.1, reach, [0.07, 0.07]);
            ray(-FRAC_PI_2, 0.1, reach, [0.07, 0.07]);
        }
    }
}
