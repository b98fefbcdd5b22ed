//! Two-bone IK.

use populace::{
    ClipPlayback, Device, JointOverride, Placement, Reach, Schedule, Space, Target, Trs, Weight,
};

use crate::fixture::{Scene, distance, everywhere, joint, scene, turn_deg};

/// Length of the arm in metres.
const LENGTH: f32 = 0.55;

fn at_once() -> Weight {
    Weight::FULL.over_secs(0.0)
}

#[test]
fn target_within_reach_is_met() {
    everywhere(|scene| {
        let placement = Placement::at([3.0, 0.0, -2.0]).facing(0.7).scaled(1.3);
        let member = scene.member(placement);
        let clip = scene.clip("sway");
        scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
        let reach =
            Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let mut worst: f32 = 0.0;
        for step in 0..60u8 {
            let x = f32::from(step);
            let direction = [(x * 0.7).sin().abs() + 0.2, (x * 1.3).sin(), (x * 0.9).cos() * 0.9];
            let length = distance(direction, [0.0; 3]);
            scene.update(0.05);
            let shoulder = scene.position(member, "leftUpperArm");
            let far = LENGTH * (0.15 + 0.8 * (x * 0.31).sin().abs());
            let target: [f32; 3] =
                std::array::from_fn(|c| shoulder[c] + direction[c] / length * far);
            let aim = if step % 2 == 0 {
                Target::InModel(target)
            } else {
                Target::Point(placement.world_from_model().transform_point(target))
            };
            scene.edit(member).reach(reach, aim, at_once()).expect("a limb that reaches");
            scene.update(0.0);
            let missed = distance(scene.position(member, "leftHand"), target);
            worst = worst.max(missed);
            assert!(missed < 0.001, "step {step}: the hand is {missed} m off the target");
        }
        println!("reach: {worst} m off at most");
    });
}

/// Returns the largest rotation of an arm joint per step, in degrees, while a target moves out of
/// reach and back at 0.2 m/s: for targets within reach, and for all.
fn largest_turns(scene: &mut Scene, step_secs: f32) -> (f32, f32) {
    let member = scene.member(Placement::at([0.0; 3]));
    let reach = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
    scene.update(0.0);
    let shoulder = scene.position(member, "leftUpperArm");
    let (mut inside, mut anywhere) = (0.0_f32, 0.0_f32);
    let mut last: Option<Vec<populace::Affine>> = None;
    let mut secs = 0.0;
    while secs < 4.0 {
        // The distance from the shoulder goes from 0.2 m to 0.6 m, past the arm's length, and back.
        let out = if secs < 2.0 { 0.2 + 0.2 * secs } else { 1.0 - 0.2 * secs };
        let target = [shoulder[0] + 0.3 * out, shoulder[1] - 0.2 * out, shoulder[2] + 0.93 * out];
        scene
            .edit(member)
            .reach(reach, Target::InModel(target), at_once())
            .expect("a limb that reaches");
        scene.update(step_secs);
        let now = scene.models(member);
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
fn arm_never_jumps_as_the_target_leaves_its_range() {
    everywhere(|scene| {
        let (inside, whole) = largest_turns(scene, 1.0 / 60.0);
        let (_, half) = largest_turns(scene, 1.0 / 120.0);
        println!("reach: {inside} degrees per step in range, {whole} in all, {half} per half step");
        assert!(inside < 2.0, "the arm turned {inside} degrees in a step");
        assert!(
            (0.4..0.6).contains(&(half / whole)),
            "the arm turned {whole} degrees in a step, {half} in a half step"
        );
    });
}

#[test]
fn arm_straightens_towards_a_target_out_of_reach() {
    everywhere(|scene| {
        let member = scene.member(Placement::at([0.0; 3]));
        let reach =
            Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let target = [1.0, 4.0, 5.0];
        scene
            .edit(member)
            .reach(reach, Target::InModel(target), at_once())
            .expect("a limb that reaches");
        scene.update(0.1);
        let [shoulder, hand] =
            ["leftUpperArm", "leftHand"].map(|name| scene.position(member, name));
        let straight = distance(shoulder, hand) / LENGTH;
        let off = distance(hand, target) + distance(shoulder, hand) - distance(shoulder, target);
        assert!(
            straight > 0.99 && straight <= 1.001,
            "the arm is stretched to {straight} of its length"
        );
        assert!(off < 1e-4, "the hand is {off} m off the line to the target");
    });
}

#[test]
fn bones_of_very_different_lengths_stay_finite() {
    everywhere(|scene| {
        let member = scene.member(Placement::at([0.0; 3]));
        let hand = joint("leftHand");
        let far = JointOverride {
            joint: hand,
            space: Space::Local,
            transform: Trs { translation: [1e9, 0.4, 0.4], ..Trs::IDENTITY },
            weight: 0.45,
        };
        let mut view = scene.edit(member);
        view.override_joints(&[far]).expect("an override within the limits");
        let reach = Reach::with(hand).pole([-0.1, -0.95, 0.4]).keeping_rotation();
        view.reach(reach, [1.0, 1.0, 1.0], at_once()).expect("a limb that reaches");
        scene.update(0.1);
        let palette = scene.edit(member).palette();
        let palette = palette.expect("a palette");
        assert!(palette.iter().flat_map(|m| m.rows).flatten().all(f32::is_finite), "{palette:?}");
    });
}

#[test]
fn a_pole_without_a_direction_is_refused() {
    let mut scene = scene(Device::native(), Schedule::Fused);
    let member = scene.member(Placement::at([0.0; 3]));
    let reach = Reach::with(joint("leftHand")).pole([0.0; 3]);
    let error = scene.edit(member).reach(reach, [0.4, 1.2, 0.4], at_once()).unwrap_err();
    assert_eq!(error.to_string(), "the pole of a reach is 0; it must be of some length");
}
