use std::sync::Arc;

use populace_character::{Character, CharacterSource, PaletteEntry};
use populace_clip::Clip;
use populace_model::{
    Affine, ClipSource, Interpolation, JointIndex, JointSource, Mask, Property, Skeleton, Track,
    Trs,
};
use populace_testkit::Rng;

use super::*;
use crate::{
    BlendSpace, BlendSpacePlayback, ClipPlayback, Device, LayerSettings, LiveSettings,
    MachinePlayback, MemberId, Placement, StateMachine, StatePlayback, Weight,
};

/// A chain of joints that a clip "nod" bends.
fn chain(joints: usize) -> Character {
    let joint = |n: usize| JointSource {
        name: format!("joint{n}"),
        parent: n.checked_sub(1),
        rest: Trs { translation: [0.0, 0.1, 0.0], ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&(0..joints).map(joint).collect::<Vec<_>>()).unwrap();
    let clips = vec![nod("nod", &skeleton, joints)];
    let entry = |joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY };
    let (palette, name) = (skeleton.joints().map(entry).collect(), format!("chain of {joints}"));
    let (parts, materials, images, skins) = (vec![], vec![], vec![], vec![]);
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    Character::new(source).unwrap()
}

/// A clip whose last joint moves, with `keys` unevenly spaced keys.
fn nod(name: &str, skeleton: &Skeleton, keys: usize) -> Arc<Clip> {
    let last = skeleton.name(JointIndex(u32::try_from(skeleton.joint_count() - 1).unwrap()));
    let keys = keys.max(2);
    let times = (0..keys).map(|key| (key * key) as f32 * 0.07).collect();
    let values = (0..keys).flat_map(|key| [0.0, 0.1 + 0.01 * (key % 5) as f32, 0.02]).collect();
    let property = Property::Translation;
    let interpolation = Interpolation::Linear;
    let track = Track { joint: last.into(), property, interpolation, times, values };
    Clip::new(ClipSource { name: name.into(), tracks: vec![track] }, skeleton).unwrap().into()
}

fn crowd() -> Crowd {
    Crowd::builder().device(Device::native()).capacity(50).build().unwrap()
}

/// The number of elements of all tables.
fn elements(crowd: &Crowd) -> usize {
    let tables = &crowd.state.base.tables;
    macro_rules! sum {
        (; $($(#[$doc:meta])* $name:ident: $element:ty),* $(,)?) => {
            0 $(+ tables.$name().as_slice().len())*
        };
    }
    populace_device::with_tables!(sum)
}

fn spawn(crowd: &mut Crowd, character: CharacterId) -> MemberId {
    crowd.spawn(character, Placement::at([0.0; 3])).unwrap()
}

/// Adds one of everything, uses all of it, and removes it.
fn cycle(crowd: &mut Crowd, joints: usize) {
    let id = crowd.add_character(chain(joints)).unwrap();
    let skeleton = crowd.character(id).unwrap().asset().skeleton.clone();
    let member = spawn(crowd, id);
    let own = crowd.clip(id, "nod").unwrap();
    let mut character = crowd.character_mut(id).unwrap();
    let late = character.add_clip(&nod("late", &skeleton, 3 * joints)).unwrap();
    let mask = character.add_mask(&Mask::subtree(&skeleton, JointIndex(0))).unwrap();
    let live = character.add_live_clip("live", &LiveSettings::default()).unwrap();
    let pose: Vec<Trs> = skeleton.joints().map(|joint| *skeleton.rest(joint)).collect();
    crowd.clip_mut(live).unwrap().append(0.0, &pose).unwrap();
    crowd.clip_mut(late).unwrap().add_event_marker("half", 0.05).unwrap();
    let space = crowd.add_blend_space(BlendSpace::line(&[(own, 0.0), (late, 1.0)]).unwrap());
    let space = space.unwrap();
    let machine = StateMachine::new().state("nods", own, StatePlayback::looping());
    let machine = crowd.add_machine(&machine).unwrap();
    let mut view = crowd.member_mut(member).unwrap();
    view.set_proportions(&vec![1.25; joints]).unwrap();
    view.set_proportions(&vec![1.5; joints]).unwrap();
    view.set_layer(1, LayerSettings::default(), Some(mask)).unwrap();
    view.subscribe_events();
    view.play_blend_space(space, 0.5, BlendSpacePlayback::new()).unwrap();
    view.play_machine(machine, MachinePlayback::new().on_layer(1)).unwrap();
    crowd.update(0.1).unwrap();
    for in_use in [AssetId::from(id), late.into(), mask.into(), space.into(), machine.into()] {
        let error = crowd.remove(in_use).unwrap_err();
        assert!(matches!(error, Error::InUse { .. }), "{in_use:?}: {error}");
    }
    crowd.despawn(member).unwrap();
    crowd.remove(mask).unwrap();
    crowd.remove(space).unwrap();
    crowd.remove(machine).unwrap();
    crowd.remove(live).unwrap();
    if joints.is_multiple_of(2) {
        crowd.remove(late).unwrap();
    }
    crowd.remove(id).unwrap();
    crowd.update(0.1).unwrap();
    for gone in
        [AssetId::from(id), own.into(), late.into(), mask.into(), space.into(), machine.into()]
    {
        let error = crowd.remove(gone).unwrap_err();
        assert!(matches!(error, Error::UnknownId { .. }), "{gone:?}: {error}");
    }
}

mod slow {
    use super::*;

    #[test]
    #[ignore = "make test-slow"]
    fn ten_thousand_cycles_leave_memory_where_it_was() {
        let mut crowd = crowd();
        let stays = crowd.add_character(chain(3)).unwrap();
        let clip = crowd.clip(stays, "nod").unwrap();
        let member = spawn(&mut crowd, stays);
        crowd.member_mut(member).unwrap().play(clip, ClipPlayback::looping()).unwrap();
        crowd.update(0.1).unwrap();
        let before = elements(&crowd);
        cycle(&mut crowd, 5);
        let (after, memory) = (elements(&crowd), crowd.device_info().memory_bytes);
        assert_eq!(after, before, "one cycle left elements behind");
        for n in 0..10_000 {
            cycle(&mut crowd, 2 + n % 4);
        }
        assert_eq!((elements(&crowd), crowd.device_info().memory_bytes), (before, memory));
        let state = &crowd.state;
        assert!(state.base.assets.clips.len() <= 5 && state.base.assets.characters.len() <= 2);
        assert!(state.base.assets.bound_clips.len() == 1 && state.base.assets.replaced.is_empty());
        crowd.member_mut(member).unwrap().palette().unwrap();
    }
}

#[test]
fn palettes_are_those_of_a_crowd_that_removed_nothing() {
    let mut rng = Rng::new(5);
    let mut churned = crowd();
    let mut present: Vec<(CharacterId, MemberId, usize)> = Vec::new();
    for step in 0..400 {
        if present.len() < 6 && rng.below(2) == 0 {
            let joints = 1 + rng.below(40);
            let id = churned.add_character(chain(joints)).unwrap();
            let clip = churned.clip(id, "nod").unwrap();
            let member = spawn(&mut churned, id);
            churned
                .member_mut(member)
                .unwrap()
                .play(clip, ClipPlayback::held_at_secs(0.1))
                .unwrap();
            present.push((id, member, joints));
        } else if !present.is_empty() {
            let (id, member, _) = present.swap_remove(rng.below(present.len()));
            churned.despawn(member).unwrap();
            churned.remove(id).unwrap();
        }
        if step % 20 == 0 {
            churned.update(0.01).unwrap();
            for (_, member, joints) in &present {
                let mut fresh = crowd();
                let id = fresh.add_character(chain(*joints)).unwrap();
                let clip = fresh.clip(id, "nod").unwrap();
                let alone = spawn(&mut fresh, id);
                let mut view = fresh.member_mut(alone).unwrap();
                view.play(clip, ClipPlayback::held_at_secs(0.1)).unwrap();
                fresh.update(0.01).unwrap();
                let expected = fresh.member_mut(alone).unwrap().palette().unwrap();
                assert_eq!(churned.member_mut(*member).unwrap().palette().unwrap(), expected);
            }
        }
    }
}

#[test]
fn a_clip_that_fades_out_is_in_use_until_it_has_faded() {
    let mut crowd = crowd();
    let id = crowd.add_character(chain(3)).unwrap();
    let skeleton = crowd.character(id).unwrap().asset().skeleton.clone();
    let first = crowd.clip(id, "nod").unwrap();
    let second = nod("second", &skeleton, 4);
    let second = crowd.character_mut(id).unwrap().add_clip(&second).unwrap();
    let member = spawn(&mut crowd, id);
    for transition in [
        ClipPlayback::looping().fade_in_secs(0.3),
        ClipPlayback::looping().inertialize_in_secs(0.3),
    ] {
        let first = match crowd.clip(id, "nod") {
            Ok(first) => first,
            Err(_) => crowd.character_mut(id).unwrap().add_clip(&nod("nod", &skeleton, 3)).unwrap(),
        };
        crowd.member_mut(member).unwrap().play(first, ClipPlayback::looping()).unwrap();
        crowd.update(0.1).unwrap();
        crowd.member_mut(member).unwrap().play(second, transition).unwrap();
        crowd.update(0.1).unwrap();
        let error = crowd.remove(first).unwrap_err();
        assert!(matches!(error, Error::InUse { what: IdKind::Clip, .. }), "{error}");
        crowd.update(0.5).unwrap();
        crowd.remove(first).unwrap();
        crowd.update(0.1).unwrap();
    }
    assert!(matches!(crowd.remove(first), Err(Error::UnknownId { .. })));
    crowd.member_mut(member).unwrap().look_at([0.0, 1.0, 2.0], Weight::FULL).unwrap_err();
}
