//! Error bounds by Monte Carlo arithmetic: the oracle runs again and again with the rounding errors
//! of single precision drawn at random (Parker, "Monte Carlo Arithmetic: exploiting randomness in
//! floating-point arithmetic", UCLA CSD-970002, 1997).
//!
//! It gives the error of calculations whose sensitivity has no short formula, such as inverse
//! kinematics near a straight limb.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::Rng;
use crate::tolerance::UNIT;

/// The largest error of one operation, relative to its result. An operation here stands for up to 16
/// roundings of a device: normalising alone takes 14 ([`rotation_rounding`]).
///
/// [`rotation_rounding`]: crate::tolerance::rotation_rounding
const OPERATION: f64 = 16.0 * UNIT;
/// Runs per bound.
const RUNS: u64 = 24;
/// The factor from the largest deviation of all runs to the bound. In 24 runs the largest deviation
/// of a sum of uniform errors lies above 1.5 standard deviations except in one of 40 thousand
/// results, so the bound is at least 4.5 of them.
const MARGIN: f64 = 3.0;

/// A source of rounding errors.
pub struct Noise {
    rng: Rng,
    size: f64,
}

impl Noise {
    /// No errors.
    pub(crate) fn none() -> Self {
        Self { rng: Rng::new(0), size: 0.0 }
    }

    fn of_run(run: u64) -> Self {
        Self { rng: Rng::new(0x0015_e000 + run), size: OPERATION }
    }

    fn signed(&mut self) -> f64 {
        if self.size == 0.0 { 0.0 } else { self.rng.between(-self.size, self.size) }
    }

    /// Returns a number off by up to an operation's error.
    pub(crate) fn number(&mut self, v: f64) -> f64 {
        v + v * self.signed()
    }

    /// Returns a number off by up to an operation's error of a number of size `scale`.
    pub(crate) fn near(&mut self, v: f64, scale: f64) -> f64 {
        v + scale * self.signed()
    }

    /// Returns a vector whose components are each off by up to an operation's error of its length.
    pub(crate) fn vector(&mut self, v: DVec3) -> DVec3 {
        self.sized(v, v.length())
    }

    /// Returns a vector that is the difference of vectors of length `size`, and rounds as they do.
    pub(crate) fn sized(&mut self, v: DVec3, size: f64) -> DVec3 {
        v + DVec3::new(self.signed(), self.signed(), self.signed()) * size
    }

    /// Returns a unit quaternion with errors.
    pub(crate) fn rotation(&mut self, q: DQuat) -> DQuat {
        self.rotation_by(q, 1.0)
    }

    /// Returns a unit quaternion with errors that have grown by a factor.
    pub(crate) fn rotation_by(&mut self, q: DQuat, factor: f64) -> DQuat {
        let off = q.to_array().map(|v| v + factor * self.signed());
        if self.size == 0.0 { q } else { DQuat::from_array(off).normalize() }
    }

    /// Returns a matrix with errors relative to the length of each column.
    pub(crate) fn matrix(&mut self, m: DMat3) -> DMat3 {
        DMat3::from_cols(self.vector(m.x_axis), self.vector(m.y_axis), self.vector(m.z_axis))
    }

    /// Returns the product of two transforms with errors. Elements of a product round relative to
    /// the columns' lengths before they cancel.
    pub(crate) fn product(&mut self, a: &DAffine3, b: &DAffine3) -> DAffine3 {
        let column = |noise: &mut Self, b: DVec3| {
            let parts = [a.matrix3.x_axis * b.x, a.matrix3.y_axis * b.y, a.matrix3.z_axis * b.z];
            parts.into_iter().map(|part| noise.vector(part)).sum::<DVec3>()
        };
        let matrix3 = DMat3::from_cols(
            column(self, b.matrix3.x_axis),
            column(self, b.matrix3.y_axis),
            column(self, b.matrix3.z_axis),
        );
        let moved = column(self, b.translation);
        let sum = moved + a.translation;
        DAffine3 { matrix3, translation: sum + self.vector(a.translation) - a.translation }
    }
}

/// A result and the largest error that a device may have in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The result without errors.
    pub value: f64,
    /// The largest error. It is infinite where the result jumps within reach of rounding errors.
    pub bound: f64,
}

/// Returns the numbers that `run` calculates without errors, each with its bound. A number that no
/// run changes has the bound 0: a device must return it exactly.
///
/// # Panics
///
/// If `run` returns lists of different lengths.
#[must_use]
pub fn bounded(run: impl Fn(&mut Noise) -> Vec<f64>) -> Vec<Bounded> {
    let mut results: Vec<Bounded> =
        run(&mut Noise::none()).into_iter().map(|value| Bounded { value, bound: 0.0 }).collect();
    for nth in 0..RUNS {
        let noisy = run(&mut Noise::of_run(nth));
        assert_eq!(noisy.len(), results.len(), "every run gives the same numbers");
        for (result, noisy) in results.iter_mut().zip(noisy) {
            let off = (noisy - result.value).abs();
            result.bound = if off.is_nan() { f64::INFINITY } else { result.bound.max(off) };
        }
    }
    for result in results.iter_mut().filter(|result| result.bound > 0.0) {
        result.bound = MARGIN * result.bound + 2.0 * UNIT * result.value.abs();
    }
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_follow_the_sensitivity() {
        let exact = bounded(|_| vec![2.0]);
        assert_eq!(exact, [Bounded { value: 2.0, bound: 0.0 }]);
        // The cosine of a small angle loses half of its digits when it is turned back.
        let angle = |noise: &mut Noise| vec![noise.number(1e-3f64.cos()).min(1.0).acos()];
        let [angle] = bounded(angle)[..] else { panic!("one number") };
        assert!(angle.bound > 1e3 * OPERATION * 1e-3, "{angle:?}");
        let product = bounded(|noise| vec![noise.number(3.0) * noise.number(5.0)]);
        assert!((2.0..8.0).contains(&(product[0].bound / (15.0 * OPERATION))), "{product:?}");
    }
}
