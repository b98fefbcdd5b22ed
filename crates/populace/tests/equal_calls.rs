//! Equal calls on two crowds give equal palettes, whatever order hash maps iterate in.

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::model::{JointSource, Skeleton};
use populace::{
    Affine, Crowd, Device, Gaze, GazeLimits, JointIndex, MemberId, Placement, Target, Trs, Weight,
};

const JOINTS: u32 = 8;

/// A chain of joints, each a little to the side of its parent.
fn chain() -> Character {
    let joint = |index: u32| JointSource {
        name: format!("joint {index}"),
        parent: index.checked_sub(1).map(|parent| parent as usize),
        rest: Trs { translation: [0.1 * index as f32, 0.2, 0.0], ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&(0..JOINTS).map(joint).collect::<Vec<_>>()).expect("a good call");
    let palette =
        skeleton.joints().map(|joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY });
    let (palette, parts, materials, images, skins, clips) =
        (palette.collect(), vec![], vec![], vec![], vec![], vec![]);
    let name = "chain".into();
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

fn watch_all(crowd: &mut Crowd, member: MemberId) {
    for joint in 0..JOINTS {
        crowd
            .member_mut(member)
            .expect("a good call")
            .watch_joint(JointIndex(joint))
            .expect("a good call");
    }
}

/// Returns the palette of a member in the frame in which it starts to look at a joint of another
/// member. Before that, a member with watches on all joints is despawned.
fn palette_after_despawning_a_watched_member() -> Vec<Affine> {
    let mut crowd =
        Crowd::builder().device(Device::Native { threads: 1 }).build().expect("a good call");
    let chain = crowd.add_character(chain()).expect("a good call");
    let at = |x: f32| Placement::at([x, 0.0, 2.0 - x]);
    let [leaving, looking, other] =
        [0.0, 1.0, 2.0].map(|x| crowd.spawn(chain, at(x)).expect("a good call"));
    watch_all(&mut crowd, leaving);
    crowd.member_mut(other).expect("a good call").watch_joint(JointIndex(0)).expect("a good call");
    crowd.update(0.1).expect("a good call");
    crowd.despawn(leaving).expect("a good call");
    let limits = GazeLimits { yaw_rad: 1.5, up_rad: 1.0, down_rad: 1.0 };
    let chain = vec![(JointIndex(1), 1.0)];
    let gaze = Gaze { chain, facing: [0.0, 0.0, 1.0], limits };
    let target = Target::Joint { member: other, joint: JointIndex(3) };
    crowd
        .member_mut(looking)
        .expect("a good call")
        .look_at_with(&gaze, target, Weight::FULL.over_secs(0.0))
        .expect("a good call");
    crowd.update(0.1).expect("a good call");
    crowd.member_mut(looking).expect("a good call").palette().expect("a good call")
}

#[test]
fn equal_calls_give_equal_palettes_after_a_watched_despawn() {
    let first = palette_after_despawning_a_watched_member();
    for _ in 0..8 {
        assert_eq!(palette_after_despawning_a_watched_member(), first);
    }
    let turned = first[1].rows[0][2].abs() + first[1].rows[1][2].abs();
    assert!(
        turned < 1e-6,
        "the gaze turned by {turned} although its target has not been evaluated yet"
    );
}
