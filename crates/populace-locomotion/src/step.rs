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
        let [x, z] = velocity.map(|speed| speed / ankles);
        // Feet that roll by more than the body moves would be led to the back, where they come down
        // and stay.
        let along = if z < 0.0 { z } else { (z - rolls / ankles).max(0.0) };
        Stride::along([x, along]).turning_rad_per_m(turn_rad_per_sec / ankles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ankles_make_up_for_the_roll_of_feet_and_stay_below_the_body_on_the_spot() {
        let step = Step { mix: 0.5, cycles_per_sec: 1.0, stride_m: 0.5, ankle_m: 0.25 };
        let lead = |along: f32| step.stride([0.0, along], 0.0).lead()[1];
        assert_eq!([lead(0.5), lead(0.75), lead(0.0), lead(-0.5)], [1.0, 2.0, 0.0, -2.0]);
        let back = Step { cycles_per_sec: -1.0, ..step };
        assert_eq!(back.stride([0.0, -0.5], 0.0).lead(), [-0.0, 1.0]);
    }
}
