//! Frames between the rows of an agent.

use std::collections::BTreeMap;

/// Counts the frames between rows that follow each other.
#[derive(Default)]
pub(crate) struct Steps {
    /// The last frame of each agent; NaN before the first.
    last: Vec<f64>,
    counts: BTreeMap<u64, usize>,
}

impl Steps {
    /// Counts a row.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "steps are rounded, and only those from 1 on are counted"
    )]
    pub(crate) fn take(&mut self, agent: u32, frame: f64) {
        let agent = agent as usize;
        if self.last.len() <= agent {
            self.last.resize(agent + 1, f64::NAN);
        }
        let step = (frame - self.last[agent]).round();
        self.last[agent] = frame;
        if step >= 1.0 {
            *self.counts.entry(step as u64).or_default() += 1;
        }
    }

    /// Returns the step that most rows have, or 1.
    #[expect(clippy::cast_precision_loss, reason = "steps of more than 2^53 frames do not occur")]
    pub(crate) fn usual(&self) -> f64 {
        let most =
            self.counts.iter().max_by_key(|(step, count)| (*count, std::cmp::Reverse(*step)));
        most.map_or(1.0, |(step, _)| *step as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_step_ignores_gaps_and_steps_back() {
        let mut steps = Steps::default();
        assert_eq!(steps.usual(), 1.0);
        for (agent, frame) in [(0, 780.0), (1, 780.0), (0, 786.0), (1, 792.0), (0, 792.0), (0, 3.0)]
        {
            steps.take(agent, frame);
        }
        assert_eq!(steps.usual(), 6.0);
    }
}
