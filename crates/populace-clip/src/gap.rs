//! The gap between two rows: the deviation of interpolated rows from the curves, and subdivision
//! into more rows.

use glam::DQuat;
use populace_model::{Interpolation, JointIndex, Property, Skeleton, f64math};

use crate::curves::{Curves, Local, Side};
use crate::probes::{Reach, distance_at_probes};
use crate::row::{Motion, Row};

/// Number of intervals of a gap at whose ends the error is measured.
const MEASURED: u32 = 8;

/// Context for measuring and filling the gap between two rows.
pub(crate) struct Gap<'a> {
    pub(crate) motion: &'a dyn Motion,
    pub(crate) skeleton: &'a Skeleton,
    pub(crate) probes: &'a [f64],
    pub(crate) reach: &'a Reach<'a>,
    pub(crate) allowed: f64,
    /// Maximum number of rows of the clip.
    pub(crate) most: usize,
}

impl Gap<'_> {
    /// Pushes `from` and the rows that are needed between it and `to`, but not `to`. Returns the
    /// error bound that is kept.
    pub(crate) fn fill(&self, from: Row, to: &Row, halvings: u32, rows: &mut Vec<Row>) -> f64 {
        let middle = from.secs + (to.secs - from.secs) / 2.0;
        let can_divide =
            halvings > 0 && rows.len() < self.most && middle > from.secs && middle < to.secs;
        // If the gap can be divided, it is enough to know that the error is too large.
        let enough = if can_divide { self.allowed } else { f64::INFINITY };
        let mut bound = self.error_bound(&from, to, enough);
        if bound > self.allowed && from.secs < to.secs {
            // The bound is cheap, but often far too high.
            bound = bound.min(self.measured_error(&from, to, enough));
        }
        if bound <= self.allowed || !can_divide {
            rows.push(from);
            return bound;
        }
        let middle = Row::new(self.motion, middle, Side::After);
        let first = self.fill(from, &middle, halvings - 1, rows);
        first.max(self.fill(middle, to, halvings - 1, rows))
    }

    /// Returns an upper bound of the deviation of any probe between two rows. Each joint's own
    /// deviation moves its descendants by at most its angle times reach, and deviations add up
    /// along the chain. Infinite as soon as it exceeds `enough`.
    fn error_bound(&self, from: &Row, to: &Row, enough: f64) -> f64 {
        let reach = self.reach.over(&[&from.pose, &to.pose]);
        let mut totals = Vec::with_capacity(reach.len());
        let mut worst: f64 = 0.0;
        for joint in self.skeleton.joints() {
            let above = self.skeleton.parent(joint).map_or(0.0, |p: JointIndex| totals[p.index()]);
            let own = self.motion.deviation(joint, [from, to], reach[joint.index()]);
            let total = above + own;
            worst = worst.max(total);
            if worst > enough {
                return f64::INFINITY;
            }
            totals.push(total);
        }
        worst
    }

    /// Returns the error at sampled times between two rows, plus a tenth for the times in between.
    /// Stops at the first time at which the error exceeds `enough`.
    fn measured_error(&self, from: &Row, to: &Row, enough: f64) -> f64 {
        let parents = self.skeleton.parents();
        let mut worst: f64 = 0.0;
        for place in 1..MEASURED {
            let u = f64::from(place) / f64::from(MEASURED);
            let secs = f64::from(from.secs) + (f64::from(to.secs) - f64::from(from.secs)) * u;
            let exact = self.motion.pose(secs, Side::After);
            let exact = f64math::model_from_joints(parents, exact.iter().map(Local::affine));
            let stored = from.pose.iter().zip(&to.pose).map(|(a, b)| a.mix(b, u).affine());
            let stored = f64math::model_from_joints(parents, stored);
            for ((a, b), &probe) in exact.iter().zip(&stored).zip(self.probes) {
                worst = worst.max(1.1 * distance_at_probes(a, b, probe));
            }
            if worst > enough {
                break;
            }
        }
        worst
    }
}

impl Motion for Curves<'_> {
    fn pose(&self, secs: f64, side: Side) -> Vec<Local> {
        self.joints().map(|joint| self.local(joint, secs, side)).collect()
    }

    fn deviation(&self, joint: JointIndex, [from, to]: [&Row; 2], reach: f64) -> f64 {
        let (a, b) = (&from.pose[joint.index()], &to.pose[joint.index()]);
        let kind = |property| self.track(joint, property).map(|track| track.interpolation);
        let cubic = Property::ALL.iter().any(|&p| kind(p) == Some(Interpolation::CubicSpline));
        if cubic {
            return self.sampled_deviation(joint, [from, to], reach);
        }
        if kind(Property::Rotation) == Some(Interpolation::Linear) {
            return nlerp_error_rad(a.rotation, b.rotation) * reach;
        }
        0.0
    }
}

impl Curves<'_> {
    /// A spline minus a straight line is a cubic that is 0 at both ends. Its maximum is at most 1.1
    /// times the largest of seven evenly spaced samples.
    fn sampled_deviation(&self, joint: JointIndex, [from, to]: [&Row; 2], reach: f64) -> f64 {
        let (a, b) = (&from.pose[joint.index()], &to.pose[joint.index()]);
        let worst = (1..MEASURED).map(|point| {
            let u = f64::from(point) / f64::from(MEASURED);
            let secs = f64::from(from.secs) + (f64::from(to.secs) - f64::from(from.secs)) * u;
            let exact = self.local(joint, secs, Side::After);
            let stored = a.mix(b, u);
            exact.rotation.angle_between(stored.rotation) * reach
                + exact.translation.distance(stored.translation)
                + (exact.scale - stored.scale).abs().max_element() * reach
        });
        1.1 * worst.fold(0.0, f64::max)
    }
}

/// Returns the largest angle between slerp and normalised linear interpolation of two rotations. It
/// is taken at 0.2113 of the way (1/2 - 1/sqrt(12), where their series first differ most), with 2%
/// added because the location shifts for larger angles.
fn nlerp_error_rad(a: DQuat, b: DQuat) -> f64 {
    let cos = a.dot(b).abs().min(1.0);
    let (half_angle, sin) = (cos.acos(), (1.0 - cos * cos).sqrt());
    let u = 0.211_324_865;
    let nlerp = (u * sin).atan2(1.0 - u + u * cos);
    1.02 * 2.0 * (u * half_angle - nlerp).abs()
}
