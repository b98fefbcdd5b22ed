//! Live clips on bodies with other joints than the clip's own.

use populace::character::Character;
use populace::model::math::quat;
use populace::model::{JointSource, Role, RoleMap, Side, Skeleton};
use populace::{
    Affine, CharacterId, ClipId, ClipPlayback, LayerMode, LayerSettings, LiveSettings, MemberId,
    Placement, Streamed, Trs,
};

use super::fixture::{self, Scene, everywhere, skeleton};
use super::{followers, pose, recorded, settings, stream_evenly};

/// Returns a character with bones 1.3 times as long.
fn longer_character() -> Character {
    let own = skeleton();
    let joint = |joint: populace::JointIndex| {
        let mut rest = *own.rest(joint);
        rest.translation = rest.translation.map(|c| 1.3 * c);
        JointSource {
            name: own.name(joint).into(),
            parent: own.parent(joint).map(|p| p.index()),
            rest,
        }
    };
    let joints: Vec<_> = own.joints().map(joint).collect();
    fixture::bare("longer", Skeleton::new(&joints).expect("a skeleton"), Vec::new())
}

/// Returns a character with the same joints, of which siblings come in the opposite order.
fn mirrored_character() -> Character {
    let own = skeleton();
    let mut order: Vec<populace::JointIndex> = Vec::new();
    let mut next = vec![None];
    while let Some(parent) = next.pop() {
        order.extend(parent);
        let of: Vec<_> = own.joints().filter(|joint| own.parent(*joint) == parent).collect();
        next.extend(of.into_iter().map(Some));
    }
    let place = |joint| order.iter().position(|other| *other == joint);
    let joint = |joint: &populace::JointIndex| JointSource {
        name: own.name(*joint).into(),
        parent: own.parent(*joint).and_then(place),
        rest: *own.rest(*joint),
    };
    let joints: Vec<_> = order.iter().map(joint).collect();
    fixture::bare("mirrored", Skeleton::new(&joints).expect("a skeleton"), Vec::new())
}

/// Roles of hips and legs, the only limbs that the humanoid has in full.
fn legs(skeleton: &Skeleton) -> RoleMap {
    let (left, right) = (Side::Left, Side::Right);
    let roles = [
        (Role::Hips, "hips"),
        (Role::UpperLeg(left), "leftUpperLeg"),
        (Role::LowerLeg(left), "leftLowerLeg"),
        (Role::Foot(left), "leftFoot"),
        (Role::UpperLeg(right), "rightUpperLeg"),
        (Role::LowerLeg(right), "rightLowerLeg"),
        (Role::Foot(right), "rightFoot"),
    ];
    RoleMap::from_names(skeleton, &roles).expect("joints of those names")
}

#[test]
fn live_clip_is_retargeted_to_other_characters() {
    everywhere(|scene| {
        let other = scene.crowd.add_character(longer_character()).expect("enough capacity");
        for character in [scene.body, other] {
            let skeleton =
                scene.crowd.character(character).expect("a character").asset().skeleton.clone();
            scene
                .crowd
                .character_mut(character)
                .expect("its roles")
                .set_roles(legs(&skeleton))
                .expect("its roles");
        }
        let (live, _) = followers(scene, 2.0, &[]);
        let clip = recorded(scene);
        let members = [0, 1]
            .map(|_| scene.crowd.spawn(other, Placement::at([0.0; 3])).expect("enough capacity"));
        scene.edit(members[0]).play(live, ClipPlayback::live(0.3)).expect("a live clip");
        let now = stream_evenly(scene, live, 40, |_, _, _| {});
        let held = ClipPlayback::held_at_secs((now - f64::from(0.3_f32)) as f32);
        scene.edit(members[1]).play(clip, held).expect("a clip");
        scene.update(0.0);
        let [found, wanted] = members.map(|member| scene.models(member));
        let hips = fixture::joint("hips").index();
        let from_hips = |all: &[Affine], m: &Affine| {
            let (a, b) = (m.origin(), all[hips].origin());
            [0, 1, 2].map(|i| a[i] - b[i])
        };
        for (a, b) in found.iter().zip(&wanted).skip(1) {
            assert!(fixture::turn_deg(a, b) < 0.1, "{a:?} {b:?}");
            let [a, b] = [from_hips(&found, a), from_hips(&wanted, b)];
            assert!(fixture::distance(a, b) < 1e-3, "{a:?} {b:?}");
        }
        let [knee, hip] = ["leftLowerLeg", "leftUpperLeg"]
            .map(|name| found[fixture::joint(name).index()].origin());
        let thigh = skeleton().rest(fixture::joint("leftLowerLeg")).translation;
        let longer = fixture::distance(knee, hip) / fixture::distance(thigh, [0.0; 3]);
        assert!((longer - 1.3).abs() < 1e-3, "the leg is {longer} times as long, not 1.3 times");
    });
}

/// Adds a character with roles and a member of it.
fn add(scene: &mut Scene, character: Character) -> (CharacterId, MemberId) {
    let roles = legs(&character.skeleton);
    let id = scene.crowd.add_character(character).expect("enough capacity");
    scene.crowd.character_mut(id).expect("a character").set_roles(roles).expect("its roles");
    (id, scene.crowd.spawn(id, Placement::at([0.0; 3])).expect("enough capacity"))
}

/// Asserts that the joints of a body of its own and of [`mirrored_character`] are in the same
/// places, and turned alike within `most_deg`. Returns the number of joints in another order.
fn assert_mirrored(own: &[Affine], other: &[Affine], most_deg: f32) -> usize {
    let mirrored = mirrored_character().skeleton.clone();
    let mut moved = 0;
    for joint in skeleton().joints() {
        let same = mirrored.find(skeleton().name(joint)).expect("the same joints");
        moved += usize::from(same != joint);
        let (a, b) = (&own[joint.index()], &other[same.index()]);
        assert!(fixture::distance(a.origin(), b.origin()) < 2e-6, "{a:?} {b:?}");
        assert!(fixture::turn_deg(a, b) < most_deg, "{a:?} {b:?}");
    }
    moved
}

/// Adds a live clip to what a member shows.
fn add_live(scene: &mut Scene, live: ClipId, member: MemberId) {
    let added = LayerSettings { mode: LayerMode::Additive, weight: 1.0 };
    scene.edit(member).set_layer(1, added, None).expect("a layer");
    scene.edit(member).play(live, ClipPlayback::live(0.4).on_layer(1)).expect("a live clip");
}

#[test]
fn additive_layers_of_all_bodies_measure_from_the_first_pose_that_arrived() {
    everywhere(|scene| {
        let roles = legs(&skeleton());
        let body = scene.body;
        scene.crowd.character_mut(body).expect("a body").set_roles(roles).expect("its roles");
        let own = scene.member(Placement::at([0.0; 3]));
        let at_rest = scene.member(Placement::at([0.0; 3]));
        let (live, _) = followers(scene, 1.0, &[]);
        let early = add(scene, mirrored_character()).1;
        add_live(scene, live, own);
        add_live(scene, live, early);
        stream_evenly(scene, live, 70, |_, _, _| {});
        let same = scene.crowd.character(body).expect("a body").asset().clone();
        let same = scene.crowd.add_character(same).expect("enough capacity");
        let same = scene.crowd.spawn(same, Placement::at([0.0; 3])).expect("enough capacity");
        let late = add(scene, mirrored_character()).1;
        add_live(scene, live, same);
        add_live(scene, live, late);
        scene.update(0.0);
        let own = scene.models(own);
        assert_eq!(own, scene.models(same), "bound late");
        assert_ne!(own, scene.models(at_rest));
        for other in [early, late] {
            assert_mirrored(&own, &scene.models(other), 1e-2);
        }
    });
}

/// Returns a chain of joints, each above the one before.
fn chain(count: usize) -> Skeleton {
    let joint = |nth: usize| JointSource {
        name: format!("joint {nth}"),
        parent: nth.checked_sub(1),
        rest: Trs { translation: [0.0, 0.1, 0.0], ..Trs::IDENTITY },
    };
    Skeleton::new(&(0..count).map(joint).collect::<Vec<_>>()).expect("a skeleton")
}

#[test]
fn bodies_with_fewer_joints_add_what_they_have() {
    // More joints than blocks of sixteen that the shorter body has.
    const LONGER: usize = 40;
    everywhere(|scene| {
        let [longer, shorter] = [LONGER, 24].map(|count| {
            let character = fixture::bare("chain", chain(count), Vec::new());
            scene.crowd.add_character(character).expect("enough capacity")
        });
        let mut character = scene.crowd.character_mut(longer).expect("a character");
        let live = character.add_live_clip("chain", &settings(1.0)).expect("a live clip");
        let member = scene.crowd.spawn(shorter, Placement::at([0.0; 3])).expect("capacity");
        add_live(scene, live, member);
        for (nth, turn_deg) in [10.0_f32, 40.0].into_iter().enumerate() {
            let mut pose: Vec<_> = chain(LONGER).joints().map(|_| Trs::IDENTITY).collect();
            let (sin, cos) = (0.5 * turn_deg).to_radians().sin_cos();
            pose[3].rotation = [sin, 0.0, 0.0, cos];
            let secs = nth as f64 / 30.0;
            scene.crowd.clip_mut(live).expect("a clip").append(secs, &pose).expect("a pose");
        }
        scene.update(1.0 / 30.0 + 0.4);
        let models = scene.models(member);
        let turn_deg = fixture::turn_deg(&models[3], &models[2]);
        assert!((turn_deg - 30.0).abs() < 0.1, "it turns by {turn_deg} degrees");
    });
}

#[test]
fn bodies_bound_late_show_what_arrived_before() {
    everywhere(|scene| {
        let roles = legs(&skeleton());
        let body = scene.body;
        scene.crowd.character_mut(body).expect("a body").set_roles(roles).expect("its roles");
        let (live, own) = followers(scene, 1.0, &[0.4]);
        let (ids, early): (Vec<_>, Vec<_>) = [longer_character(), mirrored_character()]
            .map(|other| add(scene, other))
            .into_iter()
            .unzip();
        let at_rest: Vec<_> = ids
            .into_iter()
            .map(|id| scene.crowd.spawn(id, Placement::at([0.0; 3])).expect("enough capacity"))
            .collect();
        for &member in &early {
            scene.edit(member).play(live, ClipPlayback::live(0.4)).expect("a live clip");
        }
        // The ring holds 32 rows.
        stream_evenly(scene, live, 70, |_, _, _| {});
        let late = [longer_character(), mirrored_character()].map(|other| add(scene, other).1);
        for member in late {
            scene.edit(member).play(live, ClipPlayback::live(0.4)).expect("a live clip");
        }
        scene.update(0.0);
        for ((&early, late), at_rest) in early.iter().zip(late).zip(at_rest) {
            let (early, late) = (scene.models(early), scene.models(late));
            assert_eq!(early, late);
            assert_ne!(early, scene.models(at_rest));
        }
        let (own, other) = (scene.models(own[0]), scene.models(early[1]));
        let moved = assert_mirrored(&own, &other, 1e-3);
        assert!(moved > 0, "the test needs another order");
    });
}

/// Returns a character with one more joint at its left knee.
fn character_with_two_knees() -> Character {
    let own = skeleton();
    let joint = |joint: populace::JointIndex| JointSource {
        name: own.name(joint).into(),
        parent: own.parent(joint).map(|p| p.index()),
        rest: *own.rest(joint),
    };
    let mut joints: Vec<_> = own.joints().map(joint).collect();
    let knee = fixture::joint("leftLowerLeg").index();
    let count = joints.len();
    let between = JointSource { name: "between".into(), ..joints[knee].clone() };
    joints[knee] = JointSource { parent: Some(count), rest: Trs::IDENTITY, ..joints[knee].clone() };
    joints.push(between);
    fixture::bare("two knees", Skeleton::new(&joints).expect("a skeleton"), Vec::new())
}

#[test]
fn products_of_fast_rotations_take_the_short_way() {
    everywhere(|scene| {
        let source = character_with_two_knees();
        let skeleton = source.skeleton.clone();
        let (id, _) = add(scene, source);
        let (longer, member) = add(scene, longer_character());
        let at_rest = scene.crowd.spawn(longer, Placement::at([0.0; 3])).expect("enough capacity");
        let mut character = scene.crowd.character_mut(id).expect("a character");
        let live = character.add_live_clip("fast", &settings(1.0)).expect("a live clip");
        // Halfway between two poses, which are a thirtieth of a second apart.
        scene.edit(member).play(live, ClipPlayback::live(1.0 / 60.0)).expect("a live clip");
        // Both joints turn by 130 degrees: their product turns by 100 degrees the other way.
        for (nth, half_turn) in [0.0_f32, 65.0].into_iter().enumerate() {
            let mut pose: Vec<_> = skeleton.joints().map(|j| *skeleton.rest(j)).collect();
            for name in ["between", "leftLowerLeg"] {
                let (sin, cos) = half_turn.to_radians().sin_cos();
                let rotation = &mut pose[skeleton.find(name).expect("a joint").index()].rotation;
                *rotation = quat::mul(*rotation, [sin, 0.0, 0.0, cos]);
            }
            let secs = nth as f64 / 30.0;
            scene.crowd.clip_mut(live).expect("a clip").append(secs, &pose).expect("a pose");
        }
        scene.update(1.0 / 30.0);
        let shin = fixture::joint("leftLowerLeg").index();
        let turn = fixture::turn_deg(&scene.models(member)[shin], &scene.models(at_rest)[shin]);
        assert!((turn - 50.0).abs() < 1.0, "the shin turns by {turn} degrees");
    });
}

#[test]
fn other_bodies_ignore_translations_that_are_not_streamed() {
    everywhere(|scene| {
        let body = scene.body;
        let mut character = scene.crowd.character_mut(body).expect("a body");
        character.set_roles(legs(&skeleton())).expect("its roles");
        let (other, _) = add(scene, longer_character());
        let settings = LiveSettings { translations: Streamed::Nothing, ..settings(1.0) };
        let members = ["near", "far"].map(|name| {
            let mut character = scene.crowd.character_mut(body).expect("a body");
            let live = character.add_live_clip(name, &settings).expect("a live clip");
            let member = scene.crowd.spawn(other, Placement::at([0.0; 3])).expect("capacity");
            scene.edit(member).play(live, ClipPlayback::live(0.0)).expect("a live clip");
            let mut pose = pose(0.4);
            if name == "far" {
                pose.iter_mut().for_each(|trs| trs.translation = [9.0; 3]);
            }
            scene.crowd.clip_mut(live).expect("a clip").append(0.0, &pose).expect("a pose");
            member
        });
        scene.update(0.1);
        let [near, far] = members.map(|member| scene.models(member));
        assert_eq!(near, far);
    });
}
