//! Roofs, dormers and chimneys.

use super::HOUSE_DEPTH_M;
use super::style::{Finishes, Roof, Style, rgb};
use crate::build::{Builder, along_x, lathe, plate};
use crate::dice::Dice;
use glam::DVec3;

pub(super) fn build(b: &mut Builder, style: &Style, finishes: &Finishes) {
    match style.roof {
        Roof::Pitched => pitched(b, style, finishes),
        Roof::Mansard => mansard(b, style, finishes),
        Roof::Parapet => parapet(b, style, finishes),
    }
    chimney(b, style, finishes);
}

fn pitched(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let (half, eave, back) = (0.5 * style.width, style.wall_top(), -f64::from(HOUSE_DEPTH_M));
    let (ridge_z, ridge) = (0.5 * back, eave + 2.9);
    let over = 0.42;
    let drop = over * (ridge - eave) / -ridge_z;
    let low = eave - drop + 0.1;
    b.on(finishes.roof);
    b.flat(&plate(&[
        [-half, low, over],
        [half, low, over],
        [half, ridge, ridge_z],
        [-half, ridge, ridge_z],
    ]));
    b.flat(&plate(&[
        [half, eave, back],
        [-half, eave, back],
        [-half, ridge, ridge_z],
        [half, ridge, ridge_z],
    ]));
    b.on(finishes.side);
    b.flat(&plate(&[[half, eave, 0.0], [half, eave, back], [half, ridge - 0.05, ridge_z]]));
    b.flat(&plate(&[[-half, eave, back], [-half, eave, 0.0], [-half, ridge - 0.05, ridge_z]]));
    // The edge of the roof and its gutter.
    b.on(finishes.trim).tinted([0.6; 3]);
    b.block([-half, low - 0.07, over - 0.06], [half, low + 0.02, over + 0.05]);
    b.flat(&plate(&[[-half, eave, 0.0], [half, eave, 0.0], [half, low, over], [-half, low, over]]));
    let slope = (ridge - low) / (ridge_z - over);
    dormers(b, style, finishes, |z| low + slope * (z - over), -0.55);
}

fn mansard(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let (half, eave, back) = (0.5 * style.width, style.wall_top(), -f64::from(HOUSE_DEPTH_M));
    let (top, set_back) = (eave + 2.35, 0.75);
    b.on(finishes.roof);
    let (front, rear) = (-set_back, back + set_back);
    b.flat(&plate(&[
        [-half, eave, 0.1],
        [half, eave, 0.1],
        [half, top, front],
        [-half, top, front],
    ]));
    b.flat(&plate(&[
        [half, eave, back],
        [-half, eave, back],
        [-half, top, rear],
        [half, top, rear],
    ]));
    b.on(finishes.trim).tinted([0.55; 3]);
    b.flat(&plate(&[
        [-half, top, front],
        [half, top, front],
        [half, top + 0.35, rear],
        [-half, top + 0.35, rear],
    ]));
    b.block([-half, top - 0.06, front - 0.02], [half, top + 0.08, front + 0.1]);
    b.on(finishes.side);
    let side = [[eave, 0.1], [eave, back], [top, rear], [top, front]];
    b.flat(&plate(&side.map(|[y, z]| [half, y, z])));
    b.flat(&plate(&[side[1], side[0], side[3], side[2]].map(|[y, z]| [-half, y, z])));
    dormers(b, style, finishes, |z| eave + (0.1 - z) * (top - eave) / (set_back + 0.1), -0.02);
}

/// Adds windows in the roof, whose front stands at `z`. `height` is that of the roof's front.
fn dormers(
    b: &mut Builder,
    style: &Style,
    finishes: &Finishes,
    height: impl Fn(f64) -> f64,
    z: f64,
) {
    let mut dice = Dice::new(style.seed, 3);
    let is_steep = style.roof == Roof::Mansard;
    let middles = style.window_middles();
    let count = middles.len();
    for (index, x) in middles.into_iter().enumerate() {
        // A pitched roof has one in every second bay, away from the ends.
        if !is_steep && (index % 2 == 0 || count < 3) {
            continue;
        }
        let (half, low) = (0.52, height(z) + if is_steep { 0.35 } else { -0.05 });
        let top = low + 1.25;
        let deep = if is_steep { -1.2 } else { z - 2.1 };
        b.on(finishes.side).tinted([0.97; 3]);
        b.block([x - half, low - 0.3, deep], [x + half, top, z]);
        b.on(finishes.frame);
        b.block([x - half + 0.08, low + 0.05, z], [x + half - 0.08, top - 0.06, z + 0.03]);
        b.on(finishes.pane).faded([low, top], [dice.within(0.45, 0.7), 1.25]);
        for [from, to] in [[0.16, 0.49], [0.55, 0.88]] {
            let (l, r) = (x - half + from * 2.0 * half, x - half + to * 2.0 * half);
            let (d, u) = (low + 0.13, top - 0.14);
            b.flat(&plate(&[
                [l, d, z + 0.035],
                [r, d, z + 0.035],
                [r, u, z + 0.035],
                [l, u, z + 0.035],
            ]));
        }
        b.on(finishes.roof).tinted([0.9; 3]);
        let (eave, ridge, front) = (top - 0.05, top + 0.42, z + 0.16);
        let out = half + 0.12;
        b.flat(&plate(&[
            [x + out, eave, front],
            [x + out, eave, deep],
            [x, ridge, deep],
            [x, ridge, front],
        ]));
        b.flat(&plate(&[
            [x - out, eave, deep],
            [x - out, eave, front],
            [x, ridge, front],
            [x, ridge, deep],
        ]));
        b.on(finishes.trim);
        b.flat(&plate(&[[x - out, eave, front], [x + out, eave, front], [x, ridge, front]]));
        b.flat(&plate(&[
            [x - out, eave, front],
            [x - out, eave, deep],
            [x + out, eave, deep],
            [x + out, eave, front],
        ]));
    }
}

fn parapet(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let (half, top, back) = (0.5 * style.width, style.wall_top(), -f64::from(HOUSE_DEPTH_M));
    b.on(finishes.roof);
    b.flat(&plate(&[[-half, top, 0.0], [half, top, 0.0], [half, top, back], [-half, top, back]]));
    b.on(finishes.side);
    let high = top + 0.75;
    b.block([-half, top, -0.28], [half, high, -0.02]);
    b.block([-half, top, back], [half, high - 0.3, back + 0.2]);
    for x in [-half, half - 0.2] {
        b.block([x, top, back], [x + 0.2, high - 0.3, -0.28]);
    }
    b.on(finishes.trim);
    let cap = [[-0.36, high], [0.06, high], [0.06, high + 0.09], [-0.36, high + 0.14]];
    b.flat(&along_x(&cap, -half, half));
    // Panels on the parapet, and a raised middle.
    let middle = 0.28 * style.width;
    b.block([-middle, high, -0.28], [middle, high + 0.45, -0.02]);
    b.block([-middle - 0.06, high + 0.45, -0.33], [middle + 0.06, high + 0.56, 0.05]);
}

fn chimney(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let mut dice = Dice::new(style.seed, 4);
    let rise = match style.roof {
        Roof::Pitched => 3.6,
        Roof::Mansard => 3.7,
        Roof::Parapet => 1.9,
    };
    let x = (0.5 * style.width - 0.75) * dice.pick([-1.0, 1.0]);
    let (foot, top) = (style.wall_top(), style.wall_top() + rise);
    let z = -0.45 * f64::from(HOUSE_DEPTH_M);
    b.on(finishes.side).tinted([0.8, 0.74, 0.7]);
    b.block([x - 0.5, foot, z - 0.3], [x + 0.5, top, z + 0.3]);
    b.on(finishes.trim).tinted([0.75; 3]);
    b.block([x - 0.56, top, z - 0.36], [x + 0.56, top + 0.12, z + 0.36]);
    b.on(finishes.goods).tinted(rgb(0xA5_5B3F));
    for away in [-0.26, 0.26] {
        let mut pot = lathe(&[[0.12, top + 0.1], [0.1, top + 0.5], [0.14, top + 0.55]], 8);
        for point in &mut pot.points {
            *point += DVec3::new(x + away, 0.0, z);
        }
        b.add(&pot, 40.0);
    }
}
