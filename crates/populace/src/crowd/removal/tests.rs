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
    character(chain_skeleton(joints, false))
}

/// A chain of joints. A `forked` one has another joint beside the second, so that all that follow
/// have other numbers.
fn chain_skeleton(joints: usize, forked: bool) -> Skeleton {
    let rest = Trs { translation: [0.0, 0.1, 0.0], ..Trs::IDENTITY };
    let joint = |name: String, parent| JointSource { name, parent, rest };
    let mut chain = vec![joint("joint0".into(), None)];
    if forked {
        chain.push(joint("fork".into(), Some(0)));
    }
    for n in 1..joints {
        let parent = if n == 1 { 0 } else { chain.len() - 1 };
        chain.push(joint(format!("joint{n}"), Some(parent)));
    }
    Skeleton::new(&chain).unwrap()
}

/// A character whose clip "nod" bends its last joint.
fn character(skeleton: Skeleton) -> Character {
    let clips = vec![nod("nod", &skeleton, skeleton.joint_count())];
    character_with(skeleton, clips)
}

fn character_with(skeleton: Skeleton, clips: Vec<Arc<Clip>>) -> Character {
    let joints = skeleton.joint_count();
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
    // Clips of other joints are converted, and live clips as poses arrive.
    let forked = chain_skeleton(joints, true);
    let borrowed = character.add_clip(&nod("borrowed", &forked, joints)).unwrap();
    let follower = crowd.add_character(self::character(forked)).unwrap();
    let following = spawn(crowd, follower);
    crowd.member_mut(following).unwrap().play(live, ClipPlayback::live(0.0)).unwrap();
    let pose: Vec<Trs> = skeleton.joints().map(|joint| *skeleton.rest(joint)).collect();
    crowd.clip_mut(live).unwrap().append(0.0, &pose).unwrap();
    crowd.clip_mut(late).unwrap().add_event_marker("half", 0.05).unwrap();
    let points = [(own, 0.0), (late, 1.0), (borrowed, 2.0)];
    let space = crowd.add_blend_space(BlendSpace::line(&points).unwrap());
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
    crowd.clip_mut(live).unwrap().append(0.1, &pose).unwrap();
    crowd.despawn(member).unwrap();
    crowd.despawn(following).unwrap();
    if joints.is_multiple_of(3) {
        crowd.remove(follower).unwrap();
        crowd.clip_mut(live).unwrap().append(0.2, &pose).unwrap();
    }
    crowd.remove(mask).unwrap();
    crowd.remove(space).unwrap();
    crowd.remove(machine).unwrap();
    crowd.remove(live).unwrap();
    if joints.is_multiple_of(2) {
        crowd.remove(late).unwrap();
        crowd.remove(borrowed).unwrap();
    }
    crowd.remove(id).unwrap();
    if !joints.is_multiple_of(3) {
        crowd.remove(follower).unwrap();
    }
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
        assert!(state.base.assets.clips.len() <= 7 && state.base.assets.characters.len() <= 3);
        assert!(state.base.assets.bound_clips.len() == 1 && state.base.assets.replaced.is_empty());
        crowd.member_mut(member).unwrap().palette().unwrap();
    }
}

#[test]
fn palettes_are_those_of_a_crowd_that_removed_nothing() {
    let mut rng = Rng::new(5);
    let mut churned = crowd();
    let mut present: Vec<(CharacterId, [MemberId; 2], usize)> = Vec::new();
    // Its rows are the first of all, where a clip that is gone would write.
    let (_, stays) = nodder(&mut churned, 20);
    // Each character also follows a live clip of other joints, which is converted for it.
    let source = churned.add_character(character(chain_skeleton(40, true))).unwrap();
    let settings = LiveSettings::default();
    let live = churned.character_mut(source).unwrap().add_live_clip("live", &settings).unwrap();
    let swept = Trs { translation: [0.3, 0.2, 0.1], ..Trs::IDENTITY };
    for step in 0..400 {
        churned.clip_mut(live).unwrap().append(0.01 * f64::from(step), &[swept; 41]).unwrap();
        if present.len() < 6 && rng.below(2) == 0 {
            let joints = 13 + rng.below(30);
            let (id, member) = nodder(&mut churned, joints);
            let follower = spawn(&mut churned, id);
            churned.member_mut(follower).unwrap().play(live, ClipPlayback::live(0.0)).unwrap();
            present.push((id, [member, follower], joints));
        } else if !present.is_empty() {
            let (id, members, _) = present.swap_remove(rng.below(present.len()));
            members.into_iter().for_each(|member| churned.despawn(member).unwrap());
            churned.remove(id).unwrap();
        }
        if step % 20 == 0 {
            churned.update(0.01).unwrap();
            let all = present.iter().map(|(_, [member, _], joints)| (*member, *joints));
            for (member, joints) in all.chain([(stays, 20)]) {
                let mut fresh = crowd();
                let (_, alone) = nodder(&mut fresh, joints);
                fresh.update(0.01).unwrap();
                let expected = fresh.member_mut(alone).unwrap().palette().unwrap();
                assert_eq!(churned.member_mut(member).unwrap().palette().unwrap(), expected);
            }
        }
    }
}

/// Adds a chain of joints, and a member that nods.
fn nodder(crowd: &mut Crowd, joints: usize) -> (CharacterId, MemberId) {
    let id = crowd.add_character(chain(joints)).unwrap();
    let clip = crowd.clip(id, "nod").unwrap();
    let member = spawn(crowd, id);
    crowd.member_mut(member).unwrap().play(clip, ClipPlayback::held_at_secs(0.1)).unwrap();
    (id, member)
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

#[test]
fn a_character_whose_clips_do_not_fit_leaves_nothing() {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let small = crowd.add_character(chain(3)).unwrap();
    // More words than 32-bit offsets reach.
    let ring = LiveSettings { rows_per_sec: 1000.0, secs: 3600.0, ..LiveSettings::default() };
    let endless = Clip::live("endless", &chain_skeleton(2000, false), &ring).unwrap();
    let skeleton = chain_skeleton(4, false);
    let clips = vec![nod("nod", &skeleton, 4), Arc::new(endless)];
    let large = character_with(skeleton, clips);
    let counts = |crowd: &Crowd| {
        let assets = &crowd.state.base.assets;
        (assets.characters.iter().count(), assets.clips.iter().count())
    };
    let before = counts(&crowd);
    let error = crowd.add_character(large).unwrap_err().to_string();
    assert!(error.contains("rows"), "{error}");
    assert_eq!(counts(&crowd), before);
    assert_eq!(crowd.add_character(chain(4)).unwrap().index(), small.index() + 1);
}
