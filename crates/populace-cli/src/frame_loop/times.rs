//! The times of frames.

use std::time::Instant;

use populace_render::PassTimes;

/// Times of frames in milliseconds.
#[derive(Default)]
pub(crate) struct FrameTimes {
    /// From the start of the update to the written file.
    pub(super) total: Vec<f64>,
    pub(super) behave: Vec<f64>,
    pub(super) animate: Vec<f64>,
    /// The part of `animate` that chose visibility and levels of detail.
    pub(super) view: Vec<f64>,
    pub(super) draw: Vec<f64>,
    pub(super) passes: Vec<PassTimes>,
}

/// Milliseconds that a frame has taken so far.
#[derive(Default)]
pub(super) struct Spent {
    pub(super) behave: f64,
    pub(super) animate: f64,
    pub(super) view: f64,
    pub(super) draw: f64,
}

impl Spent {
    pub(super) fn add(&mut self, other: &Self) {
        self.behave += other.behave;
        self.animate += other.animate;
        self.view += other.view;
        self.draw += other.draw;
    }
}

impl FrameTimes {
    pub(super) fn add_animated(&mut self, spent: &Spent) {
        self.behave.push(spent.behave);
        self.animate.push(spent.animate);
        self.view.push(spent.view);
    }

    /// Returns the median of one pass.
    pub(crate) fn pass(&self, of: fn(&PassTimes) -> f64) -> f64 {
        median(&self.passes.iter().map(of).collect::<Vec<_>>()).unwrap_or_default()
    }

    /// Returns the medians of `total`, `behave`, `animate`, `view` and `draw`.
    pub(crate) fn medians(&self) -> [f64; 5] {
        [&self.total, &self.behave, &self.animate, &self.view, &self.draw]
            .map(|ms| median(ms).unwrap_or_default())
    }
}

/// Returns the milliseconds since `start`.
pub(super) fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// Returns the median, the upper of the two middle values if their number is even; `None` if there
/// are no values.
fn median(ms: &[f64]) -> Option<f64> {
    let mut sorted = ms.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
