//! Feet on the ground.

use populace::character::{Character, CharacterSource};
use populace::model::math::vec3;
use populace::model::{JointSource, Role, RoleMap, Side, Skeleton};
use populace::{ClipPlayback, Feet, Foot, Ground, JointIndex, Placement, Trs};

use crate::body::{axes, character, distance, everywhere, joint, rest_place, skeleton};

pub(crate) fn feet() -> Feet {
    let foot = |side: &str| Foot {
        hip: joint(&format!("{side}UpperLeg")),
        knee: joint(&format!("{side}LowerLeg")),
        ankle: joint(&format!("{side}Foot")),
    };
    Feet { pelvis: joint("hips"), feet: vec![foot("left"), foot("right")], weight: 1.0 }
}

/// Rest height of the ankle in metres.
const ANKLE: f32 = 0.08;

/// Walks a member over a ground and returns how far a foot moved at most from one frame to the next
/// while planted, how long feet were planted, and how near the ankle came to the ground and how far
/// from where it should be while planted.
fn walk(
    stage: &mut crate::body::Stage,
    height: impl Fn(f32, f32) -> f32,
    normal_y: f32,
) -> (f32, u32, f32) {
    let speed = 0.9;
    let at = |secs: f32| {
        let (x, z) = (0.3, -1.0 + speed * secs);
        Placement::at([x, height(x, z), z])
    };
    let member = stage.member(at(0.0));
    let clip = stage.clip("walk");
    stage
        .crowd
        .member_mut(member)
        .expect("a clip that plays")
        .play(clip, ClipPlayback::looping())
        .expect("a clip that plays");
    stage.crowd.member_mut(member).expect("feet").plant_feet_with(&feet()).expect("feet");
    let plain = stage.member(at(0.0));
    stage
        .crowd
        .member_mut(plain)
        .expect("a clip that plays")
        .play(clip, ClipPlayback::looping())
        .expect("a clip that plays");
    let (mut moved, mut planted, mut lifted) = (0.0_f32, 0, 0.0_f32);
    let mut last: [Option<[f32; 3]>; 2] = [None, None];
    for frame in 0..180_u16 {
        stage
            .crowd
            .member_mut(member)
            .expect("a member")
            .set_placement(at(f32::from(frame) / 60.0))
            .expect("a member");
        stage.update(1.0 / 60.0);
        let world = stage.crowd.member(member).expect("a member").placement().world_from_model();
        for (foot, name) in ["leftFoot", "rightFoot"].into_iter().enumerate() {
            let clip_height = stage.place(plain, name)[1];
            let place = world.transform_point(stage.place(member, name));
            // The leg is 0.85 m, and up to 3% of that a foot counts as planted.
            let is_planted = clip_height - ANKLE < 0.025;
            if is_planted {
                planted += 1;
                moved = moved.max(last[foot].map_or(0.0, |last| distance(last, place)));
                lifted =
                    lifted.max((place[1] - height(place[0], place[2]) - ANKLE / normal_y).abs());
            }
            last[foot] = is_planted.then_some(place);
        }
    }
    (moved, planted, lifted)
}

#[test]
fn planted_feet_stay_put_on_level_ground_and_on_a_slope() {
    everywhere(|stage| {
        let slope = 15.0_f32.to_radians().tan();
        for slopes in [[0.0, 0.0], [0.0, slope], [0.0, -slope], [slope * 0.7, slope * 0.7]] {
            stage.crowd.set_ground(&Ground::plane(0.2, slopes).expect("a plane")).expect("ground");
            let normal = vec3::unit_or([-slopes[0], 1.0, -slopes[1]], [0.0; 3]);
            let (moved, planted, lifted) =
                walk(stage, |x, z| 0.2 + slopes[0] * x + slopes[1] * z, normal[1]);
            println!(
                "slopes {slopes:?}: {moved} m a frame in {planted} planted frames, {lifted} m off \
                 the ground"
            );
            assert!(planted > 50, "feet were planted in {planted} frames alone");
            assert!(moved < 0.002, "a planted foot moved {moved} m");
            assert!(lifted < 0.002, "a planted foot was {lifted} m off the ground");
        }
    });
}

#[test]
fn feet_follow_a_height_field() {
    everywhere(|stage| {
        let height = |x: f32, z: f32| 0.1 * (x * 1.3).sin() + 0.08 * (z * 1.7).cos();
        let samples = (0..200_u16).flat_map(|row| {
            (0..60_u16)
                .map(move |column| (f32::from(column) * 0.05 - 1.0, f32::from(row) * 0.05 - 3.0))
        });
        let heights = samples.map(|(x, z)| height(x, z)).collect();
        let ground = Ground::height_field([-1.0, -3.0], 0.05, 60, heights).expect("a height field");
        stage.crowd.set_ground(&ground).expect("ground");
        let (moved, planted, lifted) = walk(stage, height, 1.0);
        println!(
            "heights: {moved} m a frame in {planted} planted frames, {lifted} m off the ground"
        );
        // The ground is interpolated, and its slope is not in what is asked here.
        assert!(moved < 0.002 && planted > 50 && lifted < 0.006, "{moved} {planted} {lifted}");
    });
}

/// The body with feet that hang on its root.
fn with_loose_feet() -> Character {
    let plain = skeleton();
    let joints = plain.joints().map(|joint| {
        let name = plain.name(joint);
        let rest = *plain.rest(joint);
        let loose = Trs {
            translation: rest_place(plain.source_from_joint(joint)),
            rotation: axes(plain.source_from_joint(joint)),
            ..rest
        };
        let parent = plain.parent(joint).map(JointIndex::index);
        if name.ends_with("Foot") {
            JointSource { name: name.into(), parent: Some(0), rest: loose }
        } else {
            JointSource { name: name.into(), parent, rest }
        }
    });
    let skeleton = Skeleton::new(&joints.collect::<Vec<_>>()).expect("joints that are right");
    let was = CharacterSource::clone(&character());
    let entry = |entry: &populace::character::PaletteEntry| populace::character::PaletteEntry {
        joint: skeleton.find(plain.name(entry.joint)).expect("a joint of that name"),
        ..*entry
    };
    let palette = was.palette.iter().map(entry).collect();
    Character::new(CharacterSource { skeleton, palette, ..was }).expect("a good character")
}

/// Hips and legs; the body lacks an arm, so that its roles are not found by themselves.
fn roles(skeleton: &Skeleton) -> RoleMap {
    let leg = |side: Side| [Role::UpperLeg(side), Role::LowerLeg(side), Role::Foot(side)];
    let legs = [leg(Side::Left), leg(Side::Right)].concat();
    let names =
        ["leftUpperLeg", "leftLowerLeg", "leftFoot", "rightUpperLeg", "rightLowerLeg", "rightFoot"];
    let mut all: Vec<_> = legs.into_iter().zip(names).collect();
    all.push((Role::Hips, "hips"));
    RoleMap::from_names(skeleton, &all).expect("hips and legs")
}

#[test]
fn feet_that_hang_elsewhere_are_planted_once_they_hang_on_legs() {
    let loose = with_loose_feet();
    let hung =
        loose.with_feet_on_legs(&roles(&loose.skeleton)).expect("feet that can hang on legs");
    // It is the body that it was made of, joint for joint.
    let plain = character();
    assert_eq!(hung.palette.len(), plain.palette.len());
    for joint in plain.skeleton.joints() {
        let found = hung.skeleton.find(plain.skeleton.name(joint)).expect("a joint of that name");
        let parent = |skeleton: &Skeleton, joint| {
            skeleton.parent(joint).map(|p| skeleton.name(p).to_owned())
        };
        assert_eq!(parent(&hung.skeleton, found), parent(&plain.skeleton, joint));
        let (a, b) = (hung.skeleton.rest(found), plain.skeleton.rest(joint));
        assert!(distance(a.translation, b.translation) < 1e-5, "{a:?} {b:?}");
    }
    everywhere(|stage| {
        let slopes = [0.0, 0.2];
        stage.crowd.set_ground(&Ground::plane(0.2, slopes).expect("a plane")).expect("ground");
        let at = Placement::at([0.3, 0.2, 0.0]);
        let mut planted = |character: Character| {
            let roles = roles(&character.skeleton);
            let id = stage.crowd.add_character(character).expect("room");
            stage.crowd.set_roles(id, roles).expect("roles of its own");
            let walk = stage.crowd.clip(id, "walk").expect("a clip of that name");
            let member = stage.crowd.spawn(id, at).expect("room");
            stage
                .crowd
                .member_mut(member)
                .expect("a clip that plays")
                .play(walk, ClipPlayback::looping())
                .expect("a clip that plays");
            stage
                .crowd
                .member_mut(member)
                .and_then(|mut m| m.plant_feet(1.0))
                .map(|()| (id, member))
        };
        let refused = planted(loose.clone()).expect_err("feet would stay behind").to_string();
        assert!(refused.contains("with_feet_on_legs"), "{refused}");
        let members = [hung.clone(), character()].map(|body| planted(body).expect("feet"));
        for _ in 0..20 {
            stage.update(0.05);
            let feet = members.map(|(id, member)| {
                let foot = stage
                    .crowd
                    .character(id)
                    .expect("it")
                    .skeleton
                    .find("leftFoot")
                    .expect("a foot");
                stage.models(member)[foot.index()].origin()
            });
            assert!(distance(feet[0], feet[1]) < 1e-4, "{feet:?}");
        }
    });
}
