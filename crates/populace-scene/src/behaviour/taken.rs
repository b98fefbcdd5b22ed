//! Points at which people are, for others that look for a place or a way.

use std::collections::HashMap;

use glam::Vec2;
use populace_locomotion::avoidance::Bystander;

/// Side of a cell in metres: the largest distance that is kept.
const CELL_M: f32 = 2.0;
/// Distance from people who stand at which a way is free, in metres.
const KEPT_M: f32 = 0.55;
/// Distance between the points of a way that are looked at, in metres.
const LOOKED_M: f32 = 0.5;

/// Points at which people are, by cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct Taken {
    cells: HashMap<[i32; 2], Vec<Vec2>>,
}

impl Taken {
    pub(crate) fn by(bystanders: &[Bystander]) -> Self {
        let mut taken = Self::default();
        bystanders.iter().for_each(|of| taken.take(of.position.into()));
        taken
    }

    /// Notes a point at which somebody is.
    pub(crate) fn take(&mut self, at: Vec2) {
        self.cells.entry(cell(at)).or_default().push(at);
    }

    /// Returns the points within a distance of at most one cell.
    fn near(&self, at: Vec2, distance_m: f32) -> impl Iterator<Item = Vec2> {
        let [x, z] = cell(at);
        let around = (x - 1..=x + 1).flat_map(move |x| (z - 1..=z + 1).map(move |z| [x, z]));
        let all = around.filter_map(|cell| self.cells.get(&cell)).flatten().copied();
        all.filter(move |other| other.distance_squared(at) < distance_m * distance_m)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Returns true if somebody is within a distance of at most one cell.
    pub(crate) fn is_near(&self, at: Vec2, distance_m: f32) -> bool {
        self.near(at, distance_m).next().is_some()
    }

    /// Returns how far the straight way to a point is free, in metres.
    pub(crate) fn free_m(&self, from: Vec2, to: Vec2) -> f32 {
        let whole_m = from.distance(to);
        let ahead = (to - from).normalize_or_zero();
        let mut way_m = LOOKED_M;
        while way_m < whole_m {
            let mut met = self.near(from + ahead * way_m, KEPT_M);
            // People beside or behind are in nobody's way.
            if met.any(|other| (other - from).dot(ahead) > 0.2) {
                return way_m;
            }
            way_m += LOOKED_M;
        }
        whole_m
    }
}

fn cell(at: Vec2) -> [i32; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "floats saturate")]
    (at / CELL_M).floor().to_array().map(|value| value as i32)
}
