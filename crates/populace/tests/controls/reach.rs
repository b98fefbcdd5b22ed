//! Two-bone reaching.

use populace::{ClipPlayback, JointOverride, Placement, Reach, Space, Target, Trs, Weight};

use crate::body::{Stage, distance, everywhere, joint, turn_deg};

const LENGTH: f32 = 0.55;

fn at_once() -> Weight {
    Weight::FULL.over_secs(0.0)
}

#[test]
fn a_target_within_reach_is_met() {
    everywhere(|stage| {
        let placement = Placement::at([3.0, 0.0, -2.0]).facing(0.7).scaled(1.3);
        let member = stage.member(placement);
        let clip = stage.clip("sway");
        stage
            .crowd
            .member_mut(member)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::looping())
            .expect("a clip that plays");
        let reach =
            Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let mut worst: f32 = 0.0;
        for step in 0..60u8 {
            let x = f32::from(step);
            let direction = [(x * 0.7).sin().abs() + 0.2, (x * 1.3).sin(), (x * 0.9).cos() * 0.9];
            let length = distance(direction, [0.0; 3]);
            stage.update(0.05);
            let shoulder = stage.place(member, "leftUpperArm");
            let far = LENGTH * (0.15 + 0.8 * (x * 0.31).sin().abs());
            let target: [f32; 3] =
                std::array::from_fn(|c| shoulder[c] + direction[c] / length * far);
            let aim = if step % 2 == 0 {
                Target::InModel(target)
            } else {
                Target::Point(placement.world_from_model().transform_point(target))
            };
            stage
                .crowd
                .member_mut(member)
                .expect("a limb that reaches")
                .reach(reach, aim, at_once())
                .expect("a limb that reaches");
            stage.update(0.0);
            let missed = distance(stage.place(member, "leftHand"), target);
            worst = worst.max(missed);
            assert!(missed < 0.001, "step {step}: the hand is {missed} m off");
        }
        println!("worst {worst}");
    });
}

/// Turns of the arm's joints between one step and the next while a target moves out of reach and
/// back at 0.2 m/s.
fn largest_turns(stage: &mut Stage, step_secs: f32) -> (f32, f32) {
    let member = stage.member(Placement::at([0.0; 3]));
    let reach = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
    stage.update(0.0);
    let shoulder = stage.place(member, "leftUpperArm");
    let (mut inside, mut anywhere) = (0.0_f32, 0.0_f32);
    let mut last: Option<Vec<populace::Affine>> = None;
    let mut secs = 0.0;
    while secs < 4.0 {
        // From 0.2 m before the shoulder to 0.6 m, past the arm's length, and to the side all the
        // while.
        let out = if secs < 2.0 { 0.2 + 0.2 * secs } else { 1.0 - 0.2 * secs };
        let target = [shoulder[0] + 0.3 * out, shoulder[1] - 0.2 * out, shoulder[2] + 0.93 * out];
        stage
            .crowd
            .member_mut(member)
            .expect("a limb that reaches")
            .reach(reach, Target::InModel(target), at_once())
            .expect("a limb that reaches");
        stage.update(step_secs);
        let now = stage.models(member);
        if let Some(last) = &last {
            for name in ["leftUpperArm", "leftLowerArm", "leftHand"] {
                let turned = turn_deg(&last[joint(name).index()], &now[joint(name).index()]);
                anywhere = anywhere.max(turned);
                if distance(target, shoulder) < 0.97 * LENGTH {
                    inside = inside.max(turned);
                }
            }
        }
        last = Some(now);
        secs += step_secs;
    }
    (inside, anywhere)
}

#[test]
fn a_target_that_moves_through_and_out_of_range_never_makes_the_arm_jump() {
    everywhere(|stage| {
        let (inside, whole) = largest_turns(stage, 1.0 / 60.0);
        let (_, half) = largest_turns(stage, 1.0 / 120.0);
        println!("inside {inside} degrees a step, anywhere {whole}, with half the step {half}");
        assert!(inside < 2.0, "{inside} degrees in a step");
        assert!(
            (0.4..0.6).contains(&(half / whole)),
            "{whole} degrees in a step, {half} in half of one"
        );
    });
}

#[test]
fn beyond_its_length_an_arm_straightens_towards_the_target() {
    everywhere(|stage| {
        let member = stage.member(Placement::at([0.0; 3]));
        let reach =
            Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let target = [1.0, 4.0, 5.0];
        stage
            .crowd
            .member_mut(member)
            .expect("a limb that reaches")
            .reach(reach, Target::InModel(target), at_once())
            .expect("a limb that reaches");
        stage.update(0.1);
        let [shoulder, hand] = ["leftUpperArm", "leftHand"].map(|name| stage.place(member, name));
        let straight = distance(shoulder, hand) / LENGTH;
        let off = distance(hand, target) + distance(shoulder, hand) - distance(shoulder, target);
        assert!(straight > 0.99 && straight <= 1.001, "{straight} of its length");
        assert!(off < 1e-4, "{off} m beside the line");
    });
}

#[test]
fn bones_of_very_different_lengths_stay_finite() {
    everywhere(|stage| {
        let member = stage.member(Placement::at([0.0; 3]));
        let hand = joint("leftHand");
        let far = JointOverride {
            joint: hand,
            space: Space::Local,
            transform: Trs { translation: [1e9, 0.4, 0.4], ..Trs::IDENTITY },
            weight: 0.45,
        };
        let mut view = stage.crowd.member_mut(member).expect("a member");
        view.override_joints(&[far]).expect("an override within the limits");
        let reach = Reach::with(hand).pole([-0.1, -0.95, 0.4]).keeping_rotation();
        view.reach(reach, [1.0, 1.0, 1.0], at_once()).expect("a limb that reaches");
        stage.update(0.1);
        let palette = stage.crowd.member_mut(member).expect("a member").palette();
        let palette = palette.expect("a palette");
        assert!(palette.iter().flat_map(|m| m.rows).flatten().all(f32::is_finite), "{palette:?}");
    });
}
