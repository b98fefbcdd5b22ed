//! Where a member stands that gets up from where it lies.

use populace::Placement;

use super::Doll;
use crate::math::{Rotation, Vector};
use crate::world::World;

/// How far below the hips a floor is looked for, in metres, for a member of scale 1.
const FLOOR_WITHIN_M: f32 = 4.0;

impl Doll {
    /// The placement whose rest pose has its hips over or under where they are now, and faces where
    /// the body does once it is set upright by the shortest turn: one that lies on its back gets up
    /// towards its feet.
    pub(crate) fn place_to_get_up(&self, place: Placement, world: &World) -> Placement {
        let hips = self.root_pose(world);
        let (rest_turn, rest_place) = self.plan.rest();
        let world_from_rest = hips.rotation * rest_turn.inverse();
        let upright =
            Rotation::from_rotation_arc((world_from_rest * Vector::Y).normalize(), Vector::Y);
        let front = upright * (world_from_rest * Vector::Z);
        let yaw_rad = front.x.atan2(front.z);
        let aside = Rotation::from_rotation_y(yaw_rad)
            * (rest_place * Vector::new(1.0, 0.0, 1.0))
            * place.scale();
        let [_, height, _] = place.position();
        let above = hips.translation + Vector::Y * 0.1 * place.scale();
        let floor = world.floor_under(above, FLOOR_WITHIN_M * place.scale()).unwrap_or(height);
        let at = hips.translation - aside;
        let placed = Placement::at([at.x, floor, at.z]).facing(yaw_rad);
        placed.scaled(place.scale())
    }
}
