//! Points and rings on the plan.

/// A point of the plan in metres.
pub(super) type Point = [f64; 2];
/// A closed ring of points; the last is joined to the first.
pub(super) type Ring = Vec<Point>;

/// Returns the angle by which a way turns to the left at `b`, in radians.
pub(super) fn turn(a: Point, b: Point, c: Point) -> f64 {
    let (p, q) = (minus(b, a), minus(c, b));
    cross(p, q).atan2(dot(p, q))
}

/// Returns true if a point is inside of a ring: a line from it crosses the ring an odd number of
/// times.
pub(crate) fn is_inside(ring: &[Point], at: Point) -> bool {
    let next = ring.iter().cycle().skip(1);
    let crosses = |(a, b): &(&Point, &Point)| {
        (a[1] > at[1]) != (b[1] > at[1])
            && at[0] < a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    ring.iter().zip(next).filter(crosses).count() % 2 == 1
}

/// Returns the area of a ring in square metres, positive if it runs counter-clockwise.
pub(super) fn area(ring: &[Point]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    0.5 * ring.iter().zip(next).map(|(a, b)| cross(*a, *b)).sum::<f64>()
}

/// Returns the length of a ring in metres.
pub(super) fn perimeter(ring: &[Point]) -> f64 {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| length(minus(*b, *a))).sum()
}

pub(super) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn plus(a: Point, b: Point, times: f64) -> Point {
    [a[0] + times * b[0], a[1] + times * b[1]]
}

pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}
