//! Edges of rings cut where they cross, on a grid.

use super::plan::{Point, Ring};

/// Points of the grid in a metre. Nearer points are one.
const GRID: f64 = 1000.0;
/// Rounds in which edges are cut. A cut moves edges onto the grid, where they may cross others.
const ROUNDS: usize = 8;

/// A point of the grid. Coordinates are below 2^30, so that products of differences fit.
type Node = [i64; 2];

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
fn crossings(edges: &mut [[Node; 2]]) -> Vec<(usize, Node)> {
    let span =
        |edge: &[Node; 2], i: usize| [edge[0][i].min(edge[1][i]), edge[0][i].max(edge[1][i])];
    edges.sort_by_key(|edge| (span(edge, 0)[0], *edge));
    let mut cuts = vec![None; edges.len()];
    for i in 0..edges.len() {
        let ([_, right], [low, high]) = (span(&edges[i], 0), span(&edges[i], 1));
        for j in i + 1..edges.len() {
            if span(&edges[j], 0)[0] > right {
                break;
            }
            let [other_low, other_high] = span(&edges[j], 1);
            if other_low > high || other_high < low || (cuts[i].is_some() && cuts[j].is_some()) {
                continue;
            }
            if let Some(at) = crossing(edges[i], edges[j]) {
                cuts[i].get_or_insert(at);
                cuts[j].get_or_insert(at);
            }
        }
    }
    cuts.into_iter().enumerate().filter_map(|(edge, at)| Some((edge, at?))).collect()
}

/// Returns the point of the grid next to where two edges cross between their ends.
fn crossing([a, b]: [Node; 2], [c, d]: [Node; 2]) -> Option<Node> {
    let side =
        |p: Node, q: Node, r: Node| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let (from, to) = (side(c, d, a), side(c, d, b));
    let (first, last) = (side(a, b, c), side(a, b, d));
    if from.signum() * to.signum() >= 0 || first.signum() * last.signum() >= 0 {
        return None;
    }
    let part = wide(from) / (wide(from) - wide(to));
    Some([0, 1].map(|i| a[i] + whole(part * wide(b[i] - a[i]))))
}

fn node(v: f64) -> i64 {
    whole(v * GRID)
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
