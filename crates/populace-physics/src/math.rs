//! Between the crowd's arithmetic and the simulation's.

use populace::model::JointIndex;
use populace::{Affine, Placement, Trs};
use rapier3d::math::Mat3;
pub(crate) use rapier3d::math::{Pose, Rotation, Vector};

/// Rapier's matrix of the first three columns.
fn linear(affine: &Affine) -> Mat3 {
    let column = |c: usize| Vector::new(affine.rows[0][c], affine.rows[1][c], affine.rows[2][c]);
    Mat3::from_cols(column(0), column(1), column(2))
}

/// Where the origin of a transform goes.
pub(crate) fn origin(affine: &Affine) -> Vector {
    Vector::from_array(affine.rows.map(|r| r[3]))
}

/// The image of a point.
pub(crate) fn point(affine: &Affine, p: Vector) -> Vector {
    Vector::from_array(affine.transform_point(p.to_array()))
}

/// The point whose image is `p`; the origin where the transform flattens space.
pub(crate) fn point_before(affine: &Affine, p: Vector) -> Vector {
    let m = linear(affine);
    if m.determinant().abs() < f32::MIN_POSITIVE {
        Vector::ZERO
    } else {
        m.inverse() * (p - origin(affine))
    }
}

/// `inverse(parent) * joint` as translation, rotation and scale; shear, which those cannot hold, is
/// left out.
pub(crate) fn local(parent: Option<&Affine>, joint: &Affine) -> Trs {
    let Some(parent) = parent else { return split(linear(joint), origin(joint)) };
    let m = linear(parent);
    if m.determinant().abs() < f32::MIN_POSITIVE {
        return Trs::IDENTITY;
    }
    let inverse = m.inverse();
    split(inverse * linear(joint), inverse * (origin(joint) - origin(parent)))
}

/// A joint's transform in model space, taken apart.
pub(crate) fn trs(affine: &Affine) -> Trs {
    split(linear(affine), origin(affine))
}

fn split(m: Mat3, translation: Vector) -> Trs {
    let mut scale = Vector::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    if m.determinant() < 0.0 {
        scale.x = -scale.x; // a mirrored joint: the mirror goes into one axis, the rest is a rotation
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

/// A rotation as the crowd writes it.
pub(crate) fn rotation_of(trs: &Trs) -> Rotation {
    Rotation::from_array(trs.rotation).normalize()
}

/// The rotation of a placement.
pub(crate) fn heading(place: &Placement) -> Rotation {
    Rotation::from_rotation_y(place.yaw_rad())
}

/// A joint by its number.
pub(crate) fn joint_index(joint: usize) -> JointIndex {
    #[expect(clippy::cast_possible_truncation, reason = "skeletons have fewer than 2^28 joints")]
    JointIndex(joint as u32)
}

/// What of a rotation turns about an axis, in radians from -pi to pi, and what swings the axis
/// itself.
pub(crate) fn twist_and_swing(q: Rotation, axis: Vector) -> (f32, f32) {
    let along = Vector::new(q.x, q.y, q.z).dot(axis);
    let twist = 2.0 * (along * q.w.signum()).atan2(q.w.abs());
    (twist, (q * axis).angle_between(axis))
}

/// The rotation that takes one rotation to another, as an axis times radians, the short way.
pub(crate) fn turn_between(from: Rotation, to: Rotation) -> Vector {
    let q = (to * from.inverse()).normalize();
    (if q.w < 0.0 { -q } else { q }).to_scaled_axis()
}
