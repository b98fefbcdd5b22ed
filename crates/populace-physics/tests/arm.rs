//! A part of a member goes limp while the rest follows its clips.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print measurements and panic on errors"
)]

mod common;

use common::{DT, Stage, length, minus};
use populace::{Placement, Play};
use populace_physics::{Error, State};

#[test]
fn limp_arm_hangs_and_other_joints_stay_bitwise_equal() {
    let mut stage = Stage::walking_man();
    let mut twin = Stage::walking_man();
    let (arm, hand) = (stage.joint("LeftUpperArm"), stage.joint("LeftHand"));
    stage.ragdolls.go_limp_from(&stage.crowd, stage.member, &stage.plan, arm).unwrap();
    let is_of_arm = |stage: &Stage, joint| {
        let up = |j| stage.skeleton().parent(j);
        std::iter::successors(Some(joint), |j| up(*j)).any(|j| j == arm)
    };
    let mut swing: f32 = 0.0;
    for frame in 0..120 {
        stage.frame();
        twin.frame();
        let (joints, clips) = (stage.joints(), twin.joints());
        for joint in stage.skeleton().joints().filter(|j| !is_of_arm(&stage, *j)) {
            assert_eq!(joints[joint.index()], clips[joint.index()], "{joint:?} in frame {frame}");
        }
        let upper = minus(stage.position(hand), stage.position(arm));
        let clip = minus(twin.position(hand), twin.position(arm));
        swing = swing.max(length(minus(upper, clip)));
        if frame > 60 {
            assert!(upper[1] < -0.8 * length(upper), "the arm hangs: {upper:?} in frame {frame}");
        }
    }
    println!("the hand is up to {swing} m from its position in the clip");
    assert!(swing > 0.05);
    assert!(matches!(stage.ragdolls.state(stage.member), State::Limp { .. }));
    let head = stage.joint("Head");
    let refused = stage.ragdolls.push(stage.member, head, [1.0, 0.0, 0.0], None);
    assert_eq!(refused, Err(Error::NotLimp), "the head follows the clips");
}

#[test]
fn limp_arm_follows_a_moving_member() {
    let mut stage = Stage::walking_man();
    let (arm, hand) = (stage.joint("RightUpperArm"), stage.joint("RightHand"));
    stage.ragdolls.go_limp_from(&stage.crowd, stage.member, &stage.plan, arm).unwrap();
    stage.crowd.place(stage.member, Placement::at([0.0; 3])).unwrap();
    let mut furthest: f32 = 0.0;
    let mut worst: f32 = 0.0;
    let mut before: Option<([f32; 3], [f32; 3])> = None;
    for frame in 1..150 {
        stage.ragdolls.step(&mut stage.crowd, DT).unwrap();
        stage
            .crowd
            .place(stage.member, Placement::at([0.0, 0.0, 1.4 * DT * frame as f32]))
            .unwrap();
        stage.crowd.update(DT).unwrap();
        let (shoulder, hand) = (stage.position(arm), stage.position(hand));
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
    let mut stage = Stage::walking_man();
    for name in ["LeftUpperArm", "RightUpperArm"] {
        let arm = stage.joint(name);
        stage.ragdolls.go_limp_from(&stage.crowd, stage.member, &stage.plan, arm).unwrap();
        stage.frames(20);
    }
    assert_eq!(stage.ragdolls.joint_angles(stage.member).len(), 6);
    stage.go_limp();
    stage.frames(200);
    assert!(stage.positions()[0][1] < 0.4, "he lies on the ground");
    let walk = stage.crowd.clip(stage.character, "Run").unwrap();
    stage.crowd.play(stage.member, walk, Play::looping()).unwrap();
    stage.frames(10);
    assert!(stage.positions()[0][1] < 0.4, "clips do not move him");
}
