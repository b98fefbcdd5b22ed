//! Root motion, on every device and schedule.
#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a failed call fails the test; not every test uses the whole fixture"
)]
#![expect(clippy::print_stdout, reason = "measured values are shown with --nocapture")]

mod far;
#[path = "../controls/fixture.rs"]
mod fixture;
mod inertialization;
mod parts;
mod view;

use std::cell::RefCell;
use std::sync::Arc;

use fixture::{Scene, character, distance, everywhere, joint};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, Property, Track};
use populace::{
    Affine, ClipId, ClipPlayback, Condition, Crowd, Device, LayerMode, LayerSettings,
    MachinePlayback, Mask, MemberId, MotionSettings, MotionSource, Placement, Split, StateMachine,
    StatePlayback,
};

/// Duration of the clips with root motion in seconds.
const SECS: f32 = 1.0;
/// Radius of the curve in metres.
const RADIUS: f32 = 2.0;
/// Rotation over one cycle of the curve, in radians.
const TURN: f32 = 0.7;

/// A walk in a curve to the left: the root moves along a circle, and a leg swings.
fn curve() -> ClipSource {
    let times: Vec<f32> = (0..=40_u8).map(|key| SECS * f32::from(key) / 40.0).collect();
    let yaw = |secs: &f32| TURN * secs / SECS;
    let position = |secs: &f32| [RADIUS * (1.0 - yaw(secs).cos()), 0.0, RADIUS * yaw(secs).sin()];
    let rotation = |secs: &f32| [0.0, (yaw(secs) / 2.0).sin(), 0.0, (yaw(secs) / 2.0).cos()];
    let track = |property, values| Track {
        joint: "root".into(),
        property,
        interpolation: Interpolation::Linear,
        times: times.clone(),
        values,
    };
    let mut source = fixture::swing(
        "curve",
        SECS,
        &[("leftUpperLeg", [1.0, 0.0, 0.0], 0.45, 0.0), ("spine", [0.0, 1.0, 0.0], 0.3, 0.2)],
    );
    source.tracks.push(track(Property::Translation, times.iter().flat_map(position).collect()));
    source.tracks.push(track(Property::Rotation, times.iter().flat_map(rotation).collect()));
    source
}

/// A walk straight ahead by `metres` per cycle.
fn straight(name: &str, metres: f32) -> ClipSource {
    let mut source = fixture::swing(name, SECS, &[("leftUpperLeg", [1.0, 0.0, 0.0], 0.45, 0.0)]);
    source.tracks.push(Track {
        joint: "root".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, SECS],
        values: vec![0.0, 0.0, 0.0, 0.0, 0.0, metres],
    });
    source
}

/// Adds a clip as it is, and with its motion extracted as root motion.
fn add(scene: &mut Scene, source: ClipSource) -> (ClipId, ClipId) {
    let whole = Clip::new(source, &character().skeleton).expect("a good clip");
    let extracted = whole.with_root_motion(&MotionSettings::default()).expect("a root that moves");
    let mut add = |clip| {
        scene
            .crowd
            .character_mut(scene.body)
            .expect("enough capacity")
            .add_clip(&Arc::new(clip))
            .expect("enough capacity")
    };
    (add(whole), add(extracted))
}

/// Returns the root motion of a number of cycles of the curve.
fn motion_after(cycles: f32) -> Affine {
    let yaw = TURN * cycles;
    let (sin, cos) = yaw.sin_cos();
    Affine {
        rows: [
            [cos, 0.0, sin, RADIUS * (1.0 - cos)],
            [0.0, 1.0, 0.0, 0.0],
            [-sin, 0.0, cos, RADIUS * sin],
        ],
    }
}

/// Returns the largest distance in metres between the transforms of a point near each joint.
fn largest_distance(a: &[Affine], b: &[Affine]) -> f32 {
    let joints = a.iter().zip(b).map(|(a, b)| {
        // A point away from the joint also shows rotations.
        distance(a.transform_point([0.2, 0.1, 0.3]), b.transform_point([0.2, 0.1, 0.3]))
    });
    joints.fold(0.0, f32::max)
}

#[test]
fn root_motion_follows_the_whole_clip_over_many_cycles() {
    everywhere(|scene| {
        let (whole, extracted) = add(scene, curve());
        let at = Placement::at([3.0, 0.0, -2.0]).facing(0.8).scaled(1.1);
        let [plain, moved] = [scene.member(at), scene.member(at)];
        scene.edit(plain).play(whole, ClipPlayback::looping().phase(0.25)).expect("a clip");
        scene.edit(moved).play(extracted, ClipPlayback::looping().phase(0.25)).expect("a clip");
        scene.edit(moved).start_root_motion().expect("a member");
        let mut worst: f32 = 0.0;
        for frame in 1..=200_u8 {
            scene.update(0.02);
            let cycles = 0.25 + f32::from(frame) * 0.02 / SECS;
            // The plain member returns to the clip's start in each cycle. Both started at 1/4 of a
            // cycle.
            let since = motion_after(-0.25).mul(&motion_after(cycles.floor()));
            let wanted: Vec<_> = scene.models(plain).iter().map(|model| since.mul(model)).collect();
            worst = worst.max(largest_distance(&wanted, &scene.models(moved)));
        }
        println!(
            "{:?}: {:.2} mm off in four cycles, 200 frames",
            scene.crowd.device_info().schedule,
            worst * 1e3
        );
        assert!(worst < 2e-3, "the pose is {worst} m off");
        let now = scene.edit(moved).moved_placement().expect("a member");
        let end = at.world_from_model().mul(&motion_after(-0.25).mul(&motion_after(4.25)));
        assert!(distance(now.position(), end.origin()) < 5e-3, "{now:?} {end:?}");
        assert!((now.yaw_rad() - 0.8 - 4.0 * TURN).abs() % std::f32::consts::TAU < 1e-3, "{now:?}");
        assert_eq!(scene.crowd.member(moved).map(|m| m.placement()), Ok(at));
    });
}

#[test]
fn removing_a_watch_keeps_other_watches() {
    let mut scene = fixture::scene(Device::native(), populace::Schedule::Fused);
    let (_, walk) = add(&mut scene, straight("walk ahead", 1.0));
    let member = walker(&mut scene, walk);
    let root = joint("root");
    let [gone, kept] = [(); 2].map(|()| scene.edit(member).watch_joint(root).expect("a joint"));
    assert_ne!(gone, kept);
    for _ in 0..3 {
        scene.edit(member).unwatch_joint(gone);
    }
    for frame in 1..=3_u8 {
        scene.update(0.25);
        scene.crowd.with_page(0, &mut |_| ()).expect("a page");
        let moved = scene.crowd.member(member).expect("a member").instance().moved;
        assert!((moved[2] - 0.25 * f32::from(frame)).abs() < 1e-4, "{moved:?}");
        assert!(scene.crowd.readback(kept).expect("a device").is_some());
        assert_eq!(scene.crowd.readback(gone), Ok(None));
    }
    scene.edit(member).unwatch_joint(kept);
    assert_eq!(scene.crowd.readback(kept), Ok(None));
    let left = scene.edit(member).watch_joint(root).expect("a joint");
    scene.update(0.25);
    scene.crowd.despawn(member).expect("a member");
    scene.update(0.25);
    assert_eq!(scene.crowd.readback(left), Ok(None));
}

/// The second frame at a tick is another frame: a jump back does not undo motion.
#[test]
fn offsets_follow_a_frame_at_the_same_time_again() {
    let mut scene = fixture::scene(Device::native(), populace::Schedule::Fused);
    let (_, walk) = add(&mut scene, straight("walk ahead", 1.0));
    let member = walker(&mut scene, walk);
    let offset = |scene: &mut Scene| {
        scene.crowd.with_page(0, &mut |_| ()).expect("a page");
        scene.crowd.member(member).expect("a member").instance().moved[2]
    };
    scene.update(0.5);
    let before = offset(&mut scene);
    assert!((before - 0.5).abs() < 1e-4, "{before}");
    scene.crowd.seek(0.0).expect("a time");
    scene.update(0.5);
    let after = offset(&mut scene);
    assert!(after > before + 0.4, "{after}");
}

#[test]
fn root_motion_can_be_started_committed_placed_and_stopped() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 1.0));
        let member =
            scene.member(Placement::at([5.0, 0.0, 0.0]).facing(std::f32::consts::FRAC_PI_2));
        scene.edit(member).play(walk, ClipPlayback::looping()).expect("a clip");
        let at = |scene: &mut Scene, wanted: [f32; 3]| {
            let hips = scene.models(member)[joint("hips").index()].origin();
            let drawn = scene
                .crowd
                .member(member)
                .expect("a member")
                .placement()
                .world_from_model()
                .transform_point(hips);
            let ([x, _, z], [a, _, b]) = (drawn, wanted);
            assert!((x - a).abs() < 1e-4 && (z - b).abs() < 1e-4, "{drawn:?} is not at {wanted:?}");
        };
        scene.update(0.5);
        at(scene, [5.0, 0.0, 0.0]);
        assert_eq!(scene.crowd.member(member).map(|m| m.has_root_motion()), Ok(false));
        scene.edit(member).start_root_motion().expect("a member");
        scene.update(0.5);
        at(scene, [5.5, 0.0, 0.0]);
        let placed = scene.edit(member).commit_root_motion().expect("a member");
        assert!(distance(placed.position(), [5.5, 0.0, 0.0]) < 1e-4, "{placed:?}");
        scene.update(0.25);
        at(scene, [5.75, 0.0, 0.0]);
        scene.edit(member).set_placement(Placement::at([0.0, 0.0, 7.0])).expect("a place");
        scene.update(0.25);
        at(scene, [0.0, 0.0, 7.25]);
        scene.edit(member).stop_root_motion().expect("a member");
        scene.update(0.25);
        at(scene, [0.0, 0.0, 7.0]);
        // Instances have the root-motion offset once the palettes have been read.
        scene.edit(member).start_root_motion().expect("a member");
        for _ in 0..4 {
            scene.update(0.125);
            scene.crowd.finish().expect("a device");
        }
        scene.crowd.with_page(0, &mut |_| ()).expect("a page");
        let moved = scene.crowd.member(member).expect("a member").instance().moved;
        assert!(distance(moved, [0.0, 0.0, 0.5]) < 1e-4, "{moved:?}");
        // A new member in the same slot starts without a root-motion offset.
        scene.edit(member).start_root_motion().expect("a member");
        scene.update(0.5);
        scene.crowd.despawn(member).expect("a member");
        assert!(scene.crowd.member_mut(member).and_then(|mut m| m.start_root_motion()).is_err());
        let next = scene.member(Placement::at([0.0; 3]));
        scene.edit(next).play(walk, ClipPlayback::looping()).expect("a clip");
        scene.edit(next).start_root_motion().expect("a member");
        assert_eq!(step_of(scene, next, 0.0), 0.0);
        assert!((step_of(scene, next, 0.125) - 0.125).abs() < 1e-5);
    });
}

/// Returns how far a member moves in a frame, in metres.
fn step_of(scene: &mut Scene, member: MemberId, secs: f32) -> f32 {
    let before = scene.edit(member).moved_placement().expect("a member").position();
    scene.update(secs);
    distance(scene.edit(member).moved_placement().expect("a member").position(), before)
}

/// Spawns a member at the origin with root motion from a clip.
fn walker(scene: &mut Scene, walk: ClipId) -> MemberId {
    let member = scene.member(Placement::at([0.0; 3]));
    scene.edit(member).play(walk, ClipPlayback::looping()).expect("a clip");
    scene.edit(member).start_root_motion().expect("a member");
    member
}

#[test]
fn starting_root_motion_each_frame_changes_nothing() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 1.0));
        let member = walker(scene, walk);
        for _ in 0..4 {
            scene.update(0.125);
            scene.edit(member).start_root_motion().expect("a member");
        }
        let moved = scene.edit(member).moved_placement().expect("a member").position();
        assert!(distance(moved, [0.0, 0.0, 0.5]) < 1e-4, "{moved:?}");
    });
}

#[test]
fn move_before_the_newest_members_ran_keeps_offsets() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 1.0));
        let first = walker(scene, walk);
        scene.update(0.5);
        let newest: Vec<_> = (0..9).map(|_| walker(scene, walk)).collect();
        let devices = scene.crowd.device_info().devices.clone();
        scene.crowd.move_to(devices).expect("the same devices");
        let z = |scene: &mut Scene, member| {
            scene.edit(member).moved_placement().expect("a member").position()[2]
        };
        assert!((z(scene, first) - 0.5).abs() < 1e-4, "{} before the next frame", z(scene, first));
        scene.update(0.25);
        assert!((z(scene, first) - 0.75).abs() < 1e-4, "{} after it", z(scene, first));
        assert!(newest.iter().all(|member| (z(scene, *member) - 0.25).abs() < 1e-4));
    });
}

/// A snapshot from before the first frame holds no motion.
#[test]
fn restored_members_begin_where_they_were_placed() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 1.0));
        let member = walker(scene, walk);
        let start = scene.crowd.snapshot().expect("a snapshot");
        for secs in [0.0, 0.5, 0.25] {
            scene.crowd.restore(&start).expect("its own snapshot");
            scene.update(secs);
            let z = scene.edit(member).moved_placement().expect("a member").position()[2];
            assert!((z - secs).abs() < 1e-4, "{z} after {secs} s");
        }
    });
}

/// A motion that begins after the snapshot takes nothing from one that was begun and undone.
#[test]
fn motions_of_an_undone_time_are_forgotten() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 1.0));
        let member = walker(scene, walk);
        scene.edit(member).stop_root_motion().expect("a member");
        scene.edit(member).watch_joint(populace::JointIndex(1)).expect("a joint");
        let start = scene.crowd.snapshot().expect("a snapshot");
        for _ in 0..3 {
            scene.update(0.1);
            scene.edit(member).start_root_motion().expect("a member");
            scene.update(0.25);
            scene.update(0.25);
            let z = scene.edit(member).moved_placement().expect("a member").position()[2];
            assert!((z - 0.5).abs() < 1e-4, "{z}");
            scene.crowd.restore(&start).expect("its own snapshot");
        }
    });
}

/// Results of times before a watch or a motion began are its own after a jump back.
#[test]
fn joints_are_read_on_after_a_jump_back() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 1.0));
        scene.update(10.0);
        let member = walker(scene, walk);
        let watch = scene.edit(member).watch_joint(populace::JointIndex(0)).expect("a joint");
        scene.update(0.5);
        scene.crowd.seek(1.0).expect("a time");
        for _ in 0..4 {
            scene.update(0.25);
        }
        scene.crowd.finish().expect("a frame");
        let seen = scene.crowd.readback(watch).expect("a watch").expect("a result");
        assert!((1.25..=2.0).contains(&seen.at_secs), "{} s", seen.at_secs);
        let moved = scene.edit(member).moved_placement().expect("a member").position()[2];
        assert!((moved - 0.5).abs() < 1e-3, "{moved}: the clip begins at 10 s");
    });
}

#[test]
fn jumps_back_in_time_do_not_undo_motion() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 1.0));
        scene.update(1.0);
        let member = walker(scene, walk);
        scene.update(0.5);
        scene.crowd.seek(0.25).expect("a time");
        let z = scene.edit(member).moved_placement().expect("a member").position()[2];
        assert!((z - 0.5).abs() < 1e-4, "{z}");
    });
}

#[test]
fn motion_of_a_walk_in_place_comes_from_its_feet() {
    let skeleton = character().skeleton.clone();
    let clip = character()
        .clips
        .iter()
        .find(|clip| clip.name() == "walk")
        .map(Arc::clone)
        .expect("a walk");
    let settings = MotionSettings { from: MotionSource::Feet, ..MotionSettings::default() };
    let moved = clip.with_root_motion(&settings).expect("feet that are known by name");
    let speed = moved.stats().ground_speed_m_per_sec.expect("a speed");
    let (end, yaw) = moved.root_motion().expect("a motion").at(SECS);
    assert_eq!((end[0], end[1], yaw), (0.0, 0.0, 0.0));
    assert!(
        (end[2] - speed * moved.duration_secs()).abs() < 1e-5 && speed.abs() > 0.1,
        "{end:?} {speed}"
    );
    assert_eq!(moved.skeleton().joint_count(), skeleton.joint_count());
}

/// Twelve members with root motion, with different phases, speeds and transitions.
fn walkers(crowd: Crowd) -> (Scene, Vec<MemberId>) {
    let mut crowd = crowd;
    let body = crowd.add_character(character()).expect("enough capacity");
    let mut scene = Scene { crowd, body };
    let (_, curve) = add(&mut scene, curve());
    let (_, walk) = add(&mut scene, straight("walk ahead", 1.3));
    let after = [Condition::AfterSecs(0.2)];
    let machine = StateMachine::new()
        .state("walk", walk, StatePlayback::looping())
        .state("curve", curve, StatePlayback::looping())
        .transition("curve", "walk", 0.0, &after)
        .transition("walk", "curve", 0.07, &after);
    let machine = scene.crowd.add_machine(&machine).expect("a machine");
    let members: Vec<_> = (0..12_u8)
        .map(|n| scene.member(Placement::at([f32::from(n), 0.0, 0.0]).facing(f32::from(n))))
        .collect();
    for (n, &member) in (0_u8..).zip(&members) {
        let play =
            ClipPlayback::looping().phase(f32::from(n) * 0.07).speed(1.5 - 0.3 * f32::from(n));
        scene.edit(member).play(curve, play).expect("a clip");
        scene.edit(member).crossfade(walk, 0.1 * f32::from(n)).expect("a clip");
        scene.edit(member).start_root_motion().expect("a member");
        // Starts in the middle of a frame.
        let secs = 0.02 * f32::from(n % 3);
        let after_secs = 0.31 + 0.07 * f32::from(n);
        let later = ClipPlayback::looping().after_secs(after_secs);
        match n % 4 {
            3 => scene
                .edit(member)
                .play_machine(
                    machine,
                    MachinePlayback::new().after_secs(after_secs).fade_in_secs(secs),
                )
                .expect("a machine"),
            2 => scene
                .edit(member)
                .play(curve, later.inertialize_in_secs(0.1 + secs))
                .expect("a clip"),
            _ => scene.edit(member).play(curve, later.fade_in_secs(secs)).expect("a clip"),
        };
    }
    (scene, members)
}

fn step(scene: &mut Scene, members: &[MemberId]) -> Vec<u32> {
    scene.update(1.0 / 60.0);
    let palettes =
        members.iter().flat_map(|&member| scene.edit(member).palette().expect("a palette"));
    palettes.flat_map(|m| m.rows).flatten().map(f32::to_bits).collect()
}

fn crowd_on(device: Device) -> Crowd {
    Crowd::builder().device(device).capacity(16).build().expect("a crowd")
}

#[test]
fn root_motion_gives_equal_bits_on_all_devices_and_schedules() {
    let first: RefCell<Option<Vec<Vec<u32>>>> = RefCell::new(None);
    everywhere(|scene| {
        let (device, schedule) =
            (scene.crowd.device_info().devices.clone(), scene.crowd.device_info().schedule);
        let crowd = Crowd::builder()
            .devices(device)
            .schedule(schedule)
            .capacity(16)
            .build()
            .expect("a crowd");
        let (mut scene, members) = walkers(crowd);
        let bits: Vec<_> = (0..90).map(|_| step(&mut scene, &members)).collect();
        let mut first = first.borrow_mut();
        assert!(*first.get_or_insert_with(|| bits.clone()) == bits, "{schedule} differs");
    });
}

#[cfg(feature = "opencl")]
#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn root_motion_survives_moves_and_splits() {
    let shared = Crowd::builder()
        .devices([Device::native(), Device::opencl(0)])
        .capacity(16)
        .build()
        .expect("a crowd");
    let ((mut moved, moving), (mut split, several), (mut twin, twins)) =
        (walkers(crowd_on(Device::native())), walkers(shared), walkers(crowd_on(Device::native())));
    for frame in 0..60 {
        if frame % 20 == 10 {
            let device = if frame % 40 == 10 { Device::opencl(0) } else { Device::native() };
            moved.crowd.move_to(device).expect("a device");
        }
        let share = f64::from(frame % 7 + 1) / 9.0;
        split.crowd.set_split(&Split::Fixed(vec![share, 1.0 - share])).expect("shares");
        let wanted = step(&mut twin, &twins);
        assert!(step(&mut moved, &moving) == wanted, "moved crowd, frame {frame}");
        assert!(step(&mut split, &several) == wanted, "split crowd, frame {frame}");
    }
}
