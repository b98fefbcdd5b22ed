//! Edges of rings cut where they cross, on a grid.

use super::plan::{Point, Ring};

/// Points of the grid in a metre. Nearer points are one.
const GRID: f64 = 1000.0;
/// Rounds in which edges are cut. A cut moves edges onto the grid, where they may cross others.
const ROUNDS: usize = 8;
/// Edges that are compared with each other rather than parted further.
const FEW: usize = 12;

/// Greatest coordinate on the grid: areas of triangles fit.
const LARGEST: i64 = (1 << 30) - 1;

/// A point of the grid.
type Node = [i64; 2];
type Edge = [Node; 2];

/// Returns the edges of rings as pairs of points of the grid. They share ends and no other points,
/// unless a crossing is left after all rounds, or a point lies on an edge.
pub(super) fn cut_edges<'a>(rings: impl IntoIterator<Item = &'a Ring>) -> Vec<[Point; 2]> {
    let mut edges = Vec::new();
    for ring in rings {
        let nodes: Vec<Node> = ring.iter().map(|p| p.map(node)).collect();
        let next = nodes.iter().cycle().skip(1);
        edges.extend(nodes.iter().zip(next).map(|(a, b)| [*a, *b]).filter(|[a, b]| a != b));
    }
    for _ in 0..ROUNDS {
        let cuts = crossings(&mut edges);
        if cuts.is_empty() {
            break;
        }
        for (edge, at) in cuts {
            let [from, to] = edges[edge];
            if at != from && at != to {
                edges[edge] = [from, at];
                edges.push([at, to]);
            }
        }
    }
    edges.into_iter().map(|edge| edge.map(|node| node.map(place))).collect()
}

/// Returns where edges cross: for each edge at most one place, in the order of the edges, which are
/// sorted by x.
fn crossings(edges: &mut [Edge]) -> Vec<(usize, Node)> {
    edges.sort_by_key(|edge| (edge[0][0].min(edge[1][0]), *edge));
    let of_two = |i: usize, j: usize| crossing(edges[i.min(j)], edges[i.max(j)]);
    let firsts = first_crossed(edges, |i, j| of_two(i, j).is_some());
    let cuts = firsts.into_iter().enumerate();
    cuts.filter_map(|(edge, first)| Some((edge, of_two(edge, first?)?))).collect()
}

/// Returns for each edge the first of all edges that crosses it.
fn first_crossed(edges: &[Edge], cross: impl Fn(usize, usize) -> bool) -> Vec<Option<usize>> {
    let mut firsts = vec![None; edges.len()];
    let corners = [[-LARGEST; 2], [LARGEST; 2]];
    let mut left = vec![Region { corners, edges: (0..edges.len()).collect() }];
    while let Some(region) = left.pop() {
        if let Some(halves) = region.halved(edges) {
            left.extend(halves);
            continue;
        }
        for &edge in &region.edges {
            let known = firsts[edge].unwrap_or(usize::MAX);
            let mut earlier = region.edges.iter().copied().take_while(|other| *other < known);
            firsts[edge] = earlier.find(|other| cross(edge, *other)).or(firsts[edge]);
        }
    }
    firsts
}

/// A rectangle of the grid.
struct Region {
    /// The corners with the least and with the greatest coordinates.
    corners: [Node; 2],
    /// The edges that touch it, in ascending order.
    edges: Vec<usize>,
}

impl Region {
    /// Returns two halves; `None` if they spare too few comparisons of edges. Edges that cross in
    /// the region cross in one of them.
    fn halved(&self, edges: &[Edge]) -> Option<[Self; 2]> {
        if self.edges.len() <= FEW {
            return None;
        }
        let comparisons = |region: &Self| region.edges.len().pow(2);
        let of_halves = |halves: &[Self; 2]| halves.iter().map(comparisons).sum::<usize>();
        let halves = [0, 1].map(|axis| self.cut(axis, edges)).into_iter().min_by_key(of_halves)?;
        (4 * of_halves(&halves) < 3 * comparisons(self)).then_some(halves)
    }

    /// Cuts the region across an axis, through the middle one of the edges' middles.
    fn cut(&self, axis: usize, edges: &[Edge]) -> [Self; 2] {
        let middle = |edge: &usize| i64::midpoint(edges[*edge][0][axis], edges[*edge][1][axis]);
        let mut middles: Vec<i64> = self.edges.iter().map(middle).collect();
        let nth = middles.len() / 2;
        let [least, most] = self.corners;
        let at = (*middles.select_nth_unstable(nth).1).clamp(least[axis], most[axis]);
        let (mut left_most, mut right_least) = (most, least);
        (left_most[axis], right_least[axis]) = (at, at);
        [[least, left_most], [right_least, most]].map(|corners| {
            let touching = self.edges.iter().copied().filter(|edge| touches(edges[*edge], corners));
            Self { corners, edges: touching.collect() }
        })
    }
}

/// Returns true if an edge and an area, between its corners with the least and the greatest
/// coordinates, have a point in common.
fn touches([a, b]: Edge, [least, most]: [Node; 2]) -> bool {
    let overlap =
        |axis: usize| a[axis].min(b[axis]) <= most[axis] && a[axis].max(b[axis]) >= least[axis];
    let corners = [least, [least[0], most[1]], [most[0], least[1]], most];
    let sides = corners.map(|corner| side(a, b, corner).signum());
    overlap(0) && overlap(1) && !(sides == [1; 4] || sides == [-1; 4])
}

/// Returns the point of the grid next to where two edges cross between their ends.
fn crossing([a, b]: Edge, [c, d]: Edge) -> Option<Node> {
    let (from, to) = (side(c, d, a), side(c, d, b));
    let (first, last) = (side(a, b, c), side(a, b, d));
    if from.signum() * to.signum() >= 0 || first.signum() * last.signum() >= 0 {
        return None;
    }
    let part = wide(from) / (wide(from) - wide(to));
    Some([0, 1].map(|i| a[i] + whole(part * wide(b[i] - a[i]))))
}

/// Returns twice the area of a triangle, positive if its corners run counter-clockwise.
fn side(p: Node, q: Node, r: Node) -> i64 {
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}

/// Returns the nearest coordinate on the grid; 0 for NaN.
fn node(v: f64) -> i64 {
    whole((v * GRID).clamp(-wide(LARGEST), wide(LARGEST)))
}

fn place(v: i64) -> f64 {
    wide(v) / GRID
}

#[expect(clippy::cast_possible_truncation, reason = "coordinates on the grid are below 2^30")]
fn whole(v: f64) -> i64 {
    v.round() as i64
}

#[expect(clippy::cast_precision_loss, reason = "a ratio of areas needs no more digits")]
fn wide(v: i64) -> f64 {
    v as f64
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use populace_random::Rng;

    use super::*;

    /// Compares all edges with each other.
    fn plainly_crossed(edges: &[Edge]) -> Vec<Option<usize>> {
        let crosses = |a: usize, b: usize| crossing(edges[a], edges[b]).is_some();
        let all = 0..edges.len();
        all.clone().map(|edge| all.clone().find(|other| crosses(edge, *other))).collect()
    }

    /// Returns edges between points in a rectangle, of which each begins where the last ends, or
    /// elsewhere.
    fn edges(
        random: &mut Rng,
        count: usize,
        [width, height]: [usize; 2],
        joined: bool,
    ) -> Vec<Edge> {
        let mut coordinate = |most: usize| i64::try_from(random.below(most)).expect("few");
        let mut point = || [coordinate(width), coordinate(height)];
        let mut last = point();
        let mut edge = |_| {
            let from = if joined { last } else { point() };
            last = point();
            [from, last]
        };
        (0..count).map(&mut edge).filter(|[a, b]| a != b).collect()
    }

    #[test]
    fn edges_cross_as_when_all_are_compared() {
        let mut random = Rng::new(7);
        for size in [[9, 9], [2, 400], [400, 3], [5000, 5000], [1, 50], [100_000_000, 1000]] {
            for count in [0, 1, 2, 13, 60, 250] {
                for joined in [false, true] {
                    let edges = edges(&mut random, count, size, joined);
                    let found =
                        first_crossed(&edges, |a, b| crossing(edges[a], edges[b]).is_some());
                    assert_eq!(found, plainly_crossed(&edges), "{count} in {size:?}, {joined}");
                }
            }
        }
    }

    #[test]
    fn edges_are_compared_with_those_near_by() {
        let count = 4000;
        let up = |nth: i64| [[20 * (nth % 3), 10 * nth], [20 * ((nth + 1) % 3), 10 * (nth + 1)]];
        let corridor: Vec<Edge> = (0..count).map(up).collect();
        let along = |nth: i64| [[0, 10 * nth], [900_000, 10 * nth]];
        let rows: Vec<Edge> = (0..count).map(along).collect();
        let turned = |edges: &[Edge]| edges.iter().map(|e| e.map(|[x, y]| [y, x])).collect();
        let far = [[[-LARGEST; 2], [LARGEST, -LARGEST]]];
        let with_far: Vec<Edge> = corridor.iter().copied().chain(far).collect();
        let star: Vec<Edge> = (1..count).map(|nth| [[nth, 9000], [-nth, -9000]]).collect();
        for edges in [turned(&corridor), corridor, turned(&rows), rows, with_far, star] {
            let compared = Cell::new(0);
            first_crossed(&edges, |a, b| {
                compared.set(compared.get() + 1);
                crossing(edges[a], edges[b]).is_some()
            });
            assert!(compared.get() < 40 * edges.len(), "{} of {}", compared.get(), edges.len());
        }
    }
}
