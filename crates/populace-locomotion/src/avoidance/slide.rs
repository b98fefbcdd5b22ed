//! Discs that slide along walls. This is the guarantee that nothing passes a wall: whatever moves a
//! walker, its last step goes through here.

use glam::{DVec2, Vec2};

use super::walls::{Wall, Walls};

/// The distance in metres that a disc keeps from walls beyond its radius, so that rounding does not
/// bring it nearer than that. Grows with the distance from the origin, as rounding does.
const SKIN_M: f64 = 1e-3;
const SKIN_SHARE: f64 = 1e-6;
/// The most walls in a row that one step slides along.
const MOST_SLIDES: usize = 6;
/// The most steps of Newton's method for one contact.
const MOST_ITERATIONS: usize = 24;
/// How far a disc that starts too near to a wall is led out in one call, in metres.
const MOST_OUT_M: f64 = 0.05;

/// A wall relative to the disc's centre.
struct Near {
    from: DVec2,
    to: DVec2,
}

impl Near {
    fn new(wall: &Wall, centre: Vec2) -> Self {
        let centre = centre.as_dvec2();
        Self { from: wall.from.as_dvec2() - centre, to: wall.to.as_dvec2() - centre }
    }

    /// Returns the vector from the nearest point of the wall to `at`.
    fn away(&self, at: DVec2) -> DVec2 {
        let along = self.to - self.from;
        let share = (at - self.from).dot(along) / along.length_squared();
        at - (self.from + along * share.clamp(0.0, 1.0))
    }

    /// Returns the distance to `at`, and the direction away from the wall.
    fn distance(&self, at: DVec2) -> (f64, DVec2) {
        let away = self.away(at);
        let distance = away.length();
        let side = (self.to - self.from).perp();
        (distance, if distance > 0.0 { away / distance } else { side.normalize_or(DVec2::X) })
    }

    /// Returns the share of a step at which the centre comes to a distance, 0 to 1, and the
    /// direction away from the wall there; `None` if the step is free.
    ///
    /// The distance from a segment is convex along a line. So Newton's method, started from
    /// outside, comes to the first contact and never passes it.
    fn contact(&self, step: DVec2, least: f64) -> Option<(f64, DVec2)> {
        let mut share = 0.0;
        let mut normal = DVec2::ZERO;
        for _ in 0..MOST_ITERATIONS {
            let distance;
            (distance, normal) = self.distance(step * share);
            let rate = normal.dot(step);
            // A step along the wall is free, with what rounding left of the part across it.
            if rate >= -1e-12 * step.length() {
                return None;
            }
            let left = distance - least;
            if left <= 1e-9 {
                return Some((share, normal));
            }
            share -= left / rate;
            if share >= 1.0 {
                return None;
            }
        }
        Some((share, normal))
    }

    /// Returns whether the line from the origin to `to` meets the wall.
    fn is_crossed(&self, to: DVec2) -> bool {
        let sides = |from: DVec2, to: DVec2, a: DVec2, b: DVec2| {
            let along = to - from;
            along.perp_dot(a - from) * along.perp_dot(b - from) < 0.0
        };
        sides(DVec2::ZERO, to, self.from, self.to) && sides(self.from, self.to, DVec2::ZERO, to)
    }
}

impl Walls {
    /// Moves a disc; see [`super::Avoidance::slide`].
    pub(crate) fn slide(&self, from: Vec2, to: Vec2, radius: f32) -> Vec2 {
        let radius = f64::from(radius);
        let mut at = from;
        let mut left = self.way_out(from, to.as_dvec2() - from.as_dvec2(), radius);
        for _ in 0..MOST_SLIDES {
            let skin = SKIN_M + SKIN_SHARE * f64::from(at.abs().max_element());
            let mut first = (1.0, None);
            self.along(at, left, radius + skin, |wall| {
                match Near::new(wall, at).contact(left, radius + skin) {
                    Some((share, normal)) if share < first.0 => first = (share, Some(normal)),
                    _ => {}
                }
            });
            let (share, normal) = first;
            let next = (at.as_dvec2() + left * share).as_vec2();
            if self.allows(at, next, radius) {
                at = next;
            }
            let Some(normal) = normal else { break };
            left *= 1.0 - share;
            left -= normal * left.dot(normal).min(0.0);
        }
        at
    }

    /// Returns a step that also leads the disc away from the wall that it is deepest in.
    fn way_out(&self, from: Vec2, step: DVec2, radius: f64) -> DVec2 {
        let mut deepest = 0.0;
        let mut normal = DVec2::ZERO;
        self.along(from, DVec2::ZERO, radius, |wall| {
            let (distance, away) = Near::new(wall, from).distance(DVec2::ZERO);
            if radius - distance > deepest {
                (deepest, normal) = (radius - distance, away);
            }
        });
        step + normal * (deepest.min(MOST_OUT_M) - step.dot(normal).min(0.0))
    }

    /// Returns whether a step crosses no wall and comes nearer to none than the radius, or than it
    /// was.
    fn allows(&self, from: Vec2, to: Vec2, radius: f64) -> bool {
        let step = to.as_dvec2() - from.as_dvec2();
        let farthest = f64::from(from.abs().max_element());
        let mut allowed = true;
        self.along(from, step, radius, |wall| {
            let wall = Near::new(wall, from);
            let (before, _) = wall.distance(DVec2::ZERO);
            let (after, _) = wall.distance(step);
            // A disc that starts too near may move along the wall in spite of rounding.
            let slack = if before < radius { 1e-6 + SKIN_SHARE * farthest } else { 0.0 };
            allowed &= after + slack >= before.min(radius) && !wall.is_crossed(step);
        });
        allowed
    }

    /// Calls `visit` with all walls within a distance of a step.
    fn along(&self, from: Vec2, step: DVec2, distance: f64, mut visit: impl FnMut(&Wall)) {
        let to = from + step.as_vec2();
        // Rounded up, by more than the rounding of the corners.
        let beyond = DVec2::splat(distance + 0.01).as_vec2() + from.abs().max(to.abs()) * 1e-6;
        self.within(from.min(to) - beyond, from.max(to) + beyond, |_, wall| visit(wall));
    }
}
