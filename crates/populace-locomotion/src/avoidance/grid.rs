//! Walkers in the cells of a grid, rebuilt for each step.

use glam::Vec2;

use super::Agents;
use super::geometry::{cell, index, root};

/// Edge of a cell in metres.
const CELL_M: f32 = 2.0;
/// The fewest cells along each side.
const FEWEST: u32 = 16;

/// A walker as its neighbours see it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    pub(crate) position: Vec2,
    pub(crate) velocity: Vec2,
    /// Direction of the preferred velocity, or zero.
    pub(crate) ahead: Vec2,
    pub(crate) radius: f32,
    pub(crate) index: u32,
    pub(crate) group: u32,
}

/// A square grid that repeats in both directions, so that it covers the whole plane with cells in
/// proportion to the walkers. A cell holds walkers of several places of the plane. Queries test the
/// distance, so they return no stranger.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    /// Cells along each side, a power of two.
    side: u32,
    /// First walker of each cell in `seen`, and the number of walkers after the last.
    starts: Vec<u32>,
    /// The cell of each walker, by index.
    cells: Vec<u32>,
    seen: Vec<Seen>,
    largest_radius: f32,
    highest_speed: f32,
}

impl Grid {
    /// Sorts all walkers by cell, and by index within a cell.
    pub(crate) fn rebuild(&mut self, agents: &Agents<'_>) {
        let count = agents.positions.len();
        self.side = FEWEST;
        while (self.side as usize).pow(2) < 2 * count {
            self.side *= 2;
        }
        self.starts.clear();
        self.starts.resize((self.side as usize).pow(2) + 1, 0);
        self.cells.clear();
        for position in agents.positions {
            let cell = self.cell(position[0], position[1]);
            self.starts[cell as usize + 1] += 1;
            self.cells.push(cell);
        }
        let mut before = 0;
        for start in &mut self.starts {
            before += *start;
            *start = before;
        }
        self.seen.resize(count, Seen::default());
        // From the last walker to the first, each cell is filled from its end. The end of a cell
        // turns into its start.
        for (nth, cell) in self.cells.iter().enumerate().rev() {
            let end = &mut self.starts[*cell as usize + 1];
            *end -= 1;
            self.seen[*end as usize] = Seen {
                position: agents.positions[nth].into(),
                velocity: agents.velocities[nth].into(),
                ahead: Vec2::from(agents.preferred[nth]).normalize_or_zero(),
                radius: agents.radii_m[nth],
                index: index(nth),
                group: agents.groups[nth],
            };
        }
        self.starts.rotate_left(1);
        if let Some(last) = self.starts.last_mut() {
            *last = index(count);
        }
        self.largest_radius = agents.radii_m.iter().copied().fold(0.0, f32::max);
        let squares = self.seen.iter().map(|walker| walker.velocity.length_squared());
        self.highest_speed = root(squares.fold(0.0, f32::max));
    }

    /// Sets bits of the indices of all walkers.
    pub(crate) fn mark(&mut self, bits: u32) {
        self.seen.iter_mut().for_each(|walker| walker.index |= bits);
    }

    fn cell(&self, x: f32, z: f32) -> u32 {
        self.row(cell(z, 1.0 / CELL_M)) + self.column(cell(x, 1.0 / CELL_M))
    }

    fn column(&self, x: i32) -> u32 {
        x.cast_unsigned() & (self.side - 1)
    }

    fn row(&self, z: i32) -> u32 {
        self.column(z) * self.side
    }

    /// All walkers, in the order of cells.
    pub(crate) fn walkers(&self) -> &[Seen] {
        &self.seen
    }

    /// The largest radius of any walker, in metres.
    pub(crate) fn largest_radius(&self) -> f32 {
        self.largest_radius
    }

    /// The highest speed of any walker, in metres per second.
    pub(crate) fn highest_speed(&self) -> f32 {
        self.highest_speed
    }

    /// The largest distance of a query, in metres: a larger one would meet the same cells again.
    pub(crate) const FARTHEST_M: f32 = CELL_M * (FEWEST as f32 / 2.0 - 1.0);

    /// Calls `visit` with place and walker for all walkers in cells within a distance, at most
    /// [`Self::FARTHEST_M`], and some farther ones.
    pub(crate) fn around(&self, position: Vec2, distance: f32, mut visit: impl FnMut(u32, &Seen)) {
        if self.seen.is_empty() {
            return;
        }
        let low = position - Vec2::splat(distance);
        let high = position + Vec2::splat(distance);
        let [first, last] =
            [low, high].map(|at| (cell(at.x, 1.0 / CELL_M), cell(at.y, 1.0 / CELL_M)));
        for z in first.1..=last.1 {
            let row = self.row(z);
            let (from, until) = (self.column(first.0), self.column(last.0));
            let mut run = |from: u32, until: u32| {
                let [from, until] =
                    [row + from, row + until + 1].map(|cell| self.starts[cell as usize]);
                let walkers = &self.seen[from as usize..until as usize];
                (from..until).zip(walkers).for_each(|(place, walker)| visit(place, walker));
            };
            if from <= until {
                run(from, until);
            } else {
                run(from, self.side - 1);
                run(0, until);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_find_everybody_near_once() {
        let mut random = fastrand::Rng::with_seed(6);
        let mut grid = Grid::default();
        // Fewer in later rounds, in the same memory. All around the origin, and far away.
        for (count, size) in [(900, 60.0), (300, 500.0), (40, 20.0), (2, 1e6), (0, 1.0)] {
            let mut place = || [(); 2].map(|()| (random.f32() * 2.0 - 1.0) * size);
            let positions: Vec<_> = (0..count).map(|_| place()).collect();
            let zeros = vec![[0.0; 2]; count];
            grid.rebuild(&Agents {
                positions: &positions,
                velocities: &zeros,
                preferred: &zeros,
                radii_m: &vec![0.25; count],
                most_speeds: &vec![1.0; count],
                groups: &vec![0; count],
            });
            for from in positions.iter().map(|at| Vec2::from(*at)) {
                let near = |at: &Vec2| at.distance(from) <= Grid::FARTHEST_M;
                let mut found = Vec::new();
                grid.around(from, Grid::FARTHEST_M, |_, other| {
                    if near(&other.position) {
                        found.push(other.index);
                    }
                });
                found.sort_unstable();
                let all = positions.iter().map(|at| Vec2::from(*at)).enumerate();
                let expected = all.filter(|(_, at)| near(at)).map(|(nth, _)| index(nth));
                assert!(found.iter().copied().eq(expected), "around {from}");
            }
        }
    }
}
