//! The stroke font: glyphs as centre lines, and text laid out in pixels.

mod glyphs;
mod marks;
mod outline;
pub(crate) mod truetype;

use crate::strokes::Segment;
use glyphs::Glyph;
use outline::Line;

/// Units of the glyphs in one size of the font.
const UNITS: f64 = 100.0;
/// Width of a stroke in units.
const STROKE: f64 = 8.8;
/// Narrowest stroke in pixels. A thinner one would be grey.
const STROKE_LEAST: f64 = 1.15;
/// Factor of a dot's radius to that of a stroke.
const DOT: f64 = 1.28;
/// Heights in units at which glyphs have horizontal strokes.
const HEIGHTS: [f64; 8] = [-19.0, 0.0, 18.0, 26.0, 34.0, 47.0, 66.0, 70.0];
/// Height of capitals and digits over the base line in sizes of the font, with half a stroke.
pub(crate) const CAP_HEIGHT: f64 = 0.70;
/// Depth under the base line in sizes of the font.
pub(crate) const DEPTH: f64 = 0.23;

/// Returns the width of a line of text in pixels.
///
/// `size_px` is the size of the font: about 1.4 times the height of a capital letter.
#[must_use]
pub fn text_width(text: &str, size_px: f64) -> f64 {
    text.chars().map(|letter| Glyph::of(letter).advance()).sum::<f64>() * size_px / UNITS
}

/// Returns the width of a stroke in pixels.
pub(crate) fn stroke_px(size_px: f64) -> f64 {
    (STROKE * size_px / UNITS).max(STROKE_LEAST)
}

/// Returns the strokes of a line of text that begins at `at` on its base line, in pixels.
pub(crate) fn strokes(text: &str, size_px: f64, at: [f64; 2]) -> Vec<Segment> {
    let grid = Grid::new(size_px);
    let (mut pen, base) = (at[0], at[1].round());
    let mut segments = Vec::new();
    for letter in text.chars() {
        let glyph = Glyph::of(letter);
        let lines = glyph.lines();
        let span = outline::span(&lines);
        let place = |v: f64| pen + (v - span[0] + glyph.bearing()) * grid.scale;
        let left = grid.snap(place(span[0]));
        let ends = [left, left + grid.width(span, outline::has_middle_stem(&lines, span))];
        let x = |v: f64| match span[1] - span[0] {
            width if width > 0.0 => ends[0] + (ends[1] - ends[0]) * (v - span[0]) / width,
            _ => ends[0],
        };
        let point = |[px, py]: [f64; 2]| [x(px), base - grid.height(py)];
        for line in &lines {
            let radius = 0.5 * grid.stroke;
            match line {
                Line::Dot(at) => segments.push(Segment::dot(point(*at), DOT * radius)),
                Line::Path(points) => segments.extend(
                    points.windows(2).map(|p| Segment::new(point(p[0]), point(p[1]), radius)),
                ),
            }
        }
        pen += glyph.advance() * grid.scale;
    }
    segments
}

/// How units become pixels: straight strokes come to lie on whole pixels.
struct Grid {
    scale: f64,
    stroke: f64,
    /// Position of the middle of a stroke in a pixel: 0.5 for an odd width, 0 for an even one.
    offset: f64,
    heights: [f64; HEIGHTS.len()],
}

impl Grid {
    fn new(size_px: f64) -> Self {
        let (scale, stroke) = (size_px / UNITS, stroke_px(size_px));
        let offset = if stroke.round() % 2.0 == 1.0 { 0.5 } else { 0.0 };
        let mut grid = Self { scale, stroke, offset, heights: [0.0; HEIGHTS.len()] };
        // The lower edge of a stroke at height 0 lies on the base line.
        let half = (0.5 * stroke.round()).max(0.5);
        grid.heights = HEIGHTS.map(|height| (height * scale).round() + half);
        grid
    }

    /// Returns a coordinate at which a stroke covers whole pixels.
    fn snap(&self, v: f64) -> f64 {
        (v - self.offset).round() + self.offset
    }

    /// Returns the width in pixels of a span in units; an even number if a straight stroke stands
    /// in its middle, so that this one covers whole pixels too.
    fn width(&self, span: [f64; 2], even: bool) -> f64 {
        let width = (span[1] - span[0]) * self.scale;
        if even { 2.0 * (0.5 * width).round() } else { width.round() }
    }

    /// Returns the height over the base line, in pixels, of a height in units.
    fn height(&self, y: f64) -> f64 {
        let above = HEIGHTS.partition_point(|h| *h < y).clamp(1, HEIGHTS.len() - 1);
        let (low, high) = (HEIGHTS[above - 1], HEIGHTS[above]);
        if !(low..=high).contains(&y) {
            let nearest = if y < low { above - 1 } else { above };
            return self.heights[nearest] + (y - HEIGHTS[nearest]) * self.scale;
        }
        let [from, to] = [self.heights[above - 1], self.heights[above]];
        from + (to - from) * (y - low) / (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Letters of European languages beyond those of English.
    const LETTERS: &str = "äöüßÄÖÜ àâæçéèêëîïôœùûÿÀÂÆÇÉÈÊËÎÏÔŒÙÛŸ áíóúñÁÍÓÚÑ ãõÃÕ ìòÌÒ åøÅØ ðþýÐÞÝ \
        ąćęłńśźżĄĆĘŁŃŚŹŻ čďěňřšťůžČĎĚŇŘŠŤŮŽ đĐ őűŐŰ ăâșțĂÂȘȚ ğışĞİŞ āēīķļņūĀĒĪĶĻŅŪ ėįųĖĮŲ";

    #[test]
    fn letters_of_european_languages_are_no_boxes() {
        let missing = strokes("\u{fffd}", 40.0, [0.0; 2]);
        for letter in LETTERS.chars().chain("¿¡«»„“€£".chars()).filter(|letter| *letter != ' ')
        {
            assert_ne!(strokes(&letter.to_string(), 40.0, [0.0; 2]), missing, "{letter}");
        }
    }

    #[test]
    fn marks_under_capitals_reach_below_the_line() {
        for letter in ["Ç", "Ş", "Ą", "Ț"] {
            let segments = strokes(letter, 40.0, [0.0, 50.0]);
            let lowest = segments.iter().flat_map(|s| [s.from[1], s.to[1]]).fold(0.0, f64::max);
            assert!(lowest > 53.0, "{letter} reaches {lowest}");
        }
    }

    #[test]
    fn width_grows_with_size_and_text() {
        assert_eq!(text_width("", 12.0), 0.0);
        let one = text_width("a", 12.0);
        assert!(one > 3.0 && one < 12.0, "{one}");
        assert!((text_width("aa", 24.0) - 4.0 * one).abs() < 1e-9);
    }

    #[test]
    fn digits_are_equally_wide() {
        let widths: Vec<_> =
            "0123456789".chars().map(|c| text_width(&c.to_string(), 1.0)).collect();
        assert!(widths.iter().all(|w| (w - widths[0]).abs() < 1e-12), "{widths:?}");
    }

    #[test]
    fn horizontal_strokes_lie_on_whole_pixels() {
        for size in [11.0, 12.0, 16.0, 24.0, 31.0] {
            for segment in strokes("EFTHLz", size, [3.3, 40.2]) {
                if segment.from[1] == segment.to[1] {
                    let edge = segment.from[1] + 0.5 * stroke_px(size).round();
                    assert!((edge - edge.round()).abs() < 1e-9, "{size}: {segment:?}");
                }
            }
        }
    }

    #[test]
    fn strokes_stay_within_the_measured_width() {
        for letter in (' '..='~').chain("°·–×µ²³−…".chars()).chain(LETTERS.chars()) {
            let text = letter.to_string();
            let width = text_width(&text, 40.0);
            for segment in strokes(&text, 40.0, [0.0, 50.0]) {
                for [x, y] in [segment.from, segment.to] {
                    assert!((-1.0..width + 1.0).contains(&x), "{letter} at {x} of {width}");
                    assert!((12.0..62.0).contains(&y), "{letter} at height {y}");
                }
            }
        }
    }
}
