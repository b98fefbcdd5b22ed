//! A picture to draw on.

use crate::Error;
use crate::strokes::{Field, Segment, Window, coverage};

/// A picture to draw on: RGBA in sRGB with straight alpha, rows from the top.
///
/// Points are in pixels from the upper left corner of the picture; the middle of the first pixel is
/// `[0.5, 0.5]`. Strokes end at the edges of the picture.
#[derive(Debug)]
pub struct Canvas<'a> {
    rgba: &'a mut [u8],
    size: [u32; 2],
}

impl<'a> Canvas<'a> {
    /// Returns a canvas on a picture of `size` pixels (width, height).
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`] if `rgba` is not four times the number of pixels.
    pub fn new(rgba: &'a mut [u8], size: [u32; 2]) -> Result<Self, Error> {
        let wanted = (u64::from(size[0]) * u64::from(size[1])).checked_mul(4);
        if wanted != Some(rgba.len() as u64) {
            return Err(Error::WrongLength { found: rgba.len(), size });
        }
        Ok(Self { rgba, size })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Size of text in pixels that reads well in a picture of this height: 12 at 360 rows and 24 at
    /// 1080.
    #[must_use]
    pub fn text_size(&self) -> f64 {
        text_size(self.size)
    }

    /// Paints strokes, first a soft dark edge of `halo.1` pixels around them.
    pub(crate) fn strokes(&mut self, segments: &[Segment], color: [u8; 4], halo: ([u8; 4], f64)) {
        let (halo_color, halo_px) = halo;
        let Some(field) = Field::new(segments, halo_px + 1.0, self.size) else { return };
        if halo_px > 0.0 {
            self.paint(field.window, |pixel| {
                let part = (1.0 - field.at(pixel) / halo_px).clamp(0.0, 1.0);
                (halo_color, part * part * (3.0 - 2.0 * part))
            });
        }
        self.paint(field.window, |pixel| (color, coverage(field.at(pixel))));
    }

    /// Paints a rectangle with rounded corners and an edge that fades over `fade_px` outwards.
    pub(crate) fn plate(&mut self, area: Area, radius: f64, fade_px: f64, color: [u8; 4]) {
        let fade = fade_px.max(1.0);
        let low = area.low.map(|v| v - fade);
        let high = area.high.map(|v| v + fade);
        let Some(window) = Window::around(low, high, self.size) else { return };
        let middle = [0, 1].map(|i| 0.5 * (area.low[i] + area.high[i]));
        let half = [0, 1].map(|i| 0.5 * (area.high[i] - area.low[i]));
        let radius = radius.min(half[0]).min(half[1]);
        self.paint(window, |[x, y]| {
            let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let out = [0, 1].map(|i| (at[i] - middle[i]).abs() - half[i] + radius);
            let outer = out.map(|v| v.max(0.0));
            let distance = (outer[0] * outer[0] + outer[1] * outer[1]).sqrt()
                + out[0].max(out[1]).min(0.0)
                - radius;
            let part = (1.0 - (distance + 0.5) / fade).clamp(0.0, 1.0);
            (color, if fade_px > 1.0 { part * part * (3.0 - 2.0 * part) } else { part })
        });
    }

    /// Lays a colour over each pixel of a window, by `ink`: sRGB with alpha, and a part of it.
    pub(crate) fn paint(&mut self, window: Window, ink: impl Fn([u32; 2]) -> ([u8; 4], f64)) {
        let width = self.size[0] as usize;
        for y in window.first[1]..window.end[1] {
            for x in window.first[0]..window.end[0] {
                let (color, part) = ink([x, y]);
                let begin = 4 * (y as usize * width + x as usize);
                if part > 0.0
                    && let Some(pixel) = self.rgba.get_mut(begin..begin + 4)
                {
                    over(pixel, color, part);
                }
            }
        }
    }
}

/// Returns the size of text in a picture of a size, in pixels.
pub(crate) fn text_size([_, height]: [u32; 2]) -> f64 {
    (6.0 + f64::from(height) / 60.0).round()
}

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
}

impl Area {
    /// Returns true if two rectangles share a point.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }
}

/// Lays `part` of a colour over a pixel, both with straight alpha.
fn over(pixel: &mut [u8], color: [u8; 4], part: f64) {
    let above = part * f64::from(color[3]) / 255.0;
    let below = f64::from(pixel[3]) / 255.0 * (1.0 - above);
    let sum = above + below;
    if sum <= 0.0 {
        return;
    }
    for (value, color) in pixel.iter_mut().zip(&color[..3]) {
        *value = byte((f64::from(*color) * above + f64::from(*value) * below) / sum);
    }
    pixel[3] = byte(255.0 * sum);
}

/// Returns the nearest whole number from 0 to 255.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded and clamped to a byte"
)]
pub(crate) fn byte(v: f64) -> u8 {
    v.round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_length_is_refused() {
        let error = Canvas::new(&mut [0; 7], [2, 1]).expect_err("7 bytes are not 2 pixels");
        assert!(error.to_string().contains("8 bytes"), "{error}");
    }

    #[test]
    fn straight_alpha_is_kept_straight() {
        let mut clear = [9, 9, 9, 0];
        over(&mut clear, [200, 100, 50, 255], 0.5);
        assert_eq!(clear, [200, 100, 50, 128], "half a colour over nothing keeps its colour");
        let mut solid = [0, 0, 0, 255];
        over(&mut solid, [200, 100, 50, 255], 0.5);
        assert_eq!(solid, [100, 50, 25, 255]);
    }
}
