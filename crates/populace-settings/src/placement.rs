//! Where members are placed in the world.

use populace_model::{Affine, LARGEST_SCALE};

use crate::check::{Check, bounded};
use crate::error::Error;
use crate::fault::Allowed;

/// Position, heading and scale of a member in the world.
///
/// Positions are in single precision: they lie 1 mm apart at 10 km from the origin, 8 mm at 100 km
/// and 6 cm at 1,000 km. Keep crowds within 10 km of the origin. At 100 km planted feet are off by
/// 3 mm, and at 1,000 km by 23 mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    position: [f32; 3],
    yaw_rad: f32,
    scale: f32,
}

impl Placement {
    /// Returns a placement at `position`, in metres, facing +Z at the character's own size.
    #[must_use]
    pub const fn at(position: [f32; 3]) -> Self {
        Self { position, yaw_rad: 0.0, scale: 1.0 }
    }

    /// Sets the heading about +Y: 0 faces +Z, a quarter turn faces +X.
    #[must_use]
    pub const fn facing(mut self, yaw_rad: f32) -> Self {
        self.yaw_rad = yaw_rad;
        self
    }

    /// Sets the factor on the character's own size.
    #[must_use]
    pub const fn scaled(mut self, scale: f32) -> Self {
        self.scale = scale;
        self
    }

    /// The position, in metres.
    #[must_use]
    pub const fn position(&self) -> [f32; 3] {
        self.position
    }

    /// The heading about +Y: 0 faces +Z, a quarter turn faces +X.
    #[must_use]
    pub const fn yaw_rad(&self) -> f32 {
        self.yaw_rad
    }

    /// The factor on the character's own size.
    #[must_use]
    pub const fn scale(&self) -> f32 {
        self.scale
    }

    /// Returns the placement as a matrix.
    #[must_use]
    pub fn world_from_model(&self) -> Affine {
        let (sin, cos) = f64::from(self.yaw_rad).sin_cos();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to the nearest f32 is what is wanted"
        )]
        let (sin, cos) = (sin as f32 * self.scale, cos as f32 * self.scale);
        let [x, y, z] = self.position;
        Affine { rows: [[cos, 0.0, sin, x], [0.0, self.scale, 0.0, y], [-sin, 0.0, cos, z]] }
    }
}

impl Check for Placement {
    fn check(&self) -> Result<(), Error> {
        bounded("the position of a member", &self.position)?;
        bounded("the heading of a member", &[self.yaw_rad])?;
        if (1.0 / LARGEST_SCALE..=LARGEST_SCALE).contains(&self.scale) {
            Ok(())
        } else {
            let allowed = Allowed::Range { least: 1e-4, most: LARGEST_SCALE.into() };
            Err(Error::BadValue { what: "the scale of a member", value: self.scale, allowed })
        }
    }
}
