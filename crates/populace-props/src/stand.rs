//! Stands for spectators, and grounds.

use glam::DVec3;
use populace_character::{Character, Error, Image};
use populace_model::convert::single;

use crate::build::{Builder, Solid, along_x, block, matt, plate, satin, tube};
use crate::furniture::{SEAT_M, SeatPoint};
use crate::images;

/// Depth in metres of a step of a stand.
pub const STEP_M: f32 = 0.8;
/// Height in metres of a step of a stand.
pub const STEP_RISE_M: f32 = 0.4;
/// Width in metres of a seat with its gap.
pub const SEAT_WIDTH_M: f32 = 0.52;

/// Width in metres of the aisle at each end of a section.
const AISLE_M: f64 = 0.6;
/// Most seats of a section.
const MOST_SEATS: u32 = 512;

/// A section of a stand: put sections side by side for a long one.
#[derive(Clone, Debug)]
pub struct Stand {
    /// The section, of one joint: its lowest step's front is at z = 0 and y = 0 to [`STEP_RISE_M`],
    /// its rows rise towards -Z, and its middle is at x = 0. Spectators face +Z.
    pub character: Character,
    /// Width in metres, with half an aisle at each end.
    pub width_m: f32,
    rows: u32,
    seats_per_row: u32,
}

/// Returns a section of a stand: steps, seats, an aisle at each end with half steps, and railings.
/// It has 1 to 512 rows, and as many seats per row as 512 seats in all leave.
///
/// The material `Top seats` is that of the seats; members may tint that region.
///
/// # Errors
///
/// Those of [`Character::new`]; no numbers cause one.
pub fn stand(rows: u32, seats_per_row: u32) -> Result<Stand, Error> {
    let rows = rows.clamp(1, MOST_SEATS);
    let seats_per_row = seats_per_row.clamp(1, MOST_SEATS / rows);
    let wide = f64::from(SEAT_WIDTH_M) * f64::from(seats_per_row) + 2.0 * AISLE_M;
    let mut b = Builder::new("stand");
    let concrete = b.finish(matt("Concrete", 0xA9_A69F));
    let shell = b.finish(satin("Top seats", 0x2F_5F9A));
    let iron = b.finish(satin("Railing", 0xC9_CCCE));
    let edge = b.finish(matt("Edge", 0xD9_B53E));
    b.on(concrete).flat(&steps(rows, wide));
    for row in 0..rows {
        let (y, z) = step(row);
        b.on(concrete).tinted([0.93; 3]);
        for side in [-1.0, 1.0] {
            // A half step up to the next row.
            let inner = side * (0.5 * wide - AISLE_M);
            let outer = side * 0.5 * wide;
            let (l, r) = (inner.min(outer), inner.max(outer));
            let high = y + 0.5 * f64::from(STEP_RISE_M);
            let back = z - f64::from(STEP_M);
            let mut half = block([l, y, back], [r, high, back + 0.38]);
            half.faces.remove(4);
            half.faces.remove(2);
            b.flat(&half);
            b.on(edge);
            let front = back + 0.381;
            b.flat(&plate(&[
                [l, high - 0.04, front],
                [r, high - 0.04, front],
                [r, high, front],
                [l, high, front],
            ]));
            b.on(concrete).tinted([0.93; 3]);
        }
    }
    b.on(shell);
    for row in 0..rows {
        for seat in seats_of(row, seats_per_row) {
            b.flat(&chair(seat));
        }
    }
    b.on(iron);
    for railing in railings(rows, wide) {
        b.add(&railing, 60.0);
    }
    let character = b.build(Vec::new())?;
    Ok(Stand { character, width_m: single(wide), rows, seats_per_row })
}

impl Stand {
    /// Returns all seats, row by row from the lowest and front one, each row from -X to +X.
    #[must_use]
    pub fn seats(&self) -> Vec<SeatPoint> {
        let seat = |at: DVec3| SeatPoint { position: at.to_array().map(single), yaw_rad: 0.0 };
        (0..self.rows).flat_map(|row| seats_of(row, self.seats_per_row)).map(seat).collect()
    }

    /// Depth in metres, from its front to its back wall.
    #[must_use]
    pub fn depth_m(&self) -> f32 {
        single(f64::from(STEP_M) * f64::from(self.rows))
    }

    /// Height in metres of its uppermost step.
    #[must_use]
    pub fn top_m(&self) -> f32 {
        single(f64::from(STEP_RISE_M) * f64::from(self.rows))
    }
}

/// Returns the height of a row's step, and its front in z.
fn step(row: u32) -> (f64, f64) {
    (f64::from(STEP_RISE_M) * f64::from(row + 1), -f64::from(STEP_M) * f64::from(row))
}

/// Returns the middles of the seats' surfaces of a row.
fn seats_of(row: u32, count: u32) -> impl Iterator<Item = DVec3> {
    let (y, z) = step(row);
    let pitch = f64::from(SEAT_WIDTH_M);
    (0..count).map(move |seat| {
        let x = pitch * (f64::from(seat) - 0.5 * f64::from(count - 1));
        DVec3::new(x, y + f64::from(SEAT_M), z - 0.5)
    })
}

/// Returns the steps with sides and back.
fn steps(rows: u32, wide: f64) -> Solid {
    let deep = f64::from(STEP_M);
    let mut outline = vec![[0.0, 0.0]];
    for row in 0..rows {
        let (y, z) = step(row);
        outline.extend([[z, y], [z - deep, y]]);
    }
    outline.push([-deep * f64::from(rows), 0.0]);
    along_x(&outline, -0.5 * wide, 0.5 * wide)
}

/// Returns a seat of six faces around the middle of its surface: a pan with a front, and a back.
fn chair(at: DVec3) -> Solid {
    let half = 0.22;
    let (front, low, back, high) = (0.2, -0.1, -0.17, 0.34);
    let p = |x: f64, y: f64, z: f64| at + DVec3::new(x * half, y, z);
    let mut solid = Solid::default();
    solid.face(&[
        p(-1.0, 0.0, front),
        p(1.0, 0.0, front),
        p(1.0, -0.01, back),
        p(-1.0, -0.01, back),
    ]);
    solid.face(&[
        p(-1.0, low, front - 0.03),
        p(1.0, low, front - 0.03),
        p(1.0, 0.0, front),
        p(-1.0, 0.0, front),
    ]);
    solid.face(&[
        p(-1.0, -0.01, back),
        p(1.0, -0.01, back),
        p(1.0, high, back - 0.06),
        p(-1.0, high, back - 0.06),
    ]);
    solid.face(&[
        p(1.0, low, back - 0.04),
        p(-1.0, low, back - 0.04),
        p(-1.0, high, back - 0.1),
        p(1.0, high, back - 0.1),
    ]);
    solid.face(&[
        p(-1.0, high, back - 0.06),
        p(1.0, high, back - 0.06),
        p(1.0, high, back - 0.1),
        p(-1.0, high, back - 0.1),
    ]);
    solid
}

/// Returns the railings in front of the lowest row, and behind the highest.
fn railings(rows: u32, wide: f64) -> Vec<Solid> {
    let half = 0.5 * wide - AISLE_M;
    let (top, _) = step(rows - 1);
    let rear = 0.06 - f64::from(STEP_M) * f64::from(rows);
    let (low, _) = step(0);
    let mut solids = Vec::new();
    for (half, y, z, high) in [(half, low, -0.05, 0.75), (0.5 * wide, top, rear, 1.1)] {
        let mut rod = |from: [f64; 2], to: [f64; 2], radius: f64| {
            let at = |[x, up]: [f64; 2]| (DVec3::new(x, y + up, z), radius);
            solids.push(tube(&[at(from), at(to)], 5));
        };
        for up in [high, 0.5 * high] {
            rod([-half, up], [half, up], 0.022);
        }
        let count = (half / 1.0).ceil().max(1.0);
        let mut x = -half;
        while x < half + 0.01 {
            rod([x, 0.0], [x, high], 0.018);
            x += 2.0 * half / count;
        }
    }
    solids
}

/// Kinds of ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GroundKind {
    /// Mown grass with stripes of two greens.
    Lawn,
    /// A field of rough grass.
    Meadow,
    /// Trodden earth.
    Earth,
}

/// Returns a level square of ground with its middle at the origin, its top at y = 0. `size_m` is kept
/// from 1 to 2,000 m; NaN counts as 1 m. The coordinates of its texture stay near 0, so that large
/// grounds are as sharp as small ones.
///
/// # Errors
///
/// Those of [`Character::new`]; no numbers cause one.
pub fn ground(kind: GroundKind, size_m: f32) -> Result<Character, Error> {
    let size = if size_m.is_nan() { 1.0 } else { f64::from(size_m).clamp(1.0, 2000.0) };
    let mut b = Builder::new("ground");
    let mut surface = |srgb: u32, image: Image| b.tiled(matt("Top ground", srgb), image, 3.2);
    let finish = match kind {
        GroundKind::Lawn => surface(0x6F_9A4A, images::grass()),
        GroundKind::Meadow => surface(0x8A_9A55, images::grass()),
        GroundKind::Earth => surface(0xA5_8A68, images::earth()),
    };
    // Bands in Z: stripes of a lawn, or faint differences of a field.
    let bands = (size / 5.5).clamp(2.0, 40.0).floor();
    let half = 0.5 * size;
    b.on(finish);
    let mut solid = |from: f64, to: f64, tone: f64| {
        let corners = [[-half, 0.0, to], [half, 0.0, to], [half, 0.0, from], [-half, 0.0, from]];
        b.tinted([tone; 3]).flat(&plate(&corners));
    };
    let mut band = 0.0;
    let mut is_light = false;
    while band < bands {
        let (from, to) = (size * band / bands - half, size * (band + 1.0) / bands - half);
        let tone = match (kind, is_light) {
            (GroundKind::Lawn, true) => 1.14,
            (GroundKind::Lawn, false) => 0.92,
            _ => 1.0,
        };
        solid(from, to, tone);
        is_light = !is_light;
        band += 1.0;
    }
    b.build(Vec::new())
}
