//! A part of a member goes limp, and the rest goes on.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests tell figures, and end where they cannot go on"
)]

mod common;

use common::{DT, Stage, length, minus};
use populace::{Placement, Play};
use populace_physics::{Error, State};

#[test]
fn an_arm_hangs_while_the_walk_goes_on_bit_for_bit() {
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
        let upper = minus(stage.place(hand), stage.place(arm));
        let clip = minus(twin.place(hand), twin.place(arm));
        swing = swing.max(length(minus(upper, clip)));
        if frame > 60 {
            assert!(upper[1] < -0.8 * length(upper), "the arm hangs: {upper:?} in frame {frame}");
        }
    }
    println!("the hand is up to {swing} m from where the clip has it");
    assert!(swing > 0.05);
    assert!(matches!(stage.ragdolls.state(stage.member), State::Limp { .. }));
    let head = stage.joint("Head");
    let refused = stage.ragdolls.push(stage.member, head, [1.0, 0.0, 0.0], None);
    assert_eq!(refused, Err(Error::NotLimp), "the head follows clips");
}

#[test]
fn the_arm_of_one_who_walks_along_goes_along() {
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
        let (shoulder, hand) = (stage.place(arm), stage.place(hand));
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
        "the hand strays {furthest} m along the way, and its speed changes by {worst} m/s a frame \
         at most"
    );
    assert!(furthest < 0.5 && worst < 2.5);
}

#[test]
fn parts_add_up_and_give_way_to_the_whole() {
    let mut stage = Stage::walking_man();
    for name in ["LeftUpperArm", "RightUpperArm"] {
        let arm = stage.joint(name);
        stage.ragdolls.go_limp_from(&stage.crowd, stage.member, &stage.plan, arm).unwrap();
        stage.frames(20);
    }
    assert_eq!(stage.ragdolls.joint_angles(stage.member).len(), 6);
    stage.go_limp();
    stage.frames(200);
    assert!(stage.places()[0][1] < 0.4, "he lies");
    let walk = stage.crowd.clip(stage.character, "Run").unwrap();
    stage.crowd.play(stage.member, walk, Play::looping()).unwrap();
    stage.frames(10);
    assert!(stage.places()[0][1] < 0.4, "clips do not lift him");
}
