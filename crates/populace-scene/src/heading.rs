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
        let speed = near[0].hypot(near[1]);
        let part = (speed - CREEPS_M_PER_SEC) / (WALKS_M_PER_SEC - CREEPS_M_PER_SEC);
        let part = part.clamp(0.0, 1.0);
        let along = [0, 1].map(|axis| part * near[axis] + (1.0 - part) * wide[axis]);
        (along[0].hypot(along[1]) > HOLDS_M_PER_SEC).then(|| along[1].atan2(along[0]))
    });
    settled(directions.collect(), step_secs)
}

/// Returns headings without gaps and sudden turns for those that data give; NaN where they give
/// none.
pub(crate) fn of_data(headings: &[f64], step_secs: f64) -> Vec<f64> {
    settled(
        headings.iter().map(|heading| heading.is_finite().then_some(*heading)).collect(),
        step_secs,
    )
}

/// Fills gaps with the heading before, or with the first one; unwraps, and turns no faster than
/// people do.
fn settled(headings: Vec<Option<f64>>, step_secs: f64) -> Vec<f64> {
    let mut last = headings.iter().flatten().next().copied().unwrap_or(0.0);
    let unwrapped: Vec<[f64; 2]> = headings
        .into_iter()
        .map(|heading| {
            last += heading.map_or(0.0, |heading| wrapped(heading - last));
            [last, 0.0]
        })
        .collect();
    let mut smooth: Vec<f64> =
        bell(&unwrapped, step_secs, TURNS_SECS).into_iter().map(|[heading, _]| heading).collect();
    // From both ends, so that half of a turn that is too fast comes before it.
    let forwards = limited(smooth.iter().copied(), step_secs);
    let mut backwards = limited(smooth.iter().rev().copied(), step_secs);
    backwards.reverse();
    for (heading, (a, b)) in smooth.iter_mut().zip(forwards.into_iter().zip(backwards)) {
        *heading = f64::midpoint(a, b);
    }
    smooth
}

fn limited(headings: impl Iterator<Item = f64>, step_secs: f64) -> Vec<f64> {
    let most = TURN_RATE * step_secs;
    let mut last = None;
    headings
        .map(|wanted| {
            let heading =
                last.map_or(wanted, |last: f64| last + (wanted - last).clamp(-most, most));
            last = Some(heading);
            heading
        })
        .collect()
}

/// Returns the angle from -pi to pi that is the same turn.
fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}
