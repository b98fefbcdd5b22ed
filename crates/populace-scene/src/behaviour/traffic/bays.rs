//! Bays: how vehicles park in them, and leave them for the road.

use glam::Vec2;
use populace::Placement;

use super::{Drive, LOSS, Lane, SWERVE_M, Traffic, Vehicle};

/// Speed while a vehicle parks or sets off, in metres per second.
pub(super) const SWERVE_M_PER_SEC: f32 = 3.2;
/// Free lengths of the lane behind and ahead of a vehicle that sets off, in metres.
const MERGE_M: [f32; 2] = [16.0, 7.0];

/// A place to park.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bay {
    pub(crate) lane: usize,
    pub(crate) along_m: f32,
    /// Distance of its middle to the left of the lane's line, in metres.
    pub(super) aside_m: f32,
    pub(crate) vehicle: Option<usize>,
}

impl Traffic {
    pub(super) fn placement(&self, lane: usize, along_m: f32, drive: Drive) -> Placement {
        let Lane { from, direction, yaw_rad, height_m, .. } = self.lanes[lane];
        let (aside_m, slope) = match drive {
            Drive::Cruises => (0.0, 0.0),
            Drive::Stands { bay, .. } => (self.bays[bay].aside_m, 0.0),
            Drive::Parks { bay } => {
                let Bay { along_m: to, aside_m, .. } = self.bays[bay];
                let (part, slope) = eased((along_m - (to - SWERVE_M)) / SWERVE_M);
                (part * aside_m, slope * aside_m / SWERVE_M)
            }
            Drive::SetsOff { bay } => {
                let Bay { along_m: from, aside_m, .. } = self.bays[bay];
                let (part, slope) = eased((along_m - from) / SWERVE_M);
                ((1.0 - part) * aside_m, -slope * aside_m / SWERVE_M)
            }
        };
        let left = Vec2::new(direction.y, -direction.x);
        let at = from + direction * along_m + left * aside_m;
        Placement::at([at.x, height_m, at.y]).facing(yaw_rad + slope.atan())
    }

    /// Sends a vehicle that stands back to the road if there is room. Returns true if it set off.
    pub(crate) fn set_off(&mut self, vehicle: usize) -> bool {
        let Vehicle { lane, along_m, drive: Drive::Stands { bay, .. }, .. } =
            self.vehicles[vehicle]
        else {
            return false;
        };
        let is_free = self.vehicles.iter().enumerate().all(|(index, other)| {
            let off = self.lanes[lane].off_m(along_m, other.along_m);
            let [behind, ahead] = MERGE_M;
            let is_near = off > -(behind + 1.5 * other.speed) && off < ahead;
            index == vehicle
                || other.lane != lane
                || matches!(other.drive, Drive::Stands { .. })
                || !is_near
        });
        if is_free {
            self.vehicles[vehicle].drive = Drive::SetsOff { bay };
        }
        is_free
    }

    /// Sends a vehicle that cruises to a free bay ahead. Returns true if there is one.
    pub(crate) fn park(&mut self, vehicle: usize) -> bool {
        let Vehicle { lane, along_m, speed, drive: Drive::Cruises, .. } = self.vehicles[vehicle]
        else {
            return false;
        };
        let brakes_m = SWERVE_M + speed.powi(2) / (1.2 * LOSS);
        let is_ahead = |bay: &Bay| (brakes_m..brakes_m + 25.0).contains(&(bay.along_m - along_m));
        let free = |bay: &Bay| bay.lane == lane && bay.vehicle.is_none() && is_ahead(bay);
        let Some(bay) = self.bays.iter().position(free) else { return false };
        self.bays[bay].vehicle = Some(vehicle);
        self.vehicles[vehicle].drive = Drive::Parks { bay };
        true
    }
}

/// Returns a smooth step from 0 to 1, and its slope.
fn eased(part: f32) -> (f32, f32) {
    let part = part.clamp(0.0, 1.0);
    (part * part * (3.0 - 2.0 * part), 6.0 * part * (1.0 - part))
}
