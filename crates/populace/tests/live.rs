//! Live clips: poses come in while members play them, on every device and schedule.

#![expect(
    clippy::expect_used,
    clippy::cast_possible_truncation,
    clippy::disallowed_methods,
    dead_code,
    reason = "a test that cannot go on fails; poses are rounded once; bodies are shared with \
              others"
)]

#[path = "controls/body.rs"]
mod body;

use std::cell::RefCell;

use body::{Stage, everywhere, skeleton, stage};
use glam::{DAffine3, DQuat, DVec3};
use populace::character::{Character, CharacterSource};
use populace::clip::Clip;
use populace::model::{
    ClipSource, Interpolation, JointSource, Property, Role, RoleMap, Side, Skeleton, Track,
};
use populace::{
    Affine, ClipId, ClipPlayback, Device, LayerMode, LayerSettings, LiveSettings, MemberId,
    Placement, Schedule, Streamed, Trs,
};

const HZ: f64 = 30.0;

/// All joints turn about axes of their own, and the hips move.
fn pose(secs: f64) -> Vec<Trs> {
    let skeleton = skeleton();
    let one = |joint: populace::JointIndex| {
        let (rest, nth) = (*skeleton.rest(joint), f64::from(joint.0));
        let axis = DVec3::new((nth * 1.1).sin(), (nth * 0.7).cos(), 0.3).normalize();
        let turn = DQuat::from_axis_angle(axis, 0.6 * (1.3 * secs + nth).sin());
        let rotation = (DQuat::from_array(rest.rotation.map(f64::from)) * turn).normalize();
        let moved = if skeleton.name(joint) == "hips" {
            [0.1 * secs.sin(), 0.0, 0.2 * secs.cos()]
        } else {
            [0.0; 3]
        };
        let [x, y, z] = moved.map(|m| m as f32);
        let [rx, ry, rz] = rest.translation;
        // Sensors give either of the two quaternions of a rotation.
        let side = if (secs * HZ).round() % 3.0 == 0.0 { -1.0 } else { 1.0 };
        Trs {
            translation: [rx + x, ry + y, rz + z],
            rotation: rotation.to_array().map(|c| (side * c) as f32),
            scale: rest.scale,
        }
    };
    skeleton.joints().map(one).collect()
}

/// Part of the way between two poses, in double precision.
fn between(a: &[Trs], b: &[Trs], u: f64) -> Vec<DAffine3> {
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

/// What an even stream of [`HZ`] shows at a time: the rows around it, within those from `first` to
/// `last`.
fn even(secs: f64, first: u32, last: u32) -> Vec<DAffine3> {
    let at = (secs * HZ).clamp(f64::from(first), f64::from(last));
    let row = at.floor();
    between(&pose(row / HZ), &pose((row + 1.0).min(f64::from(last)) / HZ), at - row)
}

#[track_caller]
fn assert_shows(stage: &mut Stage, member: MemberId, wanted: &[DAffine3], most_m: f64, what: &str) {
    let found = stage.models(member);
    let worst = found.iter().zip(wanted).map(|(a, b)| apart(a, b)).fold(0.0, f64::max);
    assert!(worst <= most_m, "{what}: {worst} m off, {:?}", stage.crowd.schedule());
}

/// How far a joint's origin, or a point 10 cm along an axis of it, is off.
fn apart(a: &Affine, b: &DAffine3) -> f64 {
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

/// A live clip and members that follow it with these delays.
fn followers(stage: &mut Stage, secs: f32, delays: &[f32]) -> (ClipId, Vec<MemberId>) {
    let live =
        stage.crowd.add_live_clip(stage.body, "actor", &settings(secs)).expect("a live clip");
    let follow = |delay: &f32| {
        let member = stage.member(Placement::at([0.0; 3]));
        stage
            .crowd
            .member_mut(member)
            .expect("a live clip")
            .play(live, ClipPlayback::live(*delay))
            .expect("a live clip");
        member
    };
    (live, delays.iter().map(follow).collect())
}

/// Poses come in evenly while frames of another length pass, for so many poses. The seconds that
/// have passed.
fn run_evenly(
    stage: &mut Stage,
    live: ClipId,
    poses: u32,
    mut look: impl FnMut(&mut Stage, f64, u32),
) -> f64 {
    const FRAME: f32 = 0.013;
    let (mut now, mut sent) = (0.0, 0);
    while sent < poses {
        while sent < poses && f64::from(sent) / HZ <= now {
            let secs = f64::from(sent) / HZ;
            stage.crowd.append(live, secs, &pose(secs)).expect("a pose");
            sent += 1;
        }
        stage.update(FRAME);
        now += f64::from(FRAME);
        look(stage, now, sent - 1);
    }
    now
}

#[test]
fn members_show_the_stream_each_with_its_delay_and_hold_its_end() {
    everywhere(|stage| {
        let delays = [0.0, 0.1, 0.25, 0.777];
        let (live, members) = followers(stage, 2.0, &delays);
        stage.update(0.5);
        let rest: Vec<_> = skeleton().joints().map(|joint| *skeleton().rest(joint)).collect();
        assert_shows(
            stage,
            members[1],
            &between(&rest, &rest, 0.0),
            1e-6,
            "at rest before the first pose",
        );
        let now = run_evenly(stage, live, 45, |stage, now, last| {
            for (&member, delay) in members.iter().zip(delays) {
                let wanted = even(now - f64::from(delay), 0, last);
                assert_shows(stage, member, &wanted, 2e-5, &format!("{now} s, {delay} s late"));
            }
            let playing = stage.crowd.member(members[2]).expect("a member").active_clips()[0];
            let wanted = (now - 0.25).clamp(0.0, f64::from(last) / HZ);
            assert!((f64::from(playing.time_secs) - wanted).abs() < 1e-4, "{playing:?} {wanted}");
            assert_eq!((playing.clip, playing.speed, playing.ends_in_secs), (live, 1.0, None));
        });
        stage.update(3600.0);
        for &member in &members {
            assert_shows(stage, member, &even(now, 0, 44), 2e-6, "the last pose holds");
        }
    });
}

#[test]
fn the_oldest_rows_are_written_over_again_and_again() {
    everywhere(|stage| {
        // 17 rows: the newest may be hardly younger than the one before.
        let (live, members) = followers(stage, 0.5, &[0.4, 0.5, 5.0]);
        run_evenly(stage, live, 17 * 40 + 5, |stage, now, last| {
            if last % 17 < 2 && last > 600 || last == 17 * 40 + 4 {
                assert_shows(stage, members[0], &even(now - 0.4, 0, last), 2e-5, "in the ring");
                assert_shows(
                    stage,
                    members[1],
                    &even(now - 0.5, 0, last),
                    2e-5,
                    "as long as was asked for",
                );
                let oldest = even(0.0, last - 16, last - 16);
                assert_shows(stage, members[2], &oldest, 2e-6, "the oldest holds");
            }
        });
    });
}

#[test]
fn an_ordinary_clip_of_the_same_poses_looks_the_same() {
    everywhere(|stage| {
        let (live, _) = followers(stage, 2.0, &[]);
        let clip = Clip::new(recording("recorded", 40), &skeleton()).expect("a clip");
        let clip = stage.crowd.add_clip(stage.body, &clip.into()).expect("room");
        let held = stage.clip("sway");
        let pairs = [0, 1].map(|layer| {
            [(live, ClipPlayback::live(0.3)), (clip, ClipPlayback::looping())].map(
                |(clip, play)| {
                    let member = stage.member(Placement::at([0.0; 3]));
                    if layer == 1 {
                        stage
                            .crowd
                            .member_mut(member)
                            .expect("a clip")
                            .play(held, ClipPlayback::held_at_secs(0.4))
                            .expect("a clip");
                        let mode = LayerMode::Additive;
                        let added = LayerSettings { mode, weight: 0.7 };
                        stage
                            .crowd
                            .member_mut(member)
                            .expect("a layer")
                            .set_layer(1, added, None)
                            .expect("a layer");
                    }
                    (member, clip, play.on_layer(layer), layer)
                },
            )
        });
        for [follows, _] in pairs {
            stage
                .crowd
                .member_mut(follows.0)
                .expect("a clip")
                .play(follows.1, follows.2)
                .expect("a clip");
        }
        let now = run_evenly(stage, live, 40, |_, _, _| {});
        let at = (now - f64::from(0.3_f32)) as f32;
        for [(follows, ..), (plays, clip, _, layer)] in pairs {
            let held = ClipPlayback::held_at_secs(at).on_layer(layer);
            stage.crowd.member_mut(plays).expect("a clip").play(clip, held).expect("a clip");
            stage.update(0.0);
            let wanted = stage.models(plays);
            let found = stage.models(follows);
            for (a, b) in found.iter().zip(&wanted) {
                assert!(body::distance(a.origin(), b.origin()) < 5e-4, "{a:?} {b:?}");
                assert!(body::turn_deg(a, b) < 0.1, "{a:?} {b:?}");
            }
        }
    });
}

/// The same poses as a file would hold them.
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
fn poses_that_come_unevenly_are_shown_at_their_own_times() {
    everywhere(|stage| {
        let (live, members) = followers(stage, 2.0, &[0.1, 0.0]);
        let (mut now, mut last) = (0.0, 0.0);
        for nth in 0..60_u32 {
            // Up to 8 ms early or late; two in a row, then none for long.
            let jitter = if nth == 0 { 0.0 } else { 0.008 * f64::from(nth * 7 % 11).sin() };
            last = f64::from(nth) / HZ + jitter + if nth % 10 == 9 { 0.015 } else { 0.0 };
            stage.crowd.append(live, last, &pose(last)).expect("a pose");
            stage.update((f64::from(nth + 1) / HZ - now) as f32);
            now = f64::from(nth + 1) / HZ;
            if nth > 3 {
                let shown = pose(now - 0.1);
                assert_shows(stage, members[0], &between(&shown, &shown, 0.0), 2e-3, "0.1 s ago");
            }
        }
        stage.update(1.0);
        let newest = pose(last);
        for member in members {
            assert_shows(
                stage,
                member,
                &between(&newest, &newest, 0.0),
                2e-6,
                "the newest pose, as it came",
            );
        }
    });
}

#[test]
fn all_devices_and_schedules_agree_to_the_bit() {
    let first: RefCell<Option<Vec<[[f32; 4]; 3]>>> = RefCell::new(None);
    everywhere(|stage| {
        let (live, members) = followers(stage, 0.5, &[0.0, 0.123, 0.4]);
        run_evenly(stage, live, 50, |_, _, _| {});
        let found: Vec<_> =
            members.into_iter().flat_map(|member| stage.models(member)).map(|m| m.rows).collect();
        assert_eq!(*first.borrow_mut().get_or_insert_with(|| found.clone()), found);
    });
}

#[test]
fn after_a_hundred_hours_nothing_is_lost() {
    const LATER: f64 = 360_000.0;
    let at = |begin: f64| {
        let mut stage = stage(Device::native(), Schedule::Fused);
        let (live, members) = followers(&mut stage, 1.0, &[0.2, 0.05]);
        stage.crowd.append(live, 1.7e9, &pose(0.0)).expect("a pose");
        stage.update(begin as f32);
        for nth in 1..60_u32 {
            let secs = f64::from(nth) / HZ;
            stage.crowd.append(live, 1.7e9 + begin + secs, &pose(secs)).expect("a pose");
            stage.update(1.0 / HZ as f32);
        }
        stage.update(0.012);
        members.iter().map(|member| stage.models(*member)).collect::<Vec<_>>()
    };
    assert_eq!(at(0.0), at(LATER), "to the bit");
}

#[test]
fn a_stream_is_tied_anew_to_the_crowds_clock() {
    everywhere(|stage| {
        let (live, members) = followers(stage, 2.0, &[0.1]);
        assert!(stage.crowd.resync_live(live, 0.0).is_err(), "nothing to tie yet");
        run_evenly(stage, live, 30, |_, _, _| {});
        stage.update(77.0);
        stage.crowd.resync_live(live, 0.75).expect("a stream");
        stage.update(0.0);
        assert_shows(stage, members[0], &even(0.65, 0, 29), 2e-5, "0.1 s before what is now");
        stage.update(0.04);
        assert_shows(stage, members[0], &even(0.69, 0, 29), 2e-5, "it goes on");
    });
}

#[test]
fn joints_come_by_name_and_what_is_not_streamed_stays() {
    everywhere(|stage| {
        let settings =
            LiveSettings { translations: Streamed::Joints(vec!["hips".into()]), ..settings(1.0) };
        let live = stage.crowd.add_live_clip(stage.body, "hips", &settings).expect("a live clip");
        let member = stage.member(Placement::at([0.0; 3]));
        stage
            .crowd
            .member_mut(member)
            .expect("a live clip")
            .play(live, ClipPlayback::live(0.0))
            .expect("a live clip");
        let (skeleton, shown) = (skeleton(), pose(0.4));
        let joint = |name: &str| skeleton.find(name).expect("a joint");
        let mut head = shown[joint("head").index()];
        head.translation = [9.0; 3];
        let hips = shown[joint("hips").index()];
        stage.crowd.append_joints(live, 0.0, &[("hips", hips)]).expect("a pose");
        stage.crowd.append_joints(live, 0.1, &[("head", head)]).expect("a pose");
        stage.update(0.2);
        let mut wanted: Vec<_> = skeleton.joints().map(|joint| *skeleton.rest(joint)).collect();
        wanted[joint("hips").index()] = hips;
        wanted[joint("head").index()].rotation = head.rotation;
        assert_shows(stage, member, &between(&wanted, &wanted, 0.0), 2e-6, "hips and head");
    });
}

/// A body of other proportions, whose axes are its own too.
fn other_body() -> Character {
    let own = skeleton();
    let joint = |joint: populace::JointIndex| {
        let mut rest = *own.rest(joint);
        rest.translation = rest.translation.map(|c| 1.3 * c);
        JointSource {
            name: own.name(joint).into(),
            parent: own.parent(joint).map(|p| p.index()),
            rest,
        }
    };
    let joints: Vec<_> = own.joints().map(joint).collect();
    let skeleton = Skeleton::new(&joints).expect("a skeleton");
    let (parts, materials, images, skins, clips, palette) =
        (vec![], vec![], vec![], vec![], vec![], vec![]);
    let name = "other".into();
    Character::new(CharacterSource {
        name,
        skeleton,
        palette,
        parts,
        materials,
        images,
        skins,
        clips,
    })
    .expect("a character")
}

/// Roles of hips and legs, the only ones that the body has in full.
fn legs(skeleton: &Skeleton) -> RoleMap {
    let (left, right) = (Side::Left, Side::Right);
    let roles = [
        (Role::Hips, "hips"),
        (Role::UpperLeg(left), "leftUpperLeg"),
        (Role::LowerLeg(left), "leftLowerLeg"),
        (Role::Foot(left), "leftFoot"),
        (Role::UpperLeg(right), "rightUpperLeg"),
        (Role::LowerLeg(right), "rightLowerLeg"),
        (Role::Foot(right), "rightFoot"),
    ];
    RoleMap::from_names(skeleton, &roles).expect("names that are there")
}

#[test]
fn a_live_clip_moves_other_bodies_by_their_roles() {
    everywhere(|stage| {
        let other = stage.crowd.add_character(other_body()).expect("room");
        for character in [stage.body, other] {
            let skeleton = stage.crowd.character(character).expect("a character").skeleton.clone();
            stage.crowd.set_roles(character, legs(&skeleton)).expect("its roles");
        }
        let (live, _) = followers(stage, 2.0, &[]);
        let clip = Clip::new(recording("recorded", 40), &skeleton()).expect("a clip");
        let clip = stage.crowd.add_clip(stage.body, &clip.into()).expect("room");
        let members =
            [0, 1].map(|_| stage.crowd.spawn(other, Placement::at([0.0; 3])).expect("room"));
        stage
            .crowd
            .member_mut(members[0])
            .expect("a live clip")
            .play(live, ClipPlayback::live(0.3))
            .expect("a live clip");
        let now = run_evenly(stage, live, 40, |_, _, _| {});
        let held = ClipPlayback::held_at_secs((now - f64::from(0.3_f32)) as f32);
        stage.crowd.member_mut(members[1]).expect("a clip").play(clip, held).expect("a clip");
        stage.update(0.0);
        let [found, wanted] = members.map(|member| stage.models(member));
        let hips = body::joint("hips").index();
        let from_hips = |all: &[Affine], m: &Affine| {
            let (a, b) = (m.origin(), all[hips].origin());
            [0, 1, 2].map(|i| a[i] - b[i])
        };
        for (a, b) in found.iter().zip(&wanted).skip(1) {
            assert!(body::turn_deg(a, b) < 0.1, "{a:?} {b:?}");
            let [a, b] = [from_hips(&found, a), from_hips(&wanted, b)];
            assert!(body::distance(a, b) < 1e-3, "{a:?} {b:?}");
        }
        let [knee, hip] =
            ["leftLowerLeg", "leftUpperLeg"].map(|name| found[body::joint(name).index()].origin());
        let thigh = skeleton().rest(body::joint("leftLowerLeg")).translation;
        let longer = body::distance(knee, hip) / body::distance(thigh, [0.0; 3]);
        assert!((longer - 1.3).abs() < 1e-3, "its own proportions: {longer}");
    });
}

#[test]
fn what_cannot_be_is_refused_and_harms_nothing() {
    let mut stage = stage(Device::native(), Schedule::Fused);
    let (live, members) = followers(&mut stage, 1.0, &[0.0]);
    let (sway, good) = (stage.clip("sway"), pose(0.0));
    let crowd = &mut stage.crowd;
    let mut bad = |secs: f64, pose: &[Trs], words: &str| {
        let error = crowd.append(live, secs, pose).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    let with = |change: fn(&mut Trs)| {
        let mut pose = good.clone();
        change(&mut pose[3]);
        pose
    };
    bad(f64::NAN, &good, "the time NaN s; it must be finite");
    bad(0.0, &good[1..], "got a pose of 18 joints; its skeleton has 19");
    bad(0.0, &with(|trs| trs.translation[1] = f32::NAN), "for the joint \"");
    bad(0.0, &with(|trs| trs.scale[1] = f32::INFINITY), "numbers must be finite");
    bad(0.0, &with(|trs| trs.rotation = [0.0; 4]), "rotations have a length");
    crowd.append(live, 5.0, &good).expect("a pose");
    let mut bad = |secs: f64, words: &str| {
        let error = crowd.append(live, secs, &good).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    bad(5.0, "a pose of 5 s after one of 5 s");
    bad(4.0, "\"actor\" got a pose at 4 s after one at 5 s; times must increase");
    bad(1e300, "within 1e10 s");
    let refused = |result: Result<(), populace::Error>, words: &str| {
        let error = result.expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(crowd.append(sway, 6.0, &good), "\"sway\" is not live");
    refused(crowd.append_joints(live, 6.0, &[("hip", good[0])]), "did you mean \"hips\"");
    for play in [ClipPlayback::looping(), ClipPlayback::once(), ClipPlayback::held_at_secs(0.0)] {
        refused(
            crowd.member_mut(members[0]).and_then(|mut m| m.play(live, play)).map(drop),
            "\"actor\" is live; it has no end",
        );
    }
    refused(
        crowd
            .member_mut(members[0])
            .and_then(|mut m| m.play(sway, ClipPlayback::live(0.1)))
            .map(drop),
        "\"sway\" is not live",
    );
    refused(
        crowd
            .member_mut(members[0])
            .and_then(|mut m| m.play(live, ClipPlayback::live(-0.1)))
            .map(drop),
        "the delay of a live clip",
    );
    let space = populace::BlendSpace::line(&[(live, 0.0), (sway, 1.0)]).expect("points");
    refused(crowd.add_blend_space(space).map(drop), "has the live clip \"actor\"");
    for (rows_per_sec, secs) in
        [(0.5, 1.0), (f32::NAN, 1.0), (30.0, 0.0), (30.0, f32::NAN), (1000.0, 1e9)]
    {
        let bad = LiveSettings { rows_per_sec, secs, ..LiveSettings::default() };
        refused(crowd.add_live_clip(stage.body, "bad", &bad).map(drop), "the clip \"bad\" is to");
    }
    crowd.append(live, 5.1, &pose(0.3)).expect("a pose");
    crowd
        .member_mut(members[0])
        .expect("as late as can be")
        .play(live, ClipPlayback::live(1e9).fade_in_secs(0.1))
        .expect("as late as can be");
    stage.update(0.2);
    assert_shows(&mut stage, members[0], &between(&good, &good, 0.0), 2e-6, "the oldest pose");
}
