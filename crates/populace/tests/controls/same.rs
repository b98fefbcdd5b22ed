//! What devices and schedules compute is the same to the bit.

use std::cell::RefCell;

use populace::{
    ClipPlayback, Feet, Foot, Gaze, GazeLimits, Ground, JointOverride, MemberId, Placement, Reach,
    Space, Target, Trs, Weight,
};

use crate::body::{Stage, everywhere, joint};

fn at_once() -> Weight {
    Weight::FULL.over_secs(0.0)
}

fn gaze(first: &str) -> Gaze {
    let chain = [(first, 0.1), ("chest", 0.2), ("neck", 0.3), ("head", 0.4)];
    let chain = chain.map(|(name, share)| (joint(name), share)).to_vec();
    let limits = GazeLimits { yaw_rad: 1.1, up_rad: 0.6, down_rad: 0.7 };
    Gaze { chain, facing: [0.0, 0.0, 1.0], limits }
}

fn feet(weight: f32) -> Feet {
    let foot = |side: &str| Foot {
        hip: joint(&format!("{side}UpperLeg")),
        knee: joint(&format!("{side}LowerLeg")),
        ankle: joint(&format!("{side}Foot")),
    };
    Feet { pelvis: joint("hips"), feet: vec![foot("left"), foot("right")], weight }
}

/// Gives a member all constraints, other ones by its number.
fn constrain(stage: &mut Stage, member: MemberId, number: u8, watched: Option<MemberId>) {
    let x = f32::from(number);
    // Ahead, at the sides beyond the limits, behind, above, below.
    let yaw = x * 0.9;
    let point = [yaw.sin() * 2.0, 1.5 + 2.0 * (x * 1.7).sin(), yaw.cos() * 2.0];
    let target = match (number % 3, watched) {
        (0, Some(member)) => Target::Joint { member, joint: joint("leftHand") },
        (1, _) => Target::Direction(point),
        _ => Target::InModel(point),
    };
    // With the hips in a gaze, legs are solved after it and not with the pelvis.
    let gaze = gaze(if number % 4 == 3 { "hips" } else { "spine" });
    let weight = Weight::new(0.5 + 0.1 * (x % 6.0)).expect("a weight").over_secs(0.3);
    let crowd = &mut stage.crowd;
    crowd.member_mut(member).expect("a gaze").look_at_with(&gaze, target, weight).expect("a gaze");
    crowd
        .member_mut(member)
        .expect("feet")
        .plant_feet_with(&feet(if number % 5 == 4 { 0.6 } else { 1.0 }))
        .expect("feet");
    let hand = [0.3 * x.sin() + 0.2, 1.2 + 0.4 * (x * 0.6).cos(), 0.4];
    if number.is_multiple_of(2) {
        let mut reach =
            Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        if number.is_multiple_of(4) {
            reach = reach.pole([0.2, -1.0, 0.1 * x]);
        }
        crowd
            .member_mut(member)
            .expect("a limb that reaches")
            .reach(reach, Target::InModel(hand), at_once())
            .expect("a limb that reaches");
    }
    if number.is_multiple_of(3) {
        let transform = Trs { translation: [0.0, 0.1, 0.05], ..Trs::IDENTITY };
        let given =
            JointOverride { joint: joint("leftEye"), space: Space::Model, transform, weight: 0.4 };
        crowd
            .member_mut(member)
            .expect("an override")
            .override_joints(&[given])
            .expect("an override");
    }
}

#[test]
fn every_device_and_schedule_moves_a_constrained_crowd_to_the_same_bits() {
    let first: RefCell<Option<Vec<u32>>> = RefCell::new(None);
    everywhere(|stage| {
        stage
            .crowd
            .set_ground(&Ground::plane(0.05, [0.1, -0.15]).expect("a plane"))
            .expect("ground");
        let mut members = Vec::new();
        for number in 0..16u8 {
            let x = f32::from(number);
            let placement =
                Placement::at([x, 0.05 + 0.1 * x, 0.0]).facing(x).scaled(0.9 + 0.02 * x);
            let member = stage.member(placement);
            let clip = stage.clip(if number % 2 == 0 { "walk" } else { "sway" });
            stage
                .crowd
                .member_mut(member)
                .expect("a clip that plays")
                .play(clip, ClipPlayback::looping())
                .expect("a clip that plays");
            constrain(stage, member, number, members.last().copied());
            members.push(member);
        }
        let mut bits = Vec::new();
        for _ in 0..12 {
            stage.update(0.06);
            for member in &members {
                let palette = stage
                    .crowd
                    .member_mut(*member)
                    .expect("a palette")
                    .palette()
                    .expect("a palette");
                bits.extend(palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits));
            }
        }
        let mut first = first.borrow_mut();
        let expected = first.get_or_insert_with(|| bits.clone());
        let apart = expected.iter().zip(&bits).filter(|(a, b)| a != b).count();
        assert_eq!(
            (apart, expected.len()),
            (0, bits.len()),
            "numbers that differ from the first stage's"
        );
    });
}

/// Members whose constraints are solved side by side do not touch each other: alike ones come out
/// alike, whoever stands beside them, as many as no work-item takes one by one.
#[test]
fn nobody_is_moved_by_who_stands_beside_them() {
    const KINDS: u8 = 16;
    let first: RefCell<Option<Vec<Vec<u32>>>> = RefCell::new(None);
    everywhere(|stage| {
        let order = (0..40u8).flat_map(|round| (0..KINDS).map(move |at| (at * 7 + round) % KINDS));
        let members: Vec<(u8, MemberId)> = order
            .map(|number| {
                let x = f32::from(number);
                let member = stage.member(Placement::at([x, 0.0, 0.0]).facing(x));
                let clip = stage.clip(if number % 2 == 0 { "walk" } else { "sway" });
                stage
                    .crowd
                    .member_mut(member)
                    .expect("a clip that plays")
                    .play(clip, ClipPlayback::looping())
                    .expect("a clip that plays");
                match number {
                    15 => {} // plain
                    14 => {
                        let mut one = feet(1.0);
                        one.feet.truncate(1);
                        stage
                            .crowd
                            .member_mut(member)
                            .expect("a foot")
                            .plant_feet_with(&one)
                            .expect("a foot");
                    }
                    _ => constrain(stage, member, number, None),
                }
                (number, member)
            })
            .collect();
        stage.update(0.2);
        // Two targets at once, for some.
        for (_, member) in members.iter().filter(|(number, _)| number % 4 == 1) {
            let target = Target::InModel([1.0, 1.2, 1.5]);
            let weight = Weight::FULL.over_secs(0.3).easing_over();
            stage
                .crowd
                .member_mut(*member)
                .expect("a gaze")
                .look_at_with(&gaze("spine"), target, weight)
                .expect("a gaze");
        }
        stage.update(0.1);
        let mut of_kind: Vec<Vec<u32>> = vec![Vec::new(); usize::from(KINDS)];
        for (number, member) in &members {
            let palette =
                stage.crowd.member_mut(*member).expect("a palette").palette().expect("a palette");
            let bits: Vec<u32> =
                palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits).collect();
            let kind = &mut of_kind[usize::from(*number)];
            if kind.is_empty() {
                *kind = bits;
            } else {
                assert!(*kind == bits, "two members of kind {number} differ");
            }
        }
        let mut first = first.borrow_mut();
        let expected = first.get_or_insert_with(|| of_kind.clone());
        assert!(*expected == of_kind, "the first stage's members differ from this one's");
    });
}
