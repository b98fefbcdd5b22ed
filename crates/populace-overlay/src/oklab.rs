//! Colours in Oklab, in which equal distances look about equally large.
//!
//! Ottosson, "A perceptual color space for image processing", 2020.

use crate::canvas::byte;

/// A colour of a scale: opaque, within the range of sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color {
    linear: [f32; 3],
    srgb: [u8; 3],
}

impl Color {
    /// Red, green and blue in linear light, 0 to 1.
    #[must_use]
    pub fn linear(&self) -> [f32; 3] {
        self.linear
    }

    /// Red, green and blue in sRGB.
    #[must_use]
    pub fn srgb(&self) -> [u8; 3] {
        self.srgb
    }

    /// Red, green and blue in sRGB with an alpha of 255.
    #[must_use]
    pub fn opaque(&self) -> [u8; 4] {
        let [red, green, blue] = self.srgb;
        [red, green, blue, 255]
    }

    /// Returns the colour of a lightness and two opponents, cut to the range of sRGB.
    pub(crate) fn of([lightness, a, b]: [f64; 3]) -> Self {
        let cube = |v: f64| v * v * v;
        let long = cube(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
        let medium = cube(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
        let short = cube(lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
        let linear = [
            4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
            -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
            -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
        ]
        .map(|v| v.clamp(0.0, 1.0));
        #[expect(clippy::cast_possible_truncation, reason = "rounds to single precision")]
        let single = linear.map(|v| v as f32);
        Self { linear: single, srgb: linear.map(|v| byte(255.0 * encoded(v))) }
    }
}

/// Returns the sRGB value, 0 to 1, of an amount of light.
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
