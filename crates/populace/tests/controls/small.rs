//! One small scene of everything, for drivers that take minutes for a frame.

use std::cell::RefCell;

use populace::{ClipPlayback, LayerMode, LayerSettings, MemberId, Placement, Target, Trs, Weight};

use crate::determinism::constrain;
use crate::fixture::{Scene, everywhere, joint};

/// Members of each phase, which a work-group computes side by side. More would take several
/// work-items of the wide form, whose locks on scratch memory race detectors do not know.
const EACH: u8 = 4;

/// Spawns members with constraints, a layer, and an inertialized transition in two phases: each of
/// the second hangs on one of the first. Some more only play a clip.
fn members(scene: &mut Scene) -> Vec<MemberId> {
    let mut members: Vec<MemberId> = Vec::new();
    for number in 0..2 * EACH {
        let member = scene.member(Placement::at([f32::from(number), 0.0, 0.0]));
        let above = members.len().checked_sub(EACH.into()).map(|nth| members[nth]);
        let (walk, sway) = (scene.clip("walk"), scene.clip("sway"));
        let play = |mut member: populace::MemberMut<'_>| {
            member.play(walk, ClipPlayback::looping().phase(0.2))?;
            member.blend(sway, ClipPlayback::looping().weight(0.4))?;
            let mode = if number % 2 == 0 { LayerMode::Override } else { LayerMode::Additive };
            member.set_layer(1, LayerSettings { mode, weight: 0.5 }, None)?;
            member.play(sway, ClipPlayback::looping().on_layer(1))
        };
        play(scene.edit(member)).expect("clips that play");
        constrain(scene, member, number, above);
        if let Some(parent) = above {
            let offset = Trs { translation: [0.1, 0.0, 0.2], ..Trs::IDENTITY };
            scene.edit(member).attach_to(parent, joint("leftHand"), offset).expect("a joint");
        }
        scene.edit(member).look_at(Target::Point([3.0, 1.0, 2.0]), Weight::FULL).expect("a gaze");
        members.push(member);
    }
    for number in 0..EACH {
        let member = scene.member(Placement::at([0.0, 0.0, f32::from(number)]));
        let walk = scene.clip("walk");
        let phase = 0.1 + 0.2 * f32::from(number);
        let play = ClipPlayback::looping().phase(phase);
        scene.edit(member).play(walk, play).expect("a clip that plays");
        members.push(member);
    }
    members
}

#[test]
fn small_scene_of_everything_gives_equal_bits() {
    let first: RefCell<Option<Vec<u32>>> = RefCell::new(None);
    everywhere(|scene| {
        let members = members(scene);
        let mut bits = Vec::new();
        for frame in 0..3 {
            if frame == 1 {
                let walk = scene.clip("walk");
                let play = ClipPlayback::looping().inertialize_in_secs(0.3);
                scene.edit(members[0]).play(walk, play).expect("a clip that plays");
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
        assert_eq!((apart, expected.len()), (0, bits.len()), "differing values, number of values");
    });
}
