//! Pictograms of trades, instead of letters.

use std::f64::consts::TAU;

use super::style::{Finishes, Style, Trade, rgb};
use crate::build::{Builder, Solid, polygon};

/// Distance in metres of the pieces of a pictogram from each other.
const LAYER_M: f64 = 0.003;

/// The colour of most pieces, sRGB.
const CREAM: u32 = 0xF0_E6D0;

/// Draws an outline in an sRGB colour over what was drawn before.
type Draw<'a> = dyn FnMut(&[[f64; 2]], u32) + 'a;

/// Adds the trade's pictogram on the plane z = 0, which reaches `size` metres from its middle.
pub(super) fn add(b: &mut Builder, style: &Style, finishes: &Finishes, size: f64) {
    let mut layer_m = 0.0;
    let mut draw = |outline: &[[f64; 2]], color: u32| {
        let scaled: Vec<[f64; 2]> = outline.iter().map(|p| p.map(|v| v * size)).collect();
        // Later ones lie over earlier ones.
        layer_m += LAYER_M;
        let mut solid: Solid = polygon(&scaled);
        for point in &mut solid.points {
            point.z = layer_m;
        }
        b.on(finishes.goods).tinted(rgb(color)).flat(&solid);
    };
    match style.trade {
        Trade::Cafe => cafe(&mut draw),
        Trade::Clothes => clothes(&mut draw),
        Trade::Books => books(&mut draw),
        Trade::Flowers => flowers(&mut draw),
        Trade::Fruit => fruit(&mut draw),
        Trade::Gifts => gifts(&mut draw),
        Trade::Bread => bread(&mut draw),
    }
}

fn cafe(draw: &mut Draw<'_>) {
    draw(&[[-0.75, 0.4], [-0.6, -0.5], [-0.4, -0.7], [0.3, -0.7], [0.5, -0.5], [0.65, 0.4]], CREAM);
    let ring = arc([0.68, -0.02], 0.36, [-0.22, 0.22], 5);
    let hole = arc([0.68, -0.02], 0.2, [0.22, -0.22], 5);
    draw(&[ring, hole].concat(), CREAM);
    draw(&[[-1.0, -0.82], [0.9, -0.82], [0.7, -1.0], [-0.8, -1.0]], CREAM);
    for x in [-0.35, 0.15] {
        draw(
            &[
                [x, 0.55],
                [x + 0.16, 0.75],
                [x, 1.0],
                [x + 0.1, 1.0],
                [x + 0.27, 0.75],
                [x + 0.1, 0.55],
            ],
            CREAM,
        );
    }
}

fn clothes(draw: &mut Draw<'_>) {
    draw(
        &[
            [-0.25, 0.9],
            [0.0, 0.72],
            [0.25, 0.9],
            [0.42, 0.85],
            [0.32, 0.25],
            [0.75, -0.9],
            [-0.75, -0.9],
            [-0.32, 0.25],
            [-0.42, 0.85],
        ],
        CREAM,
    );
    draw(
        &[[-0.3, 0.14], [0.3, 0.14], [0.32, 0.26], [-0.32, 0.26]].map(|[x, y]| [x, y + 0.03]),
        0xC9_8A3E,
    );
}

fn books(draw: &mut Draw<'_>) {
    draw(&[[-0.06, 0.5], [-0.06, -0.75], [-0.95, -0.6], [-0.95, 0.65]], CREAM);
    draw(&[[0.06, 0.5], [0.95, 0.65], [0.95, -0.6], [0.06, -0.75]], CREAM);
}

fn flowers(draw: &mut Draw<'_>) {
    draw(&[[-0.06, -1.0], [0.06, -1.0], [0.06, 0.0], [-0.06, 0.0]], 0x6E9A4E);
    draw(&[[0.05, -0.8], [0.6, -0.45], [0.3, -0.85]], 0x6E9A4E);
    for petal in 0..6 {
        let turn = TAU * f64::from(petal) / 6.0;
        draw(&circle([0.42 * turn.cos(), 0.35 + 0.42 * turn.sin()], 0.27, 8), 0xF0C4CC);
    }
    draw(&circle([0.0, 0.35], 0.24, 8), 0xE3B341);
}

fn fruit(draw: &mut Draw<'_>) {
    draw(&circle([-0.3, -0.25], 0.55, 12), 0xE0A890);
    draw(&circle([0.3, -0.25], 0.55, 12), 0xE0A890);
    draw(&[[-0.05, 0.2], [0.05, 0.2], [0.15, 0.8], [0.05, 0.8]], CREAM);
    draw(&[[0.1, 0.5], [0.45, 0.55], [0.7, 0.9], [0.35, 0.85]], 0xA9_C77E);
}

fn gifts(draw: &mut Draw<'_>) {
    draw(&[[-0.75, -0.8], [0.75, -0.8], [0.75, 0.3], [-0.75, 0.3]], CREAM);
    draw(&[[-0.85, 0.3], [0.85, 0.3], [0.85, 0.5], [-0.85, 0.5]], CREAM);
    draw(&[[0.0, 0.5], [-0.55, 0.95], [-0.7, 0.6]], 0xD9_8A5A);
    draw(&[[0.0, 0.5], [0.7, 0.6], [0.55, 0.95]], 0xD9_8A5A);
}

fn bread(draw: &mut Draw<'_>) {
    let outer = arc([0.0, -0.45], 0.95, [0.03, 0.47], 9);
    let inner = arc([0.0, -0.62], 0.55, [0.44, 0.06], 7);
    draw(&[outer, inner].concat(), 0xE9B872);
    for x in [-0.4, 0.0, 0.4] {
        draw(&[[x - 0.04, 0.1], [x + 0.04, 0.1], [x + 0.04, 0.34], [x - 0.04, 0.34]], 0x9C_6B36);
    }
}

/// Returns points of a circle between two turns.
fn arc([x, y]: [f64; 2], radius: f64, [from, to]: [f64; 2], steps: u32) -> Vec<[f64; 2]> {
    let point = |step: u32| {
        let (sin, cos) =
            (TAU * (from + (to - from) * f64::from(step) / f64::from(steps))).sin_cos();
        [x + radius * cos, y + radius * sin]
    };
    (0..=steps).map(point).collect()
}

fn circle(middle: [f64; 2], radius: f64, sides: u32) -> Vec<[f64; 2]> {
    let mut points = arc(middle, radius, [0.0, 1.0], sides);
    points.pop();
    points
}
