//! Props that follow a joint of another member.

use std::cell::RefCell;

use populace::character::{Character, CharacterSource};
use populace::model::{JointSource, Skeleton};
use populace::{
    Affine, ClipPlayback, Crowd, Device, Error, JointIndex, JointOverride, MemberId, Placement,
    Reach, Space, Target, Trs, Weight,
};

use crate::body::{Stage, character, distance, everywhere, joint};
use crate::gaze::gaze;

/// Turned, moved and scaled against the joint.
const OFFSET: Trs = Trs {
    translation: [0.1, -0.05, 0.2],
    rotation: [0.48, 0.0, 0.6, 0.64],
    scale: [0.5, 0.5, 0.5],
};

const HERE: Placement = Placement::at([0.0; 3]);

fn attach(stage: &mut Stage, prop: MemberId, to: MemberId, name: &str) {
    stage
        .crowd
        .member_mut(prop)
        .expect("a joint")
        .attach_to(to, joint(name), OFFSET)
        .expect("a joint");
}

fn play(stage: &mut Stage, member: MemberId, name: &str) {
    let clip = stage.clip(name);
    stage
        .crowd
        .member_mut(member)
        .expect("a clip that plays")
        .play(clip, ClipPlayback::looping())
        .expect("a clip that plays");
}

/// How far all joints of a prop are from where `carrier` times the offset brings those of one that
/// plays the same.
fn apart(stage: &mut Stage, prop: MemberId, alike: MemberId, carrier: &Affine) -> f32 {
    let from = carrier.mul(&Affine::from_trs(&OFFSET));
    let free = stage.models(alike).into_iter().map(|model| from.mul(&model));
    let differ = |(a, b): (&Affine, Affine)| {
        let pairs = a.rows.into_iter().flatten().zip(b.rows.into_iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let palette = stage.crowd.member_mut(prop).expect("a palette").palette().expect("a palette");
    assert_eq!(palette, stage.models(prop), "what is read is what is drawn");
    palette.iter().zip(free).map(differ).fold(0.0, f32::max)
}

#[test]
fn a_prop_is_where_its_joint_is_in_the_same_frame() {
    everywhere(|stage| {
        // The one comes before its bearer in all tables, the other after it.
        let (first, alike) = (stage.member(HERE), stage.member(HERE));
        let bearer = stage.member(HERE);
        let second = stage.member(HERE);
        for (member, clip) in [(first, "walk"), (second, "walk"), (alike, "walk"), (bearer, "sway")]
        {
            play(stage, member, clip);
        }
        attach(stage, first, bearer, "leftHand");
        attach(stage, second, bearer, "leftHand");
        // Roots have transforms of their own.
        let transform = Trs { translation: [0.3, 0.0, 0.1], scale: [0.8, 1.1, 1.0], ..OFFSET };
        let given =
            JointOverride { joint: joint("root"), space: Space::Local, transform, weight: 1.0 };
        for member in [first, second, alike] {
            stage
                .crowd
                .member_mut(member)
                .expect("an override")
                .override_joints(&[given])
                .expect("an override");
        }
        let mut last = [0.0; 3];
        for frame in 0..12_u8 {
            let x = f32::from(frame);
            let placement = Placement::at([1000.0 + x, 0.2 * x, -3.0 * x])
                .facing(0.4 * x)
                .scaled(1.0 + 0.1 * x);
            stage
                .crowd
                .member_mut(bearer)
                .expect("a member")
                .set_placement(placement)
                .expect("a member");
            if frame > 3 {
                let target = Target::InModel([0.3, 1.0 + 0.1 * x, 0.5]);
                let at_once = Weight::FULL.over_secs(0.0);
                stage
                    .crowd
                    .member_mut(bearer)
                    .expect("an arm")
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
                stage
                    .crowd
                    .member_mut(bearer)
                    .expect("an override")
                    .override_joints(&[given])
                    .expect("an override");
            }
            stage.update(0.05);
            let hand = stage.models(bearer)[joint("leftHand").index()];
            assert!(distance(hand.origin(), last) > 1e-3, "the hand moves in frame {frame}");
            last = hand.origin();
            for prop in [first, second] {
                let error = apart(stage, prop, alike, &hand);
                assert!(error < 1e-5, "{error} m in frame {frame}, {:?}", stage.crowd.schedule());
                assert_eq!(stage.crowd.member(prop).map(|m| m.placement()), Ok(placement));
            }
        }
    });
}

#[test]
fn props_hang_on_props_four_levels_deep() {
    everywhere(|stage| {
        let alike = stage.member(HERE);
        // Each comes before the one that it hangs on.
        let chain: Vec<MemberId> = (0..5).map(|_| stage.member(HERE)).collect();
        for &member in chain.iter().chain([&alike]) {
            play(stage, member, "sway");
        }
        for pair in chain.windows(2) {
            attach(stage, pair[0], pair[1], "head");
        }
        let placement = Placement::at([4.0, 0.5, -2.0]).facing(2.0).scaled(1.3);
        stage
            .crowd
            .member_mut(chain[4])
            .expect("the one that is attached to nothing")
            .set_placement(placement)
            .expect("the one that is attached to nothing");
        for frame in 0..5 {
            stage.update(0.1);
            for pair in chain.windows(2) {
                let head = stage.models(pair[1])[joint("head").index()];
                let error = apart(stage, pair[0], alike, &head);
                assert!(error < 1e-5, "{error} m in frame {frame}, {:?}", stage.crowd.schedule());
                assert_eq!(stage.crowd.member(pair[0]).map(|m| m.placement()), Ok(placement));
            }
        }
    });
}

/// Eight who sway and reach, each with somebody in the hand who looks at the next one's and has
/// somebody on the head.
fn jugglers(stage: &mut Stage) -> Vec<MemberId> {
    let hats: Vec<MemberId> = (0..8).map(|_| stage.member(HERE)).collect();
    let mut all = hats.clone();
    let bearers: Vec<MemberId> =
        (0..8_u8).map(|n| stage.member(Placement::at([f32::from(n), 0.0, 1.0]))).collect();
    for (n, (&hat, &bearer)) in hats.iter().zip(&bearers).enumerate() {
        let rider = stage.member(HERE);
        for (member, name) in [(hat, "sway"), (rider, "walk"), (bearer, "sway")] {
            let phase = n as f32 * 0.11;
            let clip = stage.clip(name);
            stage
                .crowd
                .member_mut(member)
                .expect("a clip that plays")
                .play(clip, ClipPlayback::looping().phase(phase))
                .expect("a clip that plays");
        }
        let target = Target::InModel([0.4, 1.2 + 0.05 * n as f32, 0.3]);
        let reach = Reach::with(joint("leftHand"));
        stage
            .crowd
            .member_mut(bearer)
            .expect("an arm")
            .reach(reach, target, Weight::FULL.over_secs(0.2))
            .expect("an arm");
        attach(stage, rider, bearer, "leftHand");
        attach(stage, hat, rider, "head");
        all.extend([rider, bearer]);
    }
    for n in 0..8 {
        let (rider, other) = (all[8 + 2 * n], all[8 + 2 * ((n + 3) % 8)]);
        let target = Target::Joint { member: other, joint: joint("head") };
        stage
            .crowd
            .member_mut(rider)
            .expect("a gaze")
            .look_at_with(&gaze(), target, Weight::FULL.over_secs(0.1))
            .expect("a gaze");
    }
    all
}

fn step(stage: &mut Stage, members: &[MemberId], frame: u16) -> Vec<Vec<Affine>> {
    for (n, &bearer) in (0_u8..).zip(members[8..].iter().skip(1).step_by(2)) {
        let at = Placement::at([f32::from(n), 0.0, f32::from(frame) * 0.02]).facing(f32::from(n));
        stage.crowd.member_mut(bearer).expect("a bearer").set_placement(at).expect("a bearer");
    }
    stage.update(1.0 / 30.0);
    members
        .iter()
        .map(|member| {
            stage.crowd.member_mut(*member).expect("a palette").palette().expect("a palette")
        })
        .collect()
}

#[test]
fn props_are_the_same_to_the_bit_on_every_device_and_schedule() {
    let first: RefCell<Option<Vec<Vec<Vec<Affine>>>>> = RefCell::new(None);
    everywhere(|stage| {
        let members = jugglers(stage);
        let frames: Vec<_> = (0..10).map(|frame| step(stage, &members, frame)).collect();
        let mut first = first.borrow_mut();
        let schedule = stage.crowd.schedule();
        assert!(*first.get_or_insert_with(|| frames.clone()) == frames, "{schedule:?} differs");
    });
}

#[cfg(all(feature = "opencl", not(skip_opencl)))]
fn on(mut crowd: Crowd) -> (Stage, Vec<MemberId>) {
    let body = crowd.add_character(character()).expect("room");
    let mut stage = Stage { crowd, body };
    let members = jugglers(&mut stage);
    (stage, members)
}

fn alone(device: Device) -> Crowd {
    Crowd::builder().device(device).capacity(32).build().expect("a crowd")
}

#[cfg(all(feature = "opencl", not(skip_opencl)))]
#[test]
fn props_and_bearers_may_be_on_different_devices_and_move() {
    for schedule in [populace::Schedule::Staged, populace::Schedule::Fused] {
        let devices = [Device::native(), Device::opencl(0)];
        let shared = Crowd::builder().devices(devices).schedule(schedule).capacity(32).build();
        let (mut stage, members) = on(shared.expect("a crowd"));
        let (mut twin, twins) = on(alone(Device::native()));
        for frame in 0..24 {
            let share = f64::from(frame % 7 + 1) / 9.0;
            if frame < 12 {
                let split = populace::Split::Fixed(vec![share, 1.0 - share]);
                stage.crowd.set_split(&split).expect("shares");
            } else {
                stage.crowd.move_to(devices[usize::from(frame % 2)]).expect("a device");
            }
            let (frames, wanted) =
                (step(&mut stage, &members, frame), step(&mut twin, &twins, frame));
            assert!(frames == wanted, "frame {frame}, {schedule:?}");
            let (own, other) = (stage.models(members[0]), twin.models(twins[0]));
            assert_eq!(own, other, "joints that are read in frame {frame}, {schedule:?}");
        }
    }
}

#[test]
fn others_see_a_prop_where_it_is_drawn() {
    everywhere(|stage| {
        let (prop, bearer) = (stage.member(HERE), stage.member(HERE));
        play(stage, bearer, "sway");
        attach(stage, prop, bearer, "leftHand");
        stage
            .crowd
            .member_mut(bearer)
            .expect("a bearer")
            .set_placement(Placement::at([5.0, 1.0, 2.0]).facing(1.0).scaled(2.0))
            .expect("a bearer");
        let watch = stage
            .crowd
            .member_mut(prop)
            .expect("a joint")
            .watch_joint(joint("head"))
            .expect("a joint");
        stage.update(0.3);
        stage.crowd.finish().expect("a device");
        let seen =
            stage.crowd.readback(watch).expect("a device").expect("it was seen").world_from_joint;
        let of_prop = |instance: &populace::Instance| instance.member == prop;
        let instance = stage.crowd.instances().find(of_prop).expect("it is drawn");
        let drawn = instance.world_from_model.mul(&stage.models(prop)[joint("head").index()]);
        assert!(distance(seen.origin(), drawn.origin()) < 1e-5, "{seen:?} {drawn:?}");
    });
}

#[test]
fn what_falls_off_stays_at_its_bearers_placement() {
    everywhere(|stage| {
        let [hat, rider, horse, free] = [(); 4].map(|()| stage.member(HERE));
        attach(stage, rider, horse, "chest");
        attach(stage, hat, rider, "head");
        let placement = Placement::at([1.0, 2.0, 3.0]).facing(1.0);
        stage
            .crowd
            .member_mut(horse)
            .expect("a member")
            .set_placement(placement)
            .expect("a member");
        stage.update(0.1);
        assert_ne!(stage.models(rider), stage.models(free));
        assert_eq!(
            stage.crowd.member(rider).map(|m| m.attached_to()),
            Ok(Some((horse, joint("chest"))))
        );

        stage.crowd.despawn(horse).expect("a member");
        assert_eq!(stage.crowd.member(rider).map(|m| m.attached_to()), Ok(None));
        assert_eq!(
            stage.crowd.member(hat).map(|m| m.attached_to()),
            Ok(Some((rider, joint("head"))))
        );
        stage.update(0.1);
        assert_eq!(stage.models(rider), stage.models(free));
        assert_eq!(stage.crowd.member(rider).map(|m| m.placement()), Ok(placement));
        let head = stage.models(rider)[joint("head").index()];
        assert!(apart(stage, hat, free, &head) < 1e-5, "the hat stays on the head");

        stage.crowd.member_mut(hat).expect("a member").detach().expect("a member");
        stage.crowd.member_mut(hat).expect("nothing happens").detach().expect("nothing happens");
        stage.crowd.member_mut(hat).expect("it is free").set_placement(HERE).expect("it is free");
        stage.update(0.1);
        assert_eq!(stage.models(hat), stage.models(free));

        // Over to another joint of another one, and with that one away.
        attach(stage, hat, rider, "head");
        attach(stage, hat, free, "leftHand");
        stage.crowd.despawn(rider).expect("a member");
        stage.update(0.1);
        let (alike, hand) = (free, stage.models(free)[joint("leftHand").index()]);
        assert!(apart(stage, hat, alike, &hand) < 1e-5);
        stage.crowd.despawn(hat).expect("a member");
        stage.update(0.1);
        assert_eq!(stage.crowd.member(hat).map(|m| m.attached_to()), Err(Error::StaleMember));
    });
}

#[test]
fn what_cannot_be_attached_is_refused_and_all_stays() {
    let mut crowd = alone(Device::native());
    let body = crowd.add_character(character()).expect("room");
    let bare = crowd.add_character(Character::new(bare()).expect("joints")).expect("room");
    let mut stage = Stage { crowd, body };
    let [a, b, c, d, e, f] = [(); 6].map(|()| stage.member(HERE));
    let gone = stage.member(HERE);
    stage.crowd.despawn(gone).expect("a member");
    let bare = stage.crowd.spawn(bare, HERE).expect("room");
    let head = joint("head");
    let mut refuses = |prop: MemberId, to: MemberId, joint: JointIndex, offset: Trs, told: &str| {
        let before = [prop, to].map(|member| stage.crowd.member(member).map(|m| m.attached_to()));
        let error = stage
            .crowd
            .member_mut(prop)
            .and_then(|mut m| m.attach_to(to, joint, offset))
            .expect_err("it is refused")
            .to_string();
        assert!(error.contains(told), "{error}");
        assert_eq!(
            [prop, to].map(|member| stage.crowd.member(member).map(|m| m.attached_to())),
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
    for [prop, to] in [[a, b], [b, c], [d, e]] {
        attach(&mut stage, prop, to, "head");
    }
    let error = stage
        .crowd
        .member_mut(c)
        .and_then(|mut m| m.attach_to(a, head, OFFSET))
        .expect_err("a circle")
        .to_string();
    assert!(error.contains("detach that first"), "{error}");
    attach(&mut stage, e, a, "head");
    let error = stage
        .crowd
        .member_mut(c)
        .and_then(|mut m| m.attach_to(f, head, OFFSET))
        .expect_err("too deep")
        .to_string();
    assert!(error.contains("5 levels deep; 4 at most"), "{error}");
    let error = stage
        .crowd
        .member_mut(d)
        .and_then(|mut m| m.set_placement(HERE))
        .expect_err("it is attached")
        .to_string();
    assert!(error.contains("place that one, or detach"), "{error}");
    let nan = Trs { translation: [f32::NAN; 3], ..OFFSET };
    stage
        .crowd
        .member_mut(d)
        .and_then(|mut m| m.attach_to(e, head, nan))
        .expect_err("another offset that is none");
    stage
        .crowd
        .member_mut(d)
        .and_then(|mut m| m.attach_to(b, head, nan))
        .expect_err("another bearer with such a one");
    assert_eq!(stage.crowd.member(d).map(|m| m.attached_to()), Ok(Some((e, head))));
    stage.update(0.1);
    stage
        .crowd
        .member_mut(d)
        .expect("nearer to the first")
        .attach_to(b, head, Trs::IDENTITY)
        .expect("nearer to the first");
    stage
        .crowd
        .member_mut(c)
        .expect("four levels now")
        .attach_to(f, head, OFFSET)
        .expect("four levels now");
    stage.update(0.1);
}

/// A joint and nothing to draw.
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
