//! The ground that feet stand on.

use populace_model::LARGEST;
use populace_model::convert::u32_from;

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
