//! Points and triangles.

pub(crate) type Point = [f64; 3];

pub(crate) fn difference(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the distance from a point to a triangle (C. Ericson, Real-Time Collision Detection
/// (2005), 5.1.5).
pub(crate) fn distance_to_triangle(p: Point, [a, b, c]: [Point; 3]) -> f64 {
    let (ab, ac, ap) = (difference(b, a), difference(c, a), difference(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    let far = |q: Point| dot(difference(p, q), difference(p, q)).sqrt();
    let along = |from: Point, by: Point, k: f64| [0, 1, 2].map(|i: usize| from[i] + by[i] * k);
    if d1 <= 0.0 && d2 <= 0.0 {
        return far(a);
    }
    let bp = difference(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return far(b);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return far(along(a, ab, d1 / (d1 - d3)));
    }
    let cp = difference(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return far(c);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return far(along(a, ac, d2 / (d2 - d6)));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return far(along(b, difference(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    let k = 1.0 / (va + vb + vc);
    far(along(along(a, ab, vb * k), ac, vc * k))
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns a vector out of the front of a triangle.
pub(crate) fn normal([a, b, c]: [Point; 3]) -> Point {
    cross(difference(b, a), difference(c, a))
}

/// Returns the distance along a ray to the plane of a triangle, if the ray meets the triangle there.
pub(crate) fn crossing(from: Point, along: Point, corners: [Point; 3]) -> Option<f64> {
    let out = normal(corners);
    let distance = dot(difference(corners[0], from), out) / dot(along, out);
    let at = [0, 1, 2].map(|i: usize| from[i] + along[i] * distance);
    let [a, b, c] = corners;
    let inside = |p, q| dot(cross(difference(q, p), difference(at, p)), out) >= 0.0;
    (distance > 0.0 && inside(a, b) && inside(b, c) && inside(c, a)).then_some(distance)
}
