//! How fast time passes in the window.

/// Most of the time that passes at once, in seconds; a slower machine shows slower motion.
const LONGEST_SECS: f64 = 0.25;
/// Speeds that the keys choose.
pub(crate) const SPEEDS: [f32; 9] = [0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0, 8.0];

/// Play, pause and speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    pub(crate) plays: bool,
    /// Seconds of the show in a second.
    pub(crate) speed: f32,
}

impl Default for Clock {
    fn default() -> Self {
        Self { plays: true, speed: 1.0 }
    }
}

impl Clock {
    /// Returns the seconds of the show that pass in `secs` of the window.
    pub(crate) fn passed_secs(self, secs: f64) -> f64 {
        if self.plays { (secs.max(0.0) * f64::from(self.speed)).min(LONGEST_SECS) } else { 0.0 }
    }

    /// Takes the next speed that is faster, or slower.
    pub(crate) fn change(&mut self, faster: bool) {
        let next = if faster {
            SPEEDS.into_iter().find(|speed| *speed > self.speed + 1e-3)
        } else {
            SPEEDS.into_iter().rev().find(|speed| *speed < self.speed - 1e-3)
        };
        self.speed = next.unwrap_or(self.speed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_passes_by_the_speed_and_not_in_a_pause() {
        let mut clock = Clock::default();
        assert_eq!(clock.passed_secs(0.1), 0.1);
        clock.change(true);
        assert_eq!((clock.speed, clock.passed_secs(0.1)), (1.5, 0.1 * 1.5));
        (0..9).for_each(|_| clock.change(false));
        assert_eq!(clock.speed, SPEEDS[0]);
        assert_eq!(clock.passed_secs(1e9), LONGEST_SECS);
        clock.plays = false;
        assert_eq!(clock.passed_secs(0.1), 0.0);
    }
}
