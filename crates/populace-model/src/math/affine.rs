//! Affine transforms as three rows of four; twin of `kernels/affine.cl`.

use super::{Real, Trs};

/// Returns the twelve elements, row by row, of the matrix of translation times rotation times scale
/// (glTF 2.0, section 3.5.3).
#[inline(always)]
#[must_use]
pub fn components<R: Real>(t: [R; 3], [x, y, z, w]: [R; 4], s: [R; 3]) -> [R; 12] {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    [
        (one - two * (y * y + z * z)) * s[0],
        (two * (x * y - w * z)) * s[1],
        (two * (x * z + w * y)) * s[2],
        t[0],
        (two * (x * y + w * z)) * s[0],
        (one - two * (x * x + z * z)) * s[1],
        (two * (y * z - w * x)) * s[2],
        t[1],
        (two * (x * z - w * y)) * s[0],
        (two * (y * z + w * x)) * s[1],
        (one - two * (x * x + y * y)) * s[2],
        t[2],
    ]
}

/// A 3x4 matrix, row-major: `rows[r][c]`. The missing fourth row is `0 0 0 1`.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Affine {
    /// Three rows; the last column is the translation.
    pub rows: [[f32; 4]; 3],
}

impl Affine {
    /// The identity transform.
    pub const IDENTITY: Self =
        Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// The matrix of translation times rotation times scale (glTF 2.0, section 3.5.3).
    #[inline]
    #[must_use]
    pub fn from_trs(trs: &Trs) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l] =
            components(trs.translation, trs.rotation, trs.scale);
        Self { rows: [[a, b, c, d], [e, f, g, h], [i, j, k, l]] }
    }

    /// Composes two transforms, `self * other`: `other` is applied first.
    #[inline]
    #[must_use]
    pub fn mul(&self, other: &Self) -> Self {
        let b = &other.rows;
        let row = |a: [f32; 4]| -> [f32; 4] {
            [
                a[0] * b[0][0] + a[1] * b[1][0] + a[2] * b[2][0],
                a[0] * b[0][1] + a[1] * b[1][1] + a[2] * b[2][1],
                a[0] * b[0][2] + a[1] * b[1][2] + a[2] * b[2][2],
                a[0] * b[0][3] + a[1] * b[1][3] + a[2] * b[2][3] + a[3],
            ]
        };
        Self { rows: [row(self.rows[0]), row(self.rows[1]), row(self.rows[2])] }
    }

    /// Transforms a point.
    #[inline]
    #[must_use]
    pub fn transform_point(&self, p: [f32; 3]) -> [f32; 3] {
        self.rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3])
    }

    /// Returns the image of the origin.
    #[inline]
    #[must_use]
    pub fn origin(&self) -> [f32; 3] {
        self.rows.map(|r| r[3])
    }

    /// Transforms a direction; its length changes with the transform's scale.
    #[inline]
    #[must_use]
    pub fn transform_vector(&self, v: [f32; 3]) -> [f32; 3] {
        self.rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
    }

    /// Rotates the transform by a unit quaternion about its own origin, which stays in place.
    #[inline]
    #[must_use]
    pub fn rotated(&self, rotation: [f32; 4]) -> Self {
        let [a, b, c, _, e, f, g, _, i, j, k, _] = components([0.0; 3], rotation, [1.0; 3]);
        let mut rows =
            Self { rows: [[a, b, c, 0.0], [e, f, g, 0.0], [i, j, k, 0.0]] }.mul(self).rows;
        for (row, place) in rows.iter_mut().zip(self.origin()) {
            row[3] = place;
        }
        Self { rows }
    }

    /// Returns the sixteen elements of the 4x4 matrix, column-major, as in OpenGL and glTF.
    #[must_use]
    pub fn to_cols_array(&self) -> [f32; 16] {
        let [a, b, c] = self.rows;
        [a[0], b[0], c[0], 0.0, a[1], b[1], c[1], 0.0, a[2], b[2], c[2], 0.0, a[3], b[3], c[3], 1.0]
    }

    /// Builds a transform from the sixteen elements of a 4x4 matrix, column-major. The fourth row
    /// is ignored.
    #[must_use]
    pub fn from_cols_array(m: &[f32; 16]) -> Self {
        Self {
            rows: [
                [m[0], m[4], m[8], m[12]],
                [m[1], m[5], m[9], m[13]],
                [m[2], m[6], m[10], m[14]],
            ],
        }
    }

    /// Returns whether every element is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.rows.iter().flatten().all(|v| v.is_finite())
    }
}
