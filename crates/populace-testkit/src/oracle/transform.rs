//! Transform: concatenates local transforms down the hierarchy.

use glam::{DAffine3, DMat3};

use super::OracleBody;
use super::local::Local;

/// Returns `model_from_joint` of every joint: the parent's matrix times the local `T * R * S`.
/// Matrices are used so that shear is kept.
///
/// # Panics
///
/// If the joints have a cycle, or the lengths of `locals` and `body.joints` differ.
#[must_use]
pub fn model_from_joints(body: &OracleBody, locals: &[Local]) -> Vec<DAffine3> {
    assert_eq!(body.joints.len(), locals.len(), "one local transform per joint");
    (0..locals.len()).map(|joint| model_from_joint(body, locals, joint, 0)).collect()
}

fn model_from_joint(body: &OracleBody, locals: &[Local], joint: usize, below: usize) -> DAffine3 {
    assert!(below < locals.len(), "joint {joint} is its own ancestor");
    let local = parent_from_joint(&locals[joint]);
    match body.joints[joint].parent {
        Some(parent) => model_from_joint(body, locals, parent, below + 1) * local,
        None => local,
    }
}

/// Returns the matrix of translation times rotation times scale (glTF 2.0, section 3.5.3).
pub(super) fn parent_from_joint(local: &Local) -> DAffine3 {
    let rotation = DMat3::from_quat(local.rotation);
    DAffine3 {
        matrix3: rotation * DMat3::from_diagonal(local.scale),
        translation: local.translation,
    }
}
