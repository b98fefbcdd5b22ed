//! The room behind the shop's glass, and what is on display in it.

use std::f64::consts::TAU;

use super::facade::{OPENING_M, dome, nugget};
use super::front::{GLASS_Z, ROOM_M, SILL_M};
use super::style::{DOOR_M, Finishes, LIT, ROOM_SIDE_M, Style, Trade, rgb};
use crate::build::{Builder, lathe, plate, tube};
use crate::dice::Dice;
use glam::DVec3;

/// Depth of the display behind the glass, in metres.
const DISPLAY_M: f64 = 0.65;
/// Middle of the display in z.
const SHOWN_Z: f64 = GLASS_Z - 0.36;

/// Most things of a kind in a window.
const MOST_GOODS: f64 = 5.0;

/// A shop's room under construction.
struct Display<'a> {
    b: &'a mut Builder,
    finishes: &'a Finishes,
    dice: Dice,
    /// Ends of the window in x.
    ends: [f64; 2],
}

pub(super) fn build(b: &mut Builder, style: &Style, finishes: &Finishes) {
    room(b, style, finishes);
    let dice = Dice::new(style.seed, 6);
    let mut display = Display { b, finishes, dice, ends: style.shop_window() };
    display.shelves(style);
    match style.trade {
        Trade::Cafe => display.cafe(),
        Trade::Clothes => display.clothes(),
        Trade::Books => display.books(),
        Trade::Flowers => display.flowers(),
        Trade::Fruit => display.fruit(),
        Trade::Gifts => display.gifts(),
        Trade::Bread => display.bread(),
    }
}

/// Adds floor, walls and ceiling of the room, seen from the street, and its lamps.
fn room(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let ([l, r], back, top) = (style.opening(), -ROOM_M, OPENING_M - 0.02);
    let near = -ROOM_SIDE_M;
    let mut dice = Dice::new(style.seed, 7);
    let walls = rgb(dice.pick([0xE8CE9A, 0xBFD0B4, 0xE0B698, 0xE6DCC4, 0xD9B88A]));
    // Lamps light the room.
    let dim = |factor: f64| [0, 1, 2].map(|i| walls[i] * factor * [1.3, 1.25, 1.15][i]);
    b.on(finishes.room).tinted(dim(0.78)).faded([0.0, top], [0.7, 1.0]);
    b.flat(&plate(&[[l, 0.0, back], [r, 0.0, back], [r, top, back], [l, top, back]]));
    b.tinted(dim(0.6));
    b.flat(&plate(&[[l, 0.0, near], [l, 0.0, back], [l, top, back], [l, top, near]]));
    b.flat(&plate(&[[r, 0.0, back], [r, 0.0, near], [r, top, near], [r, top, back]]));
    b.tinted(rgb(0x7A_5A3C).map(|c| 0.8 * c));
    b.flat(&plate(&[[l, 0.02, near], [r, 0.02, near], [r, 0.02, back], [l, 0.02, back]]));
    b.tinted(dim(0.8));
    b.flat(&plate(&[[l, top, back], [r, top, back], [r, top, near], [l, top, near]]));
    let [from, to] = style.shop_window();
    b.on(finishes.room).tinted(rgb(0xB8_9468));
    b.block([from, 0.0, GLASS_Z - DISPLAY_M], [to, SILL_M + 0.01, GLASS_Z - 0.05]);
    b.on(finishes.lamp).tinted(LIT);
    let mut x = l + 0.6;
    while x < r - 0.3 {
        for z in [SHOWN_Z, back + 0.7] {
            b.block([x - 0.09, top - 0.06, z - 0.09], [x + 0.09, top - 0.01, z + 0.09]);
        }
        x += 2.0;
    }
}

impl Display<'_> {
    /// Chooses a colour for what follows.
    fn color(&mut self, srgb: u32) -> &mut Builder {
        self.b.on(self.finishes.goods).tinted(rgb(srgb))
    }

    /// Returns places along the display, about `step` metres apart.
    fn places(&self, step: f64) -> Vec<f64> {
        let [from, to] = [self.ends[0] + 0.15, self.ends[1] - 0.15];
        let count = ((to - from) / step).floor().clamp(1.0, MOST_GOODS);
        let width = (to - from) / count;
        let mut places = Vec::new();
        let mut x = from + 0.5 * width;
        while x < to {
            places.push(x);
            x += width;
        }
        places
    }

    fn lathe(&mut self, at: DVec3, profile: &[[f64; 2]], sides: usize, srgb: u32) {
        let mut solid = lathe(profile, sides);
        for point in &mut solid.points {
            *point += at;
        }
        self.color(srgb).add(&solid, 50.0);
    }

    fn block(&mut self, low: [f64; 3], high: [f64; 3], srgb: u32) {
        self.color(srgb).block(low, high);
    }

    /// Adds shelves on the back wall, filled with what the trade sells.
    fn shelves(&mut self, style: &Style) {
        let [from, to] = style.opening();
        let (l, r) =
            if style.door_left { (from + 0.2, to - DOOR_M) } else { (from + DOOR_M, to - 0.2) };
        let back = 0.04 - ROOM_M;
        let colors: &[u32] = match style.trade {
            Trade::Cafe => &[0xB5_6B3F, 0xE5D6BC, 0x6E_3B2A, 0xC9_A25E],
            Trade::Clothes => &[0x3F_5C7A, 0xB5_4A52, 0xD9C7A8, 0x52_6B55],
            Trade::Books => &[0x8C_2F39, 0x2F_5D62, 0xC98A3E, 0x3A_4F7A, 0xE0D2B4],
            Trade::Flowers => &[0x5E_8A42, 0xC9_5A6A, 0x4F_7A3A, 0xE3B341],
            Trade::Fruit => &[0xC9_4A3A, 0xE0A23C, 0x7A_9A3E, 0x8C_5A2E],
            Trade::Gifts => &[0xB8_4A5A, 0x4A_7A9A, 0xE0B050, 0x5A_8A6A],
            Trade::Bread => &[0xC98A46, 0xA5_6B36, 0xE0B878, 0xB5_7A3E],
        };
        for level in 0..3 {
            let y = 0.95 + 0.55 * f64::from(level);
            self.block([l, y - 0.04, back], [r, y, back + 0.34], 0x7A_5638);
            let mut x = l + 0.1;
            while x < r - 0.5 {
                let (wide, high) = (self.dice.within(0.25, 0.7), self.dice.within(0.14, 0.38));
                let nth = self.dice.below(colors.len());
                self.color(colors[nth]);
                // Only front, top and sides can be seen.
                let (f, n) = (x + wide, back + 0.28);
                let mut solid = crate::build::block([x, y, back], [f, y + high, n]);
                solid.faces.remove(4);
                solid.faces.remove(2);
                self.b.flat(&solid);
                x = f + self.dice.within(0.03, 0.3);
            }
        }
    }

    /// Adds people of wood in clothes.
    fn clothes(&mut self) {
        for x in self.places(1.0) {
            let at = DVec3::new(x, SILL_M, SHOWN_Z + self.dice.within(-0.12, 0.08));
            let cloth =
                self.dice.pick([0xB84A4A, 0x2F5D7A, 0xE0B85A, 0x4A6B52, 0xD9D2C4, 0x7A4A6B]);
            let other = self.dice.pick([0x2E3440, 0x8C6B4A, 0xE5DCCB, 0x3A4A5E]);
            let skin = 0xE4D5C2;
            self.lathe(at, &[[0.2, 0.0], [0.18, 0.025]], 8, 0xC9C4BA);
            let is_dress = self.dice.chance(0.5);
            if is_dress {
                self.lathe(at, &[[0.03, 0.02], [0.05, 0.4]], 6, skin);
                let dress = [
                    [0.27, 0.38],
                    [0.2, 0.7],
                    [0.125, 0.98],
                    [0.165, 1.22],
                    [0.15, 1.33],
                    [0.05, 1.4],
                ];
                self.lathe(at, &dress, 7, cloth);
            } else {
                for side in [-0.08, 0.08] {
                    let leg = [[0.055, 0.02], [0.075, 0.45], [0.09, 0.85]];
                    self.lathe(at + DVec3::X * side, &leg, 5, other);
                }
                let coat = [[0.17, 0.72], [0.15, 0.95], [0.185, 1.22], [0.17, 1.33], [0.06, 1.41]];
                self.lathe(at, &coat, 7, cloth);
            }
            self.lathe(
                at,
                &[[0.04, 1.36], [0.045, 1.46], [0.085, 1.53], [0.095, 1.62], [0.05, 1.71]],
                6,
                skin,
            );
            for side in [-1.0, 1.0] {
                let bend = self.dice.within(0.0, 0.12);
                let arm = [
                    (at + DVec3::new(0.15 * side, 1.31, 0.0), 0.05),
                    (at + DVec3::new(0.25 * side, 1.06, 0.03), 0.04),
                    (at + DVec3::new((0.24 - bend) * side, 0.82, 0.08 + bend), 0.03),
                ];
                self.color(if is_dress { skin } else { cloth }).add(&tube(&arm, 4), 60.0);
            }
        }
        for x in self.places(1.4) {
            let (at, tone) = (x + 0.4, self.dice.pick([0x8C4A3A, 0x3A3A44, 0xC9A46A]));
            self.block(
                [at - 0.15, SILL_M, GLASS_Z - 0.3],
                [at + 0.13, SILL_M + 0.19, GLASS_Z - 0.19],
                tone,
            );
        }
    }

    /// Adds plates of cakes, jars and a plant.
    fn cafe(&mut self) {
        for (nth, x) in self.places(0.6).into_iter().enumerate() {
            let at = DVec3::new(x, SILL_M, SHOWN_Z + 0.12 * if nth % 2 == 0 { 1.0 } else { -1.0 });
            if nth % 3 == 2 {
                self.plant(at, 0.75);
                continue;
            }
            let tall = if nth % 2 == 0 { 0.12 } else { 0.3 };
            self.lathe(
                at,
                &[
                    [0.1, 0.0],
                    [0.03, 0.03],
                    [0.03, tall],
                    [0.17, tall + 0.02],
                    [0.18, tall + 0.035],
                ],
                8,
                0xF2EEE6,
            );
            let cake = self.dice.pick([0x8C5230, 0xE8C88A, 0xD98A8A, 0x6B3A2A]);
            let y = tall + 0.035;
            self.lathe(at, &[[0.13, y], [0.135, y + 0.09], [0.12, y + 0.11]], 9, cake);
            self.lathe(at, &[[0.137, y + 0.075], [0.125, y + 0.118]], 9, 0xF6EBDD);
            for berry in 0..4 {
                let (sin, cos) = (TAU * f64::from(berry) / 4.0).sin_cos();
                let place = at + DVec3::new(0.085 * cos, y + 0.13, 0.085 * sin);
                self.color(0xB8323A).add(&nugget(place, DVec3::splat(0.022)), 50.0);
            }
        }
    }

    fn plant(&mut self, at: DVec3, height: f64) {
        self.lathe(at, &[[0.09, 0.0], [0.13, 0.2], [0.14, 0.24]], 8, 0xB8694A);
        for nth in 0..9 {
            let (sin, cos) = (2.4 * f64::from(nth)).sin_cos();
            let tall = height * self.dice.within(0.55, 1.0);
            let out = self.dice.within(0.12, 0.26);
            let (foot, tip) = (at + DVec3::Y * 0.22, at + DVec3::new(out * cos, tall, out * sin));
            let middle = 0.5 * (foot + tip) + DVec3::new(0.3 * out * cos, 0.06, 0.3 * out * sin);
            let leaf = [(foot, 0.012), (middle, 0.05), (tip, 0.004)];
            let green = self.dice.pick([0x4F7A3A, 0x3F6B3A, 0x6B9450]);
            self.color(green).add(&tube(&leaf, 3), 20.0);
        }
    }

    fn books(&mut self) {
        let colors = [0x8C2F39, 0x2F5D62, 0xC98A3E, 0x3A4F7A, 0xE0D2B4, 0x5A6B3A, 0x7A3A5A];
        for (nth, x) in self.places(0.42).into_iter().enumerate() {
            if nth % 2 == 0 {
                // A pile.
                let count = 3 + self.dice.below(4);
                let mut y = SILL_M;
                for _ in 0..count {
                    let (thick, turn) =
                        (self.dice.within(0.025, 0.05), self.dice.within(-0.04, 0.04));
                    let z = SHOWN_Z + turn;
                    let color = self.dice.pick(colors);
                    self.block(
                        [x - 0.11 + turn, y, z - 0.15],
                        [x + 0.11 + turn, y + thick, z + 0.15],
                        color,
                    );
                    y += thick;
                }
                continue;
            }
            // A book on a stand, with a picture on its cover.
            let color = self.dice.pick(colors);
            let (y, z) = (SILL_M + 0.02, SHOWN_Z);
            let lean = 0.09;
            let cover = |grow: f64, out: f64| {
                let (w, h) = (0.13 * grow, 0.19 * grow);
                let at =
                    |x0: f64, up: f64| [x + x0, y + 0.19 + up, z + out - lean * (0.19 + up) / 0.38];
                [at(-w, -h), at(w, -h), at(w, h), at(-w, h)]
            };
            self.block([x - 0.1, SILL_M, z - 0.16], [x + 0.1, SILL_M + 0.02, z + 0.06], 0x6B4A30);
            self.color(color).flat(&plate(&cover(1.0, 0.0)));
            self.b.flat(&plate(&cover(1.0, -0.03)).turned());
            let picture = self.dice.pick(colors);
            self.color(picture).flat(&plate(&cover(0.6, 0.006)));
        }
    }

    fn flowers(&mut self) {
        let blooms = [0xC9403F, 0xE08AA0, 0xE5B84B, 0xF0ECE0, 0x8B5FA8, 0xE0703A];
        for (nth, x) in self.places(0.55).into_iter().enumerate() {
            let z = SHOWN_Z + 0.14 * if nth % 2 == 0 { 1.0 } else { -1.0 };
            let lift = if nth % 2 == 0 { 0.0 } else { 0.22 };
            let at = DVec3::new(x, SILL_M, z);
            if lift > 0.0 {
                self.block(
                    [x - 0.17, SILL_M, z - 0.16],
                    [x + 0.17, SILL_M + lift, z + 0.16],
                    0x8C6B48,
                );
            }
            let at = at + DVec3::Y * lift;
            let pot = self.dice.pick([0x8FA0A8, 0xB8694A, 0x5A6B70]);
            self.lathe(at, &[[0.1, 0.0], [0.14, 0.28]], 9, pot);
            let bloom = self.dice.pick(blooms);
            for stem in 0..7 {
                let (sin, cos) = (2.4 * f64::from(stem)).sin_cos();
                let out = 0.17 * (0.3 + f64::from(stem) / 7.0);
                let top = at
                    + DVec3::new(
                        out * cos,
                        0.5 - 0.9 * out + self.dice.within(0.0, 0.1),
                        out * sin,
                    );
                self.color(0x4F7A3A);
                let green = top - DVec3::Y * 0.13;
                self.b.flat(&nugget(green, DVec3::new(0.08, 0.1, 0.08)));
                self.color(bloom);
                self.b.add(&nugget(top, DVec3::new(0.07, 0.05, 0.07)), 30.0);
            }
        }
    }

    fn fruit(&mut self) {
        for x in self.places(0.6) {
            let color =
                self.dice.pick([0xC9402F, 0xE58A2C, 0x8CB03E, 0xE5C84B, 0x7A3A5A, 0xC9A03C]);
            let (l, r, back, front) = (x - 0.26, x + 0.26, SHOWN_Z - 0.24, SHOWN_Z + 0.24);
            for [low, high] in [
                [[l, SILL_M, back], [l + 0.02, SILL_M + 0.28, front]],
                [[r - 0.02, SILL_M, back], [r, SILL_M + 0.28, front]],
                [[l, SILL_M, front - 0.02], [r, SILL_M + 0.16, front]],
            ] {
                self.block(low, high, 0xB98F5C);
            }
            for row in 0..2 {
                for column in 0..3 {
                    let (u, v) = (f64::from(column), f64::from(row));
                    let at = DVec3::new(
                        l + 0.11 + 0.15 * u + self.dice.within(-0.01, 0.01),
                        SILL_M + 0.25 - 0.07 * v,
                        back + 0.13 + 0.2 * v,
                    );
                    let shade = self.dice.within(0.85, 1.1);
                    self.color(color).tinted(rgb(color).map(|c| c * shade));
                    self.b.add(&dome(at, DVec3::new(0.085, 0.08, 0.1)), 80.0);
                }
            }
        }
    }

    fn gifts(&mut self) {
        let colors = [0xB84A5A, 0x4A7A9A, 0xE0B050, 0x5A8A6A, 0xE8DCC8, 0x8A5A8A];
        for x in self.places(0.5) {
            let (mut y, z) = (SILL_M, SHOWN_Z + self.dice.within(-0.08, 0.1));
            let mut half = self.dice.within(0.14, 0.21);
            for _ in 0..1 + self.dice.below(3) {
                let high = self.dice.within(0.14, 0.26);
                let (color, ribbon) =
                    (self.dice.pick(colors), self.dice.pick([0xF2E6C8, 0xC9403F, 0xD9B45A]));
                let low = [x - half, y, z - half];
                self.color(color).block(low, [x + half, y + high, z + half]);
                let (a, t) = (half + 0.004, 0.02);
                self.block([x - t, y, z - a], [x + t, y + high + 0.004, z + a], ribbon);
                self.block([x - a, y, z - t], [x + a, y + high + 0.004, z + t], ribbon);
                y += high;
                half *= 0.75;
            }
            for side in [-1.0, 1.0] {
                self.color(0xD9B45A);
                let at = DVec3::new(x + 0.045 * side, y + 0.03, z);
                self.b.flat(&nugget(at, DVec3::new(0.05, 0.03, 0.03)));
            }
        }
    }

    fn bread(&mut self) {
        for (nth, x) in self.places(0.55).into_iter().enumerate() {
            let z = SHOWN_Z;
            let (l, r) = (x - 0.25, x + 0.25);
            // A sloping tray.
            self.block([l, SILL_M, z - 0.26], [r, SILL_M + 0.06, z + 0.26], 0x9C7446);
            self.block([l, SILL_M, z - 0.26], [r, SILL_M + 0.3, z - 0.22], 0x9C7446);
            for row in 0..3 {
                for column in 0..3 {
                    let is_long = nth % 2 == 0;
                    if is_long && column > 0 {
                        continue;
                    }
                    let at = DVec3::new(
                        if is_long { x } else { l + 0.09 + 0.16 * f64::from(column) },
                        SILL_M + 0.2 - 0.05 * f64::from(row),
                        z - 0.13 + 0.15 * f64::from(row),
                    );
                    let radii = if is_long {
                        DVec3::new(0.23, 0.055, 0.06)
                    } else {
                        DVec3::new(0.075, 0.06, 0.068)
                    };
                    let crust = self.dice.pick([0xC07E3C, 0xB06F32, 0xCF944F]);
                    self.color(crust).faded([at.y - 0.05, at.y + 0.05], [0.75, 1.15]);
                    self.b.add(&dome(at, radii), 80.0);
                    if is_long {
                        for cut in [-0.11, 0.0, 0.11] {
                            let place = at + DVec3::new(cut, 0.045, 0.0);
                            self.color(0xE8C893)
                                .add(&dome(place, DVec3::new(0.03, 0.016, 0.035)), 60.0);
                        }
                    }
                }
            }
        }
    }
}
