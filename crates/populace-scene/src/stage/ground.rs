//! Heights of the ground on and around roads.

use glam::Vec2;
use populace::{Ground, Placement};
use populace_props::Road;

use crate::Error;

/// Distance of two points at which the height of the ground is given, in metres.
const GROUND_M: f32 = 0.25;
/// How far the ground is given beyond roads, in metres.
const MARGIN_M: f32 = 1.0;
/// The largest number of points: 64 MiB, or a square kilometre.
const MOST_POINTS: f32 = 16_777_216.0;

/// A road where it lies.
pub(super) struct PlacedRoad<'a> {
    pub(super) road: &'a Road,
    pub(super) placement: Placement,
}

impl PlacedRoad<'_> {
    fn half_m(&self) -> Vec2 {
        Vec2::new(0.5 * self.road.length_m(), self.road.front_m())
    }

    /// Returns the directions of the road's X and Z in the world's X and Z.
    fn axes(&self) -> [Vec2; 2] {
        let along = Vec2::from_angle(-self.placement.yaw_rad());
        [along, along.perp()]
    }

    fn middle(&self) -> Vec2 {
        let [x, _, z] = self.placement.position();
        Vec2::new(x, z)
    }

    /// Returns the corners of the box around the road.
    fn bounds(&self) -> (Vec2, Vec2) {
        let ([along, across], half) = (self.axes(), self.half_m());
        let reach = along.abs() * half.x + across.abs() * half.y;
        (self.middle() - reach, self.middle() + reach)
    }

    /// Returns the height in metres at a point on the road or less than [`GROUND_M`] beside it.
    fn height_m(&self, at: Vec2) -> Option<f32> {
        let own = self.axes().map(|axis| axis.dot(at - self.middle()));
        let inside = Vec2::from(own).abs().cmplt(self.half_m() + GROUND_M).all();
        inside.then(|| self.placement.position()[1] + self.road.height_m(own[0], own[1]))
    }
}

/// Returns the heights of the ground on roads, which is at `plain_m` metres elsewhere; `None` without
/// roads. Where roads overlap, the later one counts.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below MOST_POINTS")]
pub(super) fn of_roads(roads: &[PlacedRoad<'_>], plain_m: f32) -> Result<Option<Ground>, Error> {
    let bounds = roads.iter().map(PlacedRoad::bounds);
    let Some((low, high)) = bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else {
        return Ok(None);
    };
    let (low, high) = (low - MARGIN_M, high + MARGIN_M);
    let counts = ((high - low) / GROUND_M).ceil() + 1.0;
    if counts.x * counts.y > MOST_POINTS {
        return Err(Error::RoadsTooFarApart { size_m: (high - low).to_array() });
    }
    let (count_x, count_z) = (counts.x as usize, counts.y as usize);
    let mut heights = vec![plain_m; count_x * count_z];
    for road in roads {
        let (from, to) = road.bounds();
        let [first, last] = [from, to].map(|at| (at - low) / GROUND_M);
        for row in first.y as usize..=(last.y.ceil() as usize).min(count_z - 1) {
            for column in first.x as usize..=(last.x.ceil() as usize).min(count_x - 1) {
                let at = low + GROUND_M * Vec2::new(column as f32, row as f32);
                if let Some(height_m) = road.height_m(at) {
                    heights[row * count_x + column] = height_m;
                }
            }
        }
    }
    let field = Ground::height_field(low.to_array(), GROUND_M, count_x, heights);
    Ok(Some(field.map_err(populace::Error::from)?))
}

#[cfg(test)]
mod tests {
    use populace_props::RoadPlan;

    use super::*;

    fn road() -> Road {
        populace_props::road(&RoadPlan::default()).expect("a road")
    }

    #[test]
    fn turned_and_raised_roads_carry_people() {
        let road = road();
        let (half_m, front_m) = (0.5 * road.length_m(), road.front_m());
        let placement = Placement::at([40.0, 3.0, -7.0]).facing(std::f32::consts::FRAC_PI_2);
        let placed = [PlacedRoad { road: &road, placement }];
        let ground = of_roads(&placed, 2.0).expect("a ground").expect("a road");
        // The road's X is the world's -Z: along the middle of a sidewalk, then beyond its end.
        let sidewalk = 40.0 + front_m - 0.5;
        assert_eq!(ground.height_at(sidewalk, -7.0 + 0.4 * half_m), 3.0);
        assert_eq!(ground.height_at(sidewalk, -7.0 + half_m + 5.0), 2.0);
        assert!(ground.height_at(40.0, -7.0 + 0.4 * half_m) < 3.0, "the carriageway is lower");
        assert_eq!(ground.height_at(40.0 + front_m + 5.0, -7.0), 2.0);
    }

    #[test]
    fn roads_too_far_apart_are_refused() {
        let road = road();
        let placed = [[0.0; 3], [100_000.0, 0.0, 100_000.0]]
            .map(|at| PlacedRoad { road: &road, placement: Placement::at(at) });
        let error = of_roads(&placed, 0.0).expect_err("too large");
        assert!(error.to_string().contains("square kilometre"), "{error}");
    }
}
