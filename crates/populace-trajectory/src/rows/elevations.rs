//! Elevations of rows, and those of rows that have none.

use std::ops::Range;

use super::{Rows, finish};
use crate::recording::Kind;

impl Rows {
    /// Returns the elevations in the order of rows, in metres; none at all if no row has one. A row
    /// without one has that between its agent's neighbouring rows by time. Agents must have their
    /// rows; `metres` are those in the unit of positions.
    pub(super) fn elevations_in_metres(&mut self, order: &[usize], metres: f64) -> Vec<f32> {
        let metres = finish::rounded(self.elevation_unit.map_or(metres, crate::Unit::in_metres));
        let count = self.clocks.len();
        let mut all = finish::in_order(&self.elevations, order, count, f32::NAN);
        all.iter_mut().for_each(|elevation| *elevation *= metres);
        let least = all.iter().copied().fold(f32::INFINITY, f32::min);
        if least == f32::INFINITY {
            return Vec::new();
        }
        let times: Vec<f64> = order.iter().map(|row| self.clocks[*row]).collect();
        let (mut filled, mut unknown) = (0_usize, 0_usize);
        for agent in &self.agents {
            let rows = agent.rows.clone();
            let missing = all[rows.clone()].iter().filter(|elevation| elevation.is_nan()).count();
            let knows = missing < rows.len();
            fill(&mut all[rows.clone()], &times[rows], least);
            if agent.kind == Kind::Person {
                filled += if knows { missing } else { 0 };
                unknown += usize::from(!knows && missing > 0);
            }
        }
        self.warn_of_elevations(filled, unknown);
        all
    }

    /// Warns of rows of people without an elevation, and of people who have none at all.
    fn warn_of_elevations(&mut self, filled: usize, unknown: usize) {
        if filled > 0 {
            let rows = if filled == 1 { "1 row has".into() } else { format!("{filled} rows have") };
            self.warnings.whole(format!(
                "{rows} no elevation, and the one between the neighbouring rows of the same person \
                 was taken"
            ));
        }
        if unknown > 0 {
            let people =
                if unknown == 1 { "1 person has".into() } else { format!("{unknown} people have") };
            self.warnings.whole(format!(
                "{people} no elevation in any row, and the least one of the file was taken"
            ));
        }
    }
}

/// Fills in the elevations of an agent where they are not numbers: on a line between those around,
/// as the nearest one before the first and after the last, and as `least` if there are none.
fn fill(elevations: &mut [f32], times: &[f64], least: f32) {
    let mut known: Option<usize> = None;
    for nth in 0..elevations.len() {
        if elevations[nth].is_nan() {
            continue;
        }
        let gap: Range<usize> = known.map_or(0, |before| before + 1)..nth;
        let (to, end) = (elevations[nth], times[nth]);
        let (from, begin) = known.map_or((to, end), |known| (elevations[known], times[known]));
        for missing in gap {
            let part = if end > begin { (times[missing] - begin) / (end - begin) } else { 0.0 };
            elevations[missing] = from + (to - from) * finish::rounded(part);
        }
        known = Some(nth);
    }
    let (after, last) = known.map_or((0, least), |known| (known + 1, elevations[known]));
    elevations[after..].fill(last);
}
