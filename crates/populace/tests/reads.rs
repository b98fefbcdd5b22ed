//! Reads give the same result on every device and schedule, in every state of a crowd.

use std::sync::Arc;

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::interop::{PaletteSource, PaletteTarget, TargetMark, View, Visibility};
use populace::model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track};
use populace::{
    Affine, BackendError, ClipId, ClipPlayback, Crowd, Device, Devices, Error, Gaze, GazeLimits,
    JointIndex, MemberId, Placement, Schedule, Target, Trs, Weight,
};

/// Returns all devices and schedules, and pairs of devices for one crowd.
fn everywhere() -> Vec<(Devices, Schedule)> {
    let native = || Devices::from(Device::Native { threads: 1 });
    let pair = || Devices::from([Device::Native { threads: 1 }, Device::Native { threads: 2 }]);
    #[cfg_attr(
        any(not(feature = "opencl"), skip_opencl),
        expect(unused_mut, reason = "nothing is added")
    )]
    let mut all =
        vec![(native(), Schedule::Staged), (native(), Schedule::Fused), (pair(), Schedule::Fused)];
    #[cfg(all(feature = "opencl", not(skip_opencl)))]
    {
        for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
            all.push((Device::opencl(0).into(), schedule));
        }
        let both = || Devices::from([Device::Native { threads: 1 }, Device::opencl(0)]);
        all.extend([(both(), Schedule::Staged), (both(), Schedule::Fused)]);
    }
    all
}

/// A character of one joint with `entries` palette entries. "Stand" holds it at a height of 0 m,
/// "Rise" at 1 m.
fn post(entries: usize) -> Character {
    let joint = JointSource { name: "post".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint]).expect("a good call");
    let clip = |name: &str, height: f32| {
        let track = Track {
            joint: "post".into(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: vec![0.0],
            values: vec![0.0, height, 0.0],
        };
        Arc::new(
            Clip::new(ClipSource { name: name.into(), tracks: vec![track] }, &skeleton)
                .expect("a good call"),
        )
    };
    let clips = vec![clip("Stand", 0.0), clip("Rise", 1.0)];
    let palette =
        vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }; entries];
    let (parts, materials, images, skins) = (vec![], vec![], vec![], vec![]);
    let name = "post".into();
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
    .expect("a good call")
}

/// A crowd of one member that plays "Stand", before the first update. Also returns "Rise".
fn crowd_playing_stand(devices: Devices, schedule: Schedule) -> (Crowd, MemberId, ClipId) {
    let mut crowd =
        Crowd::builder().devices(devices).schedule(schedule).build().expect("a good call");
    let post = crowd.add_character(post(1)).expect("a good call");
    let [stand, rise] = ["Stand", "Rise"].map(|name| crowd.clip(post, name).expect("a good call"));
    let member = crowd.spawn(post, Placement::at([0.0; 3])).expect("a good call");
    crowd
        .member_mut(member)
        .expect("a good call")
        .play(stand, ClipPlayback::looping())
        .expect("a good call");
    (crowd, member, rise)
}

/// Returns the height of a member's joint by each of the three reads.
fn heights(crowd: &mut Crowd, member: MemberId) -> [Result<f32, Error>; 3] {
    let height = |joints: Vec<Affine>| joints[0].rows[1][3];
    [
        crowd.member_mut(member).and_then(|mut m| m.palette()).map(height),
        crowd.member_mut(member).and_then(|mut m| m.model_from_joints()).map(height),
        crowd
            .member_mut(member)
            .and_then(|mut m| m.local_pose())
            .map(|pose| pose[0].translation[1]),
    ]
}

/// Returns the results of the two methods that read a page.
fn pages(crowd: &mut Crowd) -> [Result<(), Error>; 2] {
    let inherent = crowd.with_page(0, &mut |_| {});
    [inherent, PaletteSource::with_page(crowd, 0, &mut |_| {}).map_err(Error::from)]
}

#[track_caller]
fn assert_not_evaluated(crowd: &mut Crowd, member: MemberId, state: &str) {
    for found in heights(crowd, member) {
        let found = found.expect_err(state);
        assert_eq!(found, Error::Backend(BackendError::NotEvaluated), "{state}");
    }
}

#[track_caller]
fn assert_height(crowd: &mut Crowd, member: MemberId, wanted: f32, state: &str) {
    assert_eq!(heights(crowd, member), [wanted; 3].map(Ok), "{state}");
    assert_eq!(pages(crowd), [Ok(()), Ok(())], "{state}");
}

/// A view that shows what is nearer to `x` than 1 m along the x-axis.
fn view_at(x: f32) -> View {
    View {
        eye: [x, 0.0, 1.0],
        planes: [
            [1.0, 0.0, 0.0, 1.0 - x],
            [-1.0, 0.0, 0.0, 1.0 + x],
            [0.0, 1.0, 0.0, 10.0],
            [0.0, -1.0, 0.0, 10.0],
            [0.0, 0.0, 1.0, 10.0],
        ],
        pixels_per_metre: 100.0,
        to_sun: None,
        error_px: 1.0,
    }
}

/// Memory that grows and members that change devices lose what no frame writes again.
#[test]
fn hidden_members_have_no_results() {
    for (devices, schedule) in everywhere() {
        let at = |state: &str| format!("{state}, {devices}, {schedule}");
        let (mut crowd, member, rise) = crowd_playing_stand(devices.clone(), schedule);
        let show = |crowd: &mut Crowd, is_shown: bool, state: &str| {
            crowd.set_view(Some(view_at(if is_shown { 0.0 } else { 100.0 }))).unwrap();
            crowd.update(0.1).unwrap();
            let mut listed = 0;
            crowd.palettes(&mut |_, _| listed += 1).unwrap();
            assert_eq!(listed, usize::from(is_shown), "{}", at(state));
        };
        show(&mut crowd, false, "hidden from the beginning");
        assert_not_evaluated(&mut crowd, member, &at("hidden from the beginning"));
        show(&mut crowd, true, "shown");
        assert_height(&mut crowd, member, 0.0, &at("shown"));
        show(&mut crowd, false, "hidden");
        assert_not_evaluated(&mut crowd, member, &at("hidden"));
        let joint = [(member, JointIndex(0))];
        assert_eq!(
            crowd.read_joints(&joint, &mut [Affine::IDENTITY]),
            Err(Error::Backend(BackendError::NotEvaluated)),
            "{}",
            at("hidden")
        );
        let hidden = crowd.snapshot().unwrap();
        crowd.member_mut(member).unwrap().play(rise, ClipPlayback::looping()).unwrap();
        show(&mut crowd, true, "shown again");
        assert_height(&mut crowd, member, 1.0, &at("shown again"));
        crowd.restore(&hidden).unwrap();
        assert_not_evaluated(&mut crowd, member, &at("just restored"));
        show(&mut crowd, false, "restored");
        assert_not_evaluated(&mut crowd, member, &at("restored"));
        crowd.move_to(devices.clone()).unwrap();
        show(&mut crowd, false, "moved");
        assert_not_evaluated(&mut crowd, member, &at("moved"));
    }
}

/// A member takes the palette of one that is gone, or one past the end of the page.
#[test]
fn members_are_drawn_from_their_first_update_on() {
    for (devices, schedule) in everywhere() {
        let at = |state: &str| format!("{state}, {devices}, {schedule}");
        let (mut crowd, first, _) = crowd_playing_stand(devices.clone(), schedule);
        let post = crowd.member(first).unwrap().character();
        let drawn = |crowd: &Crowd| {
            let mut list = Vec::new();
            crowd.visible_members(&mut list);
            let instances =
                crowd.members().filter(|member| member.instance().visibility != Visibility::Hidden);
            assert!(instances.map(|m| m.id()).eq(list.iter().map(|visible| visible.member)));
            list.into_iter().map(|visible| visible.member).collect::<Vec<_>>()
        };
        crowd.update(0.1).unwrap();
        let second = crowd.spawn(post, Placement::at([1.0; 3])).unwrap();
        assert_eq!(drawn(&crowd), [first], "{}", at("spawned"));
        crowd.update(0.1).unwrap();
        assert_eq!(drawn(&crowd), [first, second], "{}", at("updated"));
        crowd.despawn(first).unwrap();
        let third = crowd.spawn(post, Placement::at([1.0; 3])).unwrap();
        assert_eq!(drawn(&crowd), [second], "{}", at("spawned in its place"));
        crowd.update(0.1).unwrap();
        assert_eq!(drawn(&crowd), [third, second], "{}", at("updated again"));
    }
}

/// Pages in OpenGL's memory are drawn from without a call that reads them.
#[test]
fn palettes_of_an_undone_frame_are_not_released() {
    for (devices, schedule) in everywhere() {
        let at = |state: &str| format!("{state}, {devices}, {schedule}");
        let (mut crowd, ..) = crowd_playing_stand(devices.clone(), schedule);
        crowd.set_target(PaletteTarget::Copied, &TargetMark::default()).unwrap();
        let is_released =
            |crowd: &mut Crowd| crowd.release_palettes().map(|released| released.is_some());
        assert_eq!(is_released(&mut crowd), Ok(true), "{}", at("new"));
        let new = crowd.snapshot().unwrap();
        crowd.update(0.1).unwrap();
        let updated = crowd.snapshot().unwrap();
        for (snapshot, released) in [(updated, Ok(true)), (new, Err(BackendError::NotEvaluated))] {
            crowd.update(0.1).unwrap();
            assert_eq!(is_released(&mut crowd), Ok(true), "{}", at("updated"));
            crowd.restore(&snapshot).unwrap();
            assert_eq!(is_released(&mut crowd), released, "{}", at("restored"));
        }
        crowd.move_to(devices.clone()).unwrap();
        assert_eq!(is_released(&mut crowd), Ok(false), "{}", at("moved"));
    }
}

#[test]
fn reads_give_the_same_result_in_every_state() {
    for (devices, schedule) in everywhere() {
        let at = |state: &str| format!("{state}, {devices}, {schedule}");
        let (mut crowd, member, rise) = crowd_playing_stand(devices.clone(), schedule);
        let no_pages = [(); 2].map(|()| Err(Error::Backend(BackendError::NotEvaluated)));
        assert_not_evaluated(&mut crowd, member, &at("new"));
        assert_eq!(pages(&mut crowd), no_pages, "{}", at("new"));
        assert!(PaletteSource::release_palettes(&mut crowd).unwrap().is_none(), "{}", at("new"));
        assert_eq!(
            crowd.member_mut(member).and_then(|mut m| m.moved_placement()),
            Ok(Placement::at([0.0; 3]))
        );
        let watch = crowd.member_mut(member).unwrap().watch_joint(JointIndex(0)).unwrap();
        assert_eq!(crowd.readback(watch), Ok(None), "{}", at("new"));

        crowd.update(0.1).unwrap();
        assert_height(&mut crowd, member, 0.0, &at("updated"));
        crowd.member_mut(member).unwrap().play(rise, ClipPlayback::looping()).unwrap();
        assert_height(&mut crowd, member, 0.0, &at("changed"));
        let late = crowd
            .spawn(crowd.member(member).unwrap().character(), Placement::at([1.0; 3]))
            .unwrap();
        assert_not_evaluated(&mut crowd, late, &at("spawned"));
        assert_height(&mut crowd, member, 0.0, &at("another member spawned"));
        assert!(crowd.with_page(1, &mut |_| {}).unwrap_err().to_string().contains("no page 1"));

        crowd.update(0.1).unwrap();
        assert_height(&mut crowd, member, 1.0, &at("updated again"));
        let risen = crowd.snapshot().unwrap();
        let stand = crowd.clip(crowd.member(member).unwrap().character(), "Stand").unwrap();
        crowd.member_mut(member).unwrap().play(stand, ClipPlayback::looping()).unwrap();
        crowd.update(0.1).unwrap();
        assert_height(&mut crowd, member, 0.0, &at("updated after the snapshot"));
        crowd.restore(&risen).unwrap();
        assert_height(&mut crowd, member, 1.0, &at("restored"));
        crowd.move_to(devices.clone()).unwrap();
        assert_height(&mut crowd, member, 1.0, &at("moved"));
        crowd.update(0.1).unwrap();
        assert_height(&mut crowd, member, 1.0, &at("updated after a move"));

        crowd.despawn(late).unwrap();
        for found in heights(&mut crowd, late) {
            assert_eq!(found, Err(Error::StaleMember), "{}", at("despawned"));
        }
        assert_height(&mut crowd, member, 1.0, &at("another member despawned"));
    }
}

#[test]
fn watch_never_shows_the_previous_joint_of_its_slot() {
    for (devices, schedule) in everywhere() {
        let (mut crowd, member, rise) = crowd_playing_stand(devices.clone(), schedule);
        crowd.member_mut(member).unwrap().play(rise, ClipPlayback::looping()).unwrap();
        let first = crowd.member_mut(member).unwrap().watch_joint(JointIndex(0)).unwrap();
        for _ in 0..2 {
            crowd.update(0.1).unwrap();
            crowd.finish().unwrap();
        }
        assert!(crowd.readback(first).unwrap().is_some(), "{devices}, {schedule}");
        crowd.member_mut(member).unwrap().unwatch_joint(first);
        let other = crowd
            .spawn(crowd.member(member).unwrap().character(), Placement::at([5.0; 3]))
            .unwrap();
        let second = crowd.member_mut(other).unwrap().watch_joint(JointIndex(0)).unwrap();
        assert_eq!(crowd.readback(second), Ok(None), "{devices}, {schedule}");
        crowd.update(0.1).unwrap();
        crowd.finish().unwrap();
        let seen = crowd.readback(second).unwrap().expect("the device has finished");
        assert_eq!(seen.world_from_joint.rows[0][3], 5.0, "{devices}, {schedule}");
    }
}

#[test]
fn reads_do_not_change_later_frames() {
    for (devices, schedule) in everywhere() {
        let turned = |reads: bool| {
            let (mut crowd, member, _) = crowd_playing_stand(devices.clone(), schedule);
            // Fused schedules evaluate members without palette entries only when they are read.
            let bare = crowd.add_character(post(0)).unwrap();
            let bare = crowd.spawn(bare, Placement::at([3.0, 0.0, 1.0])).unwrap();
            let chain = vec![(JointIndex(0), 1.0)];
            let limits = GazeLimits { yaw_rad: 1.5, up_rad: 1.0, down_rad: 1.0 };
            let gaze = Gaze { chain, facing: [0.0, 0.0, 1.0], limits };
            let target = Target::Joint { member: bare, joint: JointIndex(0) };
            crowd
                .member_mut(member)
                .unwrap()
                .look_at_with(&gaze, target, Weight::FULL.over_secs(0.0))
                .unwrap();
            for _ in 0..3 {
                crowd.update(0.1).unwrap();
                if reads {
                    crowd.member_mut(bare).unwrap().model_from_joints().unwrap();
                }
            }
            crowd.member_mut(member).unwrap().palette().unwrap()
        };
        assert_eq!(turned(true), turned(false), "{devices}, {schedule}");
    }
}

/// Whoever reads between updates, as ragdolls do, reads the same before a move and after it.
#[test]
fn results_are_read_after_a_move_as_before_it() {
    for (devices, schedule) in everywhere() {
        let (mut crowd, member, _) = crowd_playing_stand(devices.clone(), schedule);
        crowd.move_to(devices.clone()).unwrap();
        crowd.update(0.3).unwrap();
        let read = |crowd: &mut Crowd| {
            let mut member = crowd.member_mut(member).unwrap();
            (member.model_from_joints().unwrap(), member.palette().unwrap())
        };
        let before = read(&mut crowd);
        let secs = crowd.time_secs();
        crowd.move_to(devices.clone()).unwrap();
        assert_eq!(read(&mut crowd), before, "{devices}, {schedule}");
        assert_eq!(crowd.time_secs().to_bits(), secs.to_bits());
        crowd.move_to(Device::native()).unwrap();
        assert_eq!(read(&mut crowd), before, "{devices}, {schedule}");
    }
}
