//! Angles computed with `+ - * /` only, so that every device rounds them the same; twin of
//! `kernels/angle.cl`.

/// Half a turn in radians.
pub const HALF_TURN: f32 = std::f32::consts::PI;
/// A quarter of a turn.
const QUARTER: f32 = std::f32::consts::FRAC_PI_2;

/// Returns the angle from +X towards +Y of a vector in the plane, from -pi to pi, within 1e-6; 0
/// for a vector of length 0. With `atan(a) = atan(1/2) + atan((a - 1/2) / (1 + a/2))` the series is
/// evaluated for arguments of at most a third.
#[inline]
#[must_use]
pub fn of(y: f32, x: f32) -> f32 {
    let (across, along) = (y.abs(), x.abs());
    let steep = across > along;
    let (low, high) = if steep { (along, across) } else { (across, along) };
    if high < 1e-20 {
        return 0.0;
    }
    let ratio = low / high;
    let far = ratio > 0.25;
    let a = if far { (ratio - 0.5) / (1.0 + 0.5 * ratio) } else { ratio };
    let s = a * a;
    let series =
        1.0 + s * (-1.0 / 3.0 + s * (0.2 + s * (-1.0 / 7.0 + s * (1.0 / 9.0 + s * (-1.0 / 11.0)))));
    let near = a * series + if far { 0.463_647_6 } else { 0.0 };
    let upper = if steep { QUARTER - near } else { near };
    let right = if x < 0.0 { HALF_TURN - upper } else { upper };
    if y < 0.0 { -right } else { right }
}

/// Returns sine and cosine of an angle from -pi to pi, within 1e-6.
#[inline]
#[must_use]
pub fn sin_cos(angle: f32) -> (f32, f32) {
    // With half the angle the arguments of the series are at most a quarter turn.
    let x = 0.5 * angle;
    let s = x * x;
    let sin = x
        * (1.0
            + s * (-1.0 / 6.0
                + s * (1.0 / 120.0
                    + s * (-1.0 / 5040.0 + s * (1.0 / 362_880.0 - s * (1.0 / 39_916_800.0))))));
    let cos = 1.0
        + s * (-0.5
            + s * (1.0 / 24.0
                + s * (-1.0 / 720.0
                    + s * (1.0 / 40_320.0
                        + s * (-1.0 / 3_628_800.0 + s * (1.0 / 479_001_600.0))))));
    (2.0 * sin * cos, 1.0 - 2.0 * sin * sin)
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
