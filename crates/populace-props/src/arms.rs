//! Things that people hold or wear: shields, spears, helmets, parcels and phones.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DAffine3, DVec3};
use populace_character::{Character, Error};

use crate::build::{
    Builder, Solid, bevelled, extrude, lathe, linear, matt, metal, pane, plate, satin, sheet, tube,
    turned,
};
use crate::dice::Dice;

/// Length in metres of [`spear`].
pub const SPEAR_M: f32 = 2.2;
/// Height in metres of a spear's grip over its lower end.
pub const SPEAR_GRIP_M: f32 = 0.95;

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

fn curved_board(
    b: &mut Builder,
    [face, back]: [crate::build::Finish; 2],
    iron: crate::build::Finish,
) {
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

/// Returns a helmet for a head 0.24 m high, 0.16 m wide and 0.20 m deep. The origin is the middle of
/// the skull; the face is free along +Z. Form, crest and metal follow from the seed.
///
/// The material `Accessory crest` is its crest or band; members may tint that region.
///
/// # Errors
///
/// Those of [`Character::new`]; no seed causes one.
pub fn helmet(seed: u64) -> Result<Character, Error> {
    let mut dice = Dice::new(seed, 52);
    let mut b = Builder::new("helmet");
    let steel = dice.pick([0xA8_A8A6, 0xB8_955A, 0x8C_8A86]);
    let shell = b.finish(metal("Shell", steel, 0.38));
    let inside = b.finish(matt("Padding", 0x3A_2A20));
    let dye = dice.pick([0xA8_2E2A, 0x2F_4F74, 0xD9_CFB6, 0x3C_5A3C]);
    let crest = b.finish(matt("Accessory crest", dye));
    let style = dice.below(3);
    let peak = [0.155, 0.19, 0.15][style];
    // A bowl with room for hair, deeper than wide, that comes down to the brows.
    let bowl = |grow: f64| {
        let profile = [
            [1.0, -0.01],
            [0.99, 0.04],
            [0.9, 0.09],
            [0.66, 0.13],
            [0.34, peak - 0.01],
            [0.0, peak],
        ];
        let mut solid = lathe(&profile.map(|[r, y]| [r, y + if y > 0.0 { grow } else { 0.0 }]), 16);
        solid.faces.truncate(5 * 16);
        for point in &mut solid.points {
            point.x *= 0.1 + grow;
            point.z *= 0.122 + grow;
        }
        solid
    };
    b.on(shell).add(&bowl(0.006), 45.0);
    b.on(inside).add(&bowl(0.0).turned(), 45.0);
    b.on(shell);
    let ring = |y: f64, out: f64| -> Vec<DVec3> {
        (0..=16)
            .map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / 16.0).sin_cos();
                DVec3::new((0.106 + out) * sin, y, (0.128 + out) * cos)
            })
            .collect()
    };
    let (low, high) = (ring(-0.022, 0.004), ring(0.012, 0.006));
    b.add(&sheet(&[low.clone(), high.clone()]), 45.0);
    b.add(&sheet(&[low, high]).turned(), 45.0);
    // Plates over cheeks and neck, seen from both sides.
    for side in [-1.0, 1.0] {
        let x = 0.104 * side;
        let cheek = [
            [x, -0.01, 0.075],
            [x, -0.01, -0.02],
            [x * 0.9, -0.12, 0.0],
            [x * 0.82, -0.13, 0.07],
            [x, -0.06, 0.1],
        ];
        let front = plate(&cheek);
        let thick = bevel(&front, DVec3::X * 0.006 * side);
        b.flat(&thick);
    }
    let neck: Vec<DVec3> = ring(-0.015, 0.002)[5..=11].to_vec();
    let skirt: Vec<DVec3> =
        neck.iter().map(|p| *p + DVec3::new(p.x * 0.1, -0.08, -0.035)).collect();
    b.add(&sheet(&[skirt.clone(), neck.clone()]), 45.0);
    b.add(&sheet(&[skirt, neck]).turned(), 45.0);
    if style == 2 {
        b.flat(&bevelled([-0.012, -0.09, 0.122], [0.012, 0.03, 0.134], 0.003));
    }
    b.on(crest);
    match style {
        0 => {
            // A crest from front to back, thin and round.
            let mut outline: Vec<[f64; 2]> = (0..=10)
                .map(|k| {
                    let (sin, cos) = (2.6 * (f64::from(k) / 10.0) + 0.2).sin_cos();
                    [0.19 * cos, 0.03 + 0.235 * sin]
                })
                .collect();
            // Its lower edge lies in the shell.
            let below = [[0.121, 0.04], [0.109, 0.088], [0.08, 0.128], [0.041, 0.144]];
            outline.extend(below.map(|[z, y]| [-z, y]));
            outline.extend(below.iter().rev());
            let solid = extrude(&outline, -0.016, 0.016);
            b.at = DAffine3::from_rotation_y(-FRAC_PI_2);
            b.flat(&solid);
            b.home();
        }
        1 => {
            b.add(
                &tube(
                    &[
                        (DVec3::Y * peak, 0.012),
                        (DVec3::new(0.0, peak + 0.06, -0.02), 0.02),
                        (DVec3::new(0.0, peak + 0.02, -0.14), 0.012),
                        (DVec3::new(0.0, 0.02, -0.21), 0.004),
                    ],
                    6,
                ),
                60.0,
            );
        }
        _ => {
            let (a, c) = (ring(0.016, 0.008), ring(0.036, 0.008));
            b.add(&sheet(&[a, c]), 45.0);
        }
    }
    b.build(Vec::new())
}

/// Returns a flat piece with a thickness.
fn bevel(flat: &Solid, along: DVec3) -> Solid {
    let middle = flat.points.iter().sum::<DVec3>() / flat.points.len() as f64 + 0.5 * along;
    let mut solid = Solid::default();
    let points = &flat.points;
    solid.face(points);
    let moved: Vec<DVec3> = points.iter().map(|p| *p + along).collect();
    solid.face(&moved);
    for k in 0..points.len() {
        let next = (k + 1) % points.len();
        solid.face(&[points[k], points[next], moved[next], moved[k]]);
    }
    solid.outwards_from(middle)
}

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
    let screen = b.finish(crate::build::glow("Screen", 0xA9_C4E0, 0.4));
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
