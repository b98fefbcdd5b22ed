//! The arithmetic against glam in double precision.

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;

use super::{LARGEST, LARGEST_SCALE, Real, Trs, affine, angle, quat, vec3};
use crate::{Affine, f64math};

/// Results are below 400 for numbers up to 10, and have at most eight roundings.
const TOLERANCE: f64 = 400.0 * 8.0 / 16_777_216.0;

fn number() -> impl Strategy<Value = f32> {
    -10.0_f32..10.0
}

fn numbers<const N: usize>() -> impl Strategy<Value = [f32; N]> {
    proptest::array::uniform::<_, N>(number())
}

fn rotation() -> impl Strategy<Value = [f32; 4]> {
    numbers::<4>()
        .prop_filter("a direction", |q| quat::dot(*q, *q) > 0.1)
        .prop_map(f64math::normalized)
}

fn direction() -> impl Strategy<Value = [f32; 3]> {
    numbers::<3>()
        .prop_filter("a direction", |v| vec3::dot(*v, *v) > 0.1)
        .prop_map(|v| f64math::to_f32(f64math::vec3(v).normalize().to_array()))
}

fn trs() -> impl Strategy<Value = Trs> {
    (numbers(), rotation(), numbers()).prop_map(|(translation, rotation, scale)| Trs {
        translation,
        rotation,
        scale,
    })
}

fn matrix() -> impl Strategy<Value = Affine> {
    [numbers(), numbers(), numbers()].prop_map(|rows| Affine { rows })
}

#[track_caller]
fn assert_near<const N: usize>(found: [f32; N], expected: [f64; N]) {
    for (a, b) in found.iter().zip(expected) {
        assert!((f64::from(*a) - b).abs() < TOLERANCE, "{found:?} instead of {expected:?}");
    }
}

#[track_caller]
fn assert_same_matrix(found: &Affine, expected: DAffine3) {
    for (row, i) in found.rows.iter().zip(0..3) {
        let m = expected.matrix3;
        let wanted = [m.x_axis[i], m.y_axis[i], m.z_axis[i], expected.translation[i]];
        assert_near(*row, wanted);
    }
}

/// The matrix by its columns, without the code under test.
fn exact(m: &Affine) -> DAffine3 {
    let column = |i: usize| f64math::vec3([m.rows[0][i], m.rows[1][i], m.rows[2][i]]);
    DAffine3 {
        matrix3: glam::DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    }
}

fn double<const N: usize>(v: [f32; N]) -> [f64; N] {
    v.map(f64::from)
}

#[test]
fn comparisons_choose() {
    for (a, b) in [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (f32::NAN, 0.0), (-0.0, 0.0)] {
        assert_eq!(a.less(b), a < b, "{a} {b}");
        assert_eq!(a.at_most(b), a <= b, "{a} {b}");
    }
    assert_eq!((f32::choose(true, 2.0, 3.0), f32::choose(false, 2.0, 3.0)), (2.0, 3.0));
    for (a, b) in [(false, false), (false, true), (true, false), (true, true)] {
        assert_eq!((f32::both(a, b), f32::either(a, b), f32::others(a)), (a && b, a || b, !a));
    }
    for (number, magnitude) in [(-2.5, 2.5_f32), (2.5, 2.5), (-0.0, 0.0), (0.0, 0.0)] {
        assert_eq!(Real::abs(number).to_bits(), magnitude.to_bits(), "{number}");
    }
}

#[test]
fn what_has_no_direction_falls_back() {
    let (q, v) = ([0.0, 0.6, 0.0, 0.8], [0.0, 0.6, 0.8]);
    for (length, counts) in [(0.0, false), (0.9e-10, false), (1.1e-10, true), (1e-3, true)] {
        let (long_q, long_v) = (quat::scale(q, length), vec3::scale(v, length));
        let (given_q, given_v) = ([0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        let (unit_q, unit_v) =
            (quat::normalize_or(long_q, given_q), vec3::unit_or(long_v, given_v));
        assert_near(unit_q, double(if counts { q } else { given_q }));
        assert_near(unit_v, double(if counts { v } else { given_v }));
        let square = length * length;
        assert_eq!(vec3::root(square) > 0.0, counts, "{length}");
    }
    assert_eq!(angle::of(0.9e-20_f32, 0.0).to_bits(), 0);
    assert!(angle::of(1.1e-20_f32, 0.0) > 1.5);
}

#[test]
fn vectors_across_are_from_x_unless_that_is_near() {
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    assert_near(vec3::any_across(x), double(y));
    assert_near(vec3::any_across(y), double(x));
    assert_near(vec3::any_across([0.6, 0.0, 0.8]), [0.8, 0.0, -0.6]);
    assert_near(vec3::any_across([-0.8, 0.6, 0.0]), [0.6, 0.8, 0.0]);
}

#[test]
fn transforms_that_are_not_finite_or_too_large_are_found() {
    let identity = Trs::IDENTITY;
    assert!(identity.is_finite() && identity.is_bounded() && Affine::IDENTITY.is_finite());
    for i in 0..3 {
        let (mut moved, mut grown, mut turned) = (identity, identity, identity);
        moved.translation[i] = f32::INFINITY;
        grown.scale[i] = f32::NAN;
        turned.rotation[i] = f32::NEG_INFINITY;
        assert!(!moved.is_finite() && !grown.is_finite() && !turned.is_finite(), "{i}");
        let at = |magnitude: f32, scale: f32| {
            let mut trs = identity;
            (trs.translation[i], trs.scale[i]) = (-magnitude, -scale);
            trs.is_bounded()
        };
        assert!(at(LARGEST, LARGEST_SCALE), "{i}");
        assert!(!at(LARGEST * 1.001, 1.0) && !at(1.0, LARGEST_SCALE * 1.001), "{i}");
        let mut matrix = Affine::IDENTITY;
        matrix.rows[i][3 - i] = f32::NAN;
        assert!(!matrix.is_finite(), "{i}");
    }
}

#[test]
fn hierarchies_multiply_from_the_root_down() {
    let turn = DQuat::from_rotation_y(1.0);
    let locals = [
        DAffine3::from_rotation_translation(turn, DVec3::new(0.0, 1.0, 0.0)),
        DAffine3::from_rotation_translation(turn, DVec3::new(0.0, 0.0, 2.0)),
        DAffine3::from_translation(DVec3::new(5.0, 0.0, 0.0)),
    ];
    let joint = |i| Some(crate::JointIndex(i));
    let parents = [None, joint(0), joint(0)];
    let models = f64math::model_from_joints(&parents, locals.into_iter());
    assert_eq!(models.len(), 3);
    for (model, expected) in
        models.iter().zip([locals[0], locals[0] * locals[1], locals[0] * locals[2]])
    {
        assert!(model.abs_diff_eq(expected, 1e-12));
    }
    let turns = [turn, turn, DQuat::IDENTITY];
    let rotations = f64math::model_rotations(&parents, turns.into_iter());
    assert_eq!(rotations.len(), 3);
    for (rotation, expected) in rotations.iter().zip([turn, turn * turn, turn]) {
        assert!(rotation.abs_diff_eq(expected, 1e-12));
    }
    let at = |translation| Trs { translation, ..Trs::IDENTITY };
    let rest = [at([1.0, 1.0, 1.0]), at([0.0, -3.0, 0.0]), at([2.0, 0.0, 0.5])];
    assert_eq!(f64math::rest_extent(&parents, &rest).to_bits(), 3.0_f32.to_bits());
    let none = [at([4.0; 3]), at([0.0; 3]), at([0.0, 5e-7, 0.0])];
    assert_eq!(f64math::rest_extent(&parents, &none).to_bits(), 1.0_f32.to_bits());
    let endless = [at([0.0; 3]), at([f32::INFINITY, 0.0, 0.0]), at([0.0; 3])];
    assert_eq!(f64math::rest_extent(&parents, &endless).to_bits(), 1.0_f32.to_bits());
}

#[test]
fn sheared_matrices_have_no_local_transform() {
    let turned = Trs { rotation: [0.0, 0.6, 0.0, 0.8], scale: [1.0, 2.0, 3.0], ..Trs::IDENTITY };
    let plain = f64math::affine(&turned);
    let back = f64math::trs(plain).expect("not sheared");
    assert_near(back.rotation, double(turned.rotation));
    assert_near(back.scale, double(turned.scale));
    assert!(f64math::trs(plain * plain).is_none());
}

proptest! {
    #[test]
    fn quaternions(a in numbers::<4>(), b in numbers::<4>(), k in number(), r in rotation()) {
        let (da, db) = (f64math::quat(a), f64math::quat(b));
        let (x, y, t) = (glam::DVec4::from(da), glam::DVec4::from(db), f64::from(k));
        assert_near([quat::dot(a, b)], [x.dot(y)]);
        assert_near(quat::scale(a, k), (x * t).to_array());
        assert_near(quat::add(a, b), (x + y).to_array());
        assert_near(quat::mix(a, b, k), (x + (y - x) * t).to_array());
        assert_near(quat::mul(a, b), (da * db).to_array());
        assert_near(quat::conjugate(a), da.conjugate().to_array());
        assert_near(quat::normalize_or(r.map(|v| v * 7.0), quat::identity()), double(r));
        let chosen = [true, false].map(|which| quat::choose::<f32>(which, a, b));
        prop_assert_eq!(chosen, [a, b]);
        let sign: f32 = if quat::dot(a, b) < 0.0 { -1.0 } else { 1.0 };
        prop_assert_eq!((quat::side(a, b), quat::hemisphere(a, b)), (sign, a.map(|v| v * sign)));
        prop_assert_eq!(quat::short_way(a), quat::hemisphere(a, quat::identity()));
    }

    #[test]
    fn vectors(a in numbers::<3>(), b in numbers::<3>(), k in number(), unit in direction()) {
        let (x, y, t, u) =
            (f64math::vec3(a), f64math::vec3(b), f64::from(k), f64math::vec3(unit));
        assert_near([vec3::dot(a, b)], [x.dot(y)]);
        assert_near(vec3::cross(a, b), x.cross(y).to_array());
        assert_near(vec3::add(a, b), (x + y).to_array());
        assert_near(vec3::sub(a, b), (x - y).to_array());
        assert_near(vec3::scale(a, k), (x * t).to_array());
        assert_near(vec3::add_scaled(a, b, k), (x + y * t).to_array());
        assert_near([vec3::length(a)], [x.length()]);
        assert_near(vec3::unit_or(vec3::scale(unit, 7.0), [0.0; 3]), double(unit));
        assert_near(vec3::across(a, unit), x.reject_from_normalized(u).to_array());
        let chosen = [true, false].map(|which| vec3::choose::<f32>(which, a, b));
        prop_assert_eq!(chosen, [a, b]);
        let beside = f64math::vec3(vec3::any_across(unit));
        prop_assert!((beside.length() - 1.0).abs() < 1e-5 && beside.dot(u).abs() < 1e-5);
    }

    #[test]
    fn rotations(q in rotation(), v in numbers::<3>(), from in direction(), to in direction()) {
        assert_near(vec3::rotated(q, v), (f64math::quat(q) * f64math::vec3(v)).to_array());
        // Between nearly opposite vectors, single precision has no direction to turn in.
        prop_assume!(vec3::dot(from, to) > -0.999);
        let arc = f64math::quat(vec3::between(from, to, [0.0, 1.0, 0.0]));
        let (start, end) = (f64math::vec3(from), f64math::vec3(to));
        assert_near(f64math::to_f32((arc * start).to_array()), end.to_array());
        let angle = start.dot(end).clamp(-1.0, 1.0).acos();
        prop_assert!((2.0 * arc.w.clamp(-1.0, 1.0).acos() - angle).abs() < 2e-3, "the shortest");
    }

    #[test]
    fn parts_of_rotations(axis in direction(), half in 0.1_f64..3.0, k in 0.0_f32..1.0) {
        let a = f64math::vec3(axis);
        let q = f64math::to_f32(DQuat::from_axis_angle(a, 2.0 * half).to_array());
        // Interpolation between the identity and the rotation, then normalised.
        let part = |to: DQuat| {
            let mixed = glam::DVec4::W.lerp(to.into(), f64::from(k));
            mixed.normalize().to_array()
        };
        let told = f64math::quat(q);
        assert_near(vec3::part_as_told(q, k), part(told));
        assert_near(vec3::part_of(q, k), part(if told.w < 0.0 { -told } else { told }));
    }

    #[test]
    fn matrices(a in trs(), m in matrix(), n in matrix(), p in numbers::<3>(), q in rotation()) {
        assert_same_matrix(&Affine::from_trs(&a), f64math::affine(&a));
        let (x, y) = (exact(&m), exact(&n));
        assert_same_matrix(&m.mul(&n), x * y);
        assert_near(m.transform_point(p), x.transform_point3(f64math::vec3(p)).to_array());
        assert_near(m.transform_vector(p), x.transform_vector3(f64math::vec3(p)).to_array());
        prop_assert_eq!(double(m.origin()), x.translation.to_array());
        let turned = glam::DMat3::from_quat(f64math::quat(q)) * x.matrix3;
        assert_same_matrix(
            &m.rotated(q), DAffine3 { matrix3: turned, translation: x.translation });
        prop_assert_eq!(double(m.to_cols_array()), glam::DMat4::from(x).to_cols_array());
        prop_assert_eq!(Affine::from_cols_array(&m.to_cols_array()), m);
        prop_assert_eq!(f64math::affine_from(&m), x);
        let components = affine::components(a.translation, a.rotation, a.scale);
        prop_assert_eq!(components.as_chunks::<4>().0, Affine::from_trs(&a).rows);
    }
}
