//! Matrices of three rows of four, for one joint of several members at once. Twins of the functions
//! of `Affine`: same arithmetic, same order of operations.

use populace_model::math::{Real, components};

/// Elements of a matrix, row by row.
pub(crate) const MATRIX: usize = 12;

/// Returns the product of two transforms.
#[inline(always)]
pub(crate) fn product<R: Real>(a: &[R; MATRIX], b: &[R; MATRIX]) -> [R; MATRIX] {
    let mut result = [R::splat(0.0); MATRIX];
    for row in 0..3 {
        let [x, y, z, w] = [a[row * 4], a[row * 4 + 1], a[row * 4 + 2], a[row * 4 + 3]];
        for column in 0..3 {
            result[row * 4 + column] = x * b[column] + y * b[4 + column] + z * b[8 + column];
        }
        result[row * 4 + 3] = x * b[3] + y * b[7] + z * b[11] + w;
    }
    result
}

/// Returns the image of the origin.
#[inline(always)]
pub(crate) fn origin<R: Copy>(m: &[R; MATRIX]) -> [R; 3] {
    [m[3], m[7], m[11]]
}

/// Transforms a direction.
#[inline(always)]
pub(crate) fn transform_vector<R: Real>(m: &[R; MATRIX], [x, y, z]: [R; 3]) -> [R; 3] {
    [
        m[0] * x + m[1] * y + m[2] * z,
        m[4] * x + m[5] * y + m[6] * z,
        m[8] * x + m[9] * y + m[10] * z,
    ]
}

/// Transforms a point.
#[inline(always)]
pub(crate) fn transform_point<R: Real>(m: &[R; MATRIX], [x, y, z]: [R; 3]) -> [R; 3] {
    [
        m[0] * x + m[1] * y + m[2] * z + m[3],
        m[4] * x + m[5] * y + m[6] * z + m[7],
        m[8] * x + m[9] * y + m[10] * z + m[11],
    ]
}

/// Rotates a transform by a unit quaternion about its own origin.
#[inline(always)]
pub(crate) fn rotated<R: Real>(m: &[R; MATRIX], rotation: [R; 4]) -> [R; MATRIX] {
    let [none, whole] = [R::splat(0.0), R::splat(1.0)];
    let mut result = product(&components([none; 3], rotation, [whole; 3]), m);
    for place in [3, 7, 11] {
        result[place] = m[place];
    }
    result
}
