//! Shapes from which props are made.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::Solid;

/// Returns a box.
pub(crate) fn block(low: [f64; 3], high: [f64; 3]) -> Solid {
    let at = |x: usize, y: usize, z: usize| {
        let pick = |axis: usize, up: usize| if up == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0, x), pick(1, y), pick(2, z))
    };
    let points = (0..8).map(|i| at(i & 1, i >> 1 & 1, i >> 2)).collect();
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Solid { points, faces: faces.map(|face| face.to_vec()).to_vec() }
}

/// Returns a box whose edges are cut off by `cut` metres along each face.
pub(crate) fn bevelled(low: [f64; 3], high: [f64; 3], cut: f64) -> Solid {
    let (low, high) = (DVec3::from(low), DVec3::from(high));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    // Each corner of the box becomes three points: one on each of its faces.
    let point = |corner: usize, axis: usize| {
        let side = |a: usize| if corner >> a & 1 == 1 { 1.0 } else { -1.0 };
        let reach = |a: usize| if a == axis { half[a] } else { (half[a] - cut).max(0.0) };
        middle + DVec3::new(side(0) * reach(0), side(1) * reach(1), side(2) * reach(2))
    };
    let points: Vec<DVec3> = (0..24).map(|i| point(i / 3, i % 3)).collect();
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for axis in 0..3 {
        let (a, b, top) = ((axis + 1) % 3, (axis + 2) % 3, 1 << axis);
        let (u, v) = (1 << a, 1 << b);
        for base in [0, top] {
            faces.push([base, base | u, base | u | v, base | v].map(|c| 3 * c + axis).to_vec());
        }
        // The edges along this axis lie between the two other faces of each corner.
        for corner in [0, u, v, u | v] {
            let end = corner | top;
            faces.push(vec![3 * corner + a, 3 * corner + b, 3 * end + b, 3 * end + a]);
        }
    }
    faces.extend((0..8).map(|corner| (0..3).map(|axis| 3 * corner + axis).collect()));
    let solid = Solid { points, faces };
    solid.outwards_from(middle)
}

/// Returns one flat face of points in order.
pub(crate) fn plate(corners: &[[f64; 3]]) -> Solid {
    let points: Vec<DVec3> = corners.iter().map(|c| DVec3::from(*c)).collect();
    Solid { faces: vec![(0..points.len()).collect()], points }
}

/// Returns an open surface through rows of equally many points. Seen from its front, rows run to
/// the right, and each lies above the one before.
pub(crate) fn sheet(rows: &[Vec<DVec3>]) -> Solid {
    let count = rows.first().map_or(0, Vec::len);
    let mut solid = Solid { points: rows.concat(), faces: Vec::new() };
    for row in 1..rows.len() {
        for k in 1..count {
            let (below, above) = ((row - 1) * count + k, row * count + k);
            solid.faces.push(vec![below - 1, below, above, above - 1]);
        }
    }
    solid
}

/// Returns a flat grid in the plane z = 0 that faces +Z, between lines at the given x and y. Cells
/// for which `is_hole` is true, by column and row, are left out.
pub(crate) fn grid(xs: &[f64], ys: &[f64], is_hole: impl Fn(usize, usize) -> bool) -> Solid {
    let mut solid = Solid::default();
    for y in ys {
        solid.points.extend(xs.iter().map(|x| DVec3::new(*x, *y, 0.0)));
    }
    for row in 1..ys.len() {
        for column in (1..xs.len()).filter(|column| !is_hole(column - 1, row - 1)) {
            let (below, above) = ((row - 1) * xs.len() + column, row * xs.len() + column);
            solid.faces.push(vec![below - 1, below, above, above - 1]);
        }
    }
    solid
}

/// Returns rings of points joined to a closed tube. Rings run counter-clockwise seen from the last
/// ring, and the ends are closed by flat faces unless their ring is one point.
fn through(rings: &[Vec<DVec3>]) -> Solid {
    let mut solid = Solid::default();
    let count = rings.first().map_or(0, Vec::len);
    for ring in rings {
        solid.points.extend(ring);
    }
    for ring in 1..rings.len() {
        for k in 0..count {
            let next = (k + 1) % count;
            let (below, above) = ((ring - 1) * count, ring * count);
            solid.faces.push(vec![below + k, below + next, above + next, above + k]);
        }
    }
    let last = (rings.len().max(1) - 1) * count;
    solid.faces.push((0..count).rev().collect());
    solid.faces.push((last..last + count).collect());
    solid
}

/// Returns a solid of revolution about +Y: radius and height of each ring, from the bottom up.
/// Its ends are closed by flat faces.
pub(crate) fn lathe(profile: &[[f64; 2]], sides: usize) -> Solid {
    let ring = |[radius, y]: [f64; 2]| {
        let point = |k: usize| {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / sides as f64).sin_cos();
            // Counter-clockwise seen from above.
            DVec3::new(radius * sin, y, radius * cos)
        };
        (0..sides).map(point).collect()
    };
    through(&profile.iter().map(|p| ring(*p)).collect::<Vec<_>>())
}

/// Returns [`lathe`] about +X instead of +Y: profiles run towards +X.
pub(crate) fn spun(profile: &[[f64; 2]], sides: usize) -> Solid {
    turned(lathe(profile, sides), DVec3::Y, DVec3::X)
}

/// Returns a solid turned on the shortest way that brings one unit vector to another.
pub(crate) fn turned(mut solid: Solid, from: DVec3, to: DVec3) -> Solid {
    let turn = DQuat::from_rotation_arc(from, to);
    for point in &mut solid.points {
        *point = turn * *point;
    }
    solid
}

/// Returns a tube along points, with a radius at each. Its ends are closed by flat faces.
pub(crate) fn tube(path: &[(DVec3, f64)], sides: usize) -> Solid {
    let mut rings = Vec::with_capacity(path.len());
    let mut side = DVec3::ZERO;
    for (index, (place, radius)) in path.iter().enumerate() {
        let before = path[index.saturating_sub(1)].0;
        let after = path[(index + 1).min(path.len() - 1)].0;
        let along = (after - before).normalize_or(DVec3::Y);
        // The side of the ring before, so that tubes do not twist.
        let start = if index == 0 { along.any_orthonormal_vector() } else { side };
        side = (start - along * start.dot(along)).normalize_or(along.any_orthonormal_vector());
        let up = along.cross(side);
        let point = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
            *place + (side * cos + up * sin) * *radius
        };
        rings.push((0..sides).map(point).collect());
    }
    through(&rings)
}

/// Returns an outline in the plane of x and y, extruded from `back` to `front` along +Z. Its ends
/// are closed. The outline may run either way.
pub(crate) fn extrude(outline: &[[f64; 2]], back: f64, front: f64) -> Solid {
    let outline = &counter_clockwise(outline);
    let ring = |z: f64| outline.iter().map(|[x, y]| DVec3::new(*x, *y, z)).collect();
    let mut solid = through(&[ring(back), ring(front)]);
    solid.faces.truncate(outline.len());
    let count = outline.len();
    for [a, b, c] in triangles(outline) {
        solid.faces.push(vec![c, b, a]);
        solid.faces.push([a, b, c].map(|p| p + count).to_vec());
    }
    solid
}

/// Returns an outline in the plane z = 0 as one flat surface that faces +Z. The outline may run
/// either way.
pub(crate) fn polygon(outline: &[[f64; 2]]) -> Solid {
    let outline = &counter_clockwise(outline);
    let points = outline.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect();
    Solid { points, faces: triangles(outline).iter().map(|t| t.to_vec()).collect() }
}

fn counter_clockwise(outline: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let next = outline.iter().cycle().skip(1);
    let area: f64 = outline.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let mut outline = outline.to_vec();
    if area < 0.0 {
        outline.reverse();
    }
    outline
}

/// Cuts an outline into triangles, ear by ear.
fn triangles(outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let at = |p: usize| DVec2::from(outline[p]);
    let turn = |a: usize, b: usize, c: usize| (at(b) - at(a)).perp_dot(at(c) - at(a));
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let mut cut = Vec::new();
    while left.len() > 3 {
        let count = left.len();
        let corners = |k: usize| [left[(k + count - 1) % count], left[k], left[(k + 1) % count]];
        let is_ear = |k: &usize| {
            let [a, b, c] = corners(*k);
            let inside =
                |p: usize| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            let others = left.iter().filter(|p| ![a, b, c].contains(p));
            turn(a, b, c) > 0.0 && !others.copied().any(inside)
        };
        // An outline that crosses itself has no ear.
        let ear = (0..count).find(is_ear).unwrap_or(0);
        cut.push(corners(ear));
        left.remove(ear);
    }
    if let [a, b, c] = left[..] {
        cut.push([a, b, c]);
    }
    cut
}

/// Returns a ball of 80 faces with the given radii, whose points are moved in and out by the
/// fractions that `offset` returns.
pub(crate) fn lump(middle: DVec3, radii: DVec3, mut offset: impl FnMut() -> f64) -> Solid {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut points: Vec<DVec3> = Vec::new();
    for (one, other) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let (short, long) = (one, other * golden);
        points.push(DVec3::new(0.0, short, long));
        points.push(DVec3::new(short, long, 0.0));
        points.push(DVec3::new(long, 0.0, short));
    }
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let near = |p: usize, q: usize| points[p].distance(points[q]) < 2.1;
                if near(a, b) && near(b, c) && near(c, a) {
                    let (u, v) = (points[b] - points[a], points[c] - points[a]);
                    let outward = u.cross(v).dot(points[a]) > 0.0;
                    faces.push(if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    let mut solid = Solid { points, faces: Vec::new() };
    let mut middles: Vec<([usize; 2], usize)> = Vec::new();
    for [a, b, c] in faces {
        let mut between = |p: usize, q: usize| {
            let key = [p.min(q), p.max(q)];
            if let Some((_, index)) = middles.iter().find(|(k, _)| *k == key) {
                return *index;
            }
            let index = solid.point(solid.points[p] + solid.points[q]);
            middles.push((key, index));
            index
        };
        let [ab, bc, ca] = [between(a, b), between(b, c), between(c, a)];
        for face in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            solid.faces.push(face.to_vec());
        }
    }
    for point in &mut solid.points {
        *point = middle + point.normalize() * radii * (1.0 + offset());
    }
    solid
}

/// Returns an outline of z and y, extruded along X. Its ends are closed.
pub(crate) fn along_x(outline: &[[f64; 2]], from: f64, to: f64) -> Solid {
    // The swap of x and z mirrors, which turns the winding of the faces.
    let swap = DAffine3::from_cols(DVec3::Z, DVec3::Y, DVec3::X, DVec3::ZERO);
    extrude(outline, from, to).moved(&swap)
}
