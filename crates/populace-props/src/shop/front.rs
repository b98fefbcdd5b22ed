//! The shop's front: joinery, glass, door, sign and awning.

use super::facade::{OPENING_M, front_block};
use super::signs;
use super::style::{DOOR_M, Finishes, GROUND_M, LIT, Style, rgb};
use crate::build::{Builder, along_x, grid, plate, spun};
use crate::dice::Dice;
use glam::{DAffine3, DVec3};

/// The joint of the shop's door.
pub(super) const DOOR: &str = "Door";
/// Place of the shop's glass, and of its door, in z.
pub(super) const GLASS_Z: f64 = -0.1;
/// Depth of the shop's room behind the wall, in metres.
pub(super) const ROOM_M: f64 = 2.6;
/// Height in metres of the floor of the window, and of the bar under its upper lights.
pub(super) const SILL_M: f64 = 0.5;
const BAR_M: f64 = 2.32;

pub(super) fn build(b: &mut Builder, style: &Style, finishes: &Finishes) {
    joinery(b, style, finishes);
    door(b, style, finishes);
    fascia(b, style, finishes);
    if style.awning {
        awning(b, style, finishes);
    }
    if style.blade {
        blade(b, style, finishes);
    }
}

/// The edge of the door at its hinge, and at its handle, in x.
fn door_edges(style: &Style) -> [f64; 2] {
    let (middle, half) = (style.door_middle(), 0.5 * DOOR_M - 0.13);
    if style.door_left { [middle + half, middle - half] } else { [middle - half, middle + half] }
}

/// The middle of the door's handle.
pub(super) fn handle(style: &Style) -> DVec3 {
    let [hinge, free] = door_edges(style);
    DVec3::new(free + 0.12 * (hinge - free).signum(), 1.08, GLASS_Z + 0.09)
}

/// Adds the frame of the window and the panels under it, and its glass.
fn joinery(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let [from, to] = style.shop_window();
    let panes = style.shop_panes();
    let mut xs = vec![from];
    xs.extend(panes.iter().flatten());
    xs.push(to);
    let ys = [SILL_M, SILL_M + 0.08, BAR_M, BAR_M + 0.08, OPENING_M - 0.12, OPENING_M];
    let odd = |column: usize, row: usize| column % 2 == 1 && row % 2 == 1;
    frame(b, finishes, &xs, &ys, odd);
    b.on(finishes.glass);
    for [l, r] in panes.iter().copied() {
        for [low, high] in [[ys[1], ys[2]], [ys[3], ys[4]]] {
            let z = GLASS_Z;
            b.flat(&plate(&[[l, low, z], [r, low, z], [r, high, z], [l, high, z]]));
        }
    }
    // Panels under the window.
    b.on(finishes.wood);
    b.block([from, 0.0, GLASS_Z - 0.06], [to, SILL_M, -0.04]);
    b.block([from, SILL_M - 0.05, -0.05], [to, SILL_M + 0.01, 0.03]);
    b.on(finishes.trim).tinted([0.62; 3]);
    b.block([from, 0.0, -0.06], [to, 0.09, 0.0]);
    b.on(finishes.wood).tinted([1.5; 3]);
    for [l, r] in panes {
        raised(b, [l + 0.05, r - 0.05], [0.16, SILL_M - 0.1], -0.04);
    }
    pilasters(b, style, finishes);
}

/// Adds a frame with a front, and with sides that show its thickness.
fn frame(
    b: &mut Builder,
    finishes: &Finishes,
    xs: &[f64],
    ys: &[f64],
    is_hole: impl Fn(usize, usize) -> bool,
) {
    let front = GLASS_Z + 0.05;
    b.at = DAffine3::from_translation(DVec3::new(0.0, 0.0, front));
    b.on(finishes.wood).flat(&grid(xs, ys, &is_hole));
    b.home();
    b.tinted([0.7; 3]);
    for column in 1..xs.len() {
        for row in (1..ys.len()).filter(|row| is_hole(column - 1, row - 1)) {
            let (l, r, d, u) = (xs[column - 1], xs[column], ys[row - 1], ys[row]);
            let (f, g) = (front, GLASS_Z);
            b.flat(&plate(&[[l, d, f], [l, d, g], [l, u, g], [l, u, f]]));
            b.flat(&plate(&[[r, d, g], [r, d, f], [r, u, f], [r, u, g]]));
            b.flat(&plate(&[[l, d, f], [r, d, f], [r, d, g], [l, d, g]]));
            b.flat(&plate(&[[l, u, g], [r, u, g], [r, u, f], [l, u, f]]));
        }
    }
}

fn pilasters(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let [from, to] = style.opening();
    for x in [from - 0.17, to - 0.02] {
        b.on(finishes.wood);
        b.block([x, 0.0, -0.02], [x + 0.19, OPENING_M, 0.05]);
        b.block([x - 0.02, 0.0, -0.02], [x + 0.21, 0.3, 0.075]);
        b.block([x - 0.02, OPENING_M - 0.22, -0.02], [x + 0.21, OPENING_M + 0.02, 0.085]);
        b.tinted([1.5; 3]);
        front_panel(b, [x + 0.05, x + 0.14], [0.4, OPENING_M - 0.32], 0.052);
    }
}

/// Adds a panel that rises from the plane at `z` by bevelled edges.
fn raised(b: &mut Builder, [l, r]: [f64; 2], [d, u]: [f64; 2], z: f64) {
    let (cut, out) = (0.03, z + 0.022);
    let outer = [[l, d, z], [r, d, z], [r, u, z], [l, u, z]];
    let inner = [[l + cut, d + cut], [r - cut, d + cut], [r - cut, u - cut], [l + cut, u - cut]];
    let inner = inner.map(|[x, y]| [x, y, out]);
    b.flat(&plate(&inner));
    for k in 0..4 {
        let next = (k + 1) % 4;
        b.flat(&plate(&[outer[k], outer[next], inner[next], inner[k]]));
    }
}

fn front_panel(b: &mut Builder, [l, r]: [f64; 2], [d, u]: [f64; 2], z: f64) {
    b.flat(&plate(&[[l, d, z], [r, d, z], [r, u, z], [l, u, z]]));
}

/// Adds the door, which turns about its joint, and the frame around it.
fn door(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let middle = style.door_middle();
    let (l, r) = (middle - 0.5 * DOOR_M, middle + 0.5 * DOOR_M);
    let xs = [l, l + 0.12, r - 0.12, r];
    let ys = [0.0, BAR_M, BAR_M + 0.08, OPENING_M - 0.12, OPENING_M];
    frame(b, finishes, &xs, &ys, |column, row| column == 1 && row % 2 == 0 && row < 3);
    b.on(finishes.glass);
    let (g, u) = (GLASS_Z, OPENING_M - 0.12);
    b.flat(&plate(&[
        [xs[1], BAR_M + 0.08, g],
        [xs[2], BAR_M + 0.08, g],
        [xs[2], u, g],
        [xs[1], u, g],
    ]));
    b.on(finishes.trim).tinted([0.8; 3]);
    b.block([l, -0.02, GLASS_Z - 0.1], [r, 0.03, 0.02]);
    let [hinge, _] = door_edges(style);
    let joint = b.joint(DOOR, DVec3::new(hinge, 0.0, GLASS_Z), None);
    b.moved_by(Some(joint));
    let (l, r) = (xs[1] + 0.01, xs[2] - 0.01);
    let (front, back) = (GLASS_Z + 0.02, GLASS_Z - 0.025);
    b.on(finishes.wood);
    b.block([l, 0.04, back], [r, 0.78, front]);
    b.block([l, BAR_M - 0.14, back], [r, BAR_M - 0.01, front]);
    b.block([l, 0.78, back], [l + 0.12, BAR_M - 0.14, front]);
    b.block([r - 0.12, 0.78, back], [r, BAR_M - 0.14, front]);
    b.tinted([1.5; 3]);
    raised(b, [l + 0.14, r - 0.14], [0.16, 0.68], front);
    b.on(finishes.gold);
    let at = handle(style);
    for height in [-0.2, 0.2] {
        b.block([at.x - 0.015, at.y + height, GLASS_Z], [at.x + 0.015, at.y + height + 0.03, at.z]);
    }
    b.block([at.x - 0.018, at.y - 0.24, at.z - 0.018], [at.x + 0.018, at.y + 0.26, at.z + 0.018]);
    b.block([l + 0.02, 0.06, GLASS_Z], [r - 0.02, 0.13, front + 0.006]);
    b.on(finishes.glass);
    let (l, r, d, u) = (l + 0.12, r - 0.12, 0.78, BAR_M - 0.14);
    b.flat(&plate(&[[l, d, g], [r, d, g], [r, u, g], [l, u, g]]));
    b.moved_by(None);
}

/// Adds the board over the shop, with its sign.
fn fascia(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let half = 0.5 * style.width - 0.2;
    let (low, high) = (OPENING_M, GROUND_M - 0.2);
    b.on(finishes.wood);
    b.block([-half, low, -0.1], [half, high, 0.11]);
    b.tinted([1.15; 3]);
    let top = [[0.0, high], [0.24, high + 0.1], [0.24, high + 0.04], [0.11, high - 0.06]];
    b.flat(&along_x(&top, -half - 0.05, half + 0.05));
    b.on(finishes.gold);
    for y in [low + 0.07, high - 0.13] {
        front_panel(b, [0.12 - half, half - 0.12], [y, y + 0.022], 0.113);
    }
    b.at = DAffine3::from_translation(DVec3::new(0.0, 0.5 * (low + high) - 0.02, 0.11));
    signs::add(b, style, finishes, 0.2);
    // Bars beside the sign, where other shops have letters.
    for side in [-1.0, 1.0] {
        let (near, far) = (0.5 * side, side * (half - 0.35).min(1.9));
        b.on(finishes.gold);
        front_block(b, [near.min(far), near.max(far)], [-0.02, 0.015], 0.012);
        let tip = [[far, -0.06], [far + 0.06, 0.0], [far, 0.06], [far - 0.06, 0.0]];
        b.flat(&crate::build::extrude(&tip, 0.0, 0.014));
    }
    b.home();
    if !style.awning {
        lamps(b, style, finishes);
    }
}

/// Adds lamps over the fascia, which shine on it.
fn lamps(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let half = 0.5 * style.width - 0.9;
    for x in [-half, half] {
        b.on(finishes.iron);
        b.block([x - 0.015, GROUND_M - 0.24, 0.05], [x + 0.015, GROUND_M - 0.21, 0.5]);
        b.block([x - 0.06, GROUND_M - 0.3, 0.42], [x + 0.06, GROUND_M - 0.22, 0.56]);
        b.on(finishes.lamp).tinted(LIT);
        b.block([x - 0.05, GROUND_M - 0.32, 0.43], [x + 0.05, GROUND_M - 0.29, 0.55]);
    }
}

fn awning(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let [from, to] = style.opening();
    let (top, low, out) = (OPENING_M + 0.06, 2.42, 1.25);
    let count = ((to - from) / 0.3).round().max(2.0);
    let step = (to - from) / count;
    let mut dice = Dice::new(style.seed, 5);
    let colors = [rgb(style.cloth_color), rgb(dice.pick([0xF2EBDC, 0xE9E0CC]))];
    let plain = dice.chance(0.3);
    b.on(finishes.cloth);
    let mut x = from;
    let mut is_odd = false;
    while x < to - 0.5 * step {
        let color = colors[usize::from(is_odd && !plain)];
        let (l, r) = (x, x + step);
        b.tinted(color);
        b.flat(&plate(&[[l, low, out], [r, low, out], [r, top, 0.11], [l, top, 0.11]]));
        // The scallop of the valance, seen from the front and from behind.
        let (m, foot) = (0.5 * (l + r), low - 0.22);
        let front =
            [[l, low, out], [l, foot, out], [m, foot - 0.06, out], [r, foot, out], [r, low, out]];
        b.flat(&plate(&front));
        b.flat(&plate(&front.map(|[x, y, z]| [x, y, z - 0.006])).turned());
        b.tinted(color.map(|c| 0.6 * c));
        b.flat(&plate(
            &[[r, low, out], [l, low, out], [l, top, 0.1], [r, top, 0.1]]
                .map(|[x, y, z]| [x, y - 0.012, z]),
        ));
        x = r;
        is_odd = !is_odd;
    }
    b.on(finishes.iron);
    for x in [from + 0.02, to - 0.02] {
        let arm = [[0.05, 2.15], [out, low - 0.01], [out, low - 0.05], [0.05, 2.11]];
        b.flat(&along_x(&arm, x - 0.015, x + 0.015));
    }
}

/// Adds a round sign that stands out from the wall.
fn blade(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let x = if style.door_left { 0.25 - 0.5 * style.width } else { 0.5 * style.width - 0.25 };
    let y = GROUND_M + 0.62;
    b.on(finishes.iron);
    b.block([x - 0.02, y + 0.42, 0.0], [x + 0.02, y + 0.46, 0.85]);
    b.block([x - 0.02, y + 0.1, 0.0], [x + 0.02, y + 0.6, 0.04]);
    let at = DVec3::new(x, y, 0.5);
    b.on(finishes.wood);
    b.at = DAffine3::from_translation(at);
    b.add(&spun(&[[0.36, -0.035], [0.36, 0.035]], 20), 30.0);
    b.on(finishes.gold);
    b.add(&spun(&[[0.39, -0.025], [0.39, 0.025]], 20), 30.0);
    for side in [-1.0, 1.0] {
        let turn = DAffine3::from_rotation_y(side * std::f64::consts::FRAC_PI_2);
        b.at = DAffine3::from_translation(at + DVec3::X * 0.036 * side) * turn;
        signs::add(b, style, finishes, 0.22);
    }
    b.home();
}
