//! Lines of text, and labels at points.

use crate::canvas::{Area, Canvas};
use crate::font::{CAP_HEIGHT, DEPTH, stroke_px, strokes, text_width};

/// Colour of halos: sRGB and alpha.
const HALO: [u8; 4] = [10, 12, 16, 215];

/// How text is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextStyle {
    /// Size of the font in pixels: about 1.4 times the height of a capital letter.
    pub size_px: f64,
    /// Colour in sRGB with straight alpha.
    pub color: [u8; 4],
    /// With a soft dark edge, which makes it readable on any background.
    pub halo: bool,
}

impl TextStyle {
    /// Returns white text with a halo.
    #[must_use]
    pub fn new(size_px: f64) -> Self {
        Self { size_px, color: [255; 4], halo: true }
    }

    /// Returns how far the dark edge reaches from the strokes, in pixels.
    fn halo_px(&self) -> f64 {
        if self.halo { 1.2 + 1.1 * stroke_px(self.size_px) } else { 0.0 }
    }
}

/// The place of a point in its line of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The point is at the beginning of the base line.
    Start,
    /// The point is in the middle of the base line.
    Middle,
    /// The point is at the end of the base line.
    End,
}

/// A word at a point of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The point in pixels; the label stands over it.
    pub at: [f64; 2],
    /// The word.
    pub text: String,
}

impl Canvas<'_> {
    /// Draws a line of text on a base line through `at`, in pixels.
    pub fn text(&mut self, text: &str, at: [f64; 2], anchor: Anchor, style: &TextStyle) {
        let begin = [begin(text, at[0], anchor, style.size_px), at[1]];
        if !(begin[0].is_finite() && begin[1].is_finite() && style.size_px > 0.0) {
            return;
        }
        let strokes = strokes(text, style.size_px, begin);
        self.strokes(&strokes, style.color, (HALO, style.halo_px()));
    }

    /// Draws labels in the order given, without those that would overlap one drawn before or that,
    /// with their dark edges, are not wholly in the picture. Returns the indices of those drawn.
    pub fn labels(&mut self, labels: &[Label], style: &TextStyle) -> Vec<usize> {
        let size = self.size().map(f64::from);
        let mut taken: Vec<(usize, Area)> = Vec::new();
        for (index, label) in labels.iter().enumerate() {
            let area = label_area(label, style.size_px);
            let edge = style.halo_px().ceil();
            let inside = (0..2).all(|i| area.low[i] >= edge && area.high[i] <= size[i] - edge);
            if inside && !taken.iter().any(|(_, other)| other.overlaps(&area)) {
                taken.push((index, area));
            }
        }
        for (index, _) in &taken {
            let label = &labels[*index];
            self.text(&label.text, label.at, Anchor::Middle, style);
        }
        taken.into_iter().map(|(index, _)| index).collect()
    }
}

fn begin(text: &str, x: f64, anchor: Anchor, size_px: f64) -> f64 {
    let part = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => 0.5,
        Anchor::End => 1.0,
    };
    x - part * text_width(text, size_px)
}

/// Returns the pixels that a label covers.
fn label_area(label: &Label, size_px: f64) -> Area {
    let half = 0.5 * text_width(&label.text, size_px);
    let [x, y] = label.at;
    Area { low: [x - half, y - CAP_HEIGHT * size_px], high: [x + half, y + DEPTH * size_px] }
}
