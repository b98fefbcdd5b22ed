//! A part of a member goes limp while the rest follows its clips.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print measurements and panic on errors"
)]

mod common;

use common::{DT, Scene, length, minus};
use populace::{ClipPlayback, Placement};
use populace_physics::{Error, State};

#[test]
fn limp_arm_hangs_and_other_joints_stay_bitwise_equal() {
    let mut scene = Scene::walking_man();
    let mut twin = Scene::walking_man();
    let (arm, hand) = (scene.joint("LeftUpperArm"), scene.joint("LeftHand"));
    scene.ragdolls.go_limp_from(&scene.crowd, scene.member, &scene.plan, arm).unwrap();
    let is_of_arm = |scene: &Scene, joint| {
        let up = |j| scene.skeleton().parent(j);
        std::iter::successors(Some(joint), |j| up(*j)).any(|j| j == arm)
    };
    let mut swing: f32 = 0.0;
    for frame in 0..120 {
        scene.frame();
        twin.frame();
        let (joints, clips) = (scene.joints(), twin.joints());
        for joint in scene.skeleton().joints().filter(|j| !is_of_arm(&scene, *j)) {
            assert_eq!(joints[joint.index()], clips[joint.index()], "{joint:?} in frame {frame}");
        }
        let upper = minus(scene.position(hand), scene.position(arm));
        let clip = minus(twin.position(hand), twin.position(arm));
        swing = swing.max(length(minus(upper, clip)));
        if frame > 60 {
            assert!(upper[1] < -0.8 * length(upper), "the arm hangs: {upper:?} in frame {frame}");
        }
    }
    println!("the hand is up to {swing} m from its position in the clip");
    assert!(swing > 0.05);
    assert!(matches!(scene.ragdolls.state(scene.member), State::Limp { .. }));
    let head = scene.joint("Head");
    let refused = scene.ragdolls.push(scene.member, head, [1.0, 0.0, 0.0], None);
    assert_eq!(refused, Err(Error::NotLimp), "the head follows the clips");
}

#[test]
fn limp_arm_follows_a_moving_member() {
    let mut scene = Scene::walking_man();
    let (arm, hand) = (scene.joint("RightUpperArm"), scene.joint("RightHand"));
    scene.ragdolls.go_limp_from(&scene.crowd, scene.member, &scene.plan, arm).unwrap();
    scene.crowd.member_mut(scene.member).unwrap().set_placement(Placement::at([0.0; 3])).unwrap();
    let mut furthest: f32 = 0.0;
    let mut worst: f32 = 0.0;
    let mut before: Option<([f32; 3], [f32; 3])> = None;
    for frame in 1..150 {
        scene.ragdolls.step(&mut scene.crowd, DT).unwrap();
        scene
            .crowd
            .member_mut(scene.member)
            .unwrap()
            .set_placement(Placement::at([0.0, 0.0, 1.4 * DT * frame as f32]))
            .unwrap();
        scene.crowd.update(DT).unwrap();
        let (shoulder, hand) = (scene.position(arm), scene.position(hand));
        let hang = minus(hand, shoulder);
        furthest = furthest.max(hang[2].abs());
        if let Some((hand_before, step_before)) = before {
            let step = minus(hand, hand_before);
            worst = worst.max(length(minus(step, step_before)) / DT);
            before = Some((hand, step));
        } else {
            before = Some((hand, [0.0, 0.0, 1.4 * DT]));
        }
    }
    println!(
        "the hand is at most {furthest} m ahead or behind, and its velocity changes by at most \
         {worst} m/s per frame"
    );
    assert!(furthest < 0.5 && worst < 2.5);
}

#[test]
fn limp_parts_add_up_until_the_whole_is_limp() {
    let mut scene = Scene::walking_man();
    for name in ["LeftUpperArm", "RightUpperArm"] {
        let arm = scene.joint(name);
        scene.ragdolls.go_limp_from(&scene.crowd, scene.member, &scene.plan, arm).unwrap();
        scene.frames(20);
    }
    assert_eq!(scene.ragdolls.joint_angles(scene.member).len(), 6);
    scene.go_limp();
    scene.frames(200);
    assert!(scene.positions()[0][1] < 0.4, "he lies on the ground");
    let walk = scene.crowd.clip(scene.character, "Run").unwrap();
    scene.crowd.member_mut(scene.member).unwrap().play(walk, ClipPlayback::looping()).unwrap();
    scene.frames(10);
    assert!(scene.positions()[0][1] < 0.4, "clips do not move him");
}
