//! The ground that feet stand on: a plane, or heights on a grid.

use glam::DVec3;

use super::noise::Noise;

/// The ground in world space.
#[derive(Clone, Debug)]
pub enum OracleGround {
    /// A plane.
    Plane {
        /// The height at the origin, in metres.
        height: f64,
        /// The slopes along +X and +Z.
        slopes: [f64; 2],
    },
    /// Heights in between samples are interpolated bilinearly.
    Heights {
        /// World x and z of the first sample, in metres.
        corner: [f64; 2],
        /// The distance between samples, in metres.
        spacing_m: f64,
        /// Number of samples along +X, which vary fastest.
        count_x: usize,
        /// Heights in metres.
        heights: Vec<f64>,
    },
}

impl OracleGround {
    /// Returns whether the ground has heights on a grid.
    pub(super) fn has_heights(&self) -> bool {
        matches!(self, Self::Heights { .. })
    }

    /// Returns the height and the upward unit normal at a point.
    pub(super) fn at(&self, point: DVec3, noise: &mut Noise) -> (f64, DVec3) {
        let (height, [slope_x, slope_z]) = match self {
            Self::Plane { height, slopes: [x, z] } => {
                let [x_part, z_part] = [x * point.x, z * point.z];
                let size = height.abs() + x_part.abs() + z_part.abs();
                (noise.near(height + x_part + z_part, size), [*x, *z])
            }
            Self::Heights { corner, spacing_m, count_x, heights } => {
                let rows = heights.len() / count_x;
                let mut cell = |at: f64, from: f64, count: usize| {
                    let at = noise.near(at - from, at.abs() + from.abs()) / spacing_m;
                    let at = at.clamp(0.0, (count - 1) as f64);
                    let first = (0..count - 1).rev().find(|n| *n as f64 <= at).unwrap_or(0);
                    (first, at - first as f64)
                };
                let (column, across) = cell(point.x, corner[0], *count_x);
                let (row, along) = cell(point.z, corner[1], rows);
                let height = |row: usize, column: usize| heights[row * count_x + column];
                let mut parts = [[0.0; 2]; 2];
                for (r, parts) in parts.iter_mut().enumerate() {
                    *parts = [height(row + r, column), height(row + r, column + 1)];
                }
                let [near, far] = parts;
                let size = near.iter().chain(&far).fold(0.0, |a: f64, h| a.max(h.abs()));
                let mix = |a: f64, b: f64, part: f64| a * (1.0 - part) + b * part;
                let high = mix(mix(near[0], near[1], across), mix(far[0], far[1], across), along);
                let slope_x = mix(near[1] - near[0], far[1] - far[0], along) / spacing_m;
                let slope_z = mix(far[0] - near[0], far[1] - near[1], across) / spacing_m;
                let slopes = [slope_x, slope_z].map(|s| noise.near(s, size / spacing_m));
                (noise.near(high, size), slopes)
            }
        };
        (height, noise.vector(DVec3::new(-slope_x, 1.0, -slope_z).normalize()))
    }
}
