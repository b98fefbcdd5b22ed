//! Footways: where on them somebody is, and the way along them.

use glam::Vec2;

use crate::Error;
use crate::plan::FootwayPlan;

/// Distance that people keep from the edge of a footway, in metres.
const EDGE_M: f32 = 0.5;

/// A strip along a line.
#[derive(Clone, Debug)]
pub(crate) struct Footway {
    points: Vec<Vec2>,
    /// Length along the line up to each point.
    lengths: Vec<f32>,
    /// Half the width on which people walk.
    pub(crate) half_m: f32,
}

/// A place on a footway.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Length along the line, in metres.
    pub(crate) along_m: f32,
    /// Distance to the left of the line, in metres.
    pub(crate) aside_m: f32,
}

impl Footway {
    /// Makes a footway of a plan. One without length is an error.
    pub(crate) fn new(plan: &FootwayPlan) -> Result<Self, Error> {
        let mut points: Vec<Vec2> = plan.points.iter().map(|point| Vec2::from(*point)).collect();
        points.dedup();
        let mut lengths = vec![0.0];
        let mut length = 0.0;
        for pair in points.windows(2) {
            length += pair[0].distance(pair[1]);
            lengths.push(length);
        }
        let half_m = (0.5 * plan.width_m - EDGE_M).max(0.1);
        if length > 0.0 && length.is_finite() {
            return Ok(Self { points, lengths, half_m });
        }
        Err(Error::FootwayWithoutLength { name: plan.name.clone() })
    }

    pub(crate) fn length_m(&self) -> f32 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Returns the point at a place, and the direction of the line there.
    pub(crate) fn at(&self, place: Place) -> (Vec2, Vec2) {
        let along = place.along_m.clamp(0.0, self.length_m());
        let next = self.lengths.partition_point(|length| *length <= along);
        let from = next.clamp(1, self.points.len() - 1) - 1;
        let (a, b) = (self.points[from], self.points[from + 1]);
        let direction = (b - a).normalize_or_zero();
        let left = Vec2::new(direction.y, -direction.x);
        (a + direction * (along - self.lengths[from]) + left * place.aside_m, direction)
    }

    /// Returns the place of a point.
    pub(crate) fn place(&self, point: Vec2) -> Place {
        let mut best = (f32::INFINITY, Place { along_m: 0.0, aside_m: 0.0 });
        for (pair, from) in self.points.windows(2).zip(&self.lengths) {
            let direction = (pair[1] - pair[0]).normalize_or_zero();
            let off = point - pair[0];
            let along = off.dot(direction).clamp(0.0, pair[0].distance(pair[1]));
            let distance = off.distance_squared(direction * along);
            if distance < best.0 {
                let aside_m = off.dot(Vec2::new(direction.y, -direction.x));
                best = (distance, Place { along_m: from + along, aside_m });
            }
        }
        best.1
    }

    /// Returns the distance of a point from the strip, 0 within it.
    pub(crate) fn distance_m(&self, point: Vec2) -> f32 {
        let place = self.place(point);
        let half = self.half_m + EDGE_M;
        let inside = Place { aside_m: place.aside_m.clamp(-half, half), ..place };
        self.at(inside).0.distance(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_points_agree_around_a_corner() {
        let plan = FootwayPlan {
            name: "corner".into(),
            points: vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]],
            width_m: 4.0,
        };
        let footway = Footway::new(&plan).unwrap();
        assert_eq!(footway.length_m(), 20.0);
        // Facing +X, the left is -Z; facing +Z, it is +X.
        for (along_m, aside_m, point) in
            [(4.0, 1.0, [4.0, -1.0]), (15.0, 1.0, [11.0, 5.0]), (15.0, -1.0, [9.0, 5.0])]
        {
            let place = Place { along_m, aside_m };
            assert!(footway.at(place).0.distance(point.into()) < 1e-5, "{point:?}");
            let back = footway.place(point.into());
            assert!((back.along_m - along_m).abs() < 1e-5 && (back.aside_m - aside_m).abs() < 1e-5);
        }
        assert_eq!(footway.distance_m([5.0, 1.9].into()), 0.0);
        assert!((footway.distance_m([5.0, -3.0].into()) - 1.0).abs() < 1e-5);
    }
}
