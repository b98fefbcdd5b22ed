//! Points of a plane joined to triangles, and the weights of their corners.

use std::collections::{BTreeSet, HashMap};

use populace_model::convert::single;

use super::{MOST, Weights};

type Point = [f64; 2];

/// Sample points as triangles, or as a chain where all stand on one line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    /// Each axis times this measures by how far the samples spread along it.
    scale: Point,
    points: Vec<Point>,
    /// Corners counter-clockwise; empty where all points stand on one line.
    triangles: Vec<[usize; 3]>,
    /// Edges that bound all triangles, or the links of the chain; a lone point is a link to itself.
    border: Vec<[usize; 2]>,
}

/// Twice the area of a triangle, positive where it runs counter-clockwise.
fn area(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Areas below this are taken for none; coordinates are from 0 to 1 or so.
const FLAT: f64 = 1e-9;
/// Points of single precision that are meant for one line leave it by less than this, in units of
/// the largest coordinate. Nearer points are taken for one.
const NOISE: f64 = 1e-6;

/// Returns what makes the extent of points 1 along each axis along which they differ.
fn scale(points: &[[f32; 2]]) -> Point {
    let spread = |axis: usize| {
        let values = points.iter().map(|p| f64::from(p[axis]));
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    [0, 1].map(|axis| if spread(axis) > 0.0 { 1.0 / spread(axis) } else { 1.0 })
}

/// Returns the first point that is where one before it is, but for rounding.
pub(super) fn doubled(points: &[[f32; 2]]) -> Option<[f32; 2]> {
    let scale = scale(points);
    let is_near = |a: &[f32; 2], b: &[f32; 2]| {
        (0..2).all(|axis| (f64::from(a[axis]) - f64::from(b[axis])).abs() * scale[axis] < NOISE)
    };
    let numbered = points.iter().enumerate();
    let mut near = numbered.filter(|(nth, at)| points[..*nth].iter().any(|b| is_near(at, b)));
    near.next().map(|(_, at)| *at)
}

/// Above 0 where `d` lies within the circle through a counter-clockwise triangle.
fn in_circle([a, b, c]: [Point; 3], d: Point) -> f64 {
    let row = |p: Point| {
        let (x, y) = (p[0] - d[0], p[1] - d[1]);
        [x, y, x * x + y * y]
    };
    let [a, b, c] = [row(a), row(b), row(c)];
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// Returns the edges of a triangle, at the left of which it lies.
fn edges([a, b, c]: [usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

impl Plane {
    /// Joins points, none of which is [`doubled`], to triangles: one point after the other is
    /// joined to the edges that it sees, then edges are turned until Delaunay's condition holds.
    pub(super) fn new(points: &[[f32; 2]]) -> Self {
        let scale = scale(points);
        let points: Vec<Point> = points
            .iter()
            .map(|p| [f64::from(p[0]) * scale[0], f64::from(p[1]) * scale[1]])
            .collect();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| {
            points[a][0].total_cmp(&points[b][0]).then(points[a][1].total_cmp(&points[b][1]))
        });
        let mut plane = Self { scale, points, triangles: Vec::new(), border: Vec::new() };
        plane.sweep(&order);
        plane.turn_edges();
        plane
    }

    /// Whether all points stand on the line from the first to the last, but for rounding.
    fn is_line(&self, order: &[usize]) -> bool {
        let largest = self.points.iter().flatten().fold(1.0, |most: f64, c| most.max(c.abs()));
        let [first, .., last] = order else { return true };
        let off = |&at: &usize| area(self.points[*first], self.points[*last], self.points[at]);
        order.iter().all(|at| off(at).abs() <= NOISE * largest)
    }

    fn sweep(&mut self, order: &[usize]) {
        if self.is_line(order) {
            let links = order.windows(2).map(|pair| [pair[0], pair[1]]);
            self.border = links.chain((order.len() == 1).then(|| [order[0]; 2])).collect();
            return;
        }
        // The border in order, counter-clockwise; at first the points before one leaves their line.
        let mut chain: Vec<usize> = Vec::new();
        let mut rest = order.iter().copied();
        let mut apex = None;
        for next in rest.by_ref() {
            let off = match chain[..] {
                [first, .., last] => area(self.points[first], self.points[last], self.points[next]),
                _ => 0.0,
            };
            if off.abs() > FLAT {
                apex = Some((next, off));
                break;
            }
            chain.push(next);
        }
        let Some((apex, off)) = apex else { return };
        if off < 0.0 {
            chain.reverse();
        }
        self.triangles.extend(chain.windows(2).map(|pair| [pair[0], pair[1], apex]));
        chain.push(apex);
        for next in rest {
            self.join(&mut chain, next);
        }
        let count = chain.len();
        self.border = (0..count).map(|i| [chain[i], chain[(i + 1) % count]]).collect();
    }

    /// Joins a point outside to each edge of the border that it sees.
    fn join(&mut self, border: &mut Vec<usize>, next: usize) {
        let count = border.len();
        let edge = |i: usize| [border[i % count], border[(i + 1) % count]];
        let sees = |i: usize| {
            let [a, b] = edge(i).map(|corner| self.points[corner]);
            area(a, b, self.points[next]) < -FLAT
        };
        let Some(first) = (0..count).find(|&i| sees(i) && !sees(i + count - 1)) else { return };
        let seen = (first..first + count).take_while(|&i| sees(i)).count();
        let triangles: Vec<_> =
            (first..first + seen).map(|i| [edge(i)[1], edge(i)[0], next]).collect();
        self.triangles.extend(triangles);
        let kept: Vec<_> = (first + seen..=first + count).map(|i| border[i % count]).collect();
        *border = kept;
        border.push(next);
    }

    /// Turns each edge within whose two triangles' circles lies the other's corner, the first one
    /// first. Each turn brings the whole nearer to Delaunay's, so this ends; the bound is for what
    /// rounding might do.
    fn turn_edges(&mut self) {
        // The triangle at the left of each edge.
        let mut lefts: HashMap<[usize; 2], usize> = HashMap::new();
        // Edges that may have to be turned: triangles, and which of their edges.
        let mut waiting: BTreeSet<(usize, usize)> = BTreeSet::new();
        for (index, triangle) in self.triangles.iter().enumerate() {
            lefts.extend(edges(*triangle).map(|edge| (edge, index)));
            waiting.extend([0, 1, 2].map(|nth| (index, nth)));
        }
        let mut turns = 0..self.points.len().pow(2);
        while let Some((one, nth)) = waiting.pop_first() {
            let Some((other, [a, b, c, d])) = self.turned(&lefts, one, nth) else { continue };
            if turns.next().is_none() {
                return;
            }
            lefts.remove(&[c, a]);
            lefts.remove(&[a, c]);
            for (index, triangle) in [(one, [a, b, d]), (other, [b, c, d])] {
                self.triangles[index] = triangle;
                lefts.extend(edges(triangle).map(|edge| (edge, index)));
                waiting.extend([0, 1, 2].map(|nth| (index, nth)));
            }
            // Their neighbours have the same edges.
            for [from, to] in [[a, b], [b, c], [c, d], [d, a]] {
                let Some(&beyond) = lefts.get(&[to, from]) else { continue };
                let nth = edges(self.triangles[beyond]).iter().position(|edge| *edge == [to, from]);
                waiting.extend(nth.map(|nth| (beyond, nth)));
            }
        }
    }

    /// Returns the neighbour at an edge of a triangle, and the corners of both, if they are
    /// `a b c` and `a c d` and their edge should be `b d`.
    fn turned(
        &self,
        lefts: &HashMap<[usize; 2], usize>,
        one: usize,
        nth: usize,
    ) -> Option<(usize, [usize; 4])> {
        let [c, a, b] = [0, 1, 2].map(|i| self.triangles[one][(i + nth) % 3]);
        let other = *lefts.get(&[a, c])?;
        let d = self.triangles[other].into_iter().find(|corner| ![a, c].contains(corner))?;
        let at = |corner: usize| self.points[corner];
        let convex = area(at(a), at(b), at(d)) > FLAT && area(at(b), at(c), at(d)) > FLAT;
        let turns = convex && in_circle([a, b, c].map(at), at(d)) > FLAT;
        turns.then_some((other, [a, b, c, d]))
    }

    /// Weights of the corners around a point, or around the nearest point of the border.
    pub(super) fn weights(&self, at: Point) -> Weights {
        let at = [at[0] * self.scale[0], at[1] * self.scale[1]];
        let within = self.triangles.iter().map(|corners| (corners, self.shares(*corners, at)));
        let deepest = within.max_by(|a, b| least(a.1).total_cmp(&least(b.1)));
        if let Some((corners, shares)) = deepest.filter(|(_, shares)| least(*shares) >= 0.0) {
            return [0, 1, 2].map(|i| (corners[i], single(shares[i])));
        }
        let mut nearest = (f64::MAX, [(0, 0.0); MOST]);
        for &[from, to] in &self.border {
            let (a, b) = (self.points[from], self.points[to]);
            let (along, offset) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
            let length = along[0] * along[0] + along[1] * along[1];
            let share = if length > 0.0 {
                (along[0] * offset[0] + along[1] * offset[1]) / length
            } else {
                0.0
            };
            let share = share.clamp(0.0, 1.0);
            let off = [offset[0] - along[0] * share, offset[1] - along[1] * share];
            let distance = off[0] * off[0] + off[1] * off[1];
            if distance < nearest.0 {
                nearest = (distance, [(from, single(1.0 - share)), (to, single(share)), (0, 0.0)]);
            }
        }
        nearest.1
    }

    fn shares(&self, corners: [usize; 3], at: Point) -> [f64; 3] {
        let [a, b, c] = corners.map(|corner| self.points[corner]);
        let whole = area(a, b, c);
        [area(at, b, c) / whole, area(a, at, c) / whole, area(a, b, at) / whole]
    }
}

fn least(shares: [f64; 3]) -> f64 {
    shares.into_iter().fold(f64::MAX, f64::min)
}

#[cfg(test)]
mod tests;
