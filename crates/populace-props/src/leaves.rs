//! Trees.

use std::f64::consts::TAU;

use glam::DVec3;
use populace_character::{Character, Error};

use crate::build::{Builder, Finish, Solid, lathe, linear, lump, matt, satin, tube};
use crate::dice::Dice;

/// Returns a leaf as a flat kite of two triangles, seen from outside: its stem at `at`, its surface
/// across `out`. `turn_rad` turns it about `out`.
pub(crate) fn sprig(at: DVec3, out: DVec3, size_m: f64, turn_rad: f64) -> Solid {
    let out = out.normalize_or(DVec3::Y);
    let side = out.any_orthonormal_vector();
    let (sin, cos) = turn_rad.sin_cos();
    let along = side * cos + out.cross(side) * sin;
    let across = out.cross(along);
    // The tip stands out, so that outlines are leafy.
    let tip = at + (along + 0.45 * out) * size_m;
    let wide = at + (0.45 * along + 0.25 * out) * size_m;
    let points = [at, wide - 0.36 * size_m * across, tip, wide + 0.36 * size_m * across];
    Solid { points: points.to_vec(), faces: vec![vec![0, 1, 2, 3]] }
}

/// Returns a tree 5 to 7.5 m high in a pit of 1.2 m, with an iron grate. Trunk, branches, crown and
/// greens follow from the seed.
///
/// # Errors
///
/// Those of [`Character::new`]; no seed causes one.
pub fn tree(seed: u64) -> Result<Character, Error> {
    let mut dice = Dice::new(seed, 31);
    let mut b = Builder::new("tree");
    let bark = b.finish(matt("Bark", dice.pick([0x7A_6450, 0x6B_5746, 0x8A_7A66])));
    let crown = b.finish(matt("Top leaves", 0xFF_FFFF));
    grate(&mut b);
    let fork = dice.within(2.2, 2.7);
    let lean = DVec3::new(dice.within(-0.15, 0.15), 0.0, dice.within(-0.15, 0.15));
    let top = DVec3::Y * fork + lean;
    b.on(bark).faded([0.0, 3.0], [0.8, 1.1]);
    let trunk = [
        (DVec3::ZERO, 0.24),
        (DVec3::new(0.0, 0.25, 0.0), 0.15),
        (0.55 * top, 0.125),
        (top, 0.13),
        (top + DVec3::new(0.0, 0.5, 0.0), 0.08),
    ];
    b.add(&tube(&trunk, 9), 60.0);
    let mut tips: Vec<(DVec3, f64)> = Vec::new();
    let count = 5;
    let first = dice.within(0.0, TAU);
    for nth in 0..count {
        let turn = first + TAU * f64::from(nth) / f64::from(count) + dice.within(-0.3, 0.3);
        let (sin, cos) = turn.sin_cos();
        let (out, up) = (dice.within(1.0, 1.5), dice.within(0.9, 1.7));
        let foot = top + DVec3::Y * dice.within(-0.25, 0.3);
        let tip = foot + DVec3::new(out * cos, up, out * sin);
        let bend = foot.lerp(tip, 0.5) + DVec3::new(0.15 * cos, -0.12, 0.15 * sin);
        b.add(&tube(&[(foot, 0.075), (bend, 0.055), (tip, 0.025)], 6), 60.0);
        tips.push((tip, dice.within(0.8, 1.05)));
        let twig = bend + DVec3::new(0.6 * sin, dice.within(0.5, 0.9), -0.6 * cos);
        b.add(&tube(&[(bend, 0.04), (twig, 0.015)], 5), 60.0);
        tips.push((twig + DVec3::Y * 0.3, dice.within(0.6, 0.8)));
    }
    let peak =
        top + DVec3::new(dice.within(-0.3, 0.3), dice.within(2.3, 2.9), dice.within(-0.3, 0.3));
    b.add(&tube(&[(top, 0.09), (top.lerp(peak, 0.5), 0.06), (peak, 0.02)], 6), 60.0);
    tips.push((peak, dice.within(0.9, 1.1)));
    tips.push((top + DVec3::Y * 1.6, 1.25));
    leaves(&mut b, crown, &mut dice, &tips);
    b.build(Vec::new())
}

/// Adds clumps of leaves around the ends of branches: a rough body, with leaves that stand out.
fn leaves(b: &mut Builder, crown: Finish, dice: &mut Dice, tips: &[(DVec3, f64)]) {
    let green = linear(dice.pick([0x5E_8A3A, 0x6B_9442, 0x50_7C3C, 0x76_8F3A]));
    let (low, high) = tips.iter().fold((f64::MAX, f64::MIN), |(low, high), (tip, radius)| {
        (low.min(tip.y - radius), high.max(tip.y + radius))
    });
    for (tip, radius) in tips {
        let radii = DVec3::new(*radius, 0.78 * radius, *radius);
        let tone = dice.within(0.85, 1.1);
        b.on(crown).faded([low, high], [0.5, 1.2]);
        b.tint = [green[0] * tone, green[1] * tone, green[2] * tone * 0.9, 1.0];
        b.add(&lump(*tip, 0.9 * radii, || dice.within(-0.18, 0.12)), 75.0);
        let count = 74;
        for nth in 0..count {
            // Evenly spread over the sphere (the golden angle).
            let rise = 1.0 - 2.0 * (f64::from(nth) + 0.5) / f64::from(count);
            let (sin, cos) = (2.399_963 * f64::from(nth)).sin_cos();
            let flat = (1.0 - rise * rise).max(0.0).sqrt();
            let out = DVec3::new(flat * cos, rise, flat * sin);
            let at = *tip + out * radii * dice.within(0.88, 1.02);
            let hidden = tips.iter().any(|(other, r)| {
                other != tip && ((at - *other) / DVec3::new(*r, 0.78 * r, *r)).length() < 0.9
            });
            if hidden {
                continue;
            }
            let bright = tone * dice.within(0.85, 1.35);
            b.tint = [green[0] * bright, green[1] * bright, green[2] * bright * 0.85, 1.0];
            b.flat(&sprig(at, out, dice.within(0.2, 0.34), dice.within(0.0, TAU)));
        }
    }
}

/// Adds soil in a pit, with a frame and bars of iron around the trunk.
fn grate(b: &mut Builder) {
    let soil = b.finish(matt("Soil", 0x50_3E2E));
    let iron = b.finish(satin("Iron", 0x33_3432));
    b.on(soil);
    b.block([-0.6, -0.1, -0.6], [0.6, 0.006, 0.6]);
    b.on(iron);
    for side in [-0.6, 0.54] {
        b.block([-0.6, -0.1, side], [0.6, 0.018, side + 0.06]);
        b.block([side, -0.1, -0.54], [side + 0.06, 0.018, 0.54]);
    }
    for bar in 0..5 {
        let x = -0.45 + 0.2 * f64::from(bar);
        for [from, to] in [[-0.54, -0.28], [0.28, 0.54]] {
            b.block([x, 0.0, from], [x + 0.1, 0.014, to]);
        }
    }
    b.add(&lathe(&[[0.3, 0.0], [0.3, 0.016], [0.26, 0.016], [0.26, 0.0]], 12), 20.0);
}
