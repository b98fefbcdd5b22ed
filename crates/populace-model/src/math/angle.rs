//! Angles computed with `+ - * /` only, so that every device rounds them the same; twin of
//! `kernels/angle.cl`.

use super::Real;

/// Half a turn in radians.
pub const HALF_TURN: f32 = std::f32::consts::PI;
/// A quarter of a turn.
const QUARTER: f32 = std::f32::consts::FRAC_PI_2;

/// Returns the angle from +X towards +Y of a vector in the plane, from -pi to pi, within 1e-6; 0
/// for a vector of length 0. With `atan(a) = atan(1/2) + atan((a - 1/2) / (1 + a/2))` the series is
/// evaluated for arguments of at most a third.
#[inline(always)]
#[must_use]
pub fn of<R: Real>(y: R, x: R) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let (across, along) = (y.abs(), x.abs());
    let steep = along.less(across);
    let (low, high) = (R::choose(steep, along, across), R::choose(steep, across, along));
    let ratio = low / high;
    let far = R::splat(0.25).less(ratio);
    let half = R::splat(0.5);
    let a = R::choose(far, (ratio - half) / (one + half * ratio), ratio);
    let s = a * a;
    let series = polynomial(s, [1.0, -1.0 / 3.0, 0.2, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0]);
    let near = a * series + R::choose(far, R::splat(0.463_647_6), zero);
    let upper = R::choose(steep, R::splat(QUARTER) - near, near);
    let right = R::choose(x.less(zero), R::splat(HALF_TURN) - upper, upper);
    let angle = R::choose(y.less(zero), -right, right);
    R::choose(high.less(R::splat(1e-20)), zero, angle)
}

/// Returns sine and cosine of an angle from -pi to pi, within 1e-6.
#[inline(always)]
#[must_use]
pub fn sin_cos<R: Real>(angle: R) -> (R, R) {
    // With half the angle the arguments of the series are at most a quarter turn.
    let x = R::splat(0.5) * angle;
    let s = x * x;
    let sin = x * polynomial(s, SINE);
    let cos = polynomial(s, COSINE);
    let two = R::splat(2.0);
    (two * sin * cos, R::splat(1.0) - two * sin * sin)
}

/// Coefficients of sin(x) / x in powers of the square of x.
const SINE: [f32; 6] =
    [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0];
/// Coefficients of cos(x) in powers of the square of x.
const COSINE: [f32; 7] =
    [1.0, -0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0];

/// Returns a polynomial's value, by Horner's rule from the last coefficient on.
#[inline(always)]
fn polynomial<R: Real, const COUNT: usize>(x: R, coefficients: [f32; COUNT]) -> R {
    let mut value = R::splat(coefficients[COUNT - 1]);
    for coefficient in coefficients[..COUNT - 1].iter().rev() {
        value = R::splat(*coefficient) + x * value;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_agree_with_the_standard_library() {
        let mut worst: f64 = 0.0;
        // Half a turn is left out: both signs are correct there.
        for step in -9_999..=9_999_i16 {
            let angle = f64::from(step) / 10_000.0 * std::f64::consts::PI;
            #[expect(clippy::cast_possible_truncation, reason = "to the nearest")]
            let single = angle as f32;
            let (sin, cos) = sin_cos(single);
            let (exact_sin, exact_cos) = f64::from(single).sin_cos();
            worst = worst
                .max((f64::from(sin) - exact_sin).abs())
                .max((f64::from(cos) - exact_cos).abs());
            let (y, x) = (sin * 3.0, cos * 3.0);
            worst = worst.max((f64::from(of(y, x)) - f64::from(y).atan2(f64::from(x))).abs());
        }
        assert!(worst < 1e-6, "{worst}");
        assert_eq!(of(0.0, 0.0).to_bits(), 0.0_f32.to_bits());
    }
}
