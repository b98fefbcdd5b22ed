//! State of earlier frames belongs to one use of a constraint, in one course of time.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use fastrand::Rng;
use populace::{
    Affine, After, ClipPlayback, Device, Feet, Ground, MemberId, Placement, Schedule, StageUse,
    Stride, Target, UserStage, Weight,
};

use crate::feet::feet;
use crate::fixture::{Scene, everywhere, scene};
use crate::gaze::gaze;

const FRAME_SECS: f32 = 1.0 / 30.0;

fn slope(scene: &mut Scene) {
    let ground = Ground::plane(-0.05, [0.1, 0.1]).expect("a plane");
    scene.crowd.set_ground(&ground).expect("a ground");
}

/// A member that sways and has a constraint program of its own, whatever else it does.
fn swaying(scene: &mut Scene) -> MemberId {
    let member = scene.member(Placement::at([0.0; 3]));
    let clip = scene.clip("sway");
    scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
    scene.edit(member).watch_joint(populace::JointIndex(0)).expect("a joint");
    member
}

#[test]
fn feet_that_are_planted_again_start_afresh() {
    everywhere(|scene| {
        slope(scene);
        scene.update(FRAME_SECS);
        for pause in [0_u8, 1, 2, 9] {
            let [again, once] = [swaying(scene), swaying(scene)];
            scene.edit(again).plant_feet_with(&feet()).expect("feet");
            for _ in 0..4 {
                scene.update(FRAME_SECS);
            }
            let none = Feet { weight: 0.0, ..feet() };
            scene.edit(again).plant_feet_with(&none).expect("no feet");
            for frame in 0..pause {
                for member in [again, once] {
                    let at = Placement::at([0.3 * f32::from(frame), 0.0, 0.0]);
                    scene.edit(member).set_placement(at).expect("a member");
                }
                scene.update(FRAME_SECS);
            }
            for member in [again, once] {
                scene.edit(member).plant_feet_with(&feet()).expect("feet");
            }
            scene.update(FRAME_SECS);
            assert_eq!(scene.models(again), scene.models(once), "after {pause} frames");
        }
    });
}

/// Strides hold until feet are planted no longer, and do nothing before they are.
#[test]
fn strides_end_with_the_planting() {
    everywhere(|scene| {
        let walk = scene.clip("walk");
        let [plain, ended, early] = [swaying(scene), swaying(scene), swaying(scene)];
        let turned = Stride::along([0.9, 0.4]);
        scene.edit(ended).plant_feet_with(&feet()).expect("feet");
        scene.edit(ended).set_stride(turned).expect("a stride");
        let none = Feet { weight: 0.0, ..feet() };
        scene.edit(ended).plant_feet_with(&none).expect("no feet");
        scene.edit(early).set_stride(turned).expect("a stride");
        for member in [plain, ended, early] {
            scene.edit(member).play(walk, ClipPlayback::looping()).expect("a clip that plays");
            scene.edit(member).plant_feet_with(&feet()).expect("feet");
        }
        for frame in 0..60_u8 {
            for member in [plain, ended, early] {
                let at = Placement::at([0.0, 0.0, 0.03 * f32::from(frame)]);
                scene.edit(member).set_placement(at).expect("a member");
            }
            scene.update(FRAME_SECS);
            let expected = scene.models(plain);
            assert_eq!(scene.models(ended), expected, "frame {frame}, of a stride before");
            assert_eq!(scene.models(early), expected, "frame {frame}, of a stride too early");
        }
    });
}

/// The frame of a panic would lose what feet know of the frame before it.
#[test]
fn frames_in_which_a_stage_panics_leave_no_trace() {
    for schedule in [Schedule::Staged, Schedule::Fused] {
        let course = |panics: bool| {
            let mut scene = scene(Device::Native { threads: 2 }, schedule);
            slope(&mut scene);
            let [planted, tripping] = [swaying(&mut scene), swaying(&mut scene)];
            scene.edit(planted).plant_feet_with(&feet()).expect("feet");
            let trips = Arc::new(AtomicBool::new(false));
            let heard = Arc::clone(&trips);
            let trip = UserStage::new("trip").rust(move |_| {
                if heard.load(Ordering::Relaxed) {
                    resume_unwind(Box::new("tripped"));
                }
            });
            let trip = scene.crowd.add_stage(After::Transform, trip).expect("a stage");
            scene.edit(tripping).set_stage(trip, StageUse::on_all()).expect("a stage use");
            let mut shown = Vec::new();
            for frame in 0..8_u8 {
                let at = Placement::at([0.1 * f32::from(frame), 0.0, 0.0]);
                scene.edit(planted).set_placement(at).expect("a member");
                if panics && frame > 2 {
                    trips.store(true, Ordering::Relaxed);
                    let update = catch_unwind(AssertUnwindSafe(|| scene.update(FRAME_SECS)));
                    assert!(update.is_err(), "the stage panics");
                    trips.store(false, Ordering::Relaxed);
                }
                scene.update(FRAME_SECS);
                shown.push(scene.models(planted));
            }
            shown
        };
        assert_eq!(course(true), course(false), "{schedule}");
    }
}

#[test]
fn members_look_on_after_a_jump_back() {
    everywhere(|scene| {
        let member = swaying(scene);
        scene.update(10.0);
        let ahead = Target::InModel([0.5, 1.5, 2.0]);
        for secs in [10.0, 5.0, 0.0] {
            scene.crowd.seek(secs).expect("a time");
            let eased = Weight::FULL.over_secs(0.2);
            scene.edit(member).look_at_with(&gaze(), ahead, eased).expect("a gaze");
            scene.update(FRAME_SECS);
        }
    });
}

/// Makes random calls that start and end what devices remember. Returns all joints after each frame.
fn play(scene: &mut Scene, members: &[MemberId], random: &mut Rng) -> Vec<Vec<Affine>> {
    let mut seen = Vec::new();
    for _ in 0..12 {
        let member = members[random.usize(0..members.len())];
        let share = random.f32();
        match random.u8(0..6) {
            0 | 1 => {
                let weight = if random.bool() { 1.0 } else { 0.0 };
                let feet = Feet { weight, ..feet() };
                scene.edit(member).plant_feet_with(&feet).expect("feet");
            }
            2 => {
                let at = Placement::at([share, 0.0, 2.0 * share]).facing(share);
                scene.edit(member).set_placement(at).expect("a member");
            }
            3 => {
                let at = Target::InModel([share, 1.5, 1.0]);
                let eased = Weight::FULL.over_secs(0.1);
                scene.edit(member).look_at_with(&gaze(), at, eased).expect("a gaze");
            }
            _ => {
                scene.update(FRAME_SECS * share);
                seen.extend(members.iter().map(|member| scene.models(*member)));
            }
        }
    }
    seen
}

#[test]
fn restored_crowds_repeat_any_calls() {
    everywhere(|scene| {
        slope(scene);
        let members = [swaying(scene), swaying(scene), swaying(scene)];
        for seed in 0..40 {
            play(scene, &members, &mut Rng::with_seed(1000 + seed));
            let snapshot = scene.crowd.snapshot().expect("a snapshot");
            let first = play(scene, &members, &mut Rng::with_seed(seed));
            scene.crowd.restore(&snapshot).expect("its own snapshot");
            play(scene, &members, &mut Rng::with_seed(2000 + seed));
            scene.crowd.restore(&snapshot).expect("its own snapshot");
            let again = play(scene, &members, &mut Rng::with_seed(seed));
            assert!(first == again, "calls of seed {seed} gave other joints");
        }
    });
}
