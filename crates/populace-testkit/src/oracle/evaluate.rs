//! Evaluate: what time a slot shows and how much it weighs, from how it was started.

use populace_clip::{Clip, TICKS_PER_SEC};

use crate::tolerance;

/// How a clip is played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing {
    /// Again and again.
    Loop {
        /// The clock when it began.
        start_tick: u64,
        /// Where in the clip it began, from 0 to 1.
        phase: f64,
        /// 1 is the clip's own pace, negative is backwards.
        speed: f32,
    },
    /// From one end to the other, then holding that.
    Once {
        /// The clock when it began.
        start_tick: u64,
        /// 1 is the clip's own pace; negative begins at the end.
        speed: f32,
    },
    /// Standing at a time on the clip's own axis.
    Held {
        /// That time.
        secs: f32,
    },
}

/// Seconds between two readings of the clock.
fn elapsed_secs(from: u64, to: u64) -> f64 {
    assert!(from <= to, "a slot is looked at before it began");
    (to - from) as f64 / TICKS_PER_SEC as f64
}

impl Timing {
    /// The time on the clip's own axis at a time of the clock.
    ///
    /// # Panics
    ///
    /// If the clock stands before the start.
    #[must_use]
    pub fn time_secs(&self, tick: u64, clip: &Clip) -> f64 {
        let (start, duration) = (f64::from(clip.start_secs()), f64::from(clip.duration_secs()));
        match *self {
            Self::Loop { .. } if duration == 0.0 => start,
            Self::Loop { start_tick, phase, speed } => {
                let cycles = phase + elapsed_secs(start_tick, tick) * f64::from(speed) / duration;
                start + (cycles - cycles.floor()) * duration
            }
            Self::Once { start_tick, speed } => {
                let gone = elapsed_secs(start_tick, tick) * f64::from(speed.abs());
                let gone = gone.min(duration);
                if speed < 0.0 { start + duration - gone } else { start + gone }
            }
            Self::Held { secs } => f64::from(secs),
        }
    }

    /// Seconds of the clip in a second of the clock: 0 for one that has come to its end.
    #[must_use]
    pub fn speed(&self, tick: u64, clip: &Clip) -> f64 {
        match *self {
            Self::Loop { speed, .. } => f64::from(speed),
            Self::Once { start_tick, speed } => {
                let goes = elapsed_secs(start_tick, tick) * f64::from(speed.abs())
                    < f64::from(clip.duration_secs());
                if goes { f64::from(speed) } else { 0.0 }
            }
            Self::Held { .. } => 0.0,
        }
    }

    /// Whether the value jumps so near to that time that single precision may see the other side:
    /// at the seam of a loop and at STEP keys. A held time is exact, so it never is.
    ///
    /// # Panics
    ///
    /// If the clock stands before the start.
    #[must_use]
    pub fn is_near_jump(&self, tick: u64, clip: &Clip) -> bool {
        if matches!(self, Self::Held { .. }) {
            return false;
        }
        let (time, near) = (self.time_secs(tick, clip), tolerance::time_error_secs(clip));
        let (start, duration) = (f64::from(clip.start_secs()), f64::from(clip.duration_secs()));
        let seam = matches!(self, Self::Loop { .. }) && duration > 0.0;
        let jumps = |track: &&populace_model::Track| {
            track.interpolation == populace_model::Interpolation::Step
        };
        let steps = clip.source().tracks.iter().filter(jumps).flat_map(|t| &t.times[1..]);
        (seam && (time - start < near || start + duration - time < near))
            || steps.map(|t| f64::from(*t)).any(|t| (t - time).abs() < near)
    }
}

/// How a slot's weight runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weighting {
    /// Always the same.
    Constant(f32),
    /// From one weight to another, straight.
    Ramp {
        /// The clock when it began.
        tick: u64,
        /// The first weight.
        from: f32,
        /// The last weight.
        to: f32,
        /// How long it takes; at once where not above 0.
        secs: f32,
    },
}

impl Weighting {
    /// The weight at a time of the clock.
    ///
    /// # Panics
    ///
    /// If the clock stands before the start.
    #[must_use]
    pub fn weight(&self, now: u64) -> f64 {
        match *self {
            Self::Constant(weight) => f64::from(weight),
            Self::Ramp { to, secs, .. } if secs <= 0.0 => f64::from(to),
            Self::Ramp { tick, from, to, secs } => {
                let share = (elapsed_secs(tick, now) / f64::from(secs)).min(1.0);
                f64::from(from) + (f64::from(to) - f64::from(from)) * share
            }
        }
    }
}
