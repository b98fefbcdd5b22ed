//! Constraint results are equal bit for bit on every device and schedule.

use std::cell::RefCell;

use populace::{
    ClipPlayback, Contact, Feet, Foot, Gaze, GazeLimits, Ground, JointOverride, MemberId,
    Placement, Reach, Space, Stride, Target, Trs, Weight,
};

use crate::fixture::{Scene, everywhere, joint, with_soles};

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

/// Gives a member constraints of all kinds. Their parameters depend on `number`.
pub(crate) fn constrain(
    scene: &mut Scene,
    member: MemberId,
    number: u8,
    watched: Option<MemberId>,
) {
    let x = f32::from(number);
    // Directions ahead, beyond the lateral limits, behind, above and below.
    let yaw = x * 0.9;
    let point = [yaw.sin() * 2.0, 1.5 + 2.0 * (x * 1.7).sin(), yaw.cos() * 2.0];
    let target = match (number % 3, watched) {
        (0, Some(member)) => Target::Joint { member, joint: joint("leftHand") },
        (1, _) => Target::Direction(point),
        _ => Target::InModel(point),
    };
    // If the hips are in the gaze's chain, legs are solved after the gaze, not with the pelvis.
    let gaze = gaze(if number % 4 == 3 { "hips" } else { "spine" });
    let weight = Weight::new(0.5 + 0.1 * (x % 6.0)).expect("a weight").over_secs(0.3);
    scene.edit(member).look_at_with(&gaze, target, weight).expect("a gaze");
    scene
        .edit(member)
        .plant_feet_with(&feet(if number % 5 == 4 { 0.6 } else { 1.0 }))
        .expect("feet");
    let hand = [0.3 * x.sin() + 0.2, 1.2 + 0.4 * (x * 0.6).cos(), 0.4];
    if number.is_multiple_of(2) {
        let mut reach =
            Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        if number.is_multiple_of(4) {
            reach = reach.pole([0.2, -1.0, 0.1 * x]);
        }
        scene
            .edit(member)
            .reach(reach, Target::InModel(hand), at_once())
            .expect("a limb that reaches");
    }
    if number.is_multiple_of(3) {
        let transform = Trs { translation: [0.0, 0.1, 0.05], ..Trs::IDENTITY };
        let given =
            JointOverride { joint: joint("leftEye"), space: Space::Model, transform, weight: 0.4 };
        scene.edit(member).override_joints(&[given]).expect("an override");
    }
}

#[test]
fn constraints_give_equal_bits_on_every_device_and_schedule() {
    let first: RefCell<Option<Vec<u32>>> = RefCell::new(None);
    everywhere(|scene| {
        scene
            .crowd
            .set_ground(&Ground::plane(0.05, [0.1, -0.15]).expect("a plane"))
            .expect("ground");
        let soled = scene.crowd.add_character(with_soles()).expect("enough capacity");
        let (walk, ankles) = (scene.clip("walk"), ["leftFoot", "rightFoot"].map(joint));
        let contacts = ankles.map(|ankle| Contact { ankle, from_secs: 0.6, until_secs: 1.2 });
        for body in [scene.body, soled] {
            let mut character = scene.crowd.character_mut(body).expect("a character");
            character.set_contacts(walk, &contacts).expect("contacts within the clip");
        }
        let mut members = Vec::new();
        for number in 0..16u8 {
            let x = f32::from(number);
            let placement =
                Placement::at([x, 0.05 + 0.1 * x, 0.0]).facing(x).scaled(0.9 + 0.02 * x);
            let body = if number % 4 < 2 { scene.body } else { soled };
            let member = scene.crowd.spawn(body, placement).expect("enough capacity");
            let clip = scene.clip(if number % 2 == 0 { "walk" } else { "sway" });
            scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
            constrain(scene, member, number, members.last().copied());
            let stride =
                Stride::along([0.3 * (x * 0.7).sin(), 0.5 + 0.1 * x]).turning_rad_per_m(0.2 * x);
            if number % 8 < 5 {
                scene.edit(member).set_stride(stride).expect("finite numbers");
            }
            members.push(member);
        }
        let mut bits = Vec::new();
        for frame in 0..12 {
            if frame == 6 {
                let heights = (0..64_u8).map(|n| 0.05 * f32::from(n % 5)).collect();
                let ground = Ground::height_field([-1.0; 2], 0.4, 8, heights).expect("a field");
                scene.crowd.set_ground(&ground).expect("ground");
            }
            scene.update(0.06);
            for member in &members {
                let palette = scene.edit(*member).palette().expect("a palette");
                bits.extend(palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits));
            }
        }
        let mut first = first.borrow_mut();
        let expected = first.get_or_insert_with(|| bits.clone());
        let apart = expected.iter().zip(&bits).filter(|(a, b)| a != b).count();
        assert_eq!(
            (apart, expected.len()),
            (0, bits.len()),
            "(differing values, number of values) against the first scene"
        );
    });
}

/// Constraints of several members are solved in one batch. Members with equal constraints get equal
/// poses, whatever their neighbours in the batch.
#[test]
fn members_with_equal_programs_and_clips_get_the_bits_of_others() {
    let first: RefCell<Option<Vec<u32>>> = RefCell::new(None);
    for others_differ in [false, true] {
        everywhere(|scene| {
            let body = scene.crowd.add_character(with_soles()).expect("enough capacity");
            let clips = ["walk", "sway"].map(|name| scene.clip(name));
            for (clip, from_secs) in clips.into_iter().zip([0.6, 0.1]) {
                let ankle = joint("leftFoot");
                let contact = Contact { ankle, from_secs, until_secs: from_secs + 0.5 };
                let mut character = scene.crowd.character_mut(body).expect("a character");
                character.set_contacts(clip, &[contact]).expect("a contact within the clip");
            }
            let members: Vec<MemberId> = (0..36u8)
                .map(|at| {
                    let x = f32::from(at / 2);
                    let place = Placement::at([x, 0.0, 0.0]).facing(x);
                    let member = scene.crowd.spawn(body, place).expect("enough capacity");
                    let differs = others_differ && at % 2 == 0;
                    let clip = clips[usize::from(differs)];
                    let late = ClipPlayback::looping().phase(x / 20.0);
                    scene.edit(member).play(clip, late).expect("a clip that plays");
                    let weight = if differs { 0.7 } else { 1.0 };
                    scene.edit(member).plant_feet_with(&feet(weight)).expect("feet");
                    member
                })
                .collect();
            let mut bits = Vec::new();
            for _ in 0..8 {
                scene.update(0.06);
                for member in members.iter().skip(1).step_by(2) {
                    let palette = scene.edit(*member).palette().expect("a palette");
                    bits.extend(palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits));
                }
            }
            let mut first = first.borrow_mut();
            let expected = first.get_or_insert_with(|| bits.clone());
            let apart = expected.iter().zip(&bits).filter(|(a, b)| a != b).count();
            assert_eq!((apart, expected.len()), (0, bits.len()), "others differ: {others_differ}");
        });
    }
}

#[test]
fn constraint_result_is_independent_of_batch_neighbours() {
    const KINDS: u8 = 16;
    let first: RefCell<Option<Vec<Vec<u32>>>> = RefCell::new(None);
    everywhere(|scene| {
        let order = (0..40u8).flat_map(|round| (0..KINDS).map(move |at| (at * 7 + round) % KINDS));
        let members: Vec<(u8, MemberId)> = order
            .map(|number| {
                let x = f32::from(number);
                let member = scene.member(Placement::at([x, 0.0, 0.0]).facing(x));
                let clip = scene.clip(if number % 2 == 0 { "walk" } else { "sway" });
                scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
                match number {
                    15 => {} // no constraints
                    14 => {
                        let mut one = feet(1.0);
                        one.feet.truncate(1);
                        scene.edit(member).plant_feet_with(&one).expect("a foot");
                    }
                    _ => constrain(scene, member, number, None),
                }
                (number, member)
            })
            .collect();
        scene.update(0.2);
        // Some members have two targets at once.
        for (_, member) in members.iter().filter(|(number, _)| number % 4 == 1) {
            let target = Target::InModel([1.0, 1.2, 1.5]);
            let weight = Weight::FULL.over_secs(0.3).easing_over();
            scene.edit(*member).look_at_with(&gaze("spine"), target, weight).expect("a gaze");
        }
        scene.update(0.1);
        let mut of_kind: Vec<Vec<u32>> = vec![Vec::new(); usize::from(KINDS)];
        for (number, member) in &members {
            let palette = scene.edit(*member).palette().expect("a palette");
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
        assert!(*expected == of_kind, "poses differ from those of the first scene");
    });
}
