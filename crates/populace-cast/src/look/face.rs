//! Parameters of a face.

/// Form of a face. Factors are relative to an adult of average features.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Factor of the breadth of the jaw.
    pub jaw: f64,
    /// How far the chin stands out: 0 not at all, 1 average.
    pub chin: f64,
    /// How far the corners of the mouth are raised: 0 neutral, 1 a smile.
    pub smile: f64,
    /// Fullness of the lips: 0 thin, 1 average.
    pub lips: f64,
    /// Factor of the length of the nose.
    pub nose_length: f64,
    /// Factor of the breadth of the nose.
    pub nose_width: f64,
    /// Curve of the nose's ridge: negative for a snub nose, 0 straight, 1 for a hump.
    pub nose_hump: f64,
    /// Factor of the strength of brows and of the ridge below them.
    pub brow: f64,
    /// Factor of the size of the ears.
    pub ears: f64,
    /// Factor of the size of the eyes.
    pub eyes: f64,
    /// How far the eyes are open: 0 closed, 1 average.
    pub open: f64,
    /// Length of the upper lashes: 0 a thin line, 1 long.
    pub lashes: f64,
    /// Colour of the irises, as linear RGB from 0 to 1.
    pub iris: [f32; 3],
    /// Colour of the lips relative to the skin, as linear RGB factors.
    pub lip_color: [f32; 3],
}

impl Face {
    /// Returns the paint of the lips.
    pub(crate) fn lip_paint(&self) -> [f64; 3] {
        self.lip_color.map(f64::from)
    }
}
