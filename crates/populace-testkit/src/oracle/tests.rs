//! Tests of the oracle against values computed by hand.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DQuat;
use populace_character::PaletteEntry;
use populace_clip::Clip;
use populace_device::LayerMode;
use populace_model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track, Trs};

use super::*;

fn about_z(degrees: f64) -> DQuat {
    let half = degrees.to_radians() / 2.0;
    DQuat::from_xyzw(0.0, 0.0, half.sin(), half.cos())
}

fn four(q: DQuat) -> [f32; 4] {
    q.to_array().map(populace_model::convert::single)
}

fn track(property: Property, interpolation: Interpolation, times: &[f32], values: &[f32]) -> Track {
    Track {
        joint: "a".into(),
        property,
        interpolation,
        times: times.to_vec(),
        values: values.to_vec(),
    }
}

fn joint(name: &str, parent: Option<usize>, rest: Trs) -> JointSource {
    JointSource { name: name.into(), parent, rest }
}

fn one_joint(rest: Trs) -> OracleBody {
    OracleBody { joints: vec![joint("a", None, rest)], palette: vec![] }
}

fn clip(tracks: Vec<Track>) -> ClipSource {
    ClipSource { name: String::new(), tracks }
}

/// A clip of one constant translation and rotation.
fn still(x: f32, rotation: DQuat) -> ClipSource {
    clip(vec![
        track(Property::Translation, Interpolation::Linear, &[0.0], &[x, 0.0, 0.0]),
        track(Property::Rotation, Interpolation::Linear, &[0.0], &four(rotation)),
    ])
}

fn slot(clip: &ClipSource, weight: f64, layer: usize) -> OracleSlot<'_> {
    OracleSlot { clip, time_secs: 0.0, weight, layer, retarget: None }
}

#[track_caller]
fn same_rotation(a: DQuat, b: DQuat) {
    assert!(a.dot(b).abs() > 1.0 - 1e-12, "{a} differs from {b}");
}

#[track_caller]
fn close(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-7, "{a} differs from {b}");
}

#[test]
fn slerp_has_constant_speed_along_the_shorter_arc() {
    same_rotation(slerp(DQuat::IDENTITY, about_z(90.0), 1.0 / 3.0), about_z(30.0));
    same_rotation(slerp(DQuat::IDENTITY, -about_z(90.0), 1.0 / 3.0), about_z(30.0));
    same_rotation(slerp(about_z(-85.0), about_z(85.0), 0.25), about_z(-42.5));
    same_rotation(slerp(about_z(10.0), about_z(10.0), 0.5), about_z(10.0));
    // 200 degrees in one direction are 160 in the other.
    same_rotation(slerp(DQuat::IDENTITY, about_z(200.0), 0.5), about_z(-80.0));
}

#[test]
fn linear_track_interpolates_and_holds_at_both_ends() {
    let track = track(
        Property::Translation,
        Interpolation::Linear,
        &[1.0, 3.0],
        &[0.0, 2.0, 4.0, 4.0, 2.0, 0.0],
    );
    assert_eq!(track_value(&track, 1.5).to_array(), [1.0, 2.0, 3.0, 0.0]);
    assert_eq!(track_value(&track, -9.0).to_array(), [0.0, 2.0, 4.0, 0.0]);
    assert_eq!(track_value(&track, 9.0).to_array(), [4.0, 2.0, 0.0, 0.0]);
}

#[test]
fn step_key_holds_from_its_own_time() {
    let values = [1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, 0.0];
    let track = track(Property::Scale, Interpolation::Step, &[0.0, 0.5, 1.0], &values);
    let at = |secs: f64| track_value(&track, secs).x;
    assert_eq!([at(0.499_999), at(0.5), at(0.75)], [1.0, 2.0, 2.0]);
    assert_eq!([at(0.999_999), at(1.0), at(7.0)], [2.0, 3.0, 3.0]);
}

#[test]
fn spline_uses_hermite_polynomials_with_tangents_per_second() {
    // In-tangent, value, out-tangent of x for keys at 0 s and 2 s; y and z stay 0.
    let key = |into: f32, value: f32, out: f32| [into, 0.0, 0.0, value, 0.0, 0.0, out, 0.0, 0.0];
    let values = [key(99.0, 1.0, 0.5), key(-1.0, 3.0, 99.0)].concat();
    let track = track(Property::Translation, Interpolation::CubicSpline, &[0.0, 2.0], &values);
    // At a quarter: 0.84375 * 1 + 0.140625 * 2 * 0.5 + 0.15625 * 3 + (-0.046875) * 2 * (-1).
    assert_eq!(track_value(&track, 0.5).x, 1.546_875);
    assert_eq!(track_value(&track, 0.0).x, 1.0);
    assert_eq!(track_value(&track, 2.0).x, 3.0);
}

#[test]
fn rotation_spline_is_normalised() {
    let zero = [0.0; 4];
    let values = [zero, four(DQuat::IDENTITY), zero, zero, four(about_z(90.0)), zero].concat();
    let track = track(Property::Rotation, Interpolation::CubicSpline, &[0.0, 1.0], &values);
    let value = DQuat::from_array(track_value(&track, 0.5).to_array());
    close(value.length(), 1.0);
    close(value.dot(about_z(45.0)).abs(), 1.0);
}

#[test]
fn rotated_child_under_nonuniform_scale_shears() {
    let parent = Trs { scale: [2.0, 1.0, 1.0], ..Trs::IDENTITY };
    let child =
        Trs { translation: [1.0, 0.0, 0.0], rotation: four(about_z(45.0)), ..Trs::IDENTITY };
    // The child precedes its parent in the source.
    let mut bind = [0.0; 12];
    (bind[0], bind[5], bind[10], bind[7]) = (1.0, 1.0, 1.0, 1.0);
    let body = OracleBody {
        joints: vec![joint("child", Some(1), child), joint("parent", None, parent)],
        palette: vec![(0, bind)],
    };
    let pose = evaluate(&body, &[], &[]);
    let c = FRAC_1_SQRT_2;
    let model = [2.0 * c, -2.0 * c, 0.0, 2.0, c, c, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let got = crate::compare::row_major(&pose.model_from_joint[0]);
    got.into_iter().zip(model).for_each(|(a, b)| close(a, b));
    // The bind matrix translates by 1 along y first.
    close(pose.palette[0][3], 2.0 - 2.0 * c);
    close(pose.palette[0][7], c);
    close(pose.palette[0][0], 2.0 * c);
}

#[test]
fn layer_mix_is_divided_by_the_total_weight() {
    let body = one_joint(Trs::IDENTITY);
    let (one, other) = (still(1.0, DQuat::IDENTITY), still(3.0, -about_z(90.0)));
    let mixed = evaluate(&body, &[slot(&one, 0.1, 0), slot(&other, 0.3, 0)], &[]).locals[0];
    close(mixed.translation.x, 2.5);
    let even = evaluate(&body, &[slot(&one, 0.01, 0), slot(&other, 0.01, 0)], &[]).locals[0];
    close(even.rotation.dot(about_z(45.0)).abs(), 1.0);
    let lone = evaluate(&body, &[slot(&other, 0.01, 0), slot(&one, -1.0, 0)], &[]).locals[0];
    close(lone.translation.x, 3.0);
    let none = evaluate(&body, &[slot(&other, 0.000_9, 0)], &[]).locals[0];
    assert_eq!(none, body.rest(0));
}

#[test]
fn override_layer_blends_by_total_weight_and_mask() {
    let body = one_joint(Trs { translation: [8.0, 0.0, 0.0], ..Trs::IDENTITY });
    let (below, above) = (still(0.0, DQuat::IDENTITY), still(4.0, about_z(90.0)));
    let layer = |weight: f64, mask: f64| OracleLayer {
        weight,
        mask: Some(vec![mask]),
        ..OracleLayer::default()
    };
    // Layer 0 has weight 0 and mask 0, which are ignored.
    let x = |weight: f64, layer_weight: f64, mask: f64| {
        let slots = [slot(&below, 1.0, 0), slot(&above, weight, 1)];
        evaluate(&body, &slots, &[layer(0.0, 0.0), layer(layer_weight, mask)]).locals[0]
    };
    close(x(0.5, 0.5, 1.0).translation.x, 1.0);
    close(x(3.0, 0.5, 0.5).translation.x, 1.0);
    close(x(1.0, 1.0, 0.0).translation.x, 0.0);
    close(x(0.0, 1.0, 1.0).translation.x, 0.0);
    same_rotation_roughly(x(0.5, 1.0, 1.0).rotation, about_z(45.0));
    // Nothing plays in layer 0, so the layer is blended over the rest pose.
    let over_rest =
        evaluate(&body, &[slot(&above, 0.5, 1)], &[layer(1.0, 1.0), layer(1.0, 1.0)]).locals[0];
    close(over_rest.translation.x, 6.0);
}

#[track_caller]
fn same_rotation_roughly(a: DQuat, b: DQuat) {
    close(a.dot(b).abs(), 1.0);
}

#[test]
fn additive_layer_adds_the_difference_from_the_first_pose() {
    let rest = Trs {
        translation: [10.0, 0.0, 0.0],
        rotation: four(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)),
        scale: [2.0, 1.0, 1.0],
    };
    let body = one_joint(rest);
    let nod = clip(vec![
        // The clip begins at 1 s. The keys of the translation begin later, so its first value is
        // the reference.
        track(
            Property::Translation,
            Interpolation::Linear,
            &[2.0, 3.0],
            &[1.0, 0.0, 0.0, 1.5, 0.0, 0.0],
        ),
        track(
            Property::Rotation,
            Interpolation::Linear,
            &[1.0, 3.0],
            &[four(about_z(30.0)), four(-about_z(90.0))].concat(),
        ),
        track(Property::Scale, Interpolation::Step, &[1.0, 3.0], &[2.0, 0.0, 1.0, 3.0, 7.0, 1.0]),
    ]);
    let additive = OracleLayer { mode: LayerMode::Additive, weight: 0.5, mask: None };
    let playing = OracleSlot { time_secs: 3.0, ..slot(&nod, 1.0, 1) };
    let local = evaluate(&body, &[playing], &[OracleLayer::default(), additive]).locals[0];
    close(local.translation.x, 10.25);
    // Half of 60 degrees, applied after the base rotation.
    let base = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    same_rotation_roughly(local.rotation, base * about_z(30.0));
    // Half of the ratio 1.5; a component whose reference is 0 is unchanged.
    close(local.scale.x, 2.0 * 1.25);
    close(local.scale.y, 1.0);
}

#[test]
fn additive_slots_are_independent_of_order() {
    let body = one_joint(Trs::IDENTITY);
    let moves = |x: f32, rotation: DQuat| {
        let rotation = [four(DQuat::IDENTITY), four(rotation)].concat();
        clip(vec![
            track(
                Property::Translation,
                Interpolation::Linear,
                &[0.0, 1.0],
                &[0.0, 0.0, 0.0, x, 0.0, 0.0],
            ),
            track(Property::Rotation, Interpolation::Linear, &[0.0, 1.0], &rotation),
        ])
    };
    let (one, other) = (moves(1.0, about_z(40.0)), moves(2.0, DQuat::from_rotation_x(0.7)));
    let layers = [
        OracleLayer::default(),
        OracleLayer { mode: LayerMode::Additive, ..OracleLayer::default() },
    ];
    let at = |clip, weight| OracleSlot { time_secs: 1.0, ..slot(clip, weight, 1) };
    let a = evaluate(&body, &[at(&one, 0.8), at(&other, 0.9)], &layers).locals[0];
    let b = evaluate(&body, &[at(&other, 0.9), at(&one, 0.8)], &layers).locals[0];
    close(a.translation.x, 0.8 + 1.8);
    close(a.translation.x, b.translation.x);
    same_rotation(a.rotation, b.rotation);
}

#[test]
fn body_from_skeleton_is_in_source_order() {
    let rest = |x: f32| Trs { translation: [x, 0.0, 0.0], ..Trs::IDENTITY };
    let joints = [
        joint("hand", Some(2), rest(1.0)),
        joint("prop", None, rest(2.0)),
        joint("hips", None, rest(3.0)),
    ];
    let skeleton = Skeleton::new(&joints).expect("valid test data");
    let palette = [PaletteEntry {
        joint: skeleton.joint_from_source(0),
        joint_from_bind: populace_model::Affine::IDENTITY,
    }];
    let body = OracleBody::from_skeleton(&skeleton, &palette);
    assert_eq!(body.joints, joints);
    assert_eq!(body.palette[0].0, 0);
    let models = evaluate(&body, &[], &[]).model_from_joint;
    let x: Vec<f64> = models.iter().map(|m| m.translation.x).collect();
    assert_eq!(x, [4.0, 2.0, 3.0]);
}

#[test]
fn timing_loops_holds_and_plays_backwards() {
    let rises = track(
        Property::Translation,
        Interpolation::Linear,
        &[1.0, 3.0],
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
    );
    let skeleton = Skeleton::new(&[joint("a", None, Trs::IDENTITY)]).expect("valid test data");
    let clip = Clip::new(clip(vec![rises]), &skeleton).expect("valid test data");
    let tick = |secs: f64| populace_clip::ticks_from_secs(secs);
    let looping = |speed| Timing::Loop { start_tick: tick(1.0), phase: 0.25, speed };
    close(looping(1.0).time_secs(tick(1.0), &clip), 1.5);
    close(looping(1.0).time_secs(tick(3.0), &clip), 1.5);
    close(looping(2.0).time_secs(tick(2.0), &clip), 1.5);
    close(looping(-1.0).time_secs(tick(2.0), &clip), 2.5);
    let once = |speed| Timing::Once { start_tick: tick(1.0), speed };
    close(once(1.0).time_secs(tick(2.0), &clip), 2.0);
    close(once(1.0).time_secs(tick(9.0), &clip), 3.0);
    close(once(-0.5).time_secs(tick(2.0), &clip), 2.5);
    close(once(-1.0).time_secs(tick(9.0), &clip), 1.0);
    assert!(looping(1.0).is_near_jump(tick(2.5), &clip), "the seam");
    assert!(!looping(1.0).is_near_jump(tick(2.4), &clip));
    let ramp = Weighting::Ramp { tick: tick(1.0), from: 1.0, to: 0.5, secs: 2.0 };
    close(ramp.weight(tick(2.0)), 0.75);
    close(ramp.weight(tick(8.0)), 0.5);
}
