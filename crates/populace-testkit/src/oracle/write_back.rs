//! Write-back: computes the matrix palette.

use glam::{DAffine3, DMat4};

use super::OracleBody;
use super::noise::Noise;

/// Returns `model_from_joint * joint_from_bind` of each palette entry, 3x4, row-major.
///
/// # Panics
///
/// If an entry's joint has no matrix in `model_from_joint`.
#[must_use]
pub fn palettes(body: &OracleBody, model_from_joint: &[DAffine3]) -> Vec<[f64; 12]> {
    body.palette
        .iter()
        .map(|(joint, bind)| rows(DMat4::from(model_from_joint[*joint]) * square(bind)))
        .collect()
}

/// Returns the same with the errors of one operation.
///
/// # Panics
///
/// As [`palettes`].
#[must_use]
pub fn palettes_with(
    body: &OracleBody,
    model_from_joint: &[DAffine3],
    noise: &mut Noise,
) -> Vec<[f64; 12]> {
    let entry = |(joint, bind): &(usize, [f64; 12])| {
        let model = &model_from_joint[*joint];
        rows(DMat4::from(noise.product(model, &DAffine3::from_mat4(square(bind)))))
    };
    body.palette.iter().map(entry).collect()
}

/// Returns the 4x4 matrix of a row-major 3x4 matrix.
fn square(rows: &[f64; 12]) -> DMat4 {
    let [a, b, c] =
        [0, 4, 8].map(|first| [rows[first], rows[first + 1], rows[first + 2], rows[first + 3]]);
    DMat4::from_cols_array_2d(&[a, b, c, [0.0, 0.0, 0.0, 1.0]]).transpose()
}

/// Returns the upper three rows, row-major.
fn rows(m: DMat4) -> [f64; 12] {
    let rows = m.transpose().to_cols_array();
    std::array::from_fn(|element| rows[element])
}
