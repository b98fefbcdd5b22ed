//! The observer: progress of a benchmark, reported to its caller.

use populace::Crowd;

/// Hears of the progress of a benchmark. `()` ignores all of it.
pub trait Observer {
    /// A crowd was built. Its drivers have started, and may have replaced signal handlers.
    fn drivers_started(&mut self) {}

    /// Work of `steps` steps starts; `label` names the steps in the plural. Earlier work is done.
    fn work_started(&mut self, label: &'static str, steps: usize) {
        let _ = (label, steps);
    }

    /// One more step of the work is done.
    fn step_done(&mut self) {}

    /// Every subject has made one more frame, which is a measured one or one to warm up.
    fn frame_done(&mut self, is_measured: bool) {
        let _ = is_measured;
    }

    /// The work is done.
    fn work_done(&mut self) {}

    /// A subject is left out; `subject` says what it would have measured.
    fn skipped(&mut self, subject: &str, reason: &str) {
        let _ = (subject, reason);
    }

    /// All frames of a crowd are measured.
    fn crowd_measured(&mut self, crowd: &Crowd) {
        let _ = crowd;
    }
}

impl Observer for () {}
