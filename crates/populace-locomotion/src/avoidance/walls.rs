//! Walls: the line segments of obstacles, found through a grid.

use glam::Vec2;

use super::geometry::{cell, index, nearest_to_origin};
use super::{Error, LARGEST_M, Obstacle, WITHIN_LARGEST};

/// Edge of a cell in metres, where the area of all walls allows it.
const CELL_M: f32 = 2.0;
/// The most cells of the grid, at least and for each wall; in larger areas their edges are longer.
const MOST_CELLS: (usize, usize) = (16_384, 64);
/// No wall.
pub(crate) const NONE: u32 = u32::MAX;

/// One line segment of an obstacle. It stops walkers on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wall {
    pub(crate) from: Vec2,
    pub(crate) to: Vec2,
    /// The wall that ends where this one starts, or [`NONE`].
    pub(crate) before: u32,
    /// The wall that starts where this one ends, or [`NONE`].
    pub(crate) after: u32,
}

/// All walls, and the walls of each cell of a grid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    all: Vec<Wall>,
    origin: Vec2,
    cells_per_m: f32,
    columns: usize,
    rows: usize,
    /// First wall of each cell in `listed`, and the number of walls after the last.
    starts: Vec<u32>,
    listed: Vec<u32>,
}

impl Walls {
    /// Checks all obstacles and sorts their walls into cells.
    pub(crate) fn new(obstacles: &[Obstacle]) -> Result<Self, Error> {
        let mut all = Vec::new();
        for (nth, obstacle) in obstacles.iter().enumerate() {
            check(nth, obstacle)?;
            append(&mut all, obstacle);
        }
        let mut walls = Self { all, ..Self::default() };
        if !walls.all.is_empty() {
            walls.sort();
        }
        Ok(walls)
    }

    pub(crate) fn all(&self) -> &[Wall] {
        &self.all
    }

    fn sort(&mut self) {
        let points = || self.all.iter().flat_map(|wall| [wall.from, wall.to]);
        let low = points().fold(Vec2::INFINITY, Vec2::min);
        let size = points().fold(Vec2::NEG_INFINITY, Vec2::max) - low;
        let most = MOST_CELLS.0.max(MOST_CELLS.1 * self.all.len()) as f32;
        let mut edge = CELL_M;
        while (size.x / edge + 1.0) * (size.y / edge + 1.0) > most {
            edge *= 2.0;
        }
        (self.origin, self.cells_per_m) = (low, 1.0 / edge);
        let count = |length: f32| cell(length, 1.0 / edge).unsigned_abs() as usize + 1;
        (self.columns, self.rows) = (count(size.x), count(size.y));
        let mut pairs = Vec::new();
        for (nth, wall) in self.all.iter().enumerate() {
            self.cells(wall.from.min(wall.to), wall.from.max(wall.to), |cell| {
                if self.touches(cell, wall) {
                    pairs.push((cell, index(nth)));
                }
            });
        }
        pairs.sort_unstable();
        let cells = 0..=self.columns * self.rows;
        self.starts =
            cells.map(|cell| index(pairs.partition_point(|(of, _)| *of < cell))).collect();
        self.listed = pairs.into_iter().map(|(_, wall)| wall).collect();
    }

    /// Calls `visit` for all cells that a rectangle touches.
    fn cells(&self, low: Vec2, high: Vec2, mut visit: impl FnMut(usize)) {
        let within = |coordinate: f32, count: usize| {
            let cell = cell(coordinate, self.cells_per_m);
            usize::try_from(cell.max(0)).unwrap_or(0).min(count - 1)
        };
        if self.columns == 0 {
            return;
        }
        let (low, high) = (low - self.origin, high - self.origin);
        for row in within(low.y, self.rows)..=within(high.y, self.rows) {
            for column in within(low.x, self.columns)..=within(high.x, self.columns) {
                visit(row * self.columns + column);
            }
        }
    }

    /// Returns whether a wall comes near a cell: nearer to its middle than its corners are, and a
    /// tenth.
    fn touches(&self, cell: usize, wall: &Wall) -> bool {
        let edge = 1.0 / self.cells_per_m;
        let at = Vec2::new((cell % self.columns) as f32, (cell / self.columns) as f32);
        let middle = self.origin + (at + 0.5) * edge;
        let nearest = nearest_to_origin(wall.from - middle, wall.to - middle);
        nearest.length() <= 0.8 * edge
    }

    /// Calls `visit` with all walls in the cells of a rectangle, and some farther ones. A wall may
    /// come up more than once.
    pub(crate) fn within(&self, low: Vec2, high: Vec2, mut visit: impl FnMut(u32, &Wall)) {
        let size = Vec2::new(self.columns as f32, self.rows as f32) / self.cells_per_m;
        let apart = low.cmpgt(self.origin + size).any() || high.cmplt(self.origin).any();
        if self.all.is_empty() || apart {
            return;
        }
        self.cells(low, high, |cell| {
            let [from, until] = [cell, cell + 1].map(|cell| self.starts[cell] as usize);
            for wall in &self.listed[from..until] {
                visit(*wall, &self.all[*wall as usize]);
            }
        });
    }
}

/// Refuses obstacles that are no lines.
fn check(obstacle: usize, shape: &Obstacle) -> Result<(), Error> {
    let points = &shape.points;
    if points.len() < 2 {
        return Err(Error::TooFewPoints { obstacle, points: points.len() });
    }
    for (point, at) in points.iter().enumerate() {
        if let Some(&value) = at.iter().find(|value| value.is_nan() || value.abs() > LARGEST_M) {
            return Err(Error::BadPoint { obstacle, point, value, rule: WITHIN_LARGEST });
        }
        let before = if point > 0 { point - 1 } else { points.len() - 1 };
        if (point > 0 || shape.closed) && points[before] == *at {
            return Err(Error::RepeatedPoint { obstacle, before, point });
        }
    }
    Ok(())
}

fn append(all: &mut Vec<Wall>, shape: &Obstacle) {
    let count = shape.points.len();
    // Two points that close have one wall between them.
    let closed = shape.closed && count > 2;
    let first = all.len();
    let last = if closed { count - 1 } else { count - 2 };
    for nth in 0..=last {
        let beside = |there: bool, other: usize| if there { index(first + other) } else { NONE };
        all.push(Wall {
            from: shape.points[nth].into(),
            to: shape.points[(nth + 1) % count].into(),
            before: beside(nth > 0 || closed, if nth > 0 { nth - 1 } else { last }),
            after: beside(nth < last || closed, if nth < last { nth + 1 } else { 0 }),
        });
    }
}
