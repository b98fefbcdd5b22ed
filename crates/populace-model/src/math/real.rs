//! What the stages compute with: one `f32`, or several side by side.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or several that go through the same arithmetic: one for each of several joints.
///
/// The stages are written once for any `Real`, in `populace-native`, and once in OpenCL C, in the
/// same order of operations. They use no function beyond `+ - * /`, so that devices that round
/// quotients correctly agree bit for bit.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The answer of a comparison, for each number.
    type Choice: Copy;

    /// The same number everywhere.
    fn splat(value: f32) -> Self;

    /// Where `self` is below `other`.
    fn less(self, other: Self) -> Self::Choice;

    /// `a` where chosen, else `b`.
    fn choose(which: Self::Choice, a: Self, b: Self) -> Self;

    /// A first guess of `1 / sqrt(self)`, within 3.5%, from the bits: half the exponent, turned
    /// around.
    #[must_use]
    fn inverse_sqrt_guess(self) -> Self;

    /// `1 / sqrt(self)` within three units in the last place, by `+ - *` alone: a guess and three
    /// steps of Newton's method. Every device rounds it alike, and it costs a CPU less than a root
    /// and a quotient. `self` is positive and normal.
    #[inline(always)]
    #[must_use]
    fn inverse_sqrt(self) -> Self {
        let half = Self::splat(0.5) * self;
        let step = |y: Self| y * (Self::splat(1.5) - half * y * y);
        step(step(step(self.inverse_sqrt_guess())))
    }

    /// `self` at `t = 0`, moving towards `to` as `t` grows: `self + (to - self) * t`.
    #[inline(always)]
    #[must_use]
    fn mix(self, to: Self, t: Self) -> Self {
        self + (to - self) * t
    }
}

/// The magic number of [`Real::inverse_sqrt_guess`]: it halves and turns around the exponent's
/// bias, and balances the error.
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
    fn the_inverse_root_is_within_three_units_in_the_last_place() {
        let mut worst: f64 = 0.0;
        // A float for each of 100,000 steps over all exponents that squares of lengths can have.
        for bits in (1e-20f32.to_bits()..1e20f32.to_bits()).step_by(11_113) {
            let x = f32::from_bits(bits);
            let exact = 1.0 / f64::from(x).sqrt();
            let unit = exact * f64::from(f32::EPSILON);
            worst = worst.max((f64::from(x.inverse_sqrt()) - exact).abs() / unit);
        }
        assert!(worst < 3.0, "{worst}");
    }
}
