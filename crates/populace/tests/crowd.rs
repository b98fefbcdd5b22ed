//! Basic behaviour of [`Crowd`], on every device.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]

use std::sync::Arc;

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::interop::PaletteSource;
use populace::model::{
    ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track,
};
use populace::model::{Role, RoleMap, Side};
use populace::{
    Affine, ClipPlayback, Crowd, Device, Error, IdKind, LayerMode, LayerSettings, Mask, MemberId,
    MemberLook, Placement, Trs,
};

fn track(joint: &str, height: f32) -> Track {
    Track {
        joint: joint.into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, height, 0.0, 0.0, height + 1.0, 0.0],
    }
}

/// A character of two joints. Its clips lift the base from 0 to 1 m ("low") and from 10 to 11 m
/// ("high"), and the tip from 5 to 6 m ("tip").
fn lift() -> Character {
    let joint = |name: &str, parent| JointSource { name: name.into(), parent, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint("base", None), joint("tip", Some(0))]).unwrap();
    let clip = |name: &str, joint: &str, height| {
        let source = ClipSource { name: name.into(), tracks: vec![track(joint, height)] };
        Arc::new(Clip::new(source, &skeleton).unwrap())
    };
    let clips = vec![clip("low", "base", 0.0), clip("high", "base", 10.0), clip("tip", "tip", 5.0)];
    let palette = vec![PaletteEntry { joint: JointIndex(1), joint_from_bind: Affine::IDENTITY }];
    let (parts, materials, images, skins) = (vec![], vec![], vec![], vec![]);
    let name = "lift".into();
    Character::new(CharacterSource {
        name,
        skeleton,
        palette,
        parts,
        materials,
        images,
        skins,
        clips,
    })
    .unwrap()
}

/// A character of hips and legs with unusual joint names. Its clip lifts the hips by `height`
/// metres.
fn legs(word: &str, height: f32) -> (Character, RoleMap) {
    let at = |y: f32| Trs { translation: [0.0, y * height, 0.0], ..Trs::IDENTITY };
    let joint =
        |name: &str, parent, rest| JointSource { name: format!("{word} {name}"), parent, rest };
    let mut joints = vec![joint("middle", None, at(1.0))];
    for (side, hip) in [("one", 1), ("other", 4)] {
        joints.push(joint(&format!("{side} a"), Some(0), at(0.0)));
        joints.push(joint(&format!("{side} b"), Some(hip), at(-0.5)));
        joints.push(joint(&format!("{side} c"), Some(hip + 1), at(-0.4)));
    }
    let skeleton = Skeleton::new(&joints).unwrap();
    let (left, right) = (Side::Left, Side::Right);
    let roles = [
        (Role::Hips, "middle"),
        (Role::UpperLeg(left), "one a"),
        (Role::LowerLeg(left), "one b"),
        (Role::Foot(left), "one c"),
        (Role::UpperLeg(right), "other a"),
        (Role::LowerLeg(right), "other b"),
        (Role::Foot(right), "other c"),
    ];
    let names: Vec<_> =
        roles.iter().map(|(role, name)| (*role, format!("{word} {name}"))).collect();
    let names: Vec<_> = names.iter().map(|(role, name)| (*role, name.as_str())).collect();
    let map = RoleMap::from_names(&skeleton, &names).unwrap();
    let mut lift = track(&joints[0].name, 0.0);
    lift.values = vec![0.0, height, 0.0, 0.0, 2.0 * height, 0.0];
    let clip = Arc::new(
        Clip::new(ClipSource { name: "jump".into(), tracks: vec![lift] }, &skeleton).unwrap(),
    );
    let (parts, materials, images, skins, palette) = (vec![], vec![], vec![], vec![], vec![]);
    let (name, clips) = (word.into(), vec![clip]);
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    (Character::new(source).unwrap(), map)
}

fn clips_are_retargeted_by_user_defined_roles(device: Device) {
    let mut crowd = Crowd::builder().device(device).capacity(2).build().unwrap();
    let ((tall, tall_roles), (short, short_roles)) = (legs("tall", 2.0), legs("short", 0.5));
    let (tall, short) = (crowd.add_character(tall).unwrap(), crowd.add_character(short).unwrap());
    let jump = crowd.clip(tall, "jump").unwrap();
    let member = crowd.spawn(short, Placement::at([0.0; 3])).unwrap();
    let refused = crowd
        .member_mut(member)
        .and_then(|mut m| m.play(jump, ClipPlayback::held_at_secs(0.5)))
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("\"tall middle\"") && refused.contains("RoleMap::from_names"),
        "{refused}"
    );
    crowd.character_mut(short).unwrap().set_roles(short_roles).unwrap();
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play(jump, ClipPlayback::held_at_secs(0.5)))
            .is_err(),
        "the clip played without roles"
    );
    crowd.clip_mut(jump).unwrap().set_roles(tall_roles).unwrap();
    crowd.member_mut(member).unwrap().play(jump, ClipPlayback::held_at_secs(0.5)).unwrap();
    crowd.update(0.0).unwrap();
    // In the middle of the clip: 1.5 times the hips' height of 0.5 m of this character.
    assert_near(height(&mut crowd, member, 0), 0.75);
}

fn height(crowd: &mut Crowd, member: MemberId, joint: usize) -> f32 {
    crowd.member_mut(member).unwrap().model_from_joints().unwrap()[joint].rows[1][3]
}

#[track_caller]
fn assert_near(value: f32, wanted: f32) {
    assert!((value - wanted).abs() < 1e-3, "{value} instead of {wanted}");
}

fn crowd_of(device: Device, capacity: usize) -> (Crowd, populace::CharacterId) {
    let mut crowd = Crowd::builder().device(device).capacity(capacity).build().unwrap();
    let id = crowd.add_character(lift()).unwrap();
    (crowd, id)
}

fn play_crossfade_and_stop(device: Device) {
    let (mut crowd, id) = crowd_of(device, 4);
    let (low, high) = (crowd.clip(id, "low").unwrap(), crowd.clip(id, "high").unwrap());
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd.update(0.1).unwrap();
    assert_near(height(&mut crowd, member, 0), 0.0); // rest

    // The first clip starts at full weight in spite of its fade.
    crowd
        .member_mut(member)
        .unwrap()
        .play(low, ClipPlayback::held_at_secs(0.5).fade_in_secs(1.0))
        .unwrap();
    crowd.update(0.0).unwrap();
    assert_near(height(&mut crowd, member, 0), 0.5);

    crowd
        .member_mut(member)
        .unwrap()
        .play(high, ClipPlayback::held_at_secs(0.5).fade_in_secs(1.0))
        .unwrap();
    crowd.update(0.25).unwrap();
    assert_near(height(&mut crowd, member, 0), 0.75 * 0.5 + 0.25 * 10.5);
    crowd.update(0.75).unwrap();
    assert_near(height(&mut crowd, member, 0), 10.5);

    crowd.member_mut(member).unwrap().stop(0, 0.0).unwrap();
    crowd.update(0.1).unwrap();
    assert_near(height(&mut crowd, member, 0), 0.0);
}

fn blends_and_layers(device: Device) {
    let (mut crowd, id) = crowd_of(device, 4);
    let [low, high, tip] = ["low", "high", "tip"].map(|name| crowd.clip(id, name).unwrap());
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .play(low, ClipPlayback::held_at_secs(0.0).weight(0.25))
        .unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .blend(high, ClipPlayback::held_at_secs(0.0).weight(0.75))
        .unwrap();
    crowd.update(0.0).unwrap();
    assert_near(height(&mut crowd, member, 0), 7.5);

    let skeleton = crowd.character(id).unwrap().asset().skeleton.clone();
    let on_tip = Mask::subtree(&skeleton, skeleton.find("tip").unwrap());
    let on_tip = crowd.character_mut(id).unwrap().add_mask(&on_tip).unwrap();
    let half = LayerSettings { mode: LayerMode::Override, weight: 0.5 };
    crowd
        .member_mut(member)
        .unwrap()
        .play(tip, ClipPlayback::held_at_secs(0.0).on_layer(1))
        .unwrap();
    crowd.member_mut(member).unwrap().set_layer(1, half, Some(on_tip)).unwrap();
    crowd.update(0.0).unwrap();
    assert_near(height(&mut crowd, member, 0), 7.5); // masked
    assert_near(height(&mut crowd, member, 1), 7.5 + 2.5);

    // "tip" rises by 0.4 m from its first row to 0.4 s.
    crowd
        .member_mut(member)
        .unwrap()
        .play(tip, ClipPlayback::held_at_secs(0.4).on_layer(2))
        .unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .set_layer(2, LayerSettings { mode: LayerMode::Additive, weight: 1.0 }, None)
        .unwrap();
    crowd.update(0.0).unwrap();
    assert_near(height(&mut crowd, member, 1), 7.5 + 2.5 + 0.4);
}

fn members_can_be_spawned_and_despawned(device: Device) {
    let (mut crowd, id) = crowd_of(device, 3);
    let [low, high] = ["low", "high"].map(|name| crowd.clip(id, name).unwrap());
    let spawn = |crowd: &mut Crowd| crowd.spawn(id, Placement::at([0.0; 3]));
    let members: Vec<_> = (0..3).map(|_| spawn(&mut crowd).unwrap()).collect();
    assert_eq!(spawn(&mut crowd), Err(Error::Full { capacity: 3 }));
    for &member in &members {
        crowd.member_mut(member).unwrap().play(high, ClipPlayback::held_at_secs(0.0)).unwrap();
    }
    let look = MemberLook::PLAIN.without_option(0);
    for (number, &member) in (1..).zip(&members) {
        let mut member = crowd.member_mut(member).unwrap();
        member.set_user_data(number);
        member.set_look(look);
    }
    crowd.update(0.0).unwrap();
    crowd.despawn(members[1]).unwrap();
    assert_eq!(crowd.despawn(members[1]), Err(Error::StaleMember));

    let new_member = spawn(&mut crowd).unwrap();
    let details = |of| crowd.member(of).map(|member| (member.user_data(), member.look())).unwrap();
    assert_eq!(details(new_member), (0, MemberLook::PLAIN), "those of the member before are gone");
    assert_eq!(details(members[2]), (3, look));
    assert_eq!(
        crowd.member_mut(members[1]).and_then(|mut m| m.set_placement(Placement::at([1.0; 3]))),
        Err(Error::StaleMember)
    );
    crowd.member_mut(new_member).unwrap().play(low, ClipPlayback::held_at_secs(1.0)).unwrap();
    crowd.update(0.0).unwrap();
    assert_near(height(&mut crowd, new_member, 0), 1.0);
    assert_near(height(&mut crowd, members[0], 0), 10.0);
    assert_near(height(&mut crowd, members[2], 0), 10.0);
    assert_eq!(crowd.instances().count(), 3);
}

fn twenty_starts_within_300_ms_never_show_the_rest_pose(device: Device) {
    // Slots run out and the weakest clips are evicted. The rest pose at 0 m never shows.
    let (mut crowd, id) = crowd_of(device, 1);
    let [low, high] = ["low", "high"].map(|name| crowd.clip(id, name).unwrap());
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd.member_mut(member).unwrap().play(high, ClipPlayback::held_at_secs(0.0)).unwrap();
    for step in 0..20 {
        let clip = if step % 2 == 0 { high } else { low };
        crowd
            .member_mut(member)
            .unwrap()
            .play(clip, ClipPlayback::held_at_secs(1.0).fade_in_secs(0.2))
            .unwrap();
        crowd.update(0.015).unwrap();
        assert!(height(&mut crowd, member, 0) > 0.9, "step {step}");
    }
}

fn added_clip_plays_in_the_next_frame(device: Device) {
    let (mut crowd, id) = crowd_of(device, 1);
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd.update(0.1).unwrap();
    let skeleton = crowd.character(id).unwrap().asset().skeleton.clone();
    let source = ClipSource { name: "late".into(), tracks: vec![track("base", 20.0)] };
    let late = crowd
        .character_mut(id)
        .unwrap()
        .add_clip(&Arc::new(Clip::new(source, &skeleton).unwrap()))
        .unwrap();
    assert_eq!(crowd.clip(id, "late").unwrap(), late);
    crowd.member_mut(member).unwrap().play(late, ClipPlayback::looping().phase(0.5)).unwrap();
    crowd.update(0.25).unwrap();
    assert_near(height(&mut crowd, member, 0), 20.75);
}

fn bad_crowd_values_are_refused_and_change_nothing(device: Device) {
    let (mut crowd, id) = crowd_of(device, 2);
    let low = crowd.clip(id, "low").unwrap();
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    assert!(crowd.spawn(id, Placement::at([f32::NAN, 0.0, 0.0])).is_err());
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.set_placement(Placement::at([0.0; 3]).scaled(0.0)))
            .is_err()
    );
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play(low, ClipPlayback::looping().speed(f32::INFINITY)))
            .is_err()
    );
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play(low, ClipPlayback::looping().weight(1.5)))
            .is_err()
    );
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play(low, ClipPlayback::looping().on_layer(4)))
            .is_err()
    );
    assert!(crowd.update(-1.0).is_err());
    assert!(crowd.update(1e30).is_err());
    assert!(crowd.update(f32::NAN).is_err());
    let error = crowd.clip(id, "hihg").unwrap_err();
    assert_eq!(error.to_string(), "\"lift\" has no clip \"hihg\"; did you mean \"high\"?");
    crowd.update(0.0).unwrap();
    assert_near(height(&mut crowd, member, 0), 0.0);
    assert_eq!(crowd.member_count(), 1);
}

/// Each member has 400,000 palette entries. Two fill most of a page, so the third is on the second
/// page.
fn palettes_on_the_second_page_are_correct(device: Device) {
    let mut source = (*lift()).clone();
    source.palette = vec![source.palette[0]; 400_000];
    let mut crowd = Crowd::builder().device(device).build().unwrap();
    let id = crowd.add_character(Character::new(source).unwrap()).unwrap();
    let high = crowd.clip(id, "high").unwrap();
    let members: Vec<_> =
        (0..3).map(|_| crowd.spawn(id, Placement::at([0.0; 3])).unwrap()).collect();
    crowd.member_mut(members[2]).unwrap().play(high, ClipPlayback::held_at_secs(0.5)).unwrap();
    crowd.update(0.0).unwrap();
    assert_eq!(crowd.page_lengths().len(), 2);
    let palette = crowd.member_mut(members[2]).unwrap().palette().unwrap();
    assert_near(palette[0].rows[1][3], 10.5);
    assert!(palette.iter().all(|matrix| *matrix == palette[0]));
    let last = crowd.instances().last().unwrap();
    assert_eq!(last.palette_first, populace::interop::PAGE_ENTRIES);
    let mut seen = Vec::new();
    crowd.with_page(1, &mut |page| seen = page[..3].to_vec()).unwrap();
    assert_near(seen[1].0[3], 10.5);
}

macro_rules! on_devices {
    ($($test:ident),* $(,)?) => {
        mod native {
            $(#[test] fn $test() { super::$test(populace::Device::native()); })*
        }
        mod opencl {
            $(
                #[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
                #[test]
                fn $test() { super::$test(populace::Device::opencl(0)); }
            )*
        }
    };
}
on_devices!(
    play_crossfade_and_stop,
    clips_are_retargeted_by_user_defined_roles,
    blends_and_layers,
    members_can_be_spawned_and_despawned,
    twenty_starts_within_300_ms_never_show_the_rest_pose,
    added_clip_plays_in_the_next_frame,
    bad_crowd_values_are_refused_and_change_nothing,
    palettes_on_the_second_page_are_correct,
);

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn crowd_continues_on_another_device() {
    let (mut crowd, id) = crowd_of(Device::native(), 2);
    let low = crowd.clip(id, "low").unwrap();
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd.member_mut(member).unwrap().play(low, ClipPlayback::looping()).unwrap();
    crowd.update(0.25).unwrap();
    let before = crowd.member_mut(member).unwrap().palette().unwrap();
    crowd.move_to(Device::opencl(0)).unwrap();
    crowd.update(0.0).unwrap();
    assert_eq!(crowd.member_mut(member).unwrap().palette().unwrap(), before);
    crowd.update(0.5).unwrap();
    assert_near(height(&mut crowd, member, 0), 0.75);
    assert!(crowd.move_to(Device::opencl(99)).is_err());
    assert_eq!(crowd.device_info().devices, Device::opencl(0).into());
}

#[test]
fn mask_of_another_character_is_refused() {
    let (mut crowd, id) = crowd_of(Device::native(), 2);
    let other = crowd.add_character(lift()).unwrap();
    let skeleton = crowd.character(other).unwrap().asset().skeleton.clone();
    let mask = crowd
        .character_mut(other)
        .unwrap()
        .add_mask(&Mask::subtree(&skeleton, JointIndex(0)))
        .unwrap();
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    let mut member = crowd.member_mut(member).unwrap();
    let refused = member.set_layer(1, LayerSettings::default(), Some(mask)).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "there is no mask 0 in this character; ids are valid in the character that returned them, \
         until it is removed"
    );
}

#[test]
fn slot_counts_out_of_range_are_refused() {
    for (slots, good) in [(0, false), (1, true), (8, true), (9, false), (300, false)] {
        let built = Crowd::builder().device(Device::native()).slots_per_member(slots).build();
        match built.err() {
            None => assert!(good, "{slots}"),
            Some(error) => {
                let text = error.to_string();
                assert!(
                    !good && text.contains(&format!("is {slots}; it must be from 1 to 8")),
                    "{text}"
                );
            }
        }
    }
}

#[test]
fn ids_of_another_crowd_are_refused() {
    let (mut ours, id) = crowd_of(Device::native(), 2);
    let (mut other, other_id) = crowd_of(Device::native(), 2);
    let member = ours.spawn(id, Placement::at([0.0; 3])).unwrap();
    let foreign = other.spawn(other_id, Placement::at([0.0; 3])).unwrap();
    let (clip, other_clip) = (ours.clip(id, "low").unwrap(), other.clip(other_id, "low").unwrap());
    let skeleton = other.character(other_id).unwrap().asset().skeleton.clone();
    let mask = other
        .character_mut(other_id)
        .unwrap()
        .add_mask(&Mask::subtree(&skeleton, JointIndex(0)))
        .unwrap();
    let played =
        other.member_mut(foreign).unwrap().play(other_clip, ClipPlayback::looping()).unwrap();
    let watch = other.member_mut(foreign).unwrap().watch_joint(JointIndex(0)).unwrap();
    let unknown = |what, result: Result<(), Error>| {
        assert!(
            matches!(&result, Err(Error::UnknownId { what: w, .. }) if *w == what),
            "{what}: {result:?}"
        );
    };
    unknown(IdKind::Member, ours.despawn(foreign));
    unknown(IdKind::Member, ours.member(foreign).map(|m| m.active_clips()).map(drop));
    unknown(
        IdKind::Member,
        ours.member_mut(played.member()).and_then(|mut m| m.set_weight(played, 1.0, 0.0)),
    );
    unknown(
        IdKind::Member,
        ours.member_mut(played.member()).and_then(|mut m| m.set_speed(played, 1.0)),
    );
    unknown(IdKind::Watch, ours.readback(watch).map(drop));
    unknown(IdKind::Character, ours.spawn(other_id, Placement::at([0.0; 3])).map(drop));
    unknown(
        IdKind::Clip,
        ours.member_mut(member)
            .and_then(|mut m| m.play(other_clip, ClipPlayback::looping()))
            .map(drop),
    );
    assert!(
        ours.member_mut(member)
            .and_then(|mut m| m.set_layer(1, LayerSettings::default(), Some(mask)))
            .is_err()
    );
    ours.member_mut(member).unwrap().play(clip, ClipPlayback::looping()).unwrap();
    ours.update(0.1).unwrap();
}

/// Takes time in proportion to the number of members: most of a minute if it grew with the square.
#[test]
fn eighty_thousand_listeners_with_proportions_of_their_own_come_and_leave() {
    let (mut crowd, id) = crowd_of(Device::native(), 80_000);
    let [low, high] = ["low", "high"].map(|name| crowd.clip(id, name).unwrap());
    let spawned = (0..80_000).map(|_| crowd.spawn(id, Placement::at([0.0; 3])).unwrap());
    let members: Vec<_> = spawned.collect();
    let mut factor = 1.0;
    for member in &members {
        factor += 1e-6;
        let mut view = crowd.member_mut(*member).unwrap();
        view.set_proportions(&[factor, 1.0]).unwrap();
        view.subscribe_events();
        view.play(low, ClipPlayback::once()).unwrap();
        view.play(high, ClipPlayback::looping().after_secs(1.0)).unwrap();
    }
    crowd.update(2.0).unwrap();
    assert_eq!(crowd.events().len(), members.len(), "each clip ends once");
    for member in members {
        crowd.despawn(member).unwrap();
    }
    assert_eq!(crowd.members().count(), 0);
}
