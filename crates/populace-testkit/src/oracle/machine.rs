//! State machines: the states that a machine has entered, and what it shows of them.
//!
//! In each frame a machine takes the first transition out of its state whose conditions all hold,
//! unless the fade of the last one still runs. Durations are whole ticks, so nothing is decided
//! within a rounding error.

use populace_clip::TICKS_PER_SEC;
use populace_device::{Condition, Transition};

/// A state that a machine has entered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleEntry {
    /// Index of the state.
    pub state: usize,
    /// The clock when it was entered.
    pub tick: u64,
    /// The length of the fade from the state before.
    pub fade_secs: f32,
}

/// The course of a machine through its states; the last entry is the state that it is in.
#[derive(Clone, Debug, PartialEq)]
pub struct OracleCourse {
    entries: Vec<OracleEntry>,
}

impl OracleEntry {
    fn fade_ticks(&self) -> u64 {
        ticks(f64::from(self.fade_secs))
    }
}

/// Returns the whole number of ticks that is nearest to a time.
fn ticks(secs: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a short time")]
    let ticks = (secs * TICKS_PER_SEC as f64).round() as u64;
    ticks
}

fn holds(condition: &Condition, parameters: &[f32], elapsed: u64) -> bool {
    match *condition {
        Condition::Above(parameter, value) => parameters[parameter as usize] > value,
        Condition::Below(parameter, value) => parameters[parameter as usize] < value,
        Condition::After(ticks) => elapsed >= ticks,
    }
}

impl OracleCourse {
    /// Begins in a state at a tick.
    #[must_use]
    pub fn new(state: usize, tick: u64) -> Self {
        Self { entries: vec![OracleEntry { state, tick, fade_secs: 0.0 }] }
    }

    /// Returns the entry into the state that the machine is in.
    ///
    /// # Panics
    ///
    /// Never: a course has at least one entry.
    #[must_use]
    pub fn now(&self) -> OracleEntry {
        *self.entries.last().expect("a course has an entry")
    }

    /// Returns how many transitions were taken.
    #[must_use]
    pub fn transitions(&self) -> usize {
        self.entries.len() - 1
    }

    /// Takes at most one transition. `ways` are the transitions out of each state.
    ///
    /// # Panics
    ///
    /// If a state or a parameter does not exist.
    pub fn step(&mut self, ways: &[Vec<Transition>], parameters: &[f32], tick: u64) {
        let now = self.now();
        let elapsed = tick - now.tick;
        if elapsed < now.fade_ticks() {
            return;
        }
        let taken = ways[now.state].iter().find(|way| {
            way.conditions.iter().all(|condition| holds(condition, parameters, elapsed))
        });
        if let Some(&Transition { to, fade_secs, .. }) = taken {
            self.entries.push(OracleEntry { state: to, tick, fade_secs });
        }
    }

    /// Returns the states that show at a tick, each with its share of the machine's weight.
    #[must_use]
    pub fn shown(&self, tick: u64) -> Vec<(OracleEntry, f64)> {
        let now = self.now();
        let elapsed_secs = (tick - now.tick) as f64 / TICKS_PER_SEC as f64;
        let Some(before) = self.entries.iter().rev().nth(1) else { return vec![(now, 1.0)] };
        if now.fade_ticks() == 0 {
            return vec![(now, 1.0)];
        }
        let share = (elapsed_secs / f64::from(now.fade_secs)).min(1.0);
        vec![(now, share), (*before, 1.0 - share)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fade_ends_before_the_next_transition_is_taken() {
        let secs = |secs: f64| ticks(secs);
        let to = |to, fade_secs, conditions| Transition { to, fade_secs, conditions };
        let ways = [
            vec![
                to(0, 0.0, vec![Condition::Above(0, 2.0)]),
                to(1, 0.5, vec![Condition::Above(0, 0.5), Condition::After(secs(1.0))]),
            ],
            vec![to(0, 0.0, vec![])],
        ];
        let mut course = OracleCourse::new(0, 0);
        let mut entered = Vec::new();
        for tenth in 1..20 {
            course.step(&ways, &[1.0], secs(0.1 * f64::from(tenth)));
            entered.push((course.now().state, course.shown(secs(0.1 * f64::from(tenth)))[0].1));
        }
        let states: String = entered.iter().map(|(state, _)| state.to_string()).collect();
        assert_eq!(states, "0000000001111100000");
        assert!((entered[11].1 - 0.4).abs() < 1e-6, "{entered:?}");
        assert_eq!(course.transitions(), 2);
    }
}
