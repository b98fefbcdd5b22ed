//! Root motion: members that their clips move, on every device and schedule.
#![expect(
    clippy::disallowed_methods,
    reason = "tests have no need of the same bits on every machine"
)]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a test that cannot go on fails; bodies are shared with others"
)]
#![expect(
    clippy::print_stdout,
    reason = "what is measured is for those who run tests with --nocapture"
)]

#[path = "../controls/body.rs"]
mod body;
mod inertialization;
mod parts;

use std::cell::RefCell;
use std::sync::Arc;

use body::{Stage, character, distance, everywhere, joint};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, Property, Track};
use populace::{
    Affine, ClipId, ClipPlayback, Condition, Crowd, Device, LayerMode, LayerSettings,
    MachinePlayback, Mask, MemberId, MotionSettings, MotionSource, Placement, Split, StateMachine,
    StatePlayback,
};

const SECS: f32 = 1.0;
/// Metres and radians of one cycle of the curve.
const RADIUS: f32 = 2.0;
const TURN: f32 = 0.7;

/// A walk in a curve to the left: the root goes along a circle, and the legs swing.
fn curve() -> ClipSource {
    let times: Vec<f32> = (0..=40_u8).map(|key| SECS * f32::from(key) / 40.0).collect();
    let yaw = |secs: &f32| TURN * secs / SECS;
    let place = |secs: &f32| [RADIUS * (1.0 - yaw(secs).cos()), 0.0, RADIUS * yaw(secs).sin()];
    let turn = |secs: &f32| [0.0, (yaw(secs) / 2.0).sin(), 0.0, (yaw(secs) / 2.0).cos()];
    let track = |property, values| Track {
        joint: "root".into(),
        property,
        interpolation: Interpolation::Linear,
        times: times.clone(),
        values,
    };
    let mut source = body::swing(
        "curve",
        SECS,
        &[("leftUpperLeg", [1.0, 0.0, 0.0], 0.45, 0.0), ("spine", [0.0, 1.0, 0.0], 0.3, 0.2)],
    );
    source.tracks.push(track(Property::Translation, times.iter().flat_map(place).collect()));
    source.tracks.push(track(Property::Rotation, times.iter().flat_map(turn).collect()));
    source
}

/// Straight ahead at a speed.
fn straight(name: &str, metres: f32) -> ClipSource {
    let mut source = body::swing(name, SECS, &[("leftUpperLeg", [1.0, 0.0, 0.0], 0.45, 0.0)]);
    source.tracks.push(Track {
        joint: "root".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, SECS],
        values: vec![0.0, 0.0, 0.0, 0.0, 0.0, metres],
    });
    source
}

fn add(stage: &mut Stage, source: ClipSource) -> (ClipId, ClipId) {
    let whole = Clip::new(source, &character().skeleton).expect("a good clip");
    let taken = whole.with_root_motion(&MotionSettings::default()).expect("a root that moves");
    let mut add = |clip| stage.crowd.add_clip(stage.body, &Arc::new(clip)).expect("room");
    (add(whole), add(taken))
}

/// What so many cycles of the curve do, and a part of one.
fn carried(cycles: f32) -> Affine {
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

fn apart(a: &[Affine], b: &[Affine]) -> f32 {
    let joints = a.iter().zip(b).map(|(a, b)| {
        // Where a point away from the joint goes tells turns too.
        distance(a.transform_point([0.2, 0.1, 0.3]), b.transform_point([0.2, 0.1, 0.3]))
    });
    joints.fold(0.0, f32::max)
}

#[test]
fn members_go_where_the_whole_clip_would_take_them_cycle_after_cycle() {
    everywhere(|stage| {
        let (whole, taken) = add(stage, curve());
        let at = Placement::at([3.0, 0.0, -2.0]).facing(0.8).scaled(1.1);
        let [plain, moved] = [stage.member(at), stage.member(at)];
        stage
            .crowd
            .member_mut(plain)
            .expect("a clip")
            .play(whole, ClipPlayback::looping().phase(0.25))
            .expect("a clip");
        stage
            .crowd
            .member_mut(moved)
            .expect("a clip")
            .play(taken, ClipPlayback::looping().phase(0.25))
            .expect("a clip");
        stage.crowd.member_mut(moved).expect("a member").start_root_motion().expect("a member");
        let mut worst: f32 = 0.0;
        for frame in 1..=200_u8 {
            stage.update(0.02);
            let cycles = 0.25 + f32::from(frame) * 0.02 / SECS;
            // The plain one is back at the clip's start in each cycle; both began a quarter in.
            let since = carried(-0.25).mul(&carried(cycles.floor()));
            let wanted: Vec<_> = stage.models(plain).iter().map(|model| since.mul(model)).collect();
            worst = worst.max(apart(&wanted, &stage.models(moved)));
        }
        println!("{:?}: {:.2} mm in four cycles, 200 frames", stage.crowd.schedule(), worst * 1e3);
        assert!(worst < 2e-3, "{worst} m");
        let now =
            stage.crowd.member_mut(moved).expect("a member").moved_placement().expect("a member");
        let end = at.world_from_model().mul(&carried(-0.25).mul(&carried(4.25)));
        assert!(distance(now.position(), end.origin()) < 5e-3, "{now:?} {end:?}");
        assert!((now.yaw_rad() - 0.8 - 4.0 * TURN).abs() % std::f32::consts::TAU < 1e-3, "{now:?}");
        assert_eq!(stage.crowd.member(moved).map(|m| m.placement()), Ok(at));
    });
}

#[test]
fn a_watch_that_was_let_go_of_touches_nobody_elses() {
    let mut stage = body::stage(Device::native(), populace::Schedule::Fused);
    let (_, walk) = add(&mut stage, straight("walk ahead", 1.0));
    let member = walker(&mut stage, walk);
    let root = joint("root");
    let [gone, kept] = [(); 2].map(|()| {
        stage.crowd.member_mut(member).expect("a joint").watch_joint(root).expect("a joint")
    });
    assert_ne!(gone, kept);
    for _ in 0..3 {
        stage.crowd.unwatch(gone);
    }
    for frame in 1..=3_u8 {
        stage.update(0.25);
        stage.crowd.with_page(0, &mut |_| ()).expect("a page");
        let moved = stage.crowd.instances().find(|i| i.member == member).expect("a member").moved;
        assert!((moved[2] - 0.25 * f32::from(frame)).abs() < 1e-4, "{moved:?}");
        assert!(stage.crowd.readback(kept).expect("a device").is_some());
        assert_eq!(stage.crowd.readback(gone), Ok(None));
    }
    stage.crowd.unwatch(kept);
    assert_eq!(stage.crowd.readback(kept), Ok(None));
    let left = stage.crowd.member_mut(member).expect("a joint").watch_joint(root).expect("a joint");
    stage.update(0.25);
    stage.crowd.despawn(member).expect("a member");
    stage.update(0.25);
    assert_eq!(stage.crowd.readback(left), Ok(None));
}

#[test]
fn members_are_placed_let_go_and_moved_on() {
    everywhere(|stage| {
        let (_, walk) = add(stage, straight("walk ahead", 1.0));
        let member =
            stage.member(Placement::at([5.0, 0.0, 0.0]).facing(std::f32::consts::FRAC_PI_2));
        stage
            .crowd
            .member_mut(member)
            .expect("a clip")
            .play(walk, ClipPlayback::looping())
            .expect("a clip");
        let at = |stage: &mut Stage, wanted: [f32; 3]| {
            let hips = stage.models(member)[joint("hips").index()].origin();
            let drawn = stage
                .crowd
                .member(member)
                .expect("a member")
                .placement()
                .world_from_model()
                .transform_point(hips);
            let ([x, _, z], [a, _, b]) = (drawn, wanted);
            assert!((x - a).abs() < 1e-4 && (z - b).abs() < 1e-4, "{drawn:?} is not at {wanted:?}");
        };
        stage.update(0.5);
        at(stage, [5.0, 0.0, 0.0]);
        assert_eq!(stage.crowd.member(member).map(|m| m.has_root_motion()), Ok(false));
        stage.crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
        stage.update(0.5);
        at(stage, [5.5, 0.0, 0.0]);
        let placed = stage
            .crowd
            .member_mut(member)
            .expect("a member")
            .commit_root_motion()
            .expect("a member");
        assert!(distance(placed.position(), [5.5, 0.0, 0.0]) < 1e-4, "{placed:?}");
        stage.update(0.25);
        at(stage, [5.75, 0.0, 0.0]);
        stage
            .crowd
            .member_mut(member)
            .expect("a place")
            .set_placement(Placement::at([0.0, 0.0, 7.0]))
            .expect("a place");
        stage.update(0.25);
        at(stage, [0.0, 0.0, 7.25]);
        stage.crowd.member_mut(member).expect("a member").stop_root_motion().expect("a member");
        stage.update(0.25);
        at(stage, [0.0, 0.0, 7.0]);
        // Those who draw know where it is, once they have the palettes.
        stage.crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
        for _ in 0..4 {
            stage.update(0.125);
            stage.crowd.finish().expect("a device");
        }
        stage.crowd.with_page(0, &mut |_| ()).expect("a page");
        let moved = stage.crowd.instances().find(|i| i.member == member).expect("a member").moved;
        assert!(distance(moved, [0.0, 0.0, 0.5]) < 1e-4, "{moved:?}");
        // A newcomer does not go on where one who left was.
        stage.crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
        stage.update(0.5);
        stage.crowd.despawn(member).expect("a member");
        assert!(stage.crowd.member_mut(member).and_then(|mut m| m.start_root_motion()).is_err());
        let next = stage.member(Placement::at([0.0; 3]));
        stage
            .crowd
            .member_mut(next)
            .expect("a clip")
            .play(walk, ClipPlayback::looping())
            .expect("a clip");
        stage.crowd.member_mut(next).expect("a member").start_root_motion().expect("a member");
        assert_eq!(step_of(stage, next, 0.0), 0.0);
        assert!((step_of(stage, next, 0.125) - 0.125).abs() < 1e-5);
    });
}

/// How far a member goes in a frame.
fn step_of(stage: &mut Stage, member: MemberId, secs: f32) -> f32 {
    let before = stage
        .crowd
        .member_mut(member)
        .expect("a member")
        .moved_placement()
        .expect("a member")
        .position();
    stage.update(secs);
    distance(
        stage
            .crowd
            .member_mut(member)
            .expect("a member")
            .moved_placement()
            .expect("a member")
            .position(),
        before,
    )
}

/// A member that a clip moves from the origin on.
fn walker(stage: &mut Stage, walk: ClipId) -> MemberId {
    let member = stage.member(Placement::at([0.0; 3]));
    stage
        .crowd
        .member_mut(member)
        .expect("a clip")
        .play(walk, ClipPlayback::looping())
        .expect("a clip");
    stage.crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
    member
}

#[test]
fn being_told_each_frame_to_be_moved_does_not_hold_a_member_back() {
    everywhere(|stage| {
        let (_, walk) = add(stage, straight("walk ahead", 1.0));
        let member = walker(stage, walk);
        for _ in 0..4 {
            stage.update(0.125);
            stage
                .crowd
                .member_mut(member)
                .expect("a member")
                .start_root_motion()
                .expect("a member");
        }
        let moved = stage
            .crowd
            .member_mut(member)
            .expect("a member")
            .moved_placement()
            .expect("a member")
            .position();
        assert!(distance(moved, [0.0, 0.0, 0.5]) < 1e-4, "{moved:?}");
    });
}

#[test]
fn members_stay_where_they_are_on_a_move_before_the_newest_were_ever_evaluated() {
    everywhere(|stage| {
        let (_, walk) = add(stage, straight("walk ahead", 1.0));
        let first = walker(stage, walk);
        stage.update(0.5);
        let newest: Vec<_> = (0..9).map(|_| walker(stage, walk)).collect();
        let devices = stage.crowd.devices().clone();
        stage.crowd.move_to(devices).expect("another of its kind");
        let z = |stage: &mut Stage, member| {
            stage
                .crowd
                .member_mut(member)
                .expect("a member")
                .moved_placement()
                .expect("a member")
                .position()[2]
        };
        assert!((z(stage, first) - 0.5).abs() < 1e-4, "{} before the next frame", z(stage, first));
        stage.update(0.25);
        assert!((z(stage, first) - 0.75).abs() < 1e-4, "{} after it", z(stage, first));
        assert!(newest.iter().all(|member| (z(stage, *member) - 0.25).abs() < 1e-4));
    });
}

#[test]
fn feet_that_walk_in_place_set_the_pace() {
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

/// Twelve members in as many curves and speeds.
fn walkers(crowd: Crowd) -> (Stage, Vec<MemberId>) {
    let mut crowd = crowd;
    let body = crowd.add_character(character()).expect("room");
    let mut stage = Stage { crowd, body };
    let (_, curve) = add(&mut stage, curve());
    let (_, walk) = add(&mut stage, straight("walk ahead", 1.3));
    let after = [Condition::AfterSecs(0.2)];
    let machine = StateMachine::new()
        .state("walk", walk, StatePlayback::looping())
        .state("curve", curve, StatePlayback::looping())
        .transition("curve", "walk", 0.0, &after)
        .transition("walk", "curve", 0.07, &after);
    let machine = stage.crowd.add_machine(&machine).expect("a machine");
    let members: Vec<_> = (0..12_u8)
        .map(|n| stage.member(Placement::at([f32::from(n), 0.0, 0.0]).facing(f32::from(n))))
        .collect();
    for (n, &member) in (0_u8..).zip(&members) {
        let play =
            ClipPlayback::looping().phase(f32::from(n) * 0.07).speed(1.5 - 0.3 * f32::from(n));
        stage.crowd.member_mut(member).expect("a clip").play(curve, play).expect("a clip");
        stage
            .crowd
            .member_mut(member)
            .expect("a clip")
            .crossfade(walk, 0.1 * f32::from(n))
            .expect("a clip");
        stage.crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
        // What starts in the midst of a frame.
        let secs = 0.02 * f32::from(n % 3);
        let after_secs = 0.31 + 0.07 * f32::from(n);
        let later = ClipPlayback::looping().after_secs(after_secs);
        match n % 4 {
            3 => stage
                .crowd
                .member_mut(member)
                .expect("a machine")
                .play_machine(
                    machine,
                    MachinePlayback::new().after_secs(after_secs).fade_in_secs(secs),
                )
                .expect("a machine"),
            2 => stage
                .crowd
                .member_mut(member)
                .expect("a clip")
                .play(curve, later.inertialize_in_secs(0.1 + secs))
                .expect("a clip"),
            _ => stage
                .crowd
                .member_mut(member)
                .expect("a clip")
                .play(curve, later.fade_in_secs(secs))
                .expect("a clip"),
        };
    }
    (stage, members)
}

fn step(stage: &mut Stage, members: &[MemberId]) -> Vec<u32> {
    stage.update(1.0 / 60.0);
    let palettes = members.iter().flat_map(|&member| {
        stage.crowd.member_mut(member).expect("a palette").palette().expect("a palette")
    });
    palettes.flat_map(|m| m.rows).flatten().map(f32::to_bits).collect()
}

fn alone(device: Device) -> Crowd {
    Crowd::builder().device(device).capacity(16).build().expect("a crowd")
}

#[test]
fn every_device_and_schedule_moves_members_to_the_same_bits() {
    let first: RefCell<Option<Vec<Vec<u32>>>> = RefCell::new(None);
    everywhere(|stage| {
        let (device, schedule) = (stage.crowd.devices().clone(), stage.crowd.schedule());
        let crowd = Crowd::builder()
            .devices(device)
            .schedule(schedule)
            .capacity(16)
            .build()
            .expect("a crowd");
        let (mut stage, members) = walkers(crowd);
        let bits: Vec<_> = (0..90).map(|_| step(&mut stage, &members)).collect();
        let mut first = first.borrow_mut();
        assert!(*first.get_or_insert_with(|| bits.clone()) == bits, "{schedule} differs");
    });
}

#[cfg(feature = "opencl")]
#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn members_go_on_where_they_are_on_another_device_and_on_several() {
    let shared = Crowd::builder()
        .devices([Device::native(), Device::opencl(0)])
        .capacity(16)
        .build()
        .expect("a crowd");
    let ((mut moved, moving), (mut split, several), (mut twin, twins)) =
        (walkers(alone(Device::native())), walkers(shared), walkers(alone(Device::native())));
    for frame in 0..60 {
        if frame % 20 == 10 {
            let device = if frame % 40 == 10 { Device::opencl(0) } else { Device::native() };
            moved.crowd.move_to(device).expect("a device");
        }
        let share = f64::from(frame % 7 + 1) / 9.0;
        split.crowd.set_split(&Split::Fixed(vec![share, 1.0 - share])).expect("shares");
        let wanted = step(&mut twin, &twins);
        assert!(step(&mut moved, &moving) == wanted, "moved, frame {frame}");
        assert!(step(&mut split, &several) == wanted, "split, frame {frame}");
    }
}
