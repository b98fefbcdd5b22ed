//! The ground that feet stand on. Twin of the functions of the ground in `kernels/foothold.cl`.

use populace_model::LARGEST;
use populace_model::convert::u32_from;
use populace_model::math::{Real, vec3};

use crate::Error;
use crate::fault::{ConstraintFault, ConstraintPart};
use crate::layout;
use crate::tables::Tables;

/// The ground in world space: a plane, or heights on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    plane: layout::Ground,
    heights: Vec<f32>,
}

impl Ground {
    /// Creates a plane with the given height in metres at the world's origin and slopes in metres
    /// per metre along +X and +Z.
    ///
    /// # Errors
    ///
    /// [`Error::BadConstraint`] if a number is not finite or its magnitude exceeds [`LARGEST`].
    pub fn plane(height: f32, [slope_x, slope_z]: [f32; 2]) -> Result<Self, Error> {
        if [height, slope_x, slope_z].iter().all(|v| v.abs() <= LARGEST) {
            let plane =
                layout::Ground { offset: height, slope_x, slope_z, ..layout::Ground::default() };
            return Ok(Self { plane, heights: Vec::new() });
        }
        Err(ConstraintFault::NotBounded { part: ConstraintPart::GroundPlane }.into())
    }

    /// Creates a height field from heights in metres. The grid begins at `corner` (world x and z in
    /// metres) and has a sample every `spacing_m` metres; `count_x` samples are along +X, which
    /// vary fastest. Heights are interpolated bilinearly between samples; outside the grid those of
    /// its border continue.
    ///
    /// # Errors
    ///
    /// [`Error::BadConstraint`] if a number is not finite or its magnitude exceeds [`LARGEST`], the
    /// spacing is not above 0, or there are fewer than two samples in either direction.
    pub fn height_field(
        corner: [f32; 2],
        spacing_m: f32,
        count_x: usize,
        heights: Vec<f32>,
    ) -> Result<Self, Error> {
        let count_z = heights.len().checked_div(count_x).unwrap_or(0);
        let numbers = heights.iter().chain(&corner).all(|v| v.abs() <= LARGEST);
        let grid = count_x >= 2 && count_z >= 2 && count_x * count_z == heights.len();
        let per_metre = 1.0 / spacing_m;
        if !(numbers && grid && spacing_m > 0.0 && per_metre.is_finite() && per_metre > 0.0) {
            let heights = heights.len();
            return Err(ConstraintFault::HeightField { heights, count_x, spacing_m }.into());
        }
        let plane = layout::Ground {
            grid_x: corner[0],
            grid_z: corner[1],
            per_metre,
            count_x: u32_from(count_x),
            count_z: u32_from(count_z),
            ..layout::Ground::default()
        };
        Ok(Self { plane, heights })
    }

    /// Returns the height in metres at a point of the world.
    #[must_use]
    pub fn height_at(&self, x: f32, z: f32) -> f32 {
        self.plane.at(&self.heights, x, z).0
    }
}

/// Returns the last sample at or before a position on a grid, except the very last one, and the
/// part of the way to the next sample. Positions are in samples, and clamped to the grid.
fn grid_sample(at: f32, count: u32) -> (u32, f32) {
    let last = (count - 1) as f32;
    let at = if at > 0.0 { if at < last { at } else { last } } else { 0.0 };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and a count"
    )]
    let whole = (at as u32).min(count - 2);
    (whole, at - whole as f32)
}

impl layout::Ground {
    /// Returns the height of the plane, without the grid, at a point of the world.
    #[inline(always)]
    #[must_use]
    pub fn plane_at<R: Real>(&self, x: R, z: R) -> R {
        R::splat(self.offset) + R::splat(self.slope_x) * x + R::splat(self.slope_z) * z
    }

    /// Returns the height and the upward unit normal at a point of the world. `heights` are the
    /// samples of the grid.
    #[must_use]
    pub fn at(&self, heights: &[f32], x: f32, z: f32) -> (f32, [f32; 3]) {
        let mut height = self.plane_at(x, z);
        let mut slope = [self.slope_x, self.slope_z];
        if self.per_metre > 0.0 {
            let (column, across) = grid_sample((x - self.grid_x) * self.per_metre, self.count_x);
            let (row, along) = grid_sample((z - self.grid_z) * self.per_metre, self.count_z);
            let at = |row: u32, column: u32| heights[(row * self.count_x + column) as usize];
            let (h00, h10) = (at(row, column), at(row, column + 1));
            let (h01, h11) = (at(row + 1, column), at(row + 1, column + 1));
            let (near, far) = (h00 + (h10 - h00) * across, h01 + (h11 - h01) * across);
            height += near + (far - near) * along;
            slope[0] += ((h10 - h00) + ((h11 - h01) - (h10 - h00)) * along) * self.per_metre;
            slope[1] += (far - near) * self.per_metre;
        }
        (height, vec3::unit_or([-slope[0], 1.0, -slope[1]], [0.0, 1.0, 0.0]))
    }
}

impl Default for Ground {
    /// The level ground through the world's origin.
    fn default() -> Self {
        Self { plane: layout::Ground::default(), heights: Vec::new() }
    }
}

impl Tables {
    /// Sets the ground.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 32-bit offsets.
    pub fn set_ground(&mut self, ground: &Ground) -> Result<(), Error> {
        self.all.heights.truncate(0);
        self.all.heights.extend(ground.heights.iter().copied())?;
        self.all.ground.grow(1, ground.plane);
        self.all.ground.set(0, ground.plane);
        Ok(())
    }
}
