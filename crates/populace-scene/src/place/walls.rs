//! Walls, door posts, edges of the floor and blocks.

use super::doors::Outline;
use super::mesh::{Faces, over};
use super::plan::{Point, cross, dot, length, minus, plus};

/// Largest length of a mitre in thicknesses.
const MITRE_MOST: f64 = 2.5;
/// Width of a door post in metres, and how far it is higher than the wall.
const POST_M: f64 = 0.16;
const POST_RISE_M: f64 = 0.12;

/// Sizes in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    pub(super) height: f64,
    pub(super) thickness: f64,
    pub(super) slab: f64,
}

/// The meshes that take faces.
pub(super) struct Faced<'a> {
    pub(super) floor: &'a mut Faces,
    pub(super) walls: &'a mut Faces,
    pub(super) posts: &'a mut Faces,
    pub(super) edges: &'a mut Faces,
}

/// Builds the wall along an outline, its inside on the left: outside of it, with mitred corners. In
/// doors there is floor instead. Beneath both is the edge of the floor.
pub(super) fn build_wall(outline: &Outline, sizes: Sizes, into: &mut Faced<'_>) {
    let count = outline.points.len();
    let outer = mitred(&outline.points, sizes.thickness);
    for (i, open) in outline.open.iter().enumerate() {
        let next = (i + 1) % count;
        let [a, b] = [outline.points[i], outline.points[next]];
        let [far_a, far_b] = [outer[i], outer[next]];
        let edge = [
            over(far_a, -sizes.slab),
            over(far_b, -sizes.slab),
            over(far_b, 0.0),
            over(far_a, 0.0),
        ];
        into.edges.quad(edge);
        if *open {
            strip(into.floor, [a, b], [far_a, far_b], 0.0);
        } else {
            let high = |p| over(p, sizes.height);
            into.walls.quad([over(b, 0.0), over(a, 0.0), high(a), high(b)]);
            into.walls.quad([over(far_a, 0.0), over(far_b, 0.0), high(far_b), high(far_a)]);
            strip(into.walls, [a, b], [far_a, far_b], sizes.height);
        }
        let before = outline.open[(i + count - 1) % count];
        if *open != before {
            // The end of the wall looks into the door: along the outline where the door begins.
            let [p, q] = if *open { [a, far_a] } else { [far_a, a] };
            let high = sizes.height;
            into.walls.quad([over(q, 0.0), over(p, 0.0), over(p, high), over(q, high)]);
            let last = (i + count - 1) % count;
            let wall = if *open { [outline.points[last], a] } else { [a, b] };
            post(into.posts, [a, far_a], unit(minus(wall[1], wall[0])), sizes);
        }
    }
}

/// Adds a level strip between an outline's side and the outer one.
fn strip(faces: &mut Faces, [a, b]: [Point; 2], [far_a, far_b]: [Point; 2], height: f64) {
    faces.quad([over(far_a, height), over(far_b, height), over(b, height), over(a, height)]);
}

/// Adds a post around the end of a wall, which goes from `ends[0]` to `ends[1]`, turned as the wall.
fn post(faces: &mut Faces, ends: [Point; 2], along: Point, sizes: Sizes) {
    let middle = plus(ends[0], minus(ends[1], ends[0]), 0.5);
    let half = 0.5 * POST_M.max(1.3 * sizes.thickness);
    let across = [-along[1], along[0]];
    let corner = |u: f64, v: f64| plus(plus(middle, along, u * half), across, v * half);
    let ring = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    build_sides(faces, &ring, sizes.height + POST_RISE_M);
    let top = ring.map(|p| over(p, sizes.height + POST_RISE_M));
    faces.quad(top);
}

/// Adds the upright sides of a block on the floor, whose ring runs counter-clockwise.
pub(super) fn build_sides(faces: &mut Faces, ring: &[Point], height: f64) {
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        faces.quad([over(*a, 0.0), over(*b, 0.0), over(*b, height), over(*a, height)]);
    }
}

/// Returns the points of a ring moved to its right by a thickness.
fn mitred(ring: &[Point], thickness: f64) -> Vec<Point> {
    let count = ring.len();
    let moved = |i: usize| {
        let (before, at, next) = (ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count]);
        let [p, q] = [unit(minus(at, before)), unit(minus(next, at))];
        let sum = [p[1] + q[1], -p[0] - q[0]];
        // A mitre is the sum of the normals over one plus their product.
        let share = 1.0 + dot(p, q);
        let mitre = if share > 1e-6 { sum.map(|v| v / share) } else { [p[1], -p[0]] };
        let long = length(mitre);
        let fit = if long > MITRE_MOST { MITRE_MOST / long } else { 1.0 };
        // Points that go straight back, where both sides of a wall would fall together.
        let fit = if cross(p, q).abs() < 1e-12 && dot(p, q) < 0.0 { 1.0 } else { fit };
        plus(at, mitre, fit * thickness)
    };
    (0..count).map(moved).collect()
}

fn unit(v: Point) -> Point {
    let long = length(v);
    if long > 0.0 { v.map(|c| c / long) } else { [1.0, 0.0] }
}
