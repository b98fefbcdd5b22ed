//! Helmets.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DAffine3, DVec3};
use populace_character::{Character, Error};

use crate::build::{Builder, Solid, bevelled, extrude, lathe, matt, metal, plate, sheet, tube};
use crate::dice::Dice;

/// Kinds of helmets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// With a crest from front to back.
    Crested,
    /// Pointed, with hair that hangs from the point.
    Pointed,
    /// With a bar before the nose, and a band.
    Barred,
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
    let form = dice.pick([Form::Crested, Form::Pointed, Form::Barred]);
    let peak = match form {
        Form::Crested => 0.155,
        Form::Pointed => 0.19,
        Form::Barred => 0.15,
    };
    b.on(shell).add(&bowl(peak, 0.006), 45.0);
    b.on(inside).add(&bowl(peak, 0.0).turned(), 45.0);
    b.on(shell);
    both_sides(&mut b, &[ring(-0.022, 0.004), ring(0.012, 0.006)]);
    guards(&mut b);
    if form == Form::Barred {
        b.flat(&bevelled([-0.012, -0.09, 0.122], [0.012, 0.03, 0.134], 0.003));
    }
    b.on(crest);
    match form {
        Form::Crested => {
            b.at = DAffine3::from_rotation_y(-FRAC_PI_2);
            b.flat(&comb());
            b.home();
        }
        Form::Pointed => {
            let hair = [
                (DVec3::Y * peak, 0.012),
                (DVec3::new(0.0, peak + 0.06, -0.02), 0.02),
                (DVec3::new(0.0, peak + 0.02, -0.14), 0.012),
                (DVec3::new(0.0, 0.02, -0.21), 0.004),
            ];
            b.add(&tube(&hair, 6), 60.0);
        }
        Form::Barred => {
            b.add(&sheet(&[ring(0.016, 0.008), ring(0.036, 0.008)]), 45.0);
        }
    }
    b.build(Vec::new())
}

/// Returns a bowl with room for hair, deeper than wide, that comes down to the brows.
fn bowl(peak: f64, grow: f64) -> Solid {
    let profile =
        [[1.0, -0.01], [0.99, 0.04], [0.9, 0.09], [0.66, 0.13], [0.34, peak - 0.01], [0.0, peak]];
    let mut solid = lathe(&profile.map(|[r, y]| [r, y + if y > 0.0 { grow } else { 0.0 }]), 16);
    solid.faces.truncate(5 * 16);
    for point in &mut solid.points {
        point.x *= 0.1 + grow;
        point.z *= 0.122 + grow;
    }
    solid
}

/// Returns points around the bowl at a height.
fn ring(y: f64, out: f64) -> Vec<DVec3> {
    let point = |k: u32| {
        let (sin, cos) = (TAU * f64::from(k) / 16.0).sin_cos();
        DVec3::new((0.106 + out) * sin, y, (0.128 + out) * cos)
    };
    (0..=16).map(point).collect()
}

/// Adds a thin surface that is seen from both sides.
fn both_sides(b: &mut Builder, rows: &[Vec<DVec3>]) {
    b.add(&sheet(rows), 45.0);
    b.add(&sheet(rows).turned(), 45.0);
}

/// Adds plates over cheeks and neck.
fn guards(b: &mut Builder) {
    for side in [-1.0, 1.0] {
        let x = 0.104 * side;
        let cheek = [
            [x, -0.01, 0.075],
            [x, -0.01, -0.02],
            [x * 0.9, -0.12, 0.0],
            [x * 0.82, -0.13, 0.07],
            [x, -0.06, 0.1],
        ];
        b.flat(&thick(&plate(&cheek), DVec3::X * 0.006 * side));
    }
    let neck: Vec<DVec3> = ring(-0.015, 0.002)[5..=11].to_vec();
    let foot = neck.iter().map(|p| *p + DVec3::new(p.x * 0.1, -0.08, -0.035)).collect();
    both_sides(b, &[foot, neck]);
}

/// Returns a crest, thin and round, in the plane of x and y with its front to +X.
fn comb() -> Solid {
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
    extrude(&outline, -0.016, 0.016)
}

/// Returns a flat piece with a thickness.
fn thick(flat: &Solid, along: DVec3) -> Solid {
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
