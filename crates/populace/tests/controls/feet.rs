//! Foot planting.

use populace::character::{Character, CharacterSource};
use populace::model::math::vec3;
use populace::model::{JointSource, Role, RoleMap, Side, Skeleton};
use populace::{
    Affine, ClipPlayback, Contact, Feet, Foot, Ground, JointIndex, Placement, Stride, Trs,
};

use crate::fixture::{
    axes, character, distance, everywhere, joint, rest_position, skeleton, with_soles,
};

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

/// Walks a member over a ground. Returns the largest movement of a planted foot per frame in
/// metres, the number of planted foot frames, and the largest error of the ankle height of planted
/// feet in metres.
fn walk(
    scene: &mut crate::fixture::Scene,
    height: impl Fn(f32, f32) -> f32,
    normal_y: f32,
) -> (f32, u32, f32) {
    let speed = 0.9;
    let at = |secs: f32| {
        let (x, z) = (0.3, -1.0 + speed * secs);
        Placement::at([x, height(x, z), z])
    };
    let member = scene.member(at(0.0));
    let clip = scene.clip("walk");
    scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
    scene.edit(member).plant_feet_with(&feet()).expect("feet");
    let plain = scene.member(at(0.0));
    scene.edit(plain).play(clip, ClipPlayback::looping()).expect("a clip that plays");
    let (mut moved, mut planted, mut lifted) = (0.0_f32, 0, 0.0_f32);
    let mut last: [Option<[f32; 3]>; 2] = [None, None];
    for frame in 0..180_u16 {
        scene.edit(member).set_placement(at(f32::from(frame) / 60.0)).expect("a member");
        scene.update(1.0 / 60.0);
        let world = scene.crowd.member(member).expect("a member").placement().world_from_model();
        for (foot, name) in ["leftFoot", "rightFoot"].into_iter().enumerate() {
            let clip_height = scene.position(plain, name)[1];
            let place = world.transform_point(scene.position(member, name));
            // A foot counts as planted up to 3% of the leg length of 0.85 m.
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
fn planted_feet_stay_put_on_level_and_sloped_ground() {
    everywhere(|scene| {
        let slope = 15.0_f32.to_radians().tan();
        for slopes in [[0.0, 0.0], [0.0, slope], [0.0, -slope], [slope * 0.7, slope * 0.7]] {
            scene.crowd.set_ground(&Ground::plane(0.2, slopes).expect("a plane")).expect("ground");
            let normal = vec3::unit_or([-slopes[0], 1.0, -slopes[1]], [0.0; 3]);
            let (moved, planted, lifted) =
                walk(scene, |x, z| 0.2 + slopes[0] * x + slopes[1] * z, normal[1]);
            println!(
                "slopes {slopes:?}: {moved} m per frame, {planted} planted frames, {lifted} m off"
            );
            assert!(planted > 50, "feet were planted in {planted} frames only");
            assert!(moved < 0.002, "a planted foot moved {moved} m");
            assert!(lifted < 0.002, "a planted foot was {lifted} m off the ground");
        }
    });
}

#[test]
fn planted_feet_follow_a_height_field() {
    everywhere(|scene| {
        let height = |x: f32, z: f32| 0.1 * (x * 1.3).sin() + 0.08 * (z * 1.7).cos();
        let samples = (0..200_u16).flat_map(|row| {
            (0..60_u16)
                .map(move |column| (f32::from(column) * 0.05 - 1.0, f32::from(row) * 0.05 - 3.0))
        });
        let heights = samples.map(|(x, z)| height(x, z)).collect();
        let ground = Ground::height_field([-1.0, -3.0], 0.05, 60, heights).expect("a height field");
        scene.crowd.set_ground(&ground).expect("ground");
        let (moved, planted, lifted) = walk(scene, height, 1.0);
        println!("heights: {moved} m per frame, {planted} planted frames, {lifted} m off");
        // The bounds allow for interpolation of the heights; `walk` does not know the ground's
        // slope.
        assert!(moved < 0.002 && planted > 50 && lifted < 0.006, "{moved} {planted} {lifted}");
    });
}

/// Contacts of both feet of the clip "walk", on the ends of which the ankle is well above its
/// height at rest.
fn contacts() -> [Contact; 2] {
    [("leftFoot", 0.8), ("rightFoot", 0.3)].map(|(name, from_secs)| Contact {
        ankle: joint(name),
        from_secs,
        until_secs: from_secs + 0.4,
    })
}

/// Contacts of both feet from the beginning of a clip until a time in seconds.
fn contacts_until(until_secs: f32) -> [Contact; 2] {
    contacts().map(|contact| Contact { from_secs: 0.0, until_secs, ..contact })
}

#[test]
fn feet_lock_from_contact_to_lift_off() {
    everywhere(|scene| {
        let (clip, body) = (scene.clip("walk"), scene.body);
        let mut character = scene.crowd.character_mut(body).expect("a character");
        character.set_contacts(clip, &contacts()).expect("contacts within the clip");
        let at = |secs: f32| Placement::at([0.3, 0.0, 1.1 * secs]).facing(0.2 * secs);
        let member = scene.member(at(0.0));
        scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
        scene.edit(member).plant_feet_with(&feet()).expect("feet");
        let mut places = Vec::new();
        for frame in 0..120_u8 {
            let secs = f32::from(frame) / 60.0;
            scene.edit(member).set_placement(at(secs)).expect("a member");
            scene.update(if frame == 0 { 0.0 } else { 1.0 / 60.0 });
            let world =
                scene.crowd.member(member).expect("a member").placement().world_from_model();
            let place = |name| world.transform_point(scene.position(member, name));
            places.push((secs, ["leftFoot", "rightFoot"].map(place)));
        }
        for (foot, contact) in contacts().iter().enumerate() {
            let stands = |secs: f32| {
                let within = (secs - contact.from_secs).rem_euclid(1.0);
                within > 0.001 && within < contact.until_secs - contact.from_secs - 0.001
            };
            let (mut held, mut swung) = (0, 0.0_f32);
            for pair in places.windows(2) {
                let moved = distance(pair[0].1[foot], pair[1].1[foot]);
                if stands(pair[0].0) && stands(pair[1].0) {
                    held += 1;
                    assert!(moved < 1e-4, "foot {foot} moved {moved} m at {} s", pair[1].0);
                    let height = pair[1].1[foot][1];
                    assert!((height - ANKLE).abs() < 1e-4, "foot {foot} is at {height} m");
                } else {
                    swung = swung.max(moved);
                }
            }
            assert!(held > 40 && swung > 0.02, "{held} frames held, {swung} m at most");
        }
    });
}

#[test]
fn sole_rolls_over_the_point_that_stands() {
    everywhere(|scene| {
        let soled = scene.crowd.add_character(with_soles()).expect("enough capacity");
        // The whole leg swings, so the foot pitches from heel to toes.
        let clip = scene.clip("walk");
        let whole = contacts_until(1.0);
        let mut character = scene.crowd.character_mut(soled).expect("a character");
        character.set_contacts(clip, &whole).expect("contacts within the clip");
        let member = scene.crowd.spawn(soled, Placement::at([0.0; 3])).expect("enough capacity");
        scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
        scene.edit(member).plant_feet_with(&feet()).expect("feet");
        let rest = scene.crowd.character(soled).expect("a character").asset().skeleton.clone();
        let foot = joint("leftFoot");
        let rest_foot = rest.rest_model(foot);
        let in_foot: Vec<_> =
            rest.soles(foot).iter().map(|point| to_joint(&rest_foot, *point)).collect();
        let (mut heel, mut toes, mut stepping) = (0, 0, 0);
        for _ in 0..60 {
            scene.update(1.0 / 60.0);
            let model = scene.models(member)[foot.index()];
            let points: Vec<_> =
                in_foot.iter().map(|point| model.transform_point(*point)).collect();
            let lowest = (0..points.len()).min_by(|a, b| points[*a][1].total_cmp(&points[*b][1]));
            let lowest = lowest.expect("points");
            let height = points[lowest][1];
            if height > 2e-3 {
                // The leg swings farther than it reaches the ground.
                assert!(height < 0.03, "the sole is {height} m above the ground");
                stepping += 1;
                continue;
            }
            assert!(height > -2e-3, "the sole is {height} m above the ground");
            heel += u32::from(lowest == 0);
            toes += u32::from(lowest == points.len() - 1);
        }
        assert!(heel > 5 && toes > 5, "{heel} frames on the heel, {toes} on the toes");
        assert!(stepping < 15, "{stepping} frames in the air");
    });
}

/// Nothing but time ends the contacts of a body that stands: its feet step below it one by one.
#[test]
fn feet_of_who_stands_step_below_the_body() {
    everywhere(|scene| {
        let (clip, body) = (scene.clip("stand"), scene.body);
        let whole = contacts_until(1.0);
        let mut character = scene.crowd.character_mut(body).expect("a character");
        character.set_contacts(clip, &whole).expect("contacts within the clip");
        let member = scene.member(Placement::at([0.0; 3]));
        scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
        scene.edit(member).plant_feet_with(&feet()).expect("feet");
        (0..30).for_each(|_| scene.update(1.0 / 60.0));
        scene.edit(member).set_placement(Placement::at([0.0, 0.0, 0.2])).expect("a member");
        let (mut stepping, mut highest) = ([0; 2], [0.0_f32; 2]);
        for frame in 0..120 {
            scene.update(1.0 / 60.0);
            let feet = ["leftFoot", "rightFoot"].map(|name| scene.position(member, name));
            let lags = feet.map(|[_, _, z]| z < -0.19);
            assert!(frame > 3 || lags == [true; 2], "{feet:?}");
            let in_air = feet.map(|[_, y, _]| y > ANKLE + 5e-3);
            assert_ne!(in_air, [true; 2], "both are in the air in frame {frame}");
            for foot in 0..2 {
                stepping[foot] += u32::from(in_air[foot]);
                highest[foot] = highest[foot].max(feet[foot][1] - ANKLE);
            }
        }
        let feet = ["leftFoot", "rightFoot"].map(|name| scene.position(member, name));
        assert!(feet.iter().all(|[_, _, z]| z.abs() < 0.06), "{feet:?}");
        assert!(stepping.iter().all(|frames| (6..30).contains(frames)), "{stepping:?} frames");
        assert!(highest.iter().all(|height| (0.01..0.05).contains(height)), "{highest:?} m");
    });
}

/// A step up along +Z: 15 cm from z = 0 to z = 5 cm.
fn step() -> Ground {
    let heights = (0..80_u16).flat_map(|row| [if row > 40 { 0.15 } else { 0.0 }; 2]).collect();
    Ground::height_field([-2.0, -2.0], 0.05, 2, heights).expect("a height field")
}

#[test]
fn soles_stand_on_what_they_meet_of_a_step() {
    everywhere(|scene| {
        scene.crowd.set_ground(&step()).expect("ground");
        let soled = scene.crowd.add_character(with_soles()).expect("enough capacity");
        let skeleton = scene.crowd.character(soled).expect("a character").asset().skeleton.clone();
        let mut lifted = 0;
        for nth in 0..12_u8 {
            let z = 0.03 * f32::from(nth) - 0.25;
            let placement = Placement::at([0.0, 0.0, z]).facing(0.3);
            let member = scene.crowd.spawn(soled, placement).expect("enough capacity");
            scene.edit(member).plant_feet_with(&feet()).expect("feet");
            scene.update(1.0 / 60.0);
            let world = placement.world_from_model();
            for foot in ["leftFoot", "rightFoot"].map(joint) {
                let (rest, model) = (skeleton.rest_model(foot), scene.models(member)[foot.index()]);
                let points = skeleton.soles(foot).iter().map(|point| {
                    let at = model.transform_point(to_joint(&rest, *point));
                    let [x, y, z] = world.transform_point(at);
                    (y, y - step().height_at(x, z))
                });
                let points: Vec<_> = points.collect();
                let least = points.iter().map(|point| point.1).fold(f32::INFINITY, f32::min);
                assert!(least.abs() < 2e-3, "at {z} m a sole is {least} m above the ground");
                lifted += u32::from(points[0].0 > 0.1 && points[0].1 > 0.1);
            }
            scene.crowd.despawn(member).expect("a member");
        }
        assert!(lifted > 3, "{lifted} heels are over the lower side");
    });
}

/// Returns a point of model space in the space of a joint without scale.
fn to_joint(model_from_joint: &Affine, point: [f32; 3]) -> [f32; 3] {
    let from = vec3::sub(point, model_from_joint.origin());
    [0, 1, 2].map(|axis: usize| {
        (0..3).map(|row: usize| model_from_joint.rows[row][axis] * from[row]).sum()
    })
}

#[test]
fn strides_scale_turn_and_follow_directions() {
    everywhere(|scene| {
        let (clip, body) = (scene.clip("walk"), scene.body);
        // No foot ever stands, so that positions are those of the strides.
        let never = contacts_until(0.0);
        let mut character = scene.crowd.character_mut(body).expect("a character");
        character.set_contacts(clip, &never).expect("contacts within the clip");
        let strides = [
            Stride::OF_CLIPS,
            Stride::along([0.0, 0.0]),
            Stride::along([0.0, -0.5]),
            Stride::along([0.9, 0.4]),
            Stride::OF_CLIPS.turning_rad_per_m(1.5),
        ];
        let members = strides.map(|stride| {
            let member = scene.member(Placement::at([0.0; 3]));
            scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
            scene.edit(member).plant_feet_with(&feet()).expect("feet");
            scene.edit(member).set_stride(stride).expect("finite numbers");
            member
        });
        let [_, _, rest_z] = rest_position(15);
        for _ in 0..10 {
            scene.update(0.1);
            let [own, on_the_spot, back, aside, turned] =
                members.map(|member| scene.position(member, "leftFoot"));
            let step = own[2] - rest_z;
            let wanted = |x: f32, z: f32| [x, own[1], z];
            for (what, found, wanted) in [
                ("on the spot", on_the_spot, wanted(own[0], rest_z)),
                ("back", back, wanted(own[0], rest_z - 0.5 * step)),
                ("aside", aside, wanted(own[0] + step * 0.9, rest_z + step * 0.4)),
            ] {
                let apart = distance(found, wanted);
                assert!(apart < 0.01, "{what}: {found:?}, but {wanted:?} is wanted");
            }
            let angle = |at: [f32; 3]| at[0].atan2(at[2]);
            let by = angle(turned) - angle(own);
            assert!((by - 1.5 * step).abs() < 0.03 || step.abs() < 0.05, "{by} at {step}");
        }
    });
}

/// The humanoid with feet that are children of the root.
fn with_feet_on_root() -> Character {
    let plain = skeleton();
    let joints = plain.joints().map(|joint| {
        let name = plain.name(joint);
        let rest = *plain.rest(joint);
        let loose = Trs {
            translation: rest_position(plain.source_from_joint(joint)),
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
    let skeleton = Skeleton::new(&joints.collect::<Vec<_>>()).expect("valid joints");
    let source = CharacterSource::clone(&character());
    let entry = |entry: &populace::character::PaletteEntry| populace::character::PaletteEntry {
        joint: skeleton.find(plain.name(entry.joint)).expect("a joint of that name"),
        ..*entry
    };
    let palette = source.palette.iter().map(entry).collect();
    Character::new(CharacterSource { skeleton, palette, ..source }).expect("a good character")
}

/// Roles of hips and legs. The humanoid lacks an arm, so its roles are not detected.
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
fn feet_outside_legs_are_planted_after_reparenting() {
    let loose = with_feet_on_root();
    let reparented =
        loose.with_feet_on_legs(&roles(&loose.skeleton)).expect("feet that can be reparented");
    // Reparenting gives the skeleton of the plain humanoid, joint for joint.
    let plain = character();
    assert_eq!(reparented.palette.len(), plain.palette.len());
    for joint in plain.skeleton.joints() {
        let found =
            reparented.skeleton.find(plain.skeleton.name(joint)).expect("a joint of that name");
        let parent = |skeleton: &Skeleton, joint| {
            skeleton.parent(joint).map(|p| skeleton.name(p).to_owned())
        };
        assert_eq!(parent(&reparented.skeleton, found), parent(&plain.skeleton, joint));
        let (a, b) = (reparented.skeleton.rest(found), plain.skeleton.rest(joint));
        assert!(distance(a.translation, b.translation) < 1e-5, "{a:?} {b:?}");
    }
    everywhere(|scene| {
        let slopes = [0.0, 0.2];
        scene.crowd.set_ground(&Ground::plane(0.2, slopes).expect("a plane")).expect("ground");
        let at = Placement::at([0.3, 0.2, 0.0]);
        let mut planted = |character: Character| {
            let roles = roles(&character.skeleton);
            let id = scene.crowd.add_character(character).expect("enough capacity");
            scene
                .crowd
                .character_mut(id)
                .expect("roles of its own")
                .set_roles(roles)
                .expect("roles of its own");
            let walk = scene.crowd.clip(id, "walk").expect("a clip of that name");
            let member = scene.crowd.spawn(id, at).expect("enough capacity");
            scene.edit(member).play(walk, ClipPlayback::looping()).expect("a clip that plays");
            scene
                .crowd
                .member_mut(member)
                .and_then(|mut m| m.plant_feet(1.0))
                .map(|()| (id, member))
        };
        let refused = planted(loose.clone()).expect_err("feet outside the legs").to_string();
        assert!(refused.contains("with_feet_on_legs"), "{refused}");
        let members = [reparented.clone(), character()].map(|body| planted(body).expect("feet"));
        for _ in 0..20 {
            scene.update(0.05);
            let feet = members.map(|(id, member)| {
                let foot = scene
                    .crowd
                    .character(id)
                    .expect("the character")
                    .asset()
                    .skeleton
                    .find("leftFoot")
                    .expect("a foot");
                scene.models(member)[foot.index()].origin()
            });
            assert!(distance(feet[0], feet[1]) < 1e-4, "{feet:?}");
        }
    });
}
