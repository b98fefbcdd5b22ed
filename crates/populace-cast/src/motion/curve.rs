//! Monotone interpolation, periodic and not.

/// Knots of one cycle: (phase, value). Phases increase and are in [0, 1).
pub(super) type Knots = [(f64, f64)];

/// Evaluates the piecewise cubic of period 1 through `knots`. The slope at a knot is the harmonic
/// mean of the secant slopes on both sides, and 0 at an extremum. It is at most twice either secant
/// slope, so that no cubic overshoots its knots (Fritsch & Carlson, "Monotone piecewise cubic
/// interpolation", SIAM J. Numer. Anal. 17, 1980: slopes within a circle of three times the secant
/// slope suffice).
pub(super) fn at(knots: &Knots, phase: f64) -> f64 {
    let phase = phase.rem_euclid(1.0);
    let count = knots.len();
    let knot = |i: isize| {
        let cycles = i.div_euclid(count as isize);
        let (x, y) = knots[i.rem_euclid(count as isize) as usize];
        (x + cycles as f64, y)
    };
    let after = knots.iter().position(|(x, _)| *x > phase).unwrap_or(count) as isize;
    let around = [after - 2, after - 1, after, after + 1].map(knot);
    let secant = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
    let slope = |before: f64, next: f64| {
        if before * next <= 0.0 { 0.0 } else { 2.0 * before * next / (before + next) }
    };
    let secants = [0, 1, 2].map(|i| secant(around[i], around[i + 1]));
    let (from, to) = (around[1], around[2]);
    let width = to.0 - from.0;
    let (start, end) =
        (slope(secants[0], secants[1]) * width, slope(secants[1], secants[2]) * width);
    hermite((phase - from.0) / width, [from.1, to.1], [start, end])
}

/// Evaluates the piecewise cubic through `knots`, which is flat before the first and after the
/// last. Slopes are those of [`at`].
pub(super) fn through(knots: &Knots, x: f64) -> f64 {
    let last = knots.len() - 1;
    let from = knots.iter().rposition(|knot| knot.0 <= x);
    let Some(from) = from else { return knots[0].1 };
    if from == last {
        return knots[last].1;
    }
    let secant = |a: usize, b: usize| {
        let ((x0, y0), (x1, y1)) = (knots[a], knots[b]);
        if x1 > x0 { (y1 - y0) / (x1 - x0) } else { 0.0 }
    };
    let slope = |before: f64, next: f64| {
        if before * next <= 0.0 { 0.0 } else { 2.0 * before * next / (before + next) }
    };
    let own = secant(from, from + 1);
    let before = secant(from.saturating_sub(1), from);
    let next = secant(from + 1, (from + 2).min(last));
    let width = knots[from + 1].0 - knots[from].0;
    let slopes = [slope(before, own) * width, slope(own, next) * width];
    hermite((x - knots[from].0) / width, [knots[from].1, knots[from + 1].1], slopes)
}

/// Evaluates the cubic Hermite curve from `from` (t = 0) to `to` (t = 1) with the slopes `start`
/// and `end`.
pub(super) fn hermite(t: f64, [from, to]: [f64; 2], [start, end]: [f64; 2]) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + to * (3.0 * t2 - 2.0 * t3)
        + start * (t3 - 2.0 * t2 + t)
        + end * (t3 - t2)
}
