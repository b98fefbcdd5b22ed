//! Headings of people: from how they move, or from data.

use std::f64::consts::{PI, TAU};

use crate::smoothing::bell;

/// Widths in seconds over which the direction of motion is averaged: while walking, and while
/// barely moving.
const WALKS_SECS: f64 = 0.3;
const CREEPS_SECS: f64 = 1.2;
/// Speeds in metres per second up to which somebody barely moves, and from which on somebody walks.
const CREEPS_M_PER_SEC: f64 = 0.2;
const WALKS_M_PER_SEC: f64 = 0.6;
/// Below this mean speed in metres per second there is no direction: the heading is held.
const HOLDS_M_PER_SEC: f64 = 0.08;
/// The length of the mean of unit vectors from which on headings of data agree.
const AGREES: f64 = 0.6;
/// The length of such a mean from which on it points somewhere.
const POINTS: f64 = 0.2;
/// Time in seconds over which a turn is measured, and the length of the mean of such turns, as
/// unit vectors, from which on somebody turns steadily.
const TURN_SECS: f64 = 0.3;
const STEADY: f64 = 0.9;
/// Rate of a turn in radians per second below which the mean over a long time is near enough.
const STEADY_RATE: f64 = 0.25;
/// Width in seconds over which turns are spread.
const TURNS_SECS: f64 = 0.25;
/// The highest rate of turns in radians per second.
const TURN_RATE: f64 = 3.5;

/// Returns headings in radians, counter-clockwise from +x and not wrapped, for velocities on the
/// plan at even times. Headings are held while nobody moves.
pub(crate) fn of_motion(velocities: &[[f64; 2]], step_secs: f64) -> Vec<f64> {
    let near = bell(velocities, step_secs, WALKS_SECS);
    let wide = bell(velocities, step_secs, CREEPS_SECS);
    let directions = near.iter().zip(&wide).map(|(near, wide)| {
        let part = moves(*near);
        let along = [0, 1].map(|axis| part * near[axis] + (1.0 - part) * wide[axis]);
        (along[0].hypot(along[1]) > HOLDS_M_PER_SEC).then(|| along[1].atan2(along[0]))
    });
    settled(directions.collect(), step_secs)
}

/// Returns headings of data for velocities on the plan, without gaps and sudden turns. NaN is a gap.
/// Models turn people who wait in a queue to and fro: the less somebody moves, the longer the time
/// over which headings are averaged, and they are held where they disagree. Who turns steadily on the
/// spot is followed.
pub(crate) fn of_data(headings: &[f64], velocities: &[[f64; 2]], step_secs: f64) -> Vec<f64> {
    let given: Vec<[f64; 2]> = headings.iter().map(|heading| direction(*heading)).collect();
    let near = bell(velocities, step_secs, WALKS_SECS);
    let calm = calm(&given, step_secs);
    let settle = |(nth, heading): (usize, &f64)| {
        let moves = moves(near[nth]);
        if moves >= 1.0 {
            return heading.is_finite().then_some(*heading);
        }
        let [x, y] = [0, 1].map(|axis| moves * given[nth][axis] + (1.0 - moves) * calm[nth][axis]);
        (x.hypot(y) > AGREES).then(|| y.atan2(x))
    };
    settled(headings.iter().enumerate().map(settle).collect(), step_secs)
}

/// Returns the means of unit vectors over a long time, or over a short one where they turn steadily:
/// a whole turn has no mean.
fn calm(given: &[[f64; 2]], step_secs: f64) -> Vec<[f64; 2]> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few steps")]
    let half = (0.5 * TURN_SECS / step_secs).ceil() as usize;
    let last = given.len().saturating_sub(1);
    let turn = |nth: usize| {
        let ([a, b], [c, d]) = (given[nth.saturating_sub(half)], given[(nth + half).min(last)]);
        [a * c + b * d, a * d - b * c]
    };
    let turns: Vec<[f64; 2]> = (0..given.len()).map(turn).collect();
    let turns = bell(&turns, step_secs, CREEPS_SECS);
    let [wide, near] = [CREEPS_SECS, WALKS_SECS].map(|secs| bell(given, step_secs, secs));
    let turned = STEADY_RATE * 2.0 * half as f64 * step_secs;
    let is_turning = |nth: usize| {
        let [x, y] = turns[nth];
        x.hypot(y) > STEADY && y.atan2(x).abs() > turned
    };
    let one = |nth: usize| if is_turning(nth) { near[nth] } else { wide[nth] };
    (0..given.len()).map(one).collect()
}

/// Returns directions of view without gaps and sudden turns. NaN is a gap.
pub(crate) fn of_views(views: &[f64], step_secs: f64) -> Vec<f64> {
    settled(views.iter().map(|view| view.is_finite().then_some(*view)).collect(), step_secs)
}

/// Returns how much somebody moves: 0 who barely does, 1 who walks.
fn moves(velocity: [f64; 2]) -> f64 {
    let speed = velocity[0].hypot(velocity[1]);
    ((speed - CREEPS_M_PER_SEC) / (WALKS_M_PER_SEC - CREEPS_M_PER_SEC)).clamp(0.0, 1.0)
}

/// Returns the unit vector of a heading; zero for a gap.
fn direction(heading: f64) -> [f64; 2] {
    if heading.is_finite() { [heading.cos(), heading.sin()] } else { [0.0; 2] }
}

/// Fills gaps with the heading before, or with the first one; unwraps, and turns no faster than
/// people do.
fn settled(headings: Vec<Option<f64>>, step_secs: f64) -> Vec<f64> {
    let mut last = headings.iter().flatten().next().copied().unwrap_or(0.0);
    let filled: Vec<f64> = headings
        .into_iter()
        .map(|heading| {
            last = heading.unwrap_or(last);
            last
        })
        .collect();
    // Unwrapped by where they point on average: somebody whose headings go round in a moment has
    // not turned round.
    let given: Vec<[f64; 2]> = filled.iter().map(|heading| direction(*heading)).collect();
    let mut mean = filled.first().copied().unwrap_or(0.0);
    let unwrapped: Vec<[f64; 2]> = filled
        .iter()
        .zip(bell(&given, step_secs, TURNS_SECS))
        .map(|(heading, [x, y])| {
            mean += if x.hypot(y) > POINTS { wrapped(y.atan2(x) - mean) } else { 0.0 };
            [mean + wrapped(heading - mean), 0.0]
        })
        .collect();
    let mut smooth: Vec<f64> =
        bell(&unwrapped, step_secs, TURNS_SECS).into_iter().map(|[heading, _]| heading).collect();
    // From both ends, so that half of a turn that is too fast comes before it.
    let forwards = limited(smooth.iter().copied(), step_secs);
    let mut backwards = limited(smooth.iter().rev().copied(), step_secs);
    backwards.reverse();
    for (heading, (a, b)) in smooth.iter_mut().zip(forwards.into_iter().zip(backwards)) {
        *heading = f64::midpoint(a, a + nearest(b - a));
    }
    // Where the two turn round different ways.
    limited(smooth.into_iter(), step_secs)
}

/// Turns no faster than people do, the nearer way round: nobody spins to catch up with headings
/// that have gone round.
fn limited(headings: impl Iterator<Item = f64>, step_secs: f64) -> Vec<f64> {
    let most = TURN_RATE * step_secs;
    let mut last = None;
    headings
        .map(|wanted| {
            let heading =
                last.map_or(wanted, |last: f64| last + nearest(wanted - last).clamp(-most, most));
            last = Some(heading);
            heading
        })
        .collect()
}

/// Returns the shorter of the two ways to turn by an angle.
fn nearest(angle: f64) -> f64 {
    if angle.abs() <= PI { angle } else { wrapped(angle) }
}

/// Returns the angle from -pi to pi that is the same turn.
fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_SECS: f64 = 0.04;

    /// Returns velocities that last for a number of rows each.
    fn rows(parts: &[([f64; 2], usize)]) -> Vec<[f64; 2]> {
        parts.iter().flat_map(|(velocity, count)| vec![*velocity; *count]).collect()
    }

    #[test]
    fn the_heading_is_that_of_motion_and_is_held_while_standing() {
        let headings =
            of_motion(&rows(&[([0.0, 1.2], 100), ([0.0, 0.0], 200), ([1.2, 0.0], 100)]), STEP_SECS);
        assert!((headings[50] - PI / 2.0).abs() < 0.01, "{}", headings[50]);
        assert!((headings[200] - PI / 2.0).abs() < 0.05, "{}", headings[200]);
        assert!(headings[380].abs() < 0.01, "{}", headings[380]);
    }

    #[test]
    fn nobody_who_creeps_spins() {
        // Four centimetres to and fro at half a metre per second at most.
        let sway: Vec<[f64; 2]> =
            (0..400).map(|nth| [0.15, 0.4 * (f64::from(nth) * 0.2).sin()]).collect();
        let headings = of_motion(&sway, STEP_SECS);
        assert!(headings.iter().all(|heading| heading.abs() < 1.0), "{headings:.2?}");
    }

    #[test]
    fn turns_are_no_faster_than_peoples() {
        let headings = of_motion(&rows(&[([1.0, 0.0], 100), ([-1.0, 0.01], 100)]), STEP_SECS);
        let fastest = headings
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs() / STEP_SECS)
            .fold(0.0, f64::max);
        assert!(fastest <= TURN_RATE + 1e-6, "{fastest}");
        assert!((wrapped(headings[199]).abs() - PI).abs() < 0.05, "{}", headings[199]);
    }

    #[test]
    fn nobody_spins_after_headings_that_went_round() {
        // Somebody in a queue turns round within a third of a second, and then walks on.
        let round = (0..8).map(|nth| 0.8 * f64::from(nth));
        let given: Vec<f64> = [vec![0.0; 50], round.collect(), vec![0.1; 100]]
            .concat()
            .into_iter()
            .map(wrapped)
            .collect();
        let headings = of_data(&given, &vec![[1.0, 0.0]; given.len()], STEP_SECS);
        let turned: f64 = headings.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        assert!(turned < 0.6 * TAU, "{turned}");
        assert!(wrapped(headings[75] - 0.1).abs() < 0.1, "{}", headings[75]);
    }

    #[test]
    fn nobody_who_waits_turns_with_noise_and_who_turns_does() {
        let still = vec![[0.0; 2]; 300];
        // To and fro by a right angle, three times a second.
        let noise: Vec<f64> =
            (0..300).map(|nth| (f64::from(nth) * 0.75).sin() * 1.6 + 0.4).collect();
        let headings = of_data(&noise, &still, STEP_SECS);
        let far = headings.iter().map(|heading| (heading - headings[0]).abs()).fold(0.0, f64::max);
        assert!(far < 0.5, "{far}");
        let turns: Vec<f64> = (0..300).map(|nth| if nth < 150 { 0.0 } else { 1.8 }).collect();
        let headings = of_data(&turns, &still, STEP_SECS);
        assert!(headings[90].abs() < 0.05 && (headings[210] - 1.8).abs() < 0.05, "{headings:?}");
    }

    #[test]
    fn who_turns_steadily_on_the_spot_is_followed() {
        let still = vec![[0.0; 2]; 300];
        for rate in [0.3, 1.0, -1.5, 3.0] {
            let given: Vec<f64> =
                (0..300).map(|nth| 1.0 + rate * STEP_SECS * f64::from(nth)).map(wrapped).collect();
            let headings = of_data(&given, &still, STEP_SECS);
            let off = |nth: usize| wrapped(headings[nth] - given[nth]).abs();
            let most = (75..225).map(off).fold(0.0, f64::max);
            // There is no time before the first row to look at.
            assert!(most < 0.1 && off(0) < 0.2 + 0.35 * rate.abs(), "{rate} rad/s: {most} rad off");
        }
        // To and fro within 3 s is no turn.
        let sway: Vec<f64> = (0..300).map(|nth| 1.6 * (f64::from(nth) * 0.084).sin()).collect();
        let headings = of_data(&sway, &still, STEP_SECS);
        let far = headings.iter().map(|heading| (heading - headings[0]).abs()).fold(0.0, f64::max);
        assert!(far < 0.8, "{far}");
    }

    #[test]
    fn data_may_wrap_and_have_gaps() {
        let given = [3.1, f64::NAN, -3.1, -3.05, f64::NAN].map(|heading| [heading; 30]).concat();
        let headings = of_data(&given, &vec![[1.0, 0.0]; given.len()], STEP_SECS);
        assert!(headings.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.1), "{headings:?}");
        assert!((headings[149] - (2.0 * PI - 3.05)).abs() < 0.01, "{}", headings[149]);
        assert_eq!(of_data(&[f64::NAN; 3], &[[0.0; 2]; 3], STEP_SECS), [0.0; 3]);
    }
}
