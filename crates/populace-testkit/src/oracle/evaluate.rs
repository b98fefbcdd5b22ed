//! Evaluate: a slot's clip time and weight, from the clock and the way it was started.

use populace_clip::{Clip, TICKS_PER_SEC};

use crate::tolerance;

/// The mode of playback of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing {
    /// Loops.
    Loop {
        /// The clock at the start.
        start_tick: u64,
        /// The starting point in the clip, from 0 to 1.
        phase: f64,
        /// 1 is the clip's own speed; negative plays backwards.
        speed: f32,
    },
    /// Plays from one end to the other, then holds the last pose.
    Once {
        /// The clock at the start.
        start_tick: u64,
        /// 1 is the clip's own speed; negative begins at the end.
        speed: f32,
    },
    /// Holds one time.
    Held {
        /// Time on the clip's own axis.
        secs: f32,
    },
}

/// Returns the seconds between two ticks.
fn elapsed_secs(from: u64, to: u64) -> f64 {
    assert!(from <= to, "tick {to} is before the slot's start at {from}");
    (to - from) as f64 / TICKS_PER_SEC as f64
}

impl Timing {
    /// Returns the time on the clip's own axis at a tick.
    ///
    /// # Panics
    ///
    /// If the tick is before the start.
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
                let played = elapsed_secs(start_tick, tick) * f64::from(speed.abs());
                let played = played.min(duration);
                if speed < 0.0 { start + duration - played } else { start + played }
            }
            Self::Held { secs } => f64::from(secs),
        }
    }

    /// Returns the clip seconds per clock second; 0 once the clip has reached its end.
    #[must_use]
    pub fn speed(&self, tick: u64, clip: &Clip) -> f64 {
        match *self {
            Self::Loop { speed, .. } => f64::from(speed),
            Self::Once { start_tick, speed } => {
                let runs = elapsed_secs(start_tick, tick) * f64::from(speed.abs())
                    < f64::from(clip.duration_secs());
                if runs { f64::from(speed) } else { 0.0 }
            }
            Self::Held { .. } => 0.0,
        }
    }

    /// Returns whether the value jumps so near to the time that single precision may fall on the
    /// other side: at the seam of a loop or at a STEP key. Always false for a held time, which is
    /// exact.
    ///
    /// # Panics
    ///
    /// If the tick is before the start.
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

/// A slot's weight over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weighting {
    /// A constant weight.
    Constant(f32),
    /// A linear ramp.
    Ramp {
        /// The clock at the start.
        tick: u64,
        /// The first weight.
        from: f32,
        /// The last weight.
        to: f32,
        /// The ramp's length; at 0 or below the last weight holds at once.
        secs: f32,
    },
    /// A ramp times a share, which is that of one tick.
    Share {
        /// The clock at the start of the ramp.
        tick: u64,
        /// The first weight.
        from: f32,
        /// The last weight.
        to: f32,
        /// The ramp's length; at 0 or below the last weight holds at once.
        secs: f32,
        /// The factor on the ramp's weight.
        share: f64,
    },
}

impl Weighting {
    /// Returns the weight at a tick.
    ///
    /// # Panics
    ///
    /// If the tick is before the start.
    #[must_use]
    pub fn weight(&self, now: u64) -> f64 {
        match *self {
            Self::Constant(weight) => f64::from(weight),
            Self::Share { tick, from, to, secs, share } => {
                Self::Ramp { tick, from, to, secs }.weight(now) * share
            }
            Self::Ramp { to, secs, .. } if secs <= 0.0 => f64::from(to),
            Self::Ramp { tick, from, to, secs } => {
                let share = (elapsed_secs(tick, now) / f64::from(secs)).min(1.0);
                f64::from(from) + (f64::from(to) - f64::from(from)) * share
            }
        }
    }
}
