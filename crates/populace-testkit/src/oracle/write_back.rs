//! Write-back: the matrix palette.

use glam::{DAffine3, DMat4};

use super::OracleBody;

/// `model_from_joint * joint_from_bind` of each palette entry, 3x4, row-major.
///
/// # Panics
///
/// If an entry names a joint without a matrix.
#[must_use]
pub fn palettes(body: &OracleBody, model_from_joint: &[DAffine3]) -> Vec<[f64; 12]> {
    body.palette
        .iter()
        .map(|(joint, bind)| rows(DMat4::from(model_from_joint[*joint]) * square(bind)))
        .collect()
}

/// The 4x4 matrix of a 3x4 one that is row-major.
fn square(rows: &[f64; 12]) -> DMat4 {
    let [a, b, c] =
        [0, 4, 8].map(|first| [rows[first], rows[first + 1], rows[first + 2], rows[first + 3]]);
    DMat4::from_cols_array_2d(&[a, b, c, [0.0, 0.0, 0.0, 1.0]]).transpose()
}

/// The upper three rows.
fn rows(m: DMat4) -> [f64; 12] {
    let rows = m.transpose().to_cols_array();
    std::array::from_fn(|element| rows[element])
}
