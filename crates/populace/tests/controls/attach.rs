//! Attachments: members that follow a joint of another member, their parent.

use std::cell::RefCell;

use populace::character::{Character, CharacterSource};
use populace::model::{JointSource, Skeleton};
use populace::{
    Affine, ClipPlayback, Crowd, Device, Error, JointIndex, JointOverride, MemberId, Placement,
    Reach, Space, Target, Trs, Weight,
};

use crate::fixture::{Scene, character, distance, everywhere, joint};
use crate::gaze::gaze;

/// An offset from the joint with translation, rotation and scale.
const OFFSET: Trs = Trs {
    translation: [0.1, -0.05, 0.2],
    rotation: [0.48, 0.0, 0.6, 0.64],
    scale: [0.5, 0.5, 0.5],
};

const HERE: Placement = Placement::at([0.0; 3]);

fn attach(scene: &mut Scene, attachment: MemberId, to: MemberId, name: &str) {
    scene.edit(attachment).attach_to(to, joint(name), OFFSET).expect("a joint");
}

fn play(scene: &mut Scene, member: MemberId, name: &str) {
    let clip = scene.clip(name);
    scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
}

/// Returns the largest error of an attachment's joint transforms. Expected are those of `free`, an
/// unattached member that plays the same clip, moved by `joint` times the offset.
fn attachment_error(
    scene: &mut Scene,
    attachment: MemberId,
    free: MemberId,
    joint: &Affine,
) -> f32 {
    let from = joint.mul(&Affine::from_trs(&OFFSET));
    let wanted = scene.models(free).into_iter().map(|model| from.mul(&model));
    let differ = |(a, b): (&Affine, Affine)| {
        let pairs = a.rows.into_iter().flatten().zip(b.rows.into_iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let palette = scene.edit(attachment).palette().expect("a palette");
    assert_eq!(palette, scene.models(attachment), "model transforms and palette differ");
    palette.iter().zip(wanted).map(differ).fold(0.0, f32::max)
}

#[test]
fn attachment_follows_its_joint_in_the_same_frame() {
    everywhere(|scene| {
        // One attachment comes before its parent in all tables, the other after it.
        let (first, free) = (scene.member(HERE), scene.member(HERE));
        let parent = scene.member(HERE);
        let second = scene.member(HERE);
        for (member, clip) in [(first, "walk"), (second, "walk"), (free, "walk"), (parent, "sway")]
        {
            play(scene, member, clip);
        }
        attach(scene, first, parent, "leftHand");
        attach(scene, second, parent, "leftHand");
        // The attachments have root transforms other than the identity.
        let transform = Trs { translation: [0.3, 0.0, 0.1], scale: [0.8, 1.1, 1.0], ..OFFSET };
        let given =
            JointOverride { joint: joint("root"), space: Space::Local, transform, weight: 1.0 };
        for member in [first, second, free] {
            scene.edit(member).override_joints(&[given]).expect("an override");
        }
        let mut last = [0.0; 3];
        for frame in 0..12_u8 {
            let x = f32::from(frame);
            let placement = Placement::at([1000.0 + x, 0.2 * x, -3.0 * x])
                .facing(0.4 * x)
                .scaled(1.0 + 0.1 * x);
            scene.edit(parent).set_placement(placement).expect("a member");
            if frame > 3 {
                let target = Target::InModel([0.3, 1.0 + 0.1 * x, 0.5]);
                let at_once = Weight::FULL.over_secs(0.0);
                scene
                    .edit(parent)
                    .reach(Reach::with(joint("leftHand")), target, at_once)
                    .expect("an arm");
            }
            if frame > 6 {
                let transform = Trs {
                    scale: [1.5, 0.7, 1.2],
                    translation: [0.0, 0.1 * x, 0.1],
                    ..Trs::IDENTITY
                };
                let given = JointOverride {
                    joint: joint("spine"),
                    space: Space::Local,
                    transform,
                    weight: 0.5,
                };
                scene.edit(parent).override_joints(&[given]).expect("an override");
            }
            scene.update(0.05);
            let hand = scene.models(parent)[joint("leftHand").index()];
            assert!(
                distance(hand.origin(), last) > 1e-3,
                "the hand does not move in frame {frame}"
            );
            last = hand.origin();
            for attachment in [first, second] {
                let error = attachment_error(scene, attachment, free, &hand);
                assert!(error < 1e-5, "{error} m in frame {frame}");
                assert_eq!(scene.crowd.member(attachment).map(|m| m.placement()), Ok(placement));
            }
        }
    });
}

#[test]
fn attachments_can_be_chained_four_levels_deep() {
    everywhere(|scene| {
        let free = scene.member(HERE);
        // Each member comes before its parent in all tables.
        let chain: Vec<MemberId> = (0..5).map(|_| scene.member(HERE)).collect();
        for &member in chain.iter().chain([&free]) {
            play(scene, member, "sway");
        }
        for pair in chain.windows(2) {
            attach(scene, pair[0], pair[1], "head");
        }
        let placement = Placement::at([4.0, 0.5, -2.0]).facing(2.0).scaled(1.3);
        scene.edit(chain[4]).set_placement(placement).expect("the end of the chain");
        for frame in 0..5 {
            scene.update(0.1);
            for pair in chain.windows(2) {
                let head = scene.models(pair[1])[joint("head").index()];
                let error = attachment_error(scene, pair[0], free, &head);
                assert!(
                    error < 1e-5,
                    "{error} m in frame {frame}, {:?}",
                    scene.crowd.device_info().schedule
                );
                assert_eq!(scene.crowd.member(pair[0]).map(|m| m.placement()), Ok(placement));
            }
        }
    });
}

/// Spawns eight members that sway and reach. Each carries a rider in its hand; each rider wears a
/// hat and looks at another rider. Returns the hats, then pairs of rider and parent.
fn parents_with_attachments(scene: &mut Scene) -> Vec<MemberId> {
    let hats: Vec<MemberId> = (0..8).map(|_| scene.member(HERE)).collect();
    let mut all = hats.clone();
    let parents: Vec<MemberId> =
        (0..8_u8).map(|n| scene.member(Placement::at([f32::from(n), 0.0, 1.0]))).collect();
    for (n, (&hat, &parent)) in hats.iter().zip(&parents).enumerate() {
        let rider = scene.member(HERE);
        for (member, name) in [(hat, "sway"), (rider, "walk"), (parent, "sway")] {
            let phase = n as f32 * 0.11;
            let clip = scene.clip(name);
            scene
                .edit(member)
                .play(clip, ClipPlayback::looping().phase(phase))
                .expect("a clip that plays");
        }
        let target = Target::InModel([0.4, 1.2 + 0.05 * n as f32, 0.3]);
        let reach = Reach::with(joint("leftHand"));
        scene.edit(parent).reach(reach, target, Weight::FULL.over_secs(0.2)).expect("an arm");
        attach(scene, rider, parent, "leftHand");
        attach(scene, hat, rider, "head");
        all.extend([rider, parent]);
    }
    for n in 0..8 {
        let (rider, other) = (all[8 + 2 * n], all[8 + 2 * ((n + 3) % 8)]);
        let target = Target::Joint { member: other, joint: joint("head") };
        scene
            .edit(rider)
            .look_at_with(&gaze(), target, Weight::FULL.over_secs(0.1))
            .expect("a gaze");
    }
    all
}

fn step(scene: &mut Scene, members: &[MemberId], frame: u16) -> Vec<Vec<Affine>> {
    for (n, &parent) in (0_u8..).zip(members[8..].iter().skip(1).step_by(2)) {
        let at = Placement::at([f32::from(n), 0.0, f32::from(frame) * 0.02]).facing(f32::from(n));
        scene.edit(parent).set_placement(at).expect("a parent");
    }
    scene.update(1.0 / 30.0);
    members.iter().map(|member| scene.edit(*member).palette().expect("a palette")).collect()
}

#[test]
fn attachments_give_equal_bits_on_every_device_and_schedule() {
    let first: RefCell<Option<Vec<Vec<Vec<Affine>>>>> = RefCell::new(None);
    everywhere(|scene| {
        let members = parents_with_attachments(scene);
        let frames: Vec<_> = (0..10).map(|frame| step(scene, &members, frame)).collect();
        let mut first = first.borrow_mut();
        let schedule = scene.crowd.device_info().schedule;
        assert!(*first.get_or_insert_with(|| frames.clone()) == frames, "{schedule:?} differs");
    });
}

#[cfg(all(feature = "opencl", not(skip_opencl)))]
fn scene_on(mut crowd: Crowd) -> (Scene, Vec<MemberId>) {
    let body = crowd.add_character(character()).expect("enough capacity");
    let mut scene = Scene { crowd, body };
    let members = parents_with_attachments(&mut scene);
    (scene, members)
}

fn crowd_on(device: Device) -> Crowd {
    Crowd::builder().device(device).capacity(32).build().expect("a crowd")
}

#[cfg(all(feature = "opencl", not(skip_opencl)))]
#[test]
fn attachment_and_parent_may_be_on_different_devices() {
    for schedule in [populace::Schedule::Staged, populace::Schedule::Fused] {
        let devices = [Device::native(), Device::opencl(0)];
        let shared = Crowd::builder().devices(devices).schedule(schedule).capacity(32).build();
        let (mut scene, members) = scene_on(shared.expect("a crowd"));
        let (mut twin, twins) = scene_on(crowd_on(Device::native()));
        for frame in 0..24 {
            let share = f64::from(frame % 7 + 1) / 9.0;
            if frame < 12 {
                let split = populace::Split::Fixed(vec![share, 1.0 - share]);
                scene.crowd.set_split(&split).expect("shares");
            } else {
                scene.crowd.move_to(devices[usize::from(frame % 2)]).expect("a device");
            }
            let (frames, wanted) =
                (step(&mut scene, &members, frame), step(&mut twin, &twins, frame));
            assert!(frames == wanted, "frame {frame}, {schedule:?}");
            let (own, other) = (scene.models(members[0]), twin.models(twins[0]));
            assert_eq!(own, other, "model transforms in frame {frame}, {schedule:?}");
        }
    }
}

#[test]
fn watched_joint_of_an_attachment_is_where_it_is_drawn() {
    everywhere(|scene| {
        let (attachment, parent) = (scene.member(HERE), scene.member(HERE));
        play(scene, parent, "sway");
        attach(scene, attachment, parent, "leftHand");
        scene
            .edit(parent)
            .set_placement(Placement::at([5.0, 1.0, 2.0]).facing(1.0).scaled(2.0))
            .expect("a parent");
        let watch = scene.edit(attachment).watch_joint(joint("head")).expect("a joint");
        scene.update(0.3);
        scene.crowd.finish().expect("a device");
        let seen =
            scene.crowd.readback(watch).expect("a device").expect("a readback").world_from_joint;
        let world_from_model =
            scene.crowd.member(attachment).expect("a member").instance().world_from_model;
        let drawn = world_from_model.mul(&scene.models(attachment)[joint("head").index()]);
        assert!(distance(seen.origin(), drawn.origin()) < 1e-5, "{seen:?} {drawn:?}");
    });
}

#[test]
fn orphaned_attachment_keeps_its_parents_placement() {
    everywhere(|scene| {
        let [hat, rider, horse, free] = [(); 4].map(|()| scene.member(HERE));
        attach(scene, rider, horse, "chest");
        attach(scene, hat, rider, "head");
        let placement = Placement::at([1.0, 2.0, 3.0]).facing(1.0);
        scene.edit(horse).set_placement(placement).expect("a member");
        scene.update(0.1);
        assert_ne!(scene.models(rider), scene.models(free));
        assert_eq!(
            scene.crowd.member(rider).map(|m| m.attached_to()),
            Ok(Some((horse, joint("chest"))))
        );

        scene.crowd.despawn(horse).expect("a member");
        assert_eq!(scene.crowd.member(rider).map(|m| m.attached_to()), Ok(None));
        assert_eq!(
            scene.crowd.member(hat).map(|m| m.attached_to()),
            Ok(Some((rider, joint("head"))))
        );
        scene.update(0.1);
        assert_eq!(scene.models(rider), scene.models(free));
        assert_eq!(scene.crowd.member(rider).map(|m| m.placement()), Ok(placement));
        let head = scene.models(rider)[joint("head").index()];
        assert!(attachment_error(scene, hat, free, &head) < 1e-5, "the hat left the head");

        scene.edit(hat).detach().expect("a member");
        scene.edit(hat).detach().expect("a detached member");
        scene.edit(hat).set_placement(HERE).expect("a detached member");
        scene.update(0.1);
        assert_eq!(scene.models(hat), scene.models(free));

        // Attaching again changes the parent; the old parent is then despawned.
        attach(scene, hat, rider, "head");
        attach(scene, hat, free, "leftHand");
        scene.crowd.despawn(rider).expect("a member");
        scene.update(0.1);
        let hand = scene.models(free)[joint("leftHand").index()];
        assert!(attachment_error(scene, hat, free, &hand) < 1e-5);
        scene.crowd.despawn(hat).expect("a member");
        scene.update(0.1);
        assert_eq!(scene.crowd.member(hat).map(|m| m.attached_to()), Err(Error::StaleMember));
    });
}

#[test]
fn bad_attachments_are_refused_and_change_nothing() {
    let mut crowd = crowd_on(Device::native());
    let body = crowd.add_character(character()).expect("enough capacity");
    let bare =
        crowd.add_character(Character::new(bare()).expect("joints")).expect("enough capacity");
    let mut scene = Scene { crowd, body };
    let [a, b, gone] = [(); 3].map(|()| scene.member(HERE));
    scene.crowd.despawn(gone).expect("a member");
    let bare = scene.crowd.spawn(bare, HERE).expect("enough capacity");
    let head = joint("head");
    let mut refuses =
        |attachment: MemberId, to: MemberId, joint: JointIndex, offset: Trs, words: &str| {
            let before =
                [attachment, to].map(|member| scene.crowd.member(member).map(|m| m.attached_to()));
            let error = scene
                .crowd
                .member_mut(attachment)
                .and_then(|mut m| m.attach_to(to, joint, offset))
                .expect_err("a bad attachment")
                .to_string();
            assert!(error.contains(words), "{error}");
            assert_eq!(
                [attachment, to].map(|member| scene.crowd.member(member).map(|m| m.attached_to())),
                before
            );
        };
    refuses(gone, a, head, OFFSET, "stale");
    refuses(a, gone, head, OFFSET, "stale");
    refuses(a, b, JointIndex(19), OFFSET, "there is no joint 19; the skeleton has 19");
    refuses(a, b, head, Trs { translation: [f32::NAN, 0.0, 0.0], ..OFFSET }, "finite");
    refuses(a, b, head, Trs { rotation: [0.0; 4], ..OFFSET }, "rotation of length 1");
    refuses(a, a, head, OFFSET, "to itself");
    refuses(a, bare, JointIndex(0), OFFSET, "\"bare\"");
}

#[test]
fn cycles_deep_chains_and_placements_of_attachments_are_refused() {
    let mut crowd = crowd_on(Device::native());
    let body = crowd.add_character(character()).expect("enough capacity");
    let mut scene = Scene { crowd, body };
    let [a, b, c, d, e, f] = [(); 6].map(|()| scene.member(HERE));
    let head = joint("head");
    for [attachment, to] in [[a, b], [b, c], [d, e]] {
        attach(&mut scene, attachment, to, "head");
    }
    let error = scene
        .crowd
        .member_mut(c)
        .and_then(|mut m| m.attach_to(a, head, OFFSET))
        .expect_err("a cycle")
        .to_string();
    assert!(error.contains("detach those first"), "{error}");
    attach(&mut scene, e, a, "head");
    let error = scene
        .crowd
        .member_mut(c)
        .and_then(|mut m| m.attach_to(f, head, OFFSET))
        .expect_err("too deep")
        .to_string();
    assert!(error.contains("5 levels deep; at most 4 are possible"), "{error}");
    let error = scene
        .crowd
        .member_mut(d)
        .and_then(|mut m| m.set_placement(HERE))
        .expect_err("an attached member")
        .to_string();
    assert!(error.contains("place the parent, or detach"), "{error}");
    let nan = Trs { translation: [f32::NAN; 3], ..OFFSET };
    scene
        .crowd
        .member_mut(d)
        .and_then(|mut m| m.attach_to(e, head, nan))
        .expect_err("an offset that is not finite");
    scene
        .crowd
        .member_mut(d)
        .and_then(|mut m| m.attach_to(b, head, nan))
        .expect_err("a new parent with a bad offset");
    assert_eq!(scene.crowd.member(d).map(|m| m.attached_to()), Ok(Some((e, head))));
    scene.update(0.1);
    scene.edit(d).attach_to(b, head, Trs::IDENTITY).expect("three levels");
    scene.edit(c).attach_to(f, head, OFFSET).expect("four levels");
    scene.update(0.1);
}

/// A character of one joint with nothing to draw.
fn bare() -> CharacterSource {
    let source = JointSource { name: "joint".into(), parent: None, rest: Trs::IDENTITY };
    CharacterSource {
        name: "bare".into(),
        skeleton: Skeleton::new(&[source]).expect("a joint"),
        palette: vec![],
        parts: vec![],
        materials: vec![],
        images: vec![],
        skins: vec![],
        clips: vec![],
    }
}
