//! Lanes: where they are, and lengths along them.

use glam::Vec2;

use super::SWERVE_M;
use crate::plan::LanePlan;

/// Distance from the ends of a lane within which vehicles fade out and in, in metres.
const FADE_M: f32 = 6.0;

/// A lane.
#[derive(Clone, Debug)]
pub(crate) struct Lane {
    pub(super) from: Vec2,
    pub(super) direction: Vec2,
    pub(super) length_m: f32,
    pub(super) speed: f32,
    pub(super) yaw_rad: f32,
    pub(super) height_m: f32,
}

impl Lane {
    pub(crate) fn new(plan: &LanePlan) -> Self {
        let [from, to] = plan.ends.map(Vec2::from);
        let direction = (to - from).normalize_or(Vec2::X);
        let yaw_rad = direction.x.atan2(direction.y);
        let length_m = from.distance(to).max(1.0);
        let (speed, height_m) = (plan.speed.clamp(0.1, 40.0), plan.height_m);
        Self { from, direction, length_m, speed, yaw_rad, height_m }
    }

    pub(crate) fn length_m(&self) -> f32 {
        self.length_m
    }

    pub(crate) fn height_m(&self) -> f32 {
        self.height_m
    }

    /// Returns the part of a vehicle that is drawn: it fades out before the end of the lane, from
    /// which it comes to the start, and fades in after it. Above 1 between them.
    pub(crate) fn opacity_at(&self, along_m: f32) -> f32 {
        along_m.min(self.length_m - along_m) / FADE_M.min(0.25 * self.length_m)
    }

    /// Returns true if a vehicle can park in a bay at a point and set off again before the end of
    /// the lane, from which it comes to the start.
    pub(crate) fn has_room_for_bay(&self, at: Vec2) -> bool {
        let [along_m, _] = self.place(at);
        along_m >= SWERVE_M && along_m + SWERVE_M <= self.length_m
    }

    /// Returns how far a length along the lane is ahead of another, or behind it as a negative
    /// number: the shorter way, since the end of the lane comes to its start.
    pub(super) fn off_m(&self, from_m: f32, to_m: f32) -> f32 {
        let ahead_m = (to_m - from_m).rem_euclid(self.length_m);
        if ahead_m > 0.5 * self.length_m { ahead_m - self.length_m } else { ahead_m }
    }

    /// Returns the length along the lane of the point nearest to another, and its distance to
    /// the left.
    pub(crate) fn place(&self, point: Vec2) -> [f32; 2] {
        let off = point - self.from;
        [off.dot(self.direction), off.dot(Vec2::new(self.direction.y, -self.direction.x))]
    }
}
