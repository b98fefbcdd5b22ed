//! Longitudes and latitudes in columns that are named like metres.

use super::Rows;
use crate::recording::Kind;
use crate::{Fact, Origin, Unit};

/// The least and the greatest way in metres that all people cover together, if they are in degrees:
/// two kilometres on the ground, and more than noise of computed numbers.
const COVERED: std::ops::RangeInclusive<f64> = 1e-6..=0.02;
/// The greatest way of one person who is alone, which also stands for one who does not stand still.
const COVERED_ALONE: f64 = 0.002;
/// The greatest longitude and latitude.
const LARGEST: [f64; 2] = [180.0, 90.0];
/// Distance in metres from the origin of a plan from which on coordinates are unusual for people
/// who cover so little.
const AWAY_M: f64 = 1.0;

impl Rows {
    /// Warns of positions that must be longitudes and latitudes: in metres that are only assumed,
    /// all people would be within two centimetres. Agents must have their rows.
    pub(super) fn warn_if_degrees(&mut self, unit: Fact<Unit>, order: &[usize]) {
        if unit.value != Unit::Metres || unit.origin != Origin::Assumed {
            return;
        }
        let people = self.agents.iter().filter(|agent| agent.kind == Kind::Person);
        let rows = || people.clone().flat_map(|agent| &order[agent.rows.clone()]);
        let count = people.clone().filter(|agent| !agent.rows.is_empty()).count();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for row in rows() {
            for axis in [0, 1] {
                low[axis] = low[axis].min(self.positions[*row][axis]);
                high[axis] = high[axis].max(self.positions[*row][axis]);
            }
        }
        let covered = (high[0] - low[0]).hypot(high[1] - low[1]);
        let on_earth = [0, 1].iter().all(|axis| low[*axis].abs() <= LARGEST[*axis]);
        let is_away = low[0].abs() > AWAY_M && low[1].abs() > AWAY_M;
        let alone = count > 1 || covered <= COVERED_ALONE;
        if COVERED.contains(&covered) && alone && on_earth && is_away {
            self.warnings.whole(format!(
                "in metres all people would be within {:.1} mm, so x and y look like longitudes \
                 and latitudes; project them to metres, for example to UTM",
                covered * 1e3
            ));
        }
    }
}
