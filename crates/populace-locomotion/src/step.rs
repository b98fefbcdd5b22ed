//! How a member steps at a speed.

use populace::{SpacePoint, Stride};

/// How a member steps at a speed, at the scale of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The mix of clips: a point of the blend space.
    pub mix: f32,
    /// Cycles of two steps in a second.
    pub cycles_per_sec: f32,
    /// Metres by which the mix itself passes over the ground in a cycle: by the median velocity of
    /// the soles that its clips plant.
    pub stride_m: f32,
    /// Metres that a stride adds to it for each time more that ankles step what they do in the
    /// mix, around this speed. What feet roll stays as it is.
    pub ankle_m: f32,
}

impl Step {
    /// Returns the point of the blend space.
    #[must_use]
    pub fn point(&self) -> SpacePoint {
        SpacePoint::from(self.mix).at_cycles_per_sec(self.cycles_per_sec)
    }

    /// Returns the stride of a member that moves at a velocity `[x, z]` in its model space, in
    /// metres per second at the scale of 1, and turns at a rate in radians per second.
    #[must_use]
    pub fn stride(&self, velocity: [f32; 2], turn_rad_per_sec: f32) -> Stride {
        // While the cycle goes on, ankles pass at this velocity. The stride leads them alone: what
        // feet roll stays as it is.
        let ankles = self.cycles_per_sec * self.ankle_m;
        let rolls = self.cycles_per_sec * self.stride_m - ankles;
        if ankles == 0.0 {
            return Stride::OF_CLIPS;
        }
        let [x, z] = velocity;
        Stride::along([x / ankles, (z - rolls) / ankles])
            .turning_rad_per_m(turn_rad_per_sec / ankles)
    }
}
