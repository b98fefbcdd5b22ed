//! Doors: places at which people pass outlines.

use populace_trajectory::{Recording, Track};

use super::plan::{Point, Ring, cross, dot, is_inside, length, minus, plus};

/// Distance in metres from an outline within which people who walk there appear or leave at it.
const NEAR_M: f64 = 0.6;
/// Distance up to which they are taken to walk straight before they appear and after they leave.
const STRAIGHT_M: f64 = 1.2;
/// Distance over which the direction of a way is taken.
const MOVED_M: f64 = 0.4;
/// Distance from an outline from which somebody is outside and does not just lean over it.
const LEAN_M: f64 = 0.25;
/// Cells of the grid along the longer side, at most.
const CELLS: f64 = 256.0;

/// Edges of outlines, found by place.
pub(super) struct Edges<'a> {
    outlines: &'a [Ring],
    /// Outline, point from which the edge comes, and its place along the outline in metres.
    all: Vec<(usize, Point, Point, f64)>,
    low: Point,
    cell_m: f64,
    size: [usize; 2],
    cells: Vec<Vec<usize>>,
}

/// A place on an outline: its index, and metres along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gate {
    pub(super) outline: usize,
    pub(super) along_m: f64,
}

impl<'a> Edges<'a> {
    pub(super) fn new(outlines: &'a [Ring]) -> Self {
        let mut all = Vec::new();
        let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
        for (index, ring) in outlines.iter().enumerate() {
            let mut along = 0.0;
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                all.push((index, *a, *b, along));
                along += length(minus(*b, *a));
                low = [0, 1].map(|i| low[i].min(a[i]));
                high = [0, 1].map(|i| high[i].max(a[i]));
            }
        }
        let extent = [0, 1].map(|i| (high[i] - low[i]).max(0.0));
        let cell_m = (extent[0].max(extent[1]) / CELLS).max(1.0);
        let size = extent.map(|v| index(v / cell_m) + 1);
        let mut edges =
            Self { outlines, all, low, cell_m, size, cells: vec![Vec::new(); size[0] * size[1]] };
        for edge in 0..edges.all.len() {
            let (_, a, b, _) = edges.all[edge];
            let [first, last] = edges.span(a, b, 0.0);
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    edges.cells[y * size[0] + x].push(edge);
                }
            }
        }
        edges
    }

    /// Returns the first and the last cell of a box around two points.
    fn span(&self, a: Point, b: Point, around: f64) -> [[usize; 2]; 2] {
        let cell = |v: f64, i: usize| {
            index((v - self.low[i]) / self.cell_m).min(self.size[i].saturating_sub(1))
        };
        [
            [0, 1].map(|i| cell(a[i].min(b[i]) - around, i)),
            [0, 1].map(|i| cell(a[i].max(b[i]) + around, i)),
        ]
    }

    /// Returns the edges near a way, each once, in order.
    fn near(&self, a: Point, b: Point, around: f64) -> Vec<usize> {
        let [first, last] = self.span(a, b, around);
        let rows = first[1]..=last[1];
        let cells = rows.flat_map(|y| (first[0]..=last[0]).map(move |x| y * self.size[0] + x));
        let mut found: Vec<_> =
            cells.filter_map(|cell| self.cells.get(cell)).flatten().copied().collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Returns the place on an outline that is nearest to a point and at most `most_m` away.
    fn nearest(&self, at: Point, most_m: f64) -> Option<Gate> {
        let mut best = None;
        let mut least = most_m;
        for edge in self.near(at, at, most_m) {
            let (outline, a, b, along) = self.all[edge];
            let way = minus(b, a);
            let long = length(way);
            let part = (dot(minus(at, a), way) / (long * long)).clamp(0.0, 1.0);
            let distance = length(minus(at, plus(a, way, part)));
            if distance <= least {
                least = distance;
                best = Some(Gate { outline, along_m: along + part * long });
            }
        }
        best
    }

    /// Returns where a way crosses outlines first, and true if it does so outwards.
    fn crossing(&self, from: Point, to: Point) -> Option<(Gate, bool)> {
        let way = minus(to, from);
        let mut best: Option<(f64, Gate, bool)> = None;
        for edge in self.near(from, to, 0.0) {
            let (outline, a, b, along) = self.all[edge];
            let side = minus(b, a);
            let across = cross(way, side);
            if across == 0.0 {
                continue;
            }
            let out = minus(a, from);
            let (t, u) = (cross(out, side) / across, cross(out, way) / across);
            let meets = (0.0..=1.0).contains(&t) && (0.0..1.0).contains(&u);
            if meets && best.is_none_or(|(least, ..)| t < least) {
                let gate = Gate { outline, along_m: along + u * length(side) };
                // The inside is on the left of the edge.
                best = Some((t, gate, across > 0.0));
            }
        }
        best.map(|(_, gate, outwards)| (gate, outwards))
    }

    fn is_inside(&self, at: Point) -> bool {
        self.outlines.iter().any(|ring| is_inside(ring, at))
    }

    /// Returns where agents cross, appear or leave at the outlines within a time in seconds.
    pub(super) fn gates(&self, recording: &Recording, secs: [f64; 2]) -> Vec<Gate> {
        let mut gates = Vec::new();
        if self.all.is_empty() {
            return gates;
        }
        let recorded = recording.secs();
        for agent in &recording.agents {
            self.gates_of(&recording.track(agent), secs, recorded, &mut gates);
        }
        gates
    }

    fn gates_of(
        &self,
        track: &Track<'_>,
        secs: [f64; 2],
        recorded: [f64; 2],
        gates: &mut Vec<Gate>,
    ) {
        let first = track.times.partition_point(|t| *t < secs[0]);
        let end = track.times.partition_point(|t| *t < secs[1]);
        let wide = |p: &[f32; 2]| p.map(f64::from);
        let points: Vec<Point> =
            track.positions.get(first..end).unwrap_or_default().iter().map(wide).collect();
        let (Some(begin), Some(last)) = (points.first(), points.last()) else { return };
        // Who is there at the beginning or the end of the recording does not come or leave then.
        let [opens, closes] = recorded;
        let (came, left) = (track.times.first(), track.times.last());
        if first == 0 && came.is_some_and(|t| *t > opens) && self.is_inside(*begin) {
            gates.extend(self.end(points.iter()));
        }
        let is_end = end == track.times.len();
        if is_end && left.is_some_and(|t| *t < closes) && self.is_inside(*last) {
            gates.extend(self.end(points.iter().rev()));
        }
        let mut outside = !self.is_inside(*begin);
        let mut left_by = None;
        for pair in points.windows(2) {
            if outside || left_by.is_some() {
                let is_far = self.nearest(pair[0], LEAN_M).is_none();
                outside |= is_far;
                gates.extend(left_by.take_if(|_| is_far));
            }
            match self.crossing(pair[0], pair[1]) {
                Some((gate, true)) => left_by = Some(gate),
                Some((gate, false)) => {
                    gates.extend(outside.then_some(gate));
                    (outside, left_by) = (false, None);
                }
                None => {}
            }
        }
        gates.extend(left_by);
    }

    /// Returns the place on an outline at which a way begins, if it begins near one and comes from
    /// it.
    fn end<'p>(&self, mut points: impl Iterator<Item = &'p Point>) -> Option<Gate> {
        let begin = *points.next()?;
        self.nearest(begin, NEAR_M)?;
        let ahead = points.find(|p| length(minus(**p, begin)) > MOVED_M)?;
        let way = minus(begin, *ahead);
        let before = plus(begin, way, STRAIGHT_M / length(way));
        self.crossing(begin, before).map(|(gate, _)| gate)
    }
}

/// Returns the whole part of a number of cells.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates: negative numbers become 0"
)]
fn index(v: f64) -> usize {
    v as usize
}
