//! The look of a house, drawn by its seed.

use populace_character::Material;

use crate::build::{Builder, Finish, glass, linear, matt, metal, pane, satin};
use crate::dice::Dice;
use crate::images;

/// The goods of a shop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trade {
    Cafe,
    Clothes,
    Books,
    Flowers,
    Fruit,
    Gifts,
    Bread,
}

/// The stuff of walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wall {
    Plaster,
    Brick,
    Stone,
}

/// The form of a roof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Roof {
    Pitched,
    Mansard,
    Parapet,
}

/// Height in metres of the ground floor.
pub(super) const GROUND_M: f64 = 3.85;
/// Depth in metres up to which the sides of a shop's opening are the piers' own.
pub(super) const ROOM_SIDE_M: f64 = 0.12;
/// Width in metres of the piers beside a shop.
pub(super) const PIER_M: f64 = 0.4;
/// Width in metres of the part of a shopfront that has the door.
pub(super) const DOOR_M: f64 = 1.25;

/// Width in metres of the window's frame, and half that of the bars between its panes.
const EDGE_M: f64 = 0.09;
const BAR_M: f64 = 0.03;

/// The choices that make a house. Lengths are in metres, colours sRGB.
#[derive(Clone, Debug)]
pub(super) struct Style {
    pub(super) seed: u64,
    pub(super) width: f64,
    /// Storeys over the shop.
    pub(super) storeys: u32,
    pub(super) storey_m: f64,
    /// Windows of a storey.
    pub(super) bays: u32,
    pub(super) window_m: [f64; 2],
    pub(super) wall: Wall,
    pub(super) wall_color: u32,
    pub(super) trim_color: u32,
    pub(super) wood_color: u32,
    pub(super) frame_color: u32,
    pub(super) cloth_color: u32,
    pub(super) roof: Roof,
    pub(super) roof_color: u32,
    pub(super) shutters: bool,
    pub(super) balcony: bool,
    pub(super) boxes: bool,
    pub(super) awning: bool,
    pub(super) blade: bool,
    pub(super) trade: Trade,
    /// True if the door is on the side of +X, which is left for who leaves the house.
    pub(super) door_left: bool,
}

/// Colours that go together: wall, joinery, cloth of the awning.
const PLASTER: [[u32; 3]; 10] = [
    [0xE8D5AE, 0x3A6650, 0x3E7A58],
    [0xE6C79C, 0x8A3430, 0xA23B36],
    [0xD5DAD0, 0x2F5578, 0x35608C],
    [0xEBC4AC, 0x4A5058, 0xC46A4A],
    [0xBFCDBC, 0x6B4A30, 0xB98A3E],
    [0xEEE0C4, 0x1F6B6C, 0x2F8788],
    [0xDDB48C, 0x37503F, 0xD9A441],
    [0xC2D0DA, 0x8E3A46, 0xB0485A],
    [0xF0E2D2, 0x7F9C78, 0x6F8F5A],
    [0xE4B9A2, 0x35506A, 0x4A7A9A],
];
const BRICK: [[u32; 3]; 4] = [
    [0xA06A54, 0x2C4A56, 0x3F6F77],
    [0xAF8064, 0x3A5A44, 0xC9A34E],
    [0x8E5C50, 0x2A3C66, 0xB8474A],
    [0xBC9C7E, 0x6B4232, 0x7C8F52],
];
const STONE: [[u32; 3]; 3] = [
    [0xD8CDB8, 0x2A2E33, 0x8C2F39],
    [0xCFC8BC, 0x20443F, 0x2F6B5E],
    [0xDDD2C0, 0x4B2E2A, 0x375A86],
];

impl Style {
    pub(super) fn new(seed: u64, width: f64) -> Self {
        let mut dice = Dice::new(seed, 1);
        let wall = dice.pick([
            Wall::Plaster,
            Wall::Plaster,
            Wall::Plaster,
            Wall::Brick,
            Wall::Brick,
            Wall::Stone,
        ]);
        let [wall_color, wood_color, cloth_color] = match wall {
            Wall::Plaster => dice.pick(PLASTER),
            Wall::Brick => dice.pick(BRICK),
            Wall::Stone => dice.pick(STONE),
        };
        let storeys = dice.pick([2, 2, 3]);
        let spacing = dice.within(1.9, 2.4);
        let balcony = dice.chance(0.3);
        let roof = dice.pick([Roof::Pitched, Roof::Pitched, Roof::Mansard, Roof::Parapet]);
        Self {
            seed,
            width,
            storeys,
            storey_m: dice.within(2.95, 3.25),
            bays: whole(((width - 0.7) / spacing).floor()).clamp(2, 5),
            window_m: [dice.within(0.95, 1.15), dice.within(1.6, 1.8)],
            wall,
            wall_color,
            trim_color: dice.pick([0xF1EBDD, 0xE4DACA, 0xDCD8CF]),
            wood_color,
            frame_color: dice.pick([0xF3EFE6, 0xE9E2D2, 0x4A4F52, 0xF3EFE6]),
            cloth_color,
            roof,
            roof_color: match roof {
                Roof::Pitched => dice.pick([0xA8583F, 0x8E4A3A, 0x6E625C]),
                Roof::Mansard => dice.pick([0x5B6470, 0x4E565E]),
                Roof::Parapet => 0x8C8A86,
            },
            shutters: wall == Wall::Plaster && dice.chance(0.45),
            balcony,
            boxes: !balcony && dice.chance(0.5),
            awning: dice.chance(0.7),
            blade: dice.chance(0.45),
            trade: dice.pick([
                Trade::Cafe,
                Trade::Clothes,
                Trade::Books,
                Trade::Flowers,
                Trade::Fruit,
                Trade::Gifts,
                Trade::Bread,
            ]),
            door_left: dice.chance(0.5),
        }
    }

    /// Height in metres of the walls.
    pub(super) fn wall_top(&self) -> f64 {
        GROUND_M + f64::from(self.storeys) * self.storey_m + 0.25
    }

    /// The ends in x of the opening that the shop fills.
    pub(super) fn opening(&self) -> [f64; 2] {
        [PIER_M - 0.5 * self.width, 0.5 * self.width - PIER_M]
    }

    /// The ends in x of the shop's window, beside the door.
    pub(super) fn shop_window(&self) -> [f64; 2] {
        let [from, to] = self.opening();
        if self.door_left { [from, to - DOOR_M] } else { [from + DOOR_M, to] }
    }

    /// The ends in x of the panes of the shop's window, between the bars of its frame.
    pub(super) fn shop_panes(&self) -> Vec<[f64; 2]> {
        let [from, to] = self.shop_window();
        let count = ((to - from) / 1.7).ceil().max(1.0);
        let step = (to - from) / count;
        let mut panes = Vec::new();
        let mut pane = 0.0;
        while pane < count {
            let edge = |at: f64| if at < 0.5 || at > count - 0.5 { EDGE_M } else { BAR_M };
            let (l, r) = (from + step * pane, from + step * (pane + 1.0));
            panes.push([l + edge(pane), r - edge(pane + 1.0)]);
            pane += 1.0;
        }
        panes
    }

    /// The middle of the door in x.
    pub(super) fn door_middle(&self) -> f64 {
        let [from, to] = self.opening();
        if self.door_left { to - 0.5 * DOOR_M } else { from + 0.5 * DOOR_M }
    }

    /// Distance in metres between the middles of neighbouring windows.
    pub(super) fn window_step(&self) -> f64 {
        (self.width - 0.5) / f64::from(self.bays)
    }

    /// Middles in x of the windows of a storey.
    pub(super) fn window_middles(&self) -> Vec<f64> {
        let step = self.window_step();
        let first = -0.5 * (self.width - 0.5) + 0.5 * step;
        (0..self.bays).map(|bay| first + step * f64::from(bay)).collect()
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few windows")]
fn whole(value: f64) -> u32 {
    value as u32
}

/// The materials of a house.
pub(super) struct Finishes {
    pub(super) wall: Finish,
    pub(super) side: Finish,
    pub(super) trim: Finish,
    pub(super) wood: Finish,
    pub(super) frame: Finish,
    pub(super) pane: Finish,
    pub(super) curtain: Finish,
    pub(super) glass: Finish,
    pub(super) cloth: Finish,
    pub(super) gold: Finish,
    pub(super) iron: Finish,
    pub(super) roof: Finish,
    pub(super) room: Finish,
    pub(super) goods: Finish,
    pub(super) lamp: Finish,
    pub(super) leaves: Finish,
}

impl Finishes {
    pub(super) fn new(b: &mut Builder, style: &Style) -> Self {
        let wall = matt("Top wall", style.wall_color);
        let side = matt("Top side wall", style.wall_color);
        let white = |name: &str| matt(name, 0xFF_FFFF);
        Self {
            // Materials are drawn in this order: what hides others comes first, and saves the work
            // of shading them.
            cloth: b.finish(matt("Accessory awning", 0xFF_FFFF)),
            wood: b.finish(satin("Trousers joinery", style.wood_color)),
            gold: b.finish(metal("Gilding", 0xD9_B45A, 0.4)),
            iron: b.finish(satin("Iron", 0x22_2426)),
            frame: b.finish(satin("Window frame", style.frame_color)),
            trim: b.finish(matt("Stone trim", style.trim_color)),
            curtain: b.finish(pane("Curtain", 0xFF_FFFF)),
            pane: b.finish(pane("Pane", 0x6B_8296)),
            leaves: b.finish(white("Leaves")),
            goods: b.finish(white("Goods")),
            side: b.finish(side),
            lamp: b.finish(white("Lamp")),
            room: b.finish(white("Room")),
            wall: match style.wall {
                Wall::Plaster => b.finish(wall),
                Wall::Brick => b.tiled(lighter(wall), images::bricks(), 1.2),
                Wall::Stone => b.tiled(lighter(wall), images::ashlar(), 1.6),
            },
            roof: if style.roof == Roof::Parapet {
                b.finish(matt("Roof", style.roof_color))
            } else {
                b.tiled(lighter(matt("Roof", style.roof_color)), images::tiles(), 2.0)
            },
            // Last, so that it is drawn over what is behind it.
            glass: b.finish(glass("Shop glass", 0x9A_B0BC, 0.1)),
        }
    }
}

/// Factors of the colours of lamps, in place of light that would need a draw of its own.
pub(super) const LIT: [f64; 3] = [2.2, 2.0, 1.6];

/// Returns a material for a texture whose mean is darker than white.
pub(super) fn lighter(mut material: Material) -> Material {
    for channel in &mut material.base_color[..3] {
        *channel = (*channel * 1.4).min(1.0);
    }
    material
}

/// Returns an sRGB colour as linear factors.
pub(super) fn rgb(srgb: u32) -> [f64; 3] {
    linear(srgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_give_all_trades_walls_and_roofs() {
        let styles: Vec<Style> = (0..84).map(|seed| Style::new(seed, 7.0)).collect();
        let count = |is: &dyn Fn(&Style) -> bool| styles.iter().filter(|s| is(s)).count();
        let trades = [
            Trade::Cafe,
            Trade::Clothes,
            Trade::Books,
            Trade::Flowers,
            Trade::Fruit,
            Trade::Gifts,
            Trade::Bread,
        ];
        for trade in trades {
            let found = count(&|style| style.trade == trade);
            assert!((5..=22).contains(&found), "{found} of {trade:?}");
        }
        for wall in [Wall::Plaster, Wall::Brick, Wall::Stone] {
            assert!(count(&|style| style.wall == wall) >= 7, "{wall:?}");
        }
        for roof in [Roof::Pitched, Roof::Mansard, Roof::Parapet] {
            assert!(count(&|style| style.roof == roof) >= 10, "{roof:?}");
        }
    }
}
