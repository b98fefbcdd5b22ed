//! How vehicles follow each other, and stop.
//!
//! The acceleration is that of the intelligent driver model (M. Treiber, A. Hennecke and D. Helbing,
//! "Congested traffic states in empirical observations and microscopic simulations", Physical
//! Review E 62 (2000), 1805-1824).
#![expect(clippy::disallowed_methods, reason = "roots of the host alone; no device computes them")]

use super::bays::SWERVE_M_PER_SEC;
use super::{Drive, JAM_M, LOSS, SWERVE_M, Stop, Traffic};

/// Gain of speed, in metres per second squared.
const GAIN: f32 = 1.6;
/// Highest loss of speed, in metres per second squared.
const HARDEST: f32 = 7.0;
/// Time between two vehicles in seconds.
const HEADWAY_SECS: f32 = 1.3;
/// Nothing ahead.
const FREE_M: f32 = 1e4;

impl Traffic {
    /// Returns the acceleration of a vehicle, by its place in the order of vehicles, in metres per
    /// second squared.
    pub(super) fn acceleration(&self, place: usize, stops: &[Stop]) -> f32 {
        let index = self.order[place];
        let vehicle = &self.vehicles[index];
        let lane = &self.lanes[vehicle.lane];
        let half = 0.5 * self.models[vehicle.model].length_m;
        let mut speed = lane.speed * vehicle.pace;
        let mut ahead = self.leader(place).unwrap_or((FREE_M, lane.speed));
        match vehicle.drive {
            Drive::Parks { bay } => {
                let left = self.bays[bay].along_m - vehicle.along_m;
                // Slow from where the brakes must begin, and slower to the end of the bay.
                let slow = SWERVE_M_PER_SEC.powi(2) + 2.0 * LOSS * (left - SWERVE_M).max(0.0);
                speed = speed.min(slow.sqrt()).min((2.0 * left.max(0.0)).sqrt().max(0.3));
            }
            Drive::SetsOff { .. } => speed = speed.min(SWERVE_M_PER_SEC),
            _ => {}
        }
        for stop in stops.iter().filter(|stop| stop.lane == vehicle.lane) {
            let gap = stop.along_m - (vehicle.along_m + half);
            let needed = vehicle.speed.powi(2) / (2.0 * LOSS);
            let is_passed = gap < -stop.past_m || stop.is_polite && gap < needed;
            if !is_passed && gap + JAM_M < ahead.0 {
                // It stops at the line itself, not a distance before it.
                ahead = (gap + JAM_M, 0.0);
            }
        }
        intelligent_driver(vehicle.speed, speed, ahead)
    }

    /// Returns the distance to the vehicle ahead and its speed.
    fn leader(&self, place: usize) -> Option<(f32, f32)> {
        let vehicle = &self.vehicles[self.order[place]];
        let same = |index: &&usize| self.vehicles[**index].lane == vehicle.lane;
        let next = self.order.get(place + 1).filter(same);
        let (next, laps) = match next {
            Some(next) => (*next, 0.0),
            None => (*self.order.iter().find(same)?, self.lanes[vehicle.lane].length_m),
        };
        if next == self.order[place] {
            return None;
        }
        let other = &self.vehicles[next];
        let [own, its] = [vehicle, other].map(|of| 0.5 * self.models[of.model].length_m);
        Some((other.along_m + laps - vehicle.along_m - own - its, other.speed))
    }
}

/// Returns the acceleration of a vehicle behind another.
fn intelligent_driver(speed: f32, wanted: f32, (gap_m, leader): (f32, f32)) -> f32 {
    let closing = speed * (speed - leader) / (2.0 * (GAIN * LOSS).sqrt());
    let distance = JAM_M + (speed * HEADWAY_SECS + closing).max(0.0);
    let free = if speed <= wanted {
        GAIN * (1.0 - (speed / wanted).powi(4))
    } else {
        -LOSS * (1.0 - wanted / speed)
    };
    (free - GAIN * (distance / gap_m.max(0.1)).powi(2)).max(-HARDEST)
}
