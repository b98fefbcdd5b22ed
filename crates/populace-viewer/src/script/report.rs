//! How long input took until it was seen.

/// From an input to the picture that shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct InputTime {
    /// Number of the line of the script, from 1.
    pub line: usize,
    /// The line without its time.
    pub words: String,
    /// Seconds since the window was opened when its last event came.
    pub at_secs: f64,
    /// Milliseconds until the picture was handed to the screen.
    pub ms: f64,
    /// Number of frames until then: 1 for the next frame.
    pub frames: u32,
}

/// Times of a window that a script drove.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScriptReport {
    /// All inputs in order.
    pub inputs: Vec<InputTime>,
    /// Milliseconds from frame to frame, since the line `measure` if there is one.
    pub frame_ms: Vec<f64>,
}

impl ScriptReport {
    /// Returns the median of the milliseconds from frame to frame; 0 without frames.
    #[must_use]
    pub fn median_ms(&self) -> f64 {
        let mut sorted = self.frame_ms.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or_default()
    }

    /// Returns the largest number of frames from an input to its picture; 0 without inputs.
    #[must_use]
    pub fn most_frames(&self) -> u32 {
        self.inputs.iter().map(|input| input.frames).max().unwrap_or(0)
    }

    pub(super) fn add_frame(&mut self, ms: f64) {
        self.frame_ms.push(ms);
    }

    /// Forgets the frames until now.
    pub(super) fn begin_to_measure(&mut self) {
        self.frame_ms.clear();
    }
}
