//! Progress bars, shown only on a terminal and only for work that takes longer than a second.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work must take this long before its bar is shown.
const SHOW_AFTER: Duration = Duration::from_secs(1);

/// All bars; hidden if stderr is not a terminal.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// The progress of some work. Dropping it removes its bar.
pub(crate) struct Progress {
    bar: ProgressBar,
    start: Instant,
    shown: bool,
}

impl Progress {
    /// Starts work of `steps` steps, labelled `label`.
    pub(crate) fn new(label: &'static str, steps: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden());
        if let Ok(style) =
            ProgressStyle::with_template("{msg} {wide_bar} {pos} of {len}, {eta} left")
        {
            bar.set_style(style);
        }
        bar.set_message(label);
        Self { bar, start: Instant::now(), shown: false }
    }

    /// Counts one more step as done.
    pub(crate) fn step(&mut self) {
        self.bar.inc(1);
        if !self.shown && self.start.elapsed() > SHOW_AFTER {
            self.shown = true;
            BARS.add(self.bar.clone());
            self.bar.tick();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Hides the bars while `write` writes to stderr.
pub(crate) fn suspended(write: impl FnOnce()) {
    BARS.suspend(write);
}

/// Removes all bars.
#[cfg(unix)]
pub(crate) fn clear() {
    let _ = BARS.clear();
}
