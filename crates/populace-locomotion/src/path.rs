//! Paths that walkers follow.

use glam::Vec2;

use crate::Error;
use crate::avoidance::LARGEST_M;

/// Distance at which a walker turns to the next point of its path, in metres.
const REACHED_M: f32 = 0.5;
/// The same in seconds of its way: who is fast turns earlier.
const REACHED_SECS: f32 = 0.4;
/// Distance from its goal at which a walker has arrived, in metres.
const ARRIVED_M: f32 = 0.05;

/// Points on the ground that a walker passes in turn, `[x, z]` in metres. Equal points in a row
/// count once.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    points: Vec<Vec2>,
    closed: bool,
}

impl Path {
    /// Returns a path that ends at its last point.
    ///
    /// # Errors
    ///
    /// Fewer than two points, or a coordinate that is not from -1e6 to 1e6.
    pub fn new(points: &[[f32; 2]]) -> Result<Self, Error> {
        if points.len() < 2 {
            return Err(Error::ShortPath { points: points.len() });
        }
        points.iter().flatten().try_for_each(|value| check_coordinate(*value))?;
        Ok(Self { points: points.iter().copied().map(Vec2::from).collect(), closed: false })
    }

    /// Makes the path go on from its last point to its first.
    #[must_use]
    pub const fn closed(mut self) -> Self {
        self.closed = true;
        self
    }

    /// Returns the index of the point after another.
    pub(crate) fn after(&self, nth: u32) -> u32 {
        if (nth as usize) + 1 < self.points.len() { nth + 1 } else { 0 }
    }

    /// Returns a point to go to.
    pub(crate) fn target(&self, nth: u32) -> Target {
        let last = self.points.len() - 1;
        let nth = (nth as usize).min(last);
        Target { point: self.points[nth], is_end: nth == last && !self.closed }
    }
}

/// A point that a walker goes to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) point: Vec2,
    /// True if it stops there.
    pub(crate) is_end: bool,
}

impl Target {
    /// Returns whether a walker that does not stop there turns to the next point.
    pub(crate) fn is_passed(&self, at: Vec2, speed: f32) -> bool {
        let near = REACHED_M.max(REACHED_SECS * speed);
        !self.is_end && at.distance_squared(self.point) < near * near
    }

    /// Returns whether a walker that stops at the point is there.
    pub(crate) fn is_reached(&self, at: Vec2) -> bool {
        at.distance_squared(self.point) < ARRIVED_M * ARRIVED_M
    }

    /// Returns the velocity for a step of `secs` towards the point.
    #[expect(clippy::disallowed_methods, reason = "no device computes it; hosts round alike")]
    pub(crate) fn velocity(&self, at: Vec2, speed: f32, slows: f32, secs: f32) -> Vec2 {
        let way = self.point - at;
        let distance = way.length();
        if self.is_end && distance < ARRIVED_M || distance == 0.0 {
            return Vec2::ZERO;
        }
        // It can stop within the way: v^2 = 2 a s, with a margin. A long step ends at the point.
        let stops = || (1.4 * slows * distance).sqrt().min(distance / secs);
        let most = if self.is_end { speed.min(stops()) } else { speed };
        way * (most / distance)
    }
}

/// Refuses a coordinate that is not finite or too far away.
pub(crate) fn check_coordinate(value: f32) -> Result<(), Error> {
    crate::error::within("a coordinate", value, -LARGEST_M..=LARGEST_M, "from -1e6 to 1e6")
}
