//! Double-precision helpers for computations at load time.

use glam::{DAffine3, DQuat, DVec3};

use crate::{JointIndex, Trs};

/// Converts three components to double precision.
#[must_use]
pub fn vec3(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Converts a quaternion `x y z w` to double precision without normalising.
#[must_use]
pub fn quat(q: [f32; 4]) -> DQuat {
    DQuat::from_array(q.map(f64::from))
}

/// Rounds each number to the nearest `f32`.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the nearest f32 is what is wanted"
)]
pub fn to_f32<const N: usize>(v: [f64; N]) -> [f32; N] {
    v.map(|x| x as f32)
}

/// Normalises a quaternion, with a single rounding.
#[must_use]
pub fn normalized(q: [f32; 4]) -> [f32; 4] {
    to_f32(quat(q).normalize().to_array())
}

/// Returns the matrix of a local transform.
#[must_use]
pub fn affine(trs: &Trs) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        vec3(trs.scale),
        quat(trs.rotation),
        vec3(trs.translation),
    )
}

/// Largest difference between the elements of a transform and of its decomposition into
/// translation, rotation and scale; beyond it the transform is sheared.
const SHEARED: f64 = 1e-3;

/// Returns the local transform of a matrix, or `None` if the matrix is sheared.
#[must_use]
pub fn trs(matrix: DAffine3) -> Option<Trs> {
    let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
    let plain = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
    plain.abs_diff_eq(matrix, SHEARED).then(|| Trs {
        translation: to_f32(translation.to_array()),
        rotation: to_f32(rotation.to_array()),
        scale: to_f32(scale.to_array()),
    })
}

/// Returns `model_from_joint` of each joint from local transforms; parents must come first.
pub fn model_from_joints(
    parents: &[Option<JointIndex>],
    locals: impl Iterator<Item = DAffine3>,
) -> Vec<DAffine3> {
    let mut models: Vec<DAffine3> = Vec::with_capacity(parents.len());
    for (parent, local) in parents.iter().zip(locals) {
        models.push(parent.map_or(local, |p| models[p.index()] * local));
    }
    models
}

/// Returns the rotation of each joint in model space from local rotations, parents first; scales of
/// ancestors do not count.
pub fn model_rotations(
    parents: &[Option<JointIndex>],
    locals: impl Iterator<Item = DQuat>,
) -> Vec<DQuat> {
    let mut rotations: Vec<DQuat> = Vec::with_capacity(parents.len());
    for (parent, local) in parents.iter().zip(locals) {
        rotations.push(parent.map_or(local, |p| rotations[p.index()] * local));
    }
    rotations
}

/// Returns the largest side of the box around the joints at rest; 1 if they coincide.
pub(crate) fn rest_extent(parents: &[Option<JointIndex>], rest: &[Trs]) -> f32 {
    let models = model_from_joints(parents, rest.iter().map(affine));
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for model in &models {
        low = low.min(model.translation);
        high = high.max(model.translation);
    }
    let size = (high - low).max_element();
    if size > 1e-6 && size.is_finite() { to_f32([size])[0] } else { 1.0 }
}

/// Converts a matrix to double precision.
#[must_use]
pub fn affine_from(m: &crate::Affine) -> DAffine3 {
    let [a, b, c] = m.rows.map(|row| row.map(f64::from));
    DAffine3::from_cols_array(&[
        a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2], a[3], b[3], c[3],
    ])
}
