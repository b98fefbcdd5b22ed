//! Blend spaces of characters whose roles change meanwhile.

use std::sync::Arc;

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::model::{
    ClipSource, Interpolation, JointSource, Property, Role, RoleMap, Side, Skeleton, Track,
};
use populace::{
    Affine, BlendSpace, BlendSpacePlayback, Crowd, Device, JointIndex, MemberId, Placement, Trs,
};

const JOINTS: [(&str, Option<usize>, [f32; 3]); 7] = [
    ("middle", None, [0.0, 1.0, 0.0]),
    ("one a", Some(0), [0.1, 0.0, 0.0]),
    ("one b", Some(1), [0.0, -0.5, 0.0]),
    ("one c", Some(2), [0.0, -0.5, 0.0]),
    ("other a", Some(0), [-0.1, 0.0, 0.0]),
    ("other b", Some(4), [0.0, -0.5, 0.0]),
    ("other c", Some(5), [0.0, -0.5, 0.0]),
];

/// A body of hips and legs whose names tell no roles, and two clips: "low" lifts the hips to 1.2 m
/// and "high" to 1.5 m.
fn body() -> Character {
    let joint = |(name, parent, translation): (&str, _, _)| {
        let rest = Trs { translation, ..Trs::IDENTITY };
        JointSource { name: name.into(), parent, rest }
    };
    let skeleton = Skeleton::new(&JOINTS.map(joint)).unwrap();
    let clip = |(name, height): (&str, f32)| {
        let track = Track {
            joint: "middle".into(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0],
            values: vec![0.0, height, 0.0, 0.0, height + 0.01, 0.0],
        };
        let source = ClipSource { name: name.into(), tracks: vec![track] };
        Arc::new(Clip::new(source, &skeleton).unwrap())
    };
    let clips = [("low", 1.2), ("high", 1.5)].map(clip).into();
    let entry = |joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY };
    let palette = skeleton.joints().map(entry).collect();
    let (parts, materials, images, skins) = (vec![], vec![], vec![], vec![]);
    let name = "body".into();
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

fn roles(skeleton: &Skeleton) -> RoleMap {
    let leg = |side| [Role::UpperLeg(side), Role::LowerLeg(side), Role::Foot(side)];
    let legs = [leg(Side::Left), leg(Side::Right)].concat();
    let mut all = vec![(Role::Hips, "middle")];
    all.extend(legs.into_iter().zip(JOINTS[1..].iter().map(|joint| joint.0)));
    RoleMap::from_names(skeleton, &all).unwrap()
}

/// Plays the clips as a blend space from `after_secs` on, and calls `change` with the roles of the
/// body. Returns the crowd, with the blend space at its first clip, and the member.
fn in_a_space(
    after_secs: f32,
    change: impl Fn(&mut Crowd, MemberId, RoleMap),
) -> (Crowd, MemberId) {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let id = crowd.add_character(body()).unwrap();
    let [low, high] = ["low", "high"].map(|name| crowd.clip(id, name).unwrap());
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    let space = BlendSpace::line(&[(low, 0.0), (high, 1.0)]).unwrap();
    let space = crowd.add_blend_space(space).unwrap();
    let play = BlendSpacePlayback::new().after_secs(after_secs);
    crowd.member_mut(member).unwrap().play_blend_space(space, 0.0, play).unwrap();
    crowd.update(0.1).unwrap();
    let roles = roles(&crowd.character(id).unwrap().asset().skeleton);
    change(&mut crowd, member, roles);
    crowd.update(0.4).unwrap();
    (crowd, member)
}

#[track_caller]
fn assert_height(crowd: &mut Crowd, member: MemberId, wanted: f32) {
    let joints = crowd.member_mut(member).unwrap().model_from_joints().unwrap();
    let height = joints[JointIndex(0).index()].rows[1][3];
    assert!((height - wanted).abs() < 0.02, "the hips are at {height} m instead of {wanted}");
}

#[test]
fn blend_spaces_go_on_after_roles_have_changed() {
    let of_character = |crowd: &mut Crowd, member, roles| {
        let id = crowd.member(member).unwrap().character();
        crowd.character_mut(id).unwrap().set_roles(roles).unwrap();
    };
    let of_clips = |crowd: &mut Crowd, member, roles: RoleMap| {
        let id = crowd.member(member).unwrap().character();
        for (clip, _) in crowd.character(id).unwrap().clips() {
            crowd.clip_mut(clip).unwrap().set_roles(roles.clone()).unwrap();
        }
    };
    for after_secs in [0.0, 0.3] {
        for (mut crowd, member) in
            [in_a_space(after_secs, of_character), in_a_space(after_secs, of_clips)]
        {
            assert_height(&mut crowd, member, 1.2);
            crowd.member_mut(member).unwrap().set_blend_parameter(1.0, 0.1).unwrap();
            crowd.update(0.3).unwrap();
            assert_height(&mut crowd, member, 1.5);
        }
    }
}
