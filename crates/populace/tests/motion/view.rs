//! Views and lists of members that root motion moves.

use populace::interop::{View, Visibility};
use populace::{ClipPlayback, Crowd, Device, MemberId, Placement, Schedule, VisibleMember};

use super::fixture::{Scene, distance, everywhere, scene};
use super::{add, straight, walker};

/// A view of all that is less than 5 m from the origin along x and z.
fn box_of_ten_metres() -> View {
    View {
        eye: [0.0, 3.0, 0.0],
        planes: [
            [1.0, 0.0, 0.0, 5.0],
            [-1.0, 0.0, 0.0, 5.0],
            [0.0, 0.0, 1.0, 5.0],
            [0.0, 0.0, -1.0, 5.0],
            [0.0, 1.0, 0.0, 5.0],
        ],
        pixels_per_metre: 1000.0,
        to_sun: None,
        error_px: 1.0,
    }
}

/// A member that walks at 4 m/s from 12 m before the middle of the view.
fn passer_by(scene: &mut Scene) -> MemberId {
    let (_, walk) = add(scene, straight("walk ahead", 4.0));
    let member = scene.member(Placement::at([0.0, 0.0, -12.0]));
    scene.edit(member).play(walk, ClipPlayback::looping()).expect("a clip");
    scene.edit(member).start_root_motion().expect("a member");
    scene.crowd.set_view(Some(box_of_ten_metres())).expect("a view");
    member
}

/// Returns what a renderer draws.
fn listed(crowd: &Crowd) -> Vec<VisibleMember> {
    let mut list = Vec::new();
    crowd.visible_members(&mut list);
    list
}

/// Returns the frames, of six seconds at 10 Hz, in which the passer-by is listed. `after_update`
/// may wait for the device.
fn listed_frames(scene: &mut Scene, after_update: impl Fn(&mut Scene, MemberId)) -> Vec<u8> {
    let member = passer_by(scene);
    let frames = (1..=60_u8).filter(|_| {
        scene.update(0.1);
        after_update(scene, member);
        !listed(&scene.crowd).is_empty()
    });
    frames.collect()
}

/// The member is within 5 m of the origin from frame 18 to frame 42. Its sphere reaches farther.
fn assert_walks_through(frames: &[u8]) {
    let (first, last) = (frames.first().copied(), frames.last().copied());
    assert!(first.is_some_and(|first| (12..=19).contains(&first)), "{frames:?}");
    assert!(last.is_some_and(|last| (42..=51).contains(&last)), "{frames:?}");
}

/// Checks that the same frames list the passer-by everywhere.
fn assert_same_frames(after_update: fn(&mut Scene, MemberId)) {
    let mut native = scene(Device::native(), Schedule::Fused);
    let wanted = listed_frames(&mut native, |_, _| ());
    assert_walks_through(&wanted);
    everywhere(|scene| assert_eq!(listed_frames(scene, after_update), wanted));
}

#[test]
fn members_that_walk_into_view_are_drawn_without_any_read() {
    assert_same_frames(|_, _| ());
}

#[test]
fn members_that_walk_into_view_are_drawn_after_reads() {
    assert_same_frames(|scene, member| {
        scene.edit(member).moved_placement().expect("a member");
    });
}

#[test]
fn spheres_go_where_root_motion_goes() {
    let read: [fn(&mut Scene, MemberId); 4] = [
        |scene, member| drop(scene.edit(member).palette().expect("a palette")),
        |scene, member| drop(scene.models(member)),
        |scene, member| {
            let mut models = [populace::Affine::IDENTITY];
            let joints = [(member, populace::JointIndex(0))];
            scene.crowd.read_joints(&joints, &mut models).expect("a joint");
        },
        |scene, member| {
            scene.edit(member).moved_placement().expect("a member");
        },
    ];
    for reader in read {
        everywhere(|scene| {
            let (_, walk) = add(scene, straight("walk ahead", 4.0));
            let member = walker(scene, walk);
            scene.update(0.5);
            let before = scene.crowd.member(member).expect("a member").bounding_sphere().0;
            scene.update(2.0);
            reader(scene, member);
            let seen = scene.crowd.member(member).expect("a member");
            let ((after, radius_m), moved) = (seen.bounding_sphere(), seen.instance().moved);
            assert!(distance(moved, [0.0, 0.0, 10.0]) < 0.01, "{moved:?}");
            assert!((7.9..10.1).contains(&distance(before, after)), "{before:?} {after:?}");
            let list = listed(&scene.crowd);
            assert_eq!((list[0].center, list[0].radius_m), (after, radius_m));
        });
    }
}

#[test]
fn a_restored_crowd_chooses_the_same_members() {
    let mut scene = scene(Device::native(), Schedule::Fused);
    let member = passer_by(&mut scene);
    for _ in 0..14 {
        scene.update(0.1);
    }
    let snapshot = scene.crowd.snapshot().expect("a snapshot");
    let go_on = |scene: &mut Scene| -> Vec<Visibility> {
        let seen = (0..8).map(|_| {
            scene.update(0.1);
            scene.crowd.member(member).expect("a member").instance().visibility
        });
        seen.collect()
    };
    let first = go_on(&mut scene);
    assert!(first.contains(&Visibility::InView), "{first:?}");
    scene.crowd.restore(&snapshot).expect("a snapshot of this crowd");
    assert_eq!(go_on(&mut scene), first);
}
