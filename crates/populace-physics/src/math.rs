//! Conversions between the types of the crowd and of Rapier.

use populace::model::JointIndex;
use populace::{Affine, Placement, Trs};
use rapier3d::math::Mat3;
pub(crate) use rapier3d::math::{Pose, Rotation, Vector};

/// Returns the 3x3 part of a transform.
fn linear(affine: &Affine) -> Mat3 {
    let column = |c: usize| Vector::new(affine.rows[0][c], affine.rows[1][c], affine.rows[2][c]);
    Mat3::from_cols(column(0), column(1), column(2))
}

/// Returns the translation of a transform.
pub(crate) fn origin(affine: &Affine) -> Vector {
    Vector::from_array(affine.rows.map(|r| r[3]))
}

/// Transforms a point.
pub(crate) fn point(affine: &Affine, p: Vector) -> Vector {
    Vector::from_array(affine.transform_point(p.to_array()))
}

/// Transforms a point by the inverse. Returns the origin if the transform is singular.
pub(crate) fn inverse_transform_point(affine: &Affine, p: Vector) -> Vector {
    let m = linear(affine);
    if m.determinant().abs() < f32::MIN_POSITIVE {
        Vector::ZERO
    } else {
        m.inverse() * (p - origin(affine))
    }
}

/// Returns `inverse(parent) * joint` as translation, rotation and scale, without shear.
pub(crate) fn local(parent: Option<&Affine>, joint: &Affine) -> Trs {
    let Some(parent) = parent else { return decompose(linear(joint), origin(joint)) };
    let m = linear(parent);
    if m.determinant().abs() < f32::MIN_POSITIVE {
        return Trs::IDENTITY;
    }
    let inverse = m.inverse();
    decompose(inverse * linear(joint), inverse * (origin(joint) - origin(parent)))
}

/// Decomposes a transform into translation, rotation and scale, without shear.
pub(crate) fn trs(affine: &Affine) -> Trs {
    decompose(linear(affine), origin(affine))
}

fn decompose(m: Mat3, translation: Vector) -> Trs {
    let mut scale = Vector::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    if m.determinant() < 0.0 {
        scale.x = -scale.x; // a reflection becomes a negative scale along x
    }
    let x = (m.x_axis * scale.x.signum()).normalize_or(Vector::X);
    let y = (m.y_axis - x * x.dot(m.y_axis)).normalize_or(x.any_orthonormal_vector());
    let rotation = Rotation::from_mat3(&Mat3::from_cols(x, y, x.cross(y))).normalize();
    Trs {
        translation: translation.to_array(),
        rotation: rotation.to_array(),
        scale: scale.to_array(),
    }
}

/// Returns the rotation of a `Trs` as a unit quaternion.
pub(crate) fn rotation_of(trs: &Trs) -> Rotation {
    Rotation::from_array(trs.rotation).normalize()
}

/// Returns the rotation of a placement.
pub(crate) fn yaw_rotation(place: &Placement) -> Rotation {
    Rotation::from_rotation_y(place.yaw_rad())
}

/// Converts to a joint index.
pub(crate) fn joint_index(joint: usize) -> JointIndex {
    #[expect(clippy::cast_possible_truncation, reason = "skeletons have fewer than 2^28 joints")]
    JointIndex(joint as u32)
}

/// Returns the twist of a rotation about `axis`, in radians from -pi to pi, and the angle by which
/// it swings the axis.
pub(crate) fn twist_and_swing(q: Rotation, axis: Vector) -> (f32, f32) {
    let along = Vector::new(q.x, q.y, q.z).dot(axis);
    let twist = 2.0 * (along * q.w.signum()).atan2(q.w.abs());
    (twist, (q * axis).angle_between(axis))
}

/// Returns the shortest rotation between two rotations as axis times angle in radians.
pub(crate) fn rotation_vector_between(from: Rotation, to: Rotation) -> Vector {
    let q = (to * from.inverse()).normalize();
    (if q.w < 0.0 { -q } else { q }).to_scaled_axis()
}
