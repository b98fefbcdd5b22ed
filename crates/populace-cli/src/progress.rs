//! Bars that tell how long something still takes, on a terminal alone, for whatever takes longer
//! than a second.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Shorter work shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// All bars; hidden where stderr is no terminal.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// Steps of some work. The bar goes when this is dropped.
pub(crate) struct Progress {
    bar: ProgressBar,
    start: Instant,
    shown: bool,
}

impl Progress {
    /// Work of `steps` steps, called `what`.
    pub(crate) fn new(what: &'static str, steps: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden());
        if let Ok(style) =
            ProgressStyle::with_template("{msg} {wide_bar} {pos} of {len}, {eta} left")
        {
            bar.set_style(style);
        }
        bar.set_message(what);
        Self { bar, start: Instant::now(), shown: false }
    }

    /// One more step is done.
    pub(crate) fn step(&mut self) {
        self.bar.inc(1);
        if !self.shown && self.start.elapsed() > PATIENCE {
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

/// Writes to stderr where no bar stands meanwhile.
pub(crate) fn suspended(write: impl FnOnce()) {
    BARS.suspend(write);
}

/// Takes all bars away.
#[cfg(unix)]
pub(crate) fn clear() {
    let _ = BARS.clear();
}
