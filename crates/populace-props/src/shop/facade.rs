//! The front over the shop: wall, windows and what hangs on them.

use super::style::{Finishes, GROUND_M, PIER_M, ROOM_SIDE_M, Style, Wall, rgb};
use crate::build::{Builder, along_x, grid, lathe, plate, polygon};
use crate::dice::Dice;
use crate::leaves::sprig;
use glam::{DAffine3, DVec3};

/// Height in metres up to which the shop fills the opening of the wall.
pub(super) const OPENING_M: f64 = 2.95;
/// Depth of the windows behind the wall, in metres.
const REVEAL_M: f64 = 0.15;

/// A window: its edges in metres.
#[derive(Clone, Copy, Debug)]
struct Window {
    x: [f64; 2],
    y: [f64; 2],
    has_balcony: bool,
}

pub(super) fn build(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let windows = windows(style);
    wall(b, style, finishes, &windows);
    let mut dice = Dice::new(style.seed, 2);
    for window in &windows {
        reveal(b, finishes, window);
        glazing(b, finishes, window, &mut dice);
        surround(b, style, finishes, window);
        if style.shutters && !window.has_balcony {
            shutters(b, style, finishes, window);
        }
        if style.boxes && window.y[0] < GROUND_M + style.storey_m && dice.chance(0.7) {
            flowers(b, finishes, window, &mut dice);
        }
    }
    let iron = windows.iter().filter(|window| window.has_balcony);
    for window in iron {
        railing(b, finishes, window);
    }
    bands(b, style, finishes);
}

fn windows(style: &Style) -> Vec<Window> {
    let [width, height] = style.window_m;
    let mut windows = Vec::new();
    for storey in 0..style.storeys {
        let floor = GROUND_M + f64::from(storey) * style.storey_m;
        let has_balcony = style.balcony && storey == 0;
        let sill = floor + if has_balcony { 0.2 } else { 0.72 };
        // The uppermost rooms are lower.
        let lower = if storey + 1 == style.storeys { 0.12 } else { 0.0 };
        let head = floor + 0.72 + height - lower;
        for x in style.window_middles() {
            let x = [x - 0.5 * width, x + 0.5 * width];
            windows.push(Window { x, y: [sill, head], has_balcony });
        }
    }
    windows
}

/// Adds the wall as one grid, so that no gaps open between its pieces.
fn wall(b: &mut Builder, style: &Style, finishes: &Finishes, windows: &[Window]) {
    let [from, to] = style.opening();
    let mut xs = vec![-0.5 * style.width, from, to, 0.5 * style.width];
    xs.extend(windows.iter().flat_map(|window| window.x));
    let mut ys = vec![0.0, OPENING_M, style.wall_top()];
    ys.extend(windows.iter().flat_map(|window| window.y));
    for lines in [&mut xs, &mut ys] {
        lines.sort_by(f64::total_cmp);
        lines.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    }
    let is_hole = |column: usize, row: usize| {
        let (x, y) = (0.5 * (xs[column] + xs[column + 1]), 0.5 * (ys[row] + ys[row + 1]));
        let within = |edges: [f64; 2], v: f64| edges[0] < v && v < edges[1];
        (y < OPENING_M && within([from, to], x))
            || windows.iter().any(|window| within(window.x, x) && within(window.y, y))
    };
    b.on(finishes.wall).faded([0.0, 1.2], [0.82, 1.0]).flat(&grid(&xs, &ys, is_hole));
    // Inner sides of the piers.
    b.flat(&plate(&inner_side(from, [0.0, OPENING_M], 1.0)));
    b.flat(&plate(&inner_side(to, [0.0, OPENING_M], -1.0)));
    if style.wall != Wall::Brick {
        return;
    }
    // Quoins of light stone at the edges of brick.
    b.on(finishes.trim);
    let mut y = GROUND_M + 0.2;
    let mut is_long = true;
    while y + 0.3 < style.wall_top() - 0.3 {
        let length = if is_long { 0.36 } else { 0.22 };
        for side in [-1.0, 1.0] {
            let outer = 0.5 * style.width * side;
            let ends = [outer, outer - length * side];
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            front_block(b, [low, high], [y, y + 0.28], 0.02);
        }
        y += 0.3;
        is_long = !is_long;
    }
}

/// Adds a block on the wall without the back that nobody sees.
pub(super) fn front_block(b: &mut Builder, x: [f64; 2], y: [f64; 2], thick: f64) {
    let mut solid = crate::build::block([x[0], y[0], 0.0], [x[1], y[1], thick]);
    solid.faces.remove(4);
    b.flat(&solid);
}

/// Returns a face from the wall to behind the reveal, which looks along `side` X.
fn inner_side(x: f64, y: [f64; 2], side: f64) -> [[f64; 3]; 4] {
    let depth = if y[0] > 0.0 { REVEAL_M } else { ROOM_SIDE_M };
    let face = [[x, y[0], 0.0], [x, y[0], -depth], [x, y[1], -depth], [x, y[1], 0.0]];
    if side > 0.0 { face } else { [face[1], face[0], face[3], face[2]] }
}

fn reveal(b: &mut Builder, finishes: &Finishes, window: &Window) {
    let ([x0, x1], [y0, y1], z) = (window.x, window.y, -REVEAL_M);
    b.on(finishes.side).tinted([0.86; 3]);
    b.flat(&plate(&inner_side(x0, window.y, 1.0)));
    b.flat(&plate(&inner_side(x1, window.y, -1.0)));
    b.flat(&plate(&[[x0, y1, z], [x1, y1, z], [x1, y1, 0.0], [x0, y1, 0.0]]));
    b.flat(&plate(&[[x0, y0, 0.0], [x1, y0, 0.0], [x1, y0, z], [x0, y0, z]]));
}

/// Adds frame, pane and what hangs behind it.
fn glazing(b: &mut Builder, finishes: &Finishes, window: &Window, dice: &mut Dice) {
    let ([x0, x1], [y0, y1]) = (window.x, window.y);
    let (middle, cross) = (0.5 * (x0 + x1), y0 + 0.68 * (y1 - y0));
    let xs = [x0, x0 + 0.065, middle - 0.035, middle + 0.035, x1 - 0.065, x1];
    let ys = [y0, y0 + 0.075, cross - 0.03, cross + 0.03, y1 - 0.065, y1];
    let odd = |column: usize, row: usize| column % 2 == 1 && row % 2 == 1;
    b.at = DAffine3::from_translation(DVec3::new(0.0, 0.0, 0.045 - REVEAL_M));
    b.on(finishes.frame).flat(&grid(&xs, &ys, odd));
    b.home();
    let (back, before) = (-REVEAL_M, 0.006 - REVEAL_M);
    // Panes show a dark room below and some of the sky above.
    let depth = dice.within(0.42, 0.7);
    b.on(finishes.pane).faded([y0, y1], [depth, 1.25]);
    b.flat(&plate(&[[x0, y0, back], [x1, y0, back], [x1, y1, back], [x0, y1, back]]));
    let cloth = rgb(dice.pick([0xE9E1D0, 0xDDE0DC, 0xC9B79A, 0xB9A9A0, 0xA8B5B0]));
    b.on(finishes.curtain).tinted(cloth.map(|c| 0.72 * c)).faded([y0, y1], [0.8, 1.1]);
    match dice.below(5) {
        0 => {}
        1 => {
            // A blind, drawn half.
            let low = y1 - dice.within(0.3, 0.75) * (y1 - y0);
            let corners =
                [[x0, low, before], [x1, low, before], [x1, y1, before], [x0, y1, before]];
            b.flat(&plate(&corners));
        }
        _ => {
            let (top, foot) = (dice.within(0.3, 0.4), dice.within(0.12, 0.22));
            let w = x1 - x0;
            let left = [
                [x0, y0],
                [x0 + foot * w, y0],
                [x0 + (foot + 0.05) * w, cross],
                [x0 + top * w, y1],
            ];
            for side in [1.0, -1.0] {
                let mut corners = left.map(|[x, y]| [middle + side * (x - middle), y]).to_vec();
                corners.push([middle + side * (x0 - middle), y1]);
                b.at = DAffine3::from_translation(DVec3::Z * before);
                b.flat(&polygon(&corners));
                b.home();
            }
        }
    }
}

fn surround(b: &mut Builder, style: &Style, finishes: &Finishes, window: &Window) {
    let ([x0, x1], [y0, y1]) = (window.x, window.y);
    b.on(finishes.trim);
    if !window.has_balcony {
        b.block([x0 - 0.1, y0 - 0.1, -0.02], [x1 + 0.1, y0, 0.11]);
    }
    let thick = 0.035;
    match style.wall {
        Wall::Brick => {
            front_block(b, [x0 - 0.14, x1 + 0.14], [y1, y1 + 0.24], thick);
            let middle = 0.5 * (x0 + x1);
            front_block(b, [middle - 0.09, middle + 0.09], [y1 - 0.02, y1 + 0.3], 0.07);
        }
        Wall::Plaster | Wall::Stone => {
            front_block(b, [x0 - 0.12, x0], [y0, y1 + 0.12], thick);
            front_block(b, [x1, x1 + 0.12], [y0, y1 + 0.12], thick);
            front_block(b, [x0, x1], [y1, y1 + 0.12], thick);
            if style.wall == Wall::Stone || !style.shutters {
                let top = y1 + 0.16;
                let shelf = [[0.0, top], [0.0, top + 0.1], [0.14, top + 0.1], [0.1, top + 0.02]];
                b.flat(&along_x(&shelf, x0 - 0.18, x1 + 0.18));
            }
        }
    }
}

fn shutters(b: &mut Builder, style: &Style, finishes: &Finishes, window: &Window) {
    let ([x0, x1], [y0, y1]) = (window.x, window.y);
    // Those of neighbouring windows do not meet.
    let room = 0.5 * (style.window_step() - (x1 - x0)) - 0.13;
    let width = room.min(0.46 * (x1 - x0));
    for [from, to] in [[x0 - 0.12 - width, x0 - 0.12], [x1 + 0.12, x1 + 0.12 + width]] {
        b.on(finishes.wood);
        front_block(b, [from, to], [y0, y1], 0.045);
        // Three panels that lie deeper look like louvres from afar.
        b.tinted([0.72; 3]);
        for panel in 0..3 {
            let low = y0 + 0.07 + f64::from(panel) * (y1 - y0 - 0.07) / 3.0;
            let high = low + (y1 - y0) / 3.0 - 0.1;
            let z = 0.047;
            let (l, r) = (from + 0.06, to - 0.06);
            b.flat(&plate(&[[l, low, z], [r, low, z], [r, high, z], [l, high, z]]));
        }
    }
}

fn flowers(b: &mut Builder, finishes: &Finishes, window: &Window, dice: &mut Dice) {
    let ([x0, x1], y) = (window.x, window.y[0]);
    b.on(finishes.wood);
    b.block([x0 + 0.03, y, 0.0], [x1 - 0.03, y + 0.17, 0.17]);
    let bloom = rgb(dice.pick([0xC9403F, 0xE08AA0, 0xE5B84B, 0xF0ECE0, 0x8B5FA8]));
    let count = 4;
    for nth in 0..count {
        let share = (f64::from(nth) + 0.5) / f64::from(count);
        let at = DVec3::new(x0 + 0.08 + share * (x1 - x0 - 0.16), y + 0.22, 0.09);
        b.on(finishes.leaves).tinted(rgb(dice.pick([0x4F7A3A, 0x5E8A42, 0x44703A])));
        let radii = DVec3::new(0.19, dice.within(0.12, 0.18), 0.14);
        b.add(&nugget(at, radii), 50.0);
        b.tinted(bloom);
        for _ in 0..2 {
            let away = DVec3::new(
                dice.within(-0.12, 0.12),
                dice.within(0.03, 0.13),
                dice.within(0.02, 0.12),
            );
            b.flat(&sprig(at + away, away + DVec3::Z, 0.09, dice.within(0.0, 6.2)));
            b.flat(&sprig(at + away, away + DVec3::Z, 0.09, dice.within(0.0, 6.2)));
        }
    }
}

/// Returns a small round thing of ten faces.
pub(super) fn nugget(at: DVec3, radii: DVec3) -> crate::build::Solid {
    let mut solid = lathe(&[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]], 5);
    solid.faces.truncate(10);
    for point in &mut solid.points {
        *point = at + *point * radii;
    }
    solid
}

/// Returns the upper half of a round thing, in fifteen triangles.
pub(super) fn dome(at: DVec3, radii: DVec3) -> crate::build::Solid {
    let mut solid = lathe(&[[1.0, 0.0], [0.78, 0.62], [0.0, 1.0]], 5);
    solid.faces.truncate(10);
    for point in &mut solid.points {
        *point = at + *point * radii;
    }
    solid
}

fn railing(b: &mut Builder, finishes: &Finishes, window: &Window) {
    let ([x0, x1], y) = ([window.x[0] - 0.2, window.x[1] + 0.2], window.y[0]);
    b.on(finishes.trim);
    b.block([x0 - 0.05, y - 0.22, 0.0], [x1 + 0.05, y - 0.06, 0.55]);
    let bracket = [[0.0, y - 0.6], [0.42, y - 0.22], [0.0, y - 0.22]];
    for x in [x0 + 0.05, x1 - 0.17] {
        b.flat(&along_x(&bracket, x, x + 0.12));
    }
    b.on(finishes.iron);
    let (low, top) = (y - 0.06, y + 0.92);
    for height in [low + 0.06, top - 0.05] {
        b.block([x0, height, 0.47], [x1, height + 0.045, 0.51]);
        for x in [x0, x1 - 0.04] {
            b.block([x, height, 0.0], [x + 0.04, height + 0.045, 0.49]);
        }
    }
    let count = 9;
    for bar in 0..=count {
        let x = x0 + (x1 - x0 - 0.02) * f64::from(bar) / f64::from(count);
        bar_between(b, [x, 0.49], [low + 0.06, top]);
    }
    for z in [0.16, 0.33] {
        bar_between(b, [x0 + 0.01, z], [low + 0.06, top]);
        bar_between(b, [x1 - 0.03, z], [low + 0.06, top]);
    }
}

/// Adds an upright bar of three sides.
fn bar_between(b: &mut Builder, [x, z]: [f64; 2], [low, high]: [f64; 2]) {
    let mut bar = lathe(&[[0.014, low], [0.014, high]], 3);
    bar.faces.truncate(3);
    for point in &mut bar.points {
        *point += DVec3::new(x, 0.0, z);
    }
    b.flat(&bar);
}

/// Adds mouldings along the front: over the shop, between storeys, and the cornice.
fn bands(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let half = 0.5 * style.width;
    b.on(finishes.trim);
    let mut band = |y: f64, out: f64, high: f64| {
        let outline = [
            [0.0, y],
            [0.0, y + high],
            [out, y + high],
            [out, y + 0.6 * high],
            [0.55 * out, y + 0.35 * high],
            [0.35 * out, y],
        ];
        b.add(&along_x(&outline, -half, half), 0.5);
    };
    band(GROUND_M - 0.12, 0.16, 0.16);
    if style.wall != Wall::Plaster {
        for storey in 1..style.storeys {
            band(GROUND_M + f64::from(storey) * style.storey_m + 0.1, 0.07, 0.14);
        }
    }
    band(style.wall_top() - 0.3, 0.34, 0.3);
    // The plinths of the piers.
    for [from, to] in [[-half, PIER_M - half], [half - PIER_M, half]] {
        front_block(b, [from, to], [0.0, 0.45], 0.035);
    }
}
