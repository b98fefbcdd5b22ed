//! Targets of constraints: where they are and how much they weigh.

use glam::{DAffine3, DMat3, DVec3};
use populace_clip::TICKS_PER_SEC;
use populace_device::Place;
use populace_device::layout::{
    TARGET_DIRECTION, TARGET_FAR_M, TARGET_WATCHED, TARGET_WORLD, Target,
};

use super::Descent;

/// Where a member stands in the world.
#[derive(Clone, Copy, Debug)]
pub struct OraclePlace {
    /// `world_from_model`: a heading about +Y and one factor of scale.
    pub world_from_model: DAffine3,
}

impl Default for OraclePlace {
    fn default() -> Self {
        Self { world_from_model: DAffine3::IDENTITY }
    }
}

impl OraclePlace {
    /// Takes over a member's place.
    #[must_use]
    pub fn new(place: &Place) -> Self {
        let [sin, cos] = place.sin_cos.map(f64::from);
        let turned =
            DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
        let translation = DVec3::from_array(place.position.map(f64::from));
        Self {
            world_from_model: DAffine3 { matrix3: turned * f64::from(place.scale), translation },
        }
    }
}

/// A target at one instant.
pub(super) struct Sight {
    /// In model space.
    pub(super) position: DVec3,
    pub(super) weight: f64,
}

impl Descent<'_, '_> {
    /// Returns where targets are, seen from a point in model space, and their weights; those of no
    /// weight are left out.
    pub(super) fn sights(&mut self, targets: &[Target], from: DVec3) -> Vec<Sight> {
        let world_from_model = self.frame.place.world_from_model;
        let model_from_world = world_from_model.inverse();
        let mut seen = Vec::new();
        for target in targets {
            let weight = weight_at(target, self.frame.tick);
            let point = DVec3::from_array(target.point.xyz().map(f64::from));
            let position = match target.kind {
                TARGET_WORLD => Some(model_from_world.transform_point3(point)),
                TARGET_DIRECTION => {
                    // A direction keeps its length, whatever the member's scale is.
                    let scale = world_from_model.matrix3.y_axis.length();
                    let direction = model_from_world.transform_vector3(point) * scale;
                    Some(from + direction * f64::from(TARGET_FAR_M))
                }
                TARGET_WATCHED => self
                    .frame
                    .watched
                    .get(&target.watched)
                    .map(|joint| model_from_world.transform_point3(joint.translation + point)),
                _ => Some(point),
            };
            if let (Some(position), true) = (position, weight > 0.0) {
                let at = self.noise.vector(world_from_model.translation);
                let off =
                    (at - world_from_model.translation) + self.noise.vector(position) - position;
                let weight = self.noise.number(weight);
                seen.push(Sight { position: position + off, weight });
            }
        }
        seen
    }

    /// Returns the mean of all targets by weight, and the sum of their weights, at most 1. `None`
    /// if none has a weight.
    pub(super) fn goal(&mut self, targets: &[Target], from: DVec3) -> Option<Sight> {
        let sights = self.sights(targets, from);
        let total: f64 = sights.iter().map(|sight| sight.weight).sum();
        let sum: DVec3 = sights.iter().map(|sight| sight.position * sight.weight).sum();
        (total > 0.0).then(|| Sight { position: sum / total, weight: total.min(1.0) })
    }
}

/// Returns the weight of a target: a ramp from one value to another, at the given rate, eased at
/// both ends by the cubic `3 w^2 - 2 w^3`.
fn weight_at(target: &Target, tick: u64) -> f64 {
    let (start, end) = (f64::from(target.start_weight), f64::from(target.end_weight));
    let secs = tick.saturating_sub(target.weight_tick) as f64 / TICKS_PER_SEC as f64;
    let moved = start + f64::from(target.weight_rate) * secs;
    let ramp =
        if target.weight_rate == 0.0 { end } else { moved.clamp(start.min(end), start.max(end)) };
    ramp * ramp * (3.0 - 2.0 * ramp)
}
