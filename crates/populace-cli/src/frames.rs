//! The frames of a film, and their times.

/// Consecutive frames of a film. Frame k shows the time k / fps, whichever frames are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frames {
    /// Number of the first frame that is drawn; those before it are only evaluated.
    pub(crate) first: u32,
    /// Number of the last frame.
    pub(crate) last: u32,
    /// Frames per second, above 0.
    pub(crate) fps: f64,
}

impl Frames {
    /// Returns the time of a frame in seconds since frame 0.
    pub(crate) fn secs(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }
}

/// Returns the nearest `f32`.
#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
