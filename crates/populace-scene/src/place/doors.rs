//! Outlines with gaps where people pass.

use super::plan::{Point, Ring, length, minus, plus, turn};

/// Half of the least width of a door in metres.
const HALF_M: f64 = 0.55;
/// Places that are nearer in metres belong to one door.
const JOINED_M: f64 = 1.2;
/// Rest of a side in metres that is too short for a wall.
const REST_M: f64 = 0.35;
/// Turn in radians from which a point is a corner, which no door reaches around.
const CORNER: f64 = 0.5;
/// Points of an outline are moved to the end of a door, if they are this near in metres.
const SAME_M: f64 = 2e-3;

/// A ring of which parts are open.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outline {
    pub(super) points: Ring,
    /// True for each side, from its point to the next, that is open.
    pub(super) open: Vec<bool>,
}

impl Outline {
    /// Returns an outline without doors.
    pub(super) fn closed(points: Ring) -> Self {
        let open = vec![false; points.len()];
        Self { points, open }
    }

    /// Returns an outline with doors at some places along it, in metres.
    pub(super) fn with_doors(ring: &Ring, places: &[f64]) -> Self {
        let starts: Vec<f64> = ring
            .iter()
            .zip(ring.iter().cycle().skip(1))
            .scan(0.0, |along, (a, b)| {
                let start = *along;
                *along += length(minus(*b, *a));
                Some(start)
            })
            .collect();
        let all = super::plan::perimeter(ring);
        let mut doors = Vec::new();
        for [low, high] in sides(ring, &starts, all) {
            doors.extend(side_doors(low, high, all, places));
        }
        let mut outline = Self { points: Vec::new(), open: Vec::new() };
        for (index, from) in ring.iter().enumerate() {
            let to = ring[(index + 1) % ring.len()];
            outline.cut_side([*from, to], starts[index], &doors);
        }
        outline
    }

    /// Adds a side, cut at the ends of doors.
    fn cut_side(&mut self, [from, to]: [Point; 2], start: f64, doors: &[[f64; 2]]) {
        let way = minus(to, from);
        let long = length(way);
        let mut cuts: Vec<f64> = doors.iter().flatten().map(|end| end - start).collect();
        cuts.retain(|cut| (SAME_M..long - SAME_M).contains(cut));
        cuts.extend([0.0, long]);
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| (*a - *b).abs() < SAME_M);
        for pair in cuts.windows(2) {
            let middle = start + 0.5 * (pair[0] + pair[1]);
            self.points.push(plus(from, way, pair[0] / long));
            self.open.push(doors.iter().any(|door| (door[0]..door[1]).contains(&middle)));
        }
    }
}

/// Returns the parts of a ring between corners, as metres along it. The one over the ring's
/// beginning ends beyond the ring's length.
fn sides(ring: &[Point], starts: &[f64], all: f64) -> Vec<[f64; 2]> {
    let count = ring.len();
    let is_corner = |i: &usize| {
        turn(ring[(i + count - 1) % count], ring[*i], ring[(i + 1) % count]).abs() > CORNER
    };
    let corners: Vec<f64> = (0..count).filter(is_corner).map(|i| starts[i]).collect();
    let Some(first) = corners.first() else { return vec![[0.0, all]] };
    let next = corners.iter().skip(1).copied().chain([first + all]);
    corners.iter().zip(next).map(|(low, high)| [*low, high]).collect()
}

/// Returns the doors of one side as metres along the ring. A door over the ring's beginning is two.
fn side_doors(low: f64, high: f64, all: f64, places: &[f64]) -> Vec<[f64; 2]> {
    let beyond = |place: &f64| if *place < low { *place + all } else { *place };
    let mut within: Vec<f64> =
        places.iter().map(beyond).filter(|place| (low..high).contains(place)).collect();
    within.sort_by(f64::total_cmp);
    let mut doors: Vec<[f64; 2]> = Vec::new();
    for place in within {
        match doors.last_mut() {
            Some(door) if place - HALF_M < door[1] + JOINED_M - 2.0 * HALF_M => {
                door[1] = place + HALF_M;
            }
            _ => doors.push([place - HALF_M, place + HALF_M]),
        }
    }
    for door in &mut doors {
        door[0] = if door[0] < low + REST_M { low } else { door[0] };
        door[1] = if door[1] > high - REST_M { high } else { door[1] };
    }
    let cut = |[from, to]: [f64; 2]| {
        let parts = if from >= all {
            [[from - all, to - all], [0.0; 2]]
        } else {
            [[from, to.min(all)], [0.0, to - all]]
        };
        parts.into_iter().filter(|part| part[1] > part[0])
    };
    doors.into_iter().flat_map(cut).collect()
}
