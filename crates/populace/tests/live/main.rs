//! Live clips: poses are appended while members play them, on every device and schedule.

#![expect(
    clippy::expect_used,
    clippy::cast_possible_truncation,
    clippy::disallowed_methods,
    dead_code,
    reason = "a test that cannot go on fails; poses are rounded once; bodies are shared with \
              others"
)]

#[path = "../controls/fixture.rs"]
mod fixture;

mod bodies;
mod refusals;

use std::cell::RefCell;

use fixture::{Scene, everywhere, scene, skeleton};
use glam::{DAffine3, DQuat, DVec3};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, Property, Track};
use populace::{
    Affine, ClipId, ClipPlayback, Device, LayerMode, LayerSettings, LiveSettings, MemberId,
    Placement, Schedule, Streamed, Trs,
};

/// Rate of the stream in poses per second.
const HZ: f64 = 30.0;

/// Returns the pose at a time: each joint rotates about its own axis, and the hips move.
fn pose(secs: f64) -> Vec<Trs> {
    let skeleton = skeleton();
    let one = |joint: populace::JointIndex| {
        let (rest, nth) = (*skeleton.rest(joint), f64::from(joint.0));
        let axis = DVec3::new((nth * 1.1).sin(), (nth * 0.7).cos(), 0.3).normalize();
        let turn = DQuat::from_axis_angle(axis, 0.6 * (1.3 * secs + nth).sin());
        let rotation = (DQuat::from_array(rest.rotation.map(f64::from)) * turn).normalize();
        let offset = if skeleton.name(joint) == "hips" {
            [0.1 * secs.sin(), 0.0, 0.2 * secs.cos()]
        } else {
            [0.0; 3]
        };
        let [x, y, z] = offset.map(|m| m as f32);
        let [rx, ry, rz] = rest.translation;
        // Sensors may give either of the two quaternions of a rotation.
        let side = if (secs * HZ).round() % 3.0 == 0.0 { -1.0 } else { 1.0 };
        Trs {
            translation: [rx + x, ry + y, rz + z],
            rotation: rotation.to_array().map(|c| (side * c) as f32),
            scale: rest.scale,
        }
    };
    skeleton.joints().map(one).collect()
}

/// Interpolates two poses in double precision and returns the model transforms.
fn interpolated(a: &[Trs], b: &[Trs], u: f64) -> Vec<DAffine3> {
    let vec = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let quat = |q: [f32; 4]| DQuat::from_array(q.map(f64::from));
    let one = |(a, b): (&Trs, &Trs)| {
        let (from, to) = (quat(a.rotation), quat(b.rotation));
        let to = if from.dot(to) < 0.0 { -to } else { to };
        let rotation = (from * (1.0 - u) + to * u).normalize();
        let translation = vec(a.translation).lerp(vec(b.translation), u);
        DAffine3::from_scale_rotation_translation(vec(a.scale), rotation, translation)
    };
    let (skeleton, locals) = (skeleton(), a.iter().zip(b).map(one));
    let mut models: Vec<DAffine3> = Vec::new();
    for (joint, local) in skeleton.joints().zip(locals) {
        let parent = skeleton.parent(joint).map_or(DAffine3::IDENTITY, |p| models[p.index()]);
        models.push(parent * local);
    }
    models
}

/// Returns the expected model transforms at a time of an even stream of [`HZ`], of which the rows
/// from `first` to `last` are stored.
fn expected(secs: f64, first: u32, last: u32) -> Vec<DAffine3> {
    let at = (secs * HZ).clamp(f64::from(first), f64::from(last));
    let row = at.floor();
    interpolated(&pose(row / HZ), &pose((row + 1.0).min(f64::from(last)) / HZ), at - row)
}

#[track_caller]
fn assert_shows(
    scene: &mut Scene,
    member: MemberId,
    wanted: &[DAffine3],
    tolerance_m: f64,
    case: &str,
) {
    let found = scene.models(member);
    let worst = found.iter().zip(wanted).map(|(a, b)| distance_m(a, b)).fold(0.0, f64::max);
    assert!(
        worst <= tolerance_m,
        "{case}: {worst} m off, {:?}",
        scene.crowd.device_info().schedule
    );
}

/// Returns the largest distance in metres between the two transforms of a joint's origin and of the
/// points 10 cm along its axes.
fn distance_m(a: &Affine, b: &DAffine3) -> f64 {
    let points = [DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.1, DVec3::Z * 0.1];
    let off = |p: DVec3| {
        let found = a.transform_point(p.to_array().map(|c| c as f32));
        b.transform_point3(p).distance(DVec3::from_array(found.map(f64::from)))
    };
    points.into_iter().map(off).fold(0.0, f64::max)
}

fn settings(secs: f32) -> LiveSettings {
    LiveSettings { rows_per_sec: HZ as f32, secs, ..LiveSettings::default() }
}

/// Adds a live clip, and one member for each delay in seconds that plays it.
fn followers(scene: &mut Scene, secs: f32, delays: &[f32]) -> (ClipId, Vec<MemberId>) {
    let live = scene
        .crowd
        .character_mut(scene.body)
        .expect("a live clip")
        .add_live_clip("actor", &settings(secs))
        .expect("a live clip");
    let follow = |delay: &f32| {
        let member = scene.member(Placement::at([0.0; 3]));
        scene.edit(member).play(live, ClipPlayback::live(*delay)).expect("a live clip");
        member
    };
    (live, delays.iter().map(follow).collect())
}

/// Appends `poses` poses at an even rate while frames of another length pass, and calls `look`
/// after each frame with the time and the last row. Returns the elapsed seconds.
fn stream_evenly(
    scene: &mut Scene,
    live: ClipId,
    poses: u32,
    mut look: impl FnMut(&mut Scene, f64, u32),
) -> f64 {
    const FRAME: f32 = 0.013;
    let (mut now, mut sent) = (0.0, 0);
    while sent < poses {
        while sent < poses && f64::from(sent) / HZ <= now {
            let secs = f64::from(sent) / HZ;
            scene.crowd.clip_mut(live).expect("a pose").append(secs, &pose(secs)).expect("a pose");
            sent += 1;
        }
        scene.update(FRAME);
        now += f64::from(FRAME);
        look(scene, now, sent - 1);
    }
    now
}

#[test]
fn members_show_the_stream_with_their_delays_and_hold_its_end() {
    everywhere(|scene| {
        let delays = [0.0, 0.1, 0.25, 0.777];
        let (live, members) = followers(scene, 2.0, &delays);
        scene.update(0.5);
        let rest: Vec<_> = skeleton().joints().map(|joint| *skeleton().rest(joint)).collect();
        assert_shows(
            scene,
            members[1],
            &interpolated(&rest, &rest, 0.0),
            1e-6,
            "at rest before the first pose",
        );
        let now = stream_evenly(scene, live, 45, |scene, now, last| {
            for (&member, delay) in members.iter().zip(delays) {
                let wanted = expected(now - f64::from(delay), 0, last);
                assert_shows(scene, member, &wanted, 2e-5, &format!("{now} s, {delay} s late"));
            }
            let playing = scene.crowd.member(members[2]).expect("a member").active_clips()[0];
            let wanted = (now - 0.25).clamp(0.0, f64::from(last) / HZ);
            assert!((f64::from(playing.time_secs) - wanted).abs() < 1e-4, "{playing:?} {wanted}");
            assert_eq!((playing.clip, playing.speed, playing.ends_in_secs), (live, 1.0, None));
        });
        scene.update(3600.0);
        for &member in &members {
            assert_shows(scene, member, &expected(now, 0, 44), 2e-6, "the last pose holds");
        }
    });
}

#[test]
fn oldest_rows_are_overwritten_repeatedly() {
    everywhere(|scene| {
        // 17 rows: 16 for 0.5 s, and one more because the newest may be hardly newer than the one
        // before.
        let (live, members) = followers(scene, 0.5, &[0.4, 0.5, 5.0]);
        stream_evenly(scene, live, 17 * 40 + 5, |scene, now, last| {
            if last % 17 < 2 && last > 600 || last == 17 * 40 + 4 {
                assert_shows(
                    scene,
                    members[0],
                    &expected(now - 0.4, 0, last),
                    2e-5,
                    "within the stored time",
                );
                assert_shows(
                    scene,
                    members[1],
                    &expected(now - 0.5, 0, last),
                    2e-5,
                    "at the end of the stored time",
                );
                let oldest = expected(0.0, last - 16, last - 16);
                assert_shows(scene, members[2], &oldest, 2e-6, "the oldest row holds");
            }
        });
    });
}

/// Adds an ordinary clip of the stream's poses to the scene's body.
fn recorded(scene: &mut Scene) -> ClipId {
    let clip = Clip::new(recording("recorded", 40), &skeleton()).expect("a clip");
    let mut body = scene.crowd.character_mut(scene.body).expect("a body");
    body.add_clip(&clip.into()).expect("enough capacity")
}

#[test]
fn live_clip_equals_an_ordinary_clip_of_the_same_poses() {
    everywhere(|scene| {
        let (live, _) = followers(scene, 2.0, &[]);
        let clip = recorded(scene);
        let held = scene.clip("sway");
        let pairs = [0, 1].map(|layer| {
            [(live, ClipPlayback::live(0.3)), (clip, ClipPlayback::looping())].map(
                |(clip, play)| {
                    let member = scene.member(Placement::at([0.0; 3]));
                    if layer == 1 {
                        scene
                            .edit(member)
                            .play(held, ClipPlayback::held_at_secs(0.4))
                            .expect("a clip");
                        let mode = LayerMode::Additive;
                        let added = LayerSettings { mode, weight: 0.7 };
                        scene.edit(member).set_layer(1, added, None).expect("a layer");
                    }
                    (member, clip, play.on_layer(layer), layer)
                },
            )
        });
        for [follows, _] in pairs {
            scene.edit(follows.0).play(follows.1, follows.2).expect("a clip");
        }
        let now = stream_evenly(scene, live, 40, |_, _, _| {});
        let at = (now - f64::from(0.3_f32)) as f32;
        for [(follows, ..), (plays, clip, _, layer)] in pairs {
            let held = ClipPlayback::held_at_secs(at).on_layer(layer);
            scene.edit(plays).play(clip, held).expect("a clip");
            scene.update(0.0);
            let wanted = scene.models(plays);
            let found = scene.models(follows);
            for (a, b) in found.iter().zip(&wanted) {
                assert!(fixture::distance(a.origin(), b.origin()) < 5e-4, "{a:?} {b:?}");
                assert!(fixture::turn_deg(a, b) < 0.1, "{a:?} {b:?}");
            }
        }
    });
}

/// Returns the poses of the stream as an ordinary clip.
fn recording(name: &str, poses: u32) -> ClipSource {
    let skeleton = skeleton();
    let times: Vec<f32> = (0..poses).map(|n| (f64::from(n) / HZ) as f32).collect();
    let poses: Vec<_> = (0..poses).map(|n| pose(f64::from(n) / HZ)).collect();
    let track = |joint: populace::JointIndex, property| Track {
        joint: skeleton.name(joint).into(),
        property,
        interpolation: Interpolation::Linear,
        times: times.clone(),
        values: poses
            .iter()
            .flat_map(|pose| {
                let trs = pose[joint.index()];
                if property == Property::Rotation {
                    trs.rotation.to_vec()
                } else {
                    trs.translation.to_vec()
                }
            })
            .collect(),
    };
    let both =
        |joint| [Property::Rotation, Property::Translation].map(|property| track(joint, property));
    ClipSource { name: name.into(), tracks: skeleton.joints().flat_map(both).collect() }
}

#[test]
fn unevenly_timed_poses_are_shown_at_their_own_times() {
    everywhere(|scene| {
        let (live, members) = followers(scene, 2.0, &[0.1, 0.0]);
        let (mut now, mut last) = (0.0, 0.0);
        for nth in 0..60_u32 {
            // Poses are up to 8 ms early or late, and each tenth is 15 ms later.
            let jitter = if nth == 0 { 0.0 } else { 0.008 * f64::from(nth * 7 % 11).sin() };
            last = f64::from(nth) / HZ + jitter + if nth % 10 == 9 { 0.015 } else { 0.0 };
            scene.crowd.clip_mut(live).expect("a pose").append(last, &pose(last)).expect("a pose");
            scene.update((f64::from(nth + 1) / HZ - now) as f32);
            now = f64::from(nth + 1) / HZ;
            if nth > 3 {
                let shown = pose(now - 0.1);
                assert_shows(
                    scene,
                    members[0],
                    &interpolated(&shown, &shown, 0.0),
                    2e-3,
                    "0.1 s ago",
                );
            }
        }
        scene.update(1.0);
        let newest = pose(last);
        for member in members {
            assert_shows(
                scene,
                member,
                &interpolated(&newest, &newest, 0.0),
                2e-6,
                "the newest pose, unchanged",
            );
        }
    });
}

#[test]
fn live_clips_give_equal_bits_on_all_devices_and_schedules() {
    let first: RefCell<Option<Vec<[[f32; 4]; 3]>>> = RefCell::new(None);
    everywhere(|scene| {
        let (live, members) = followers(scene, 0.5, &[0.0, 0.123, 0.4]);
        stream_evenly(scene, live, 50, |_, _, _| {});
        let found: Vec<_> =
            members.into_iter().flat_map(|member| scene.models(member)).map(|m| m.rows).collect();
        assert_eq!(*first.borrow_mut().get_or_insert_with(|| found.clone()), found);
    });
}

#[test]
fn live_clip_keeps_its_precision_after_100_hours() {
    const LATER: f64 = 360_000.0;
    let at = |begin: f64| {
        let mut scene = scene(Device::native(), Schedule::Fused);
        let (live, members) = followers(&mut scene, 1.0, &[0.2, 0.05]);
        scene.crowd.clip_mut(live).expect("a pose").append(1.7e9, &pose(0.0)).expect("a pose");
        scene.update(begin as f32);
        for nth in 1..60_u32 {
            let secs = f64::from(nth) / HZ;
            scene
                .crowd
                .clip_mut(live)
                .expect("a pose")
                .append(1.7e9 + begin + secs, &pose(secs))
                .expect("a pose");
            scene.update(1.0 / HZ as f32);
        }
        scene.update(0.012);
        members.iter().map(|member| scene.models(*member)).collect::<Vec<_>>()
    };
    assert_eq!(at(0.0), at(LATER), "poses differ");
}

#[test]
fn stream_can_be_resynchronized_with_the_crowds_clock() {
    everywhere(|scene| {
        let (live, members) = followers(scene, 2.0, &[0.1]);
        assert!(
            scene.crowd.clip_mut(live).expect("a clip").resync(0.0).is_err(),
            "a stream without poses was synchronized"
        );
        stream_evenly(scene, live, 30, |_, _, _| {});
        scene.update(77.0);
        scene.crowd.clip_mut(live).expect("a stream").resync(0.75).expect("a stream");
        scene.update(0.0);
        assert_shows(scene, members[0], &expected(0.65, 0, 29), 2e-5, "0.1 s before the new time");
        scene.update(0.04);
        assert_shows(scene, members[0], &expected(0.69, 0, 29), 2e-5, "0.04 s later");
    });
}

#[test]
fn named_joints_are_streamed_and_others_stay_at_rest() {
    everywhere(|scene| {
        let settings =
            LiveSettings { translations: Streamed::Joints(vec!["hips".into()]), ..settings(1.0) };
        let live = scene
            .crowd
            .character_mut(scene.body)
            .expect("a live clip")
            .add_live_clip("hips", &settings)
            .expect("a live clip");
        let member = scene.member(Placement::at([0.0; 3]));
        scene.edit(member).play(live, ClipPlayback::live(0.0)).expect("a live clip");
        let (skeleton, shown) = (skeleton(), pose(0.4));
        let joint = |name: &str| skeleton.find(name).expect("a joint");
        let mut head = shown[joint("head").index()];
        head.translation = [9.0; 3];
        let hips = shown[joint("hips").index()];
        scene
            .crowd
            .clip_mut(live)
            .expect("a pose")
            .append_joints(0.0, &[("hips", hips)])
            .expect("a pose");
        scene
            .crowd
            .clip_mut(live)
            .expect("a pose")
            .append_joints(0.1, &[("head", head)])
            .expect("a pose");
        scene.update(0.2);
        let mut wanted: Vec<_> = skeleton.joints().map(|joint| *skeleton.rest(joint)).collect();
        wanted[joint("hips").index()] = hips;
        wanted[joint("head").index()].rotation = head.rotation;
        assert_shows(scene, member, &interpolated(&wanted, &wanted, 0.0), 2e-6, "hips and head");
    });
}
