//! What a constraint aims at; the twin of `kernels/targets.cl`.

use populace_device::layout::{
    Constraint, TARGET_DIRECTION, TARGET_WATCHED, TARGET_WORLD, Target, WATCHED_ELEMENTS,
};
use populace_model::math::vec3;

use super::Steering;

/// How far away a direction is looked along, in metres.
const FAR_M: f32 = 1000.0;

impl Steering<'_> {
    pub(super) fn targets(&self, constraint: &Constraint) -> &[Target] {
        let first = constraint.target_first as usize;
        &self.tables.targets().as_slice()[first..first + constraint.target_count as usize]
    }

    /// Where a target is in model space, seen from a point there, and what it weighs now: nothing
    /// before it was ever seen.
    pub(super) fn sight(&self, target: &Target, from: [f32; 3]) -> ([f32; 3], f32) {
        let weight = target.weight_at(self.tick);
        let point = target.point.xyz();
        match target.kind {
            TARGET_WORLD => (self.to_model(point), weight),
            TARGET_DIRECTION => {
                let [sin, cos, ..] = self.control.facing.0;
                let [x, y, z] = point;
                (vec3::add_scaled(from, [cos * x - sin * z, y, sin * x + cos * z], FAR_M), weight)
            }
            TARGET_WATCHED => {
                let first = (target.watched * WATCHED_ELEMENTS) as usize;
                let rows =
                    self.keeping.before.watched.get(first..first + WATCHED_ELEMENTS as usize);
                let [a, b, c] =
                    rows.map_or([[0.0; 4]; 3], |rows| [rows[0].0, rows[1].0, rows[2].0]);
                let place = vec3::add([a[3], b[3], c[3]], point);
                // Written so that what is not finite counts as never seen.
                let seen =
                    a[0] * a[0] + a[1] * a[1] + a[2] * a[2] > 0.0 && vec3::dot(place, place) < 1e30;
                if seen { (self.to_model(place), weight) } else { (from, 0.0) }
            }
            _ => (point, weight),
        }
    }

    /// The mean of all targets, weighted, and how much it weighs, at most 1.
    pub(super) fn goal(&self, constraint: &Constraint, from: [f32; 3]) -> ([f32; 3], f32) {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for target in self.targets(constraint) {
            let (place, weight) = self.sight(target, from);
            if weight > 0.0 {
                sum = vec3::add_scaled(sum, place, weight);
                total += weight;
            }
        }
        if total > 0.0 {
            (vec3::scale(sum, 1.0 / total), if total < 1.0 { total } else { 1.0 })
        } else {
            (from, 0.0)
        }
    }
}
