//! The number type of the stages: one `f32`, or several lanes.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or several lanes that go through the same arithmetic, such as one per joint.
///
/// The stages are written once for any `Real`, in `populace-native`, and once in OpenCL C, in the
/// same order of operations. They use only `+ - * /`, so that devices that round quotients
/// correctly agree bit for bit.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Result of a comparison, for each lane.
    type Choice: Copy;

    /// Sets all lanes to the same number.
    fn splat(value: f32) -> Self;

    /// Returns for each lane whether `self` is below `other`.
    fn less(self, other: Self) -> Self::Choice;

    /// Returns for each lane whether `self` is below `other` or equal to it.
    fn at_most(self, other: Self) -> Self::Choice;

    /// Returns `a` for lanes where `which` is true, else `b`.
    fn choose(which: Self::Choice, a: Self, b: Self) -> Self;

    /// Returns an estimate of `1 / sqrt(self)` from the bits, by halving and negating the exponent;
    /// within 3.5%.
    #[must_use]
    fn inverse_sqrt_guess(self) -> Self;

    /// Returns `1 / sqrt(self)` within three units in the last place, with `+ - *` only: an
    /// estimate and three steps of Newton's method. Every device rounds it the same, and a CPU
    /// computes it faster than a root and a quotient. `self` must be positive and normal.
    #[inline(always)]
    #[must_use]
    fn inverse_sqrt(self) -> Self {
        // Closures are not always inlined, and so not compiled for the caller's registers.
        let (half, most) = (Self::splat(0.5) * self, Self::splat(1.5));
        let guess = self.inverse_sqrt_guess();
        let once = guess * (most - half * guess * guess);
        let twice = once * (most - half * once * once);
        twice * (most - half * twice * twice)
    }

    /// Returns the absolute value.
    #[inline(always)]
    #[must_use]
    fn abs(self) -> Self {
        // The sum turns -0 into 0.
        Self::choose(self.less(Self::splat(0.0)), -self, self) + Self::splat(0.0)
    }

    /// Returns the lanes that are chosen by both.
    #[inline(always)]
    #[must_use]
    fn both(a: Self::Choice, b: Self::Choice) -> Self::Choice {
        let (zero, one) = (Self::splat(0.0), Self::splat(1.0));
        zero.less(Self::choose(a, Self::choose(b, one, zero), zero))
    }

    /// Returns the lanes that are chosen by either.
    #[inline(always)]
    #[must_use]
    fn either(a: Self::Choice, b: Self::Choice) -> Self::Choice {
        let (zero, one) = (Self::splat(0.0), Self::splat(1.0));
        zero.less(Self::choose(a, one, Self::choose(b, one, zero)))
    }

    /// Returns the lanes that are not chosen.
    #[inline(always)]
    #[must_use]
    fn others(which: Self::Choice) -> Self::Choice {
        let (zero, one) = (Self::splat(0.0), Self::splat(1.0));
        zero.less(Self::choose(which, zero, one))
    }

    /// Interpolates linearly: `self + (to - self) * t`.
    #[inline(always)]
    #[must_use]
    fn mix(self, to: Self, t: Self) -> Self {
        self + (to - self) * t
    }
}

/// The magic number of [`Real::inverse_sqrt_guess`]: it corrects the exponent's bias and balances
/// the error.
pub const INVERSE_SQRT_BITS: u32 = 0x5f37_59df;

impl Real for f32 {
    type Choice = bool;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn choose(which: bool, a: Self, b: Self) -> Self {
        if which { a } else { b }
    }

    #[inline(always)]
    fn inverse_sqrt_guess(self) -> Self {
        Self::from_bits(INVERSE_SQRT_BITS.wrapping_sub(self.to_bits() >> 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_sqrt_is_within_three_units_in_the_last_place() {
        let mut worst: f64 = 0.0;
        // Every 11,113th float over all exponents that squared lengths can have.
        for bits in (1e-20f32.to_bits()..1e20f32.to_bits()).step_by(11_113) {
            let x = f32::from_bits(bits);
            let exact = 1.0 / f64::from(x).sqrt();
            let unit = exact * f64::from(f32::EPSILON);
            worst = worst.max((f64::from(x.inverse_sqrt()) - exact).abs() / unit);
        }
        assert!(worst < 3.0, "{worst}");
    }
}
