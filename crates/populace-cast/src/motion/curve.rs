//! Periodic curves through given values.

/// Values over a cycle: (phase from 0 to below 1, value), phases increasing.
pub(super) type Knots = [(f64, f64)];

/// The cubics through the knots, with period 1. The slope at a knot is the harmonic mean of the
/// rises on its two sides, at most twice either, so no cubic overshoots its knots (Fritsch &
/// Carlson, "Monotone piecewise cubic interpolation", SIAM J. Numer. Anal. 17, 1980: slopes within
/// a circle of three times the rise suffice).
pub(super) fn at(knots: &Knots, phase: f64) -> f64 {
    let phase = phase.rem_euclid(1.0);
    let count = knots.len();
    let knot = |i: isize| {
        let turns = i.div_euclid(count as isize);
        let (x, y) = knots[i.rem_euclid(count as isize) as usize];
        (x + turns as f64, y)
    };
    let after = knots.iter().position(|(x, _)| *x > phase).unwrap_or(count) as isize;
    let around = [after - 2, after - 1, after, after + 1].map(knot);
    let rise = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
    let slope = |before: f64, next: f64| {
        if before * next <= 0.0 { 0.0 } else { 2.0 * before * next / (before + next) }
    };
    let rises = [0, 1, 2].map(|i| rise(around[i], around[i + 1]));
    let (from, to) = (around[1], around[2]);
    let width = to.0 - from.0;
    let (start, end) = (slope(rises[0], rises[1]) * width, slope(rises[1], rises[2]) * width);
    hermite((phase - from.0) / width, [from.1, to.1], [start, end])
}

/// A cubic from one value to another over t from 0 to 1, with these slopes at its ends.
pub(super) fn hermite(t: f64, [from, to]: [f64; 2], [start, end]: [f64; 2]) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + to * (3.0 * t2 - 2.0 * t3)
        + start * (t3 - 2.0 * t2 + t)
        + end * (t3 - t2)
}
