use glam::DAffine3;
use populace_model::{JointSource, Skeleton, Trs};

use super::*;

const SECS: f32 = 1.5;

/// A rotated and scaled root that does not move, hips that walk and turn, and a leg.
fn walker() -> Skeleton {
    let tilted = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2).to_array();
    let joint = |name: &str, parent, rest| JointSource { name: name.into(), parent, rest };
    let root =
        Trs { translation: [0.1, 0.2, 0.3], rotation: f64math::to_f32(tilted), scale: [0.01; 3] };
    let up = |y: f32| Trs { translation: [0.0, y, 0.0], ..Trs::IDENTITY };
    Skeleton::new(&[
        joint("armature", None, root),
        joint("hips", Some(0), up(90.0)),
        joint("leg", Some(1), up(-40.0)),
    ])
    .unwrap()
}

/// A walk along a curve, with a swinging leg.
fn curve(skeleton: &Skeleton) -> Clip {
    let keys = 31_u8;
    let times: Vec<f32> = (0..keys).map(|key| SECS * f32::from(key) / 30.0).collect();
    let at = |secs: f64| {
        let yaw = 1.2 * secs;
        let place =
            DVec3::new(80.0 * (1.0 - yaw.cos()), 6.0 * (9.0 * secs).sin(), 80.0 * yaw.sin());
        // Up is +Z because the armature lies on its back.
        let back = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        (
            back * (place + DVec3::Y * 90.0),
            back * DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(0.2 * (7.0 * secs).sin()),
        )
    };
    let poses: Vec<_> = times.iter().map(|secs| at(f64::from(*secs))).collect();
    let track = |joint: &str, property, values| Track {
        joint: joint.into(),
        property,
        interpolation: Interpolation::Linear,
        times: times.clone(),
        values,
    };
    let swing = |secs: &f32| f64math::to_f32(DQuat::from_rotation_x(f64::from(*secs)).to_array());
    let tracks = vec![
        track(
            "hips",
            Property::Translation,
            poses.iter().flat_map(|p| f64math::to_f32(p.0.to_array())).collect(),
        ),
        track(
            "hips",
            Property::Rotation,
            poses.iter().flat_map(|p| f64math::to_f32(p.1.to_array())).collect(),
        ),
        track("leg", Property::Rotation, times.iter().flat_map(swing).collect()),
    ];
    Clip::new(ClipSource { name: "curve".into(), tracks }, skeleton).unwrap()
}

fn models(clip: &Clip, secs: f64) -> Vec<DAffine3> {
    let curves = Curves::new(&clip.source, &clip.skeleton).unwrap();
    let locals = clip.skeleton.joints().map(|j| curves.local(j, secs, Side::After).affine());
    f64math::model_from_joints(clip.skeleton.parents(), locals)
}

fn settings(turns: bool, rises: bool) -> MotionSettings {
    MotionSettings { turns, rises, ..MotionSettings::default() }
}

#[test]
fn root_motion_and_remaining_pose_combine_to_the_original() {
    let skeleton = walker();
    let clip = curve(&skeleton);
    for settings in
        [settings(true, false), settings(true, true), settings(false, false), settings(false, true)]
    {
        let moved = clip.with_root_motion(&settings).unwrap();
        let motion = moved.root_motion().unwrap();
        let mut worst: f64 = 0.0;
        for step in 0..=300 {
            let secs = f64::from(SECS) * f64::from(step) / 300.0;
            let rigid = motion.rigid(secs);
            let carried = DAffine3::from_rotation_translation(rigid.rotation(), rigid.shift);
            // The ancestors of the hips are carried along.
            for (left, whole) in models(&moved, secs).iter().zip(models(&clip, secs)).skip(1) {
                worst = worst.max(((carried * *left).translation - whole.translation).length());
            }
        }
        // Linear interpolation of a curve of 0.8 m at 60 rows per second.
        assert!(worst < 4e-4, "{settings:?}: {worst} m");
    }
}

#[test]
fn remaining_pose_stays_in_place() {
    let clip = curve(&walker());
    let moved = clip.with_root_motion(&settings(true, false)).unwrap();
    let hips = |secs: f64| models(&moved, secs)[1];
    for step in 0..=30 {
        let now = hips(f64::from(step) * 0.05);
        let drift = now.translation - hips(0.0).translation;
        assert!(drift.x.hypot(drift.z) < 1e-4, "{drift}");
        let ahead = now.transform_vector3(DVec3::X).normalize()
            - hips(0.0).transform_vector3(DVec3::X).normalize();
        assert!(ahead.length() < 1e-3, "{ahead}");
    }
    // Components that are not requested stay in the pose.
    let rises = |secs: f64| hips(secs).translation.y - hips(0.0).translation.y;
    assert!((rises(0.17) - 0.06).abs() < 0.01, "{}", rises(0.17));
    let (end, yaw) = moved.root_motion().unwrap().at(SECS);
    assert!((yaw - 1.8).abs() < 1e-3 && end[1] == 0.0 && end[2] > 0.7, "{end:?} {yaw}");
}

#[test]
fn looped_motion_accumulates_cycles() {
    let clip = curve(&walker()).with_root_motion(&settings(true, false)).unwrap();
    let motion = clip.root_motion().unwrap();
    assert_eq!(motion.looped(0.0, 0.7), motion.at(0.7));
    // 1.8 radians per cycle, about a point 0.8 m to the side of the hips, which are not above the
    // body's own origin.
    let ([x, _, z], yaw) = motion.looped(0.5, 2.5 * SECS);
    assert!((yaw - (2.5 * 1.8 - std::f32::consts::TAU)).abs() < 1e-3, "{yaw}");
    assert!(
        (f64::from(x.hypot(z)) - 2.0 * 0.9_f64.hypot(0.3) * 2.25_f64.sin()).abs() < 5e-3,
        "{x} {z}"
    );
}

#[test]
fn missing_motion_is_reported() {
    let skeleton = walker();
    let clip = curve(&skeleton);
    let of = |name: &str| MotionSettings {
        from: MotionSource::Joint(name.into()),
        ..MotionSettings::default()
    };
    let refused = |result: Result<Clip, Error>| result.unwrap_err().to_string();
    assert!(
        refused(clip.with_root_motion(&of("leg")))
            .contains("moves \"hips\", an ancestor of \"leg\"")
    );
    assert!(refused(clip.with_root_motion(&of("hip"))).contains("hips"), "the nearest name");
    let moved = clip.with_root_motion(&of("hips")).unwrap();
    assert!(refused(moved.with_root_motion(&of("hips"))).contains("taken out already"));
    let feet = MotionSettings { from: MotionSource::Feet, ..MotionSettings::default() };
    assert!(refused(clip.with_root_motion(&feet)).contains("a known foot name"));
    let still = Clip::new(ClipSource::default(), &skeleton).unwrap();
    let root = MotionSettings { from: MotionSource::Root, ..MotionSettings::default() };
    assert!(refused(still.with_root_motion(&root)).contains("MotionSource::Feet"));
}

#[test]
fn clips_without_source_curves_keep_their_motion_and_say_so() {
    let skeleton = walker();
    let clip = curve(&skeleton);
    let columns: Vec<_> = skeleton.joints().map(Some).collect();
    let converted = clip.converted(&skeleton, vec![[true; 3]; 3], |_, pose| pose.to_vec());
    for of_rows in [converted, clip.arranged(&skeleton, &columns)] {
        for from in [MotionSource::Auto, MotionSource::Root, MotionSource::Feet] {
            let settings = MotionSettings { from, ..MotionSettings::default() };
            let refused = of_rows.with_root_motion(&settings).unwrap_err().to_string();
            assert!(refused.contains("before it is converted"), "{settings:?}: {refused}");
        }
    }
    // Where nothing moves, nothing is lost.
    let still = Clip::new(ClipSource::default(), &skeleton).unwrap();
    let still = still.arranged(&skeleton, &columns).with_root_motion(&MotionSettings::default());
    assert_eq!(still.unwrap().root_motion().unwrap().origin(), &MotionOrigin::Nothing);
}

#[test]
fn long_clips_of_few_keys_get_bounded_rows() {
    let skeleton = walker();
    let end_secs = 1e4;
    let track = Track {
        joint: "hips".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, end_secs],
        // Down in the armature, which lies on its back, is ahead in the model.
        values: vec![0.0, 0.0, 90.0, 0.0, -1e6, 90.0],
    };
    let source = ClipSource { name: "long".into(), tracks: vec![track] };
    let clip = Clip::new(source, &skeleton).unwrap();
    let moved = clip.with_root_motion(&MotionSettings::default()).unwrap();
    let motion = moved.root_motion().unwrap();
    assert!(motion.row_count() < 40_000, "{} rows", motion.row_count());
    for part in [0.25, 1.0] {
        let ([x, _, z], _) = motion.at(part * end_secs);
        let wanted = part * 1e4;
        assert!((x.hypot(z) - wanted).abs() < 0.1, "{x} {z} instead of {wanted}");
    }
    // Ten minutes have sixty rows a second.
    let minutes = curve(&skeleton).source().clone();
    let tracks = minutes.tracks.into_iter().map(|track| Track {
        times: track.times.iter().map(|secs| secs * 600.0 / SECS).collect(),
        ..track
    });
    let source = ClipSource { name: "minutes".into(), tracks: tracks.collect() };
    let clip = Clip::new(source, &skeleton).unwrap();
    let moved = clip.with_root_motion(&MotionSettings::default()).unwrap();
    assert_eq!(moved.root_motion().unwrap().row_count(), 36_001);
}

/// Hips with two feet that tread in place, one step of `reach` metres each; the hips move `far`
/// metres ahead.
fn tread(reach: f32, far: f32) -> Clip {
    let joint = |name: &str, parent, translation| JointSource {
        name: name.into(),
        parent,
        rest: Trs { translation, ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&[
        joint("hips", None, [0.0, 1.0, 0.0]),
        joint("foot.l", Some(0), [0.1, -1.0, 0.0]),
        joint("foot.r", Some(0), [-0.1, -1.0, 0.0]),
        joint("head", Some(0), [0.0, 0.8, 0.0]),
    ]);
    let times = vec![0.0, 0.5, 0.75, 1.0];
    let track = |joint: &str, values: [[f32; 3]; 4]| Track {
        joint: joint.into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: times.clone(),
        values: values.concat(),
    };
    let (front, back, up) = (reach / 2.0, -reach / 2.0, -0.8);
    let hips = |part: f32| [0.08 * part * (1.0 - part), 1.0, far * part];
    let tracks = vec![
        track("hips", [hips(0.0), hips(0.5), hips(0.75), hips(1.0)]),
        track(
            "foot.l",
            [[0.1, -1.0, front], [0.1, -1.0, back], [0.1, up, 0.0], [0.1, -1.0, front]],
        ),
        track(
            "foot.r",
            [[-0.1, -1.0, back], [-0.1, -1.0, front], [-0.1, -1.0, 0.0], [-0.1, -1.0, back]],
        ),
    ];
    Clip::new(ClipSource { name: "tread".into(), tracks }, &skeleton.unwrap()).unwrap()
}

#[test]
fn auto_source_moves_walks_and_leaves_idles_standing() {
    let chosen = |clip: &Clip| {
        let taken = clip.with_root_motion(&MotionSettings::default()).unwrap();
        let motion = taken.root_motion().unwrap();
        let left = taken.source() == clip.source();
        (motion.origin().clone(), motion.metres_per_sec(), motion.looped(0.0, 4.0).0[2], left)
    };
    let (origin, speed, after, left) = chosen(&tread(0.0, 1.5));
    assert_eq!((origin, left), (MotionOrigin::Joint("hips".into()), false));
    assert!((speed - 1.5).abs() < 0.01 && (after - 6.0).abs() < 1e-3, "{speed} {after}");
    let walk = tread(0.6, 0.0);
    let (origin, speed, after, left) = chosen(&walk);
    assert_eq!((origin, left), (MotionOrigin::Feet, true));
    assert_eq!(Some(speed), walk.stats().ground_speed_m_per_sec);
    assert!(speed > 0.5 && (after - 4.0 * speed).abs() < 1e-3, "{speed} {after}");
    // Hips that sway while the feet stay, and a clip without any motion.
    for idle in [tread(0.01, 0.02), Clip::new(ClipSource::default(), &walker()).unwrap()] {
        assert_eq!(chosen(&idle), (MotionOrigin::Nothing, 0.0, 0.0, true));
    }
    // Turning on the spot is motion, too.
    let (origin, ..) = chosen(&curve(&walker()));
    assert_eq!(origin, MotionOrigin::Joint("hips".into()));
}
