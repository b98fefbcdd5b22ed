//! Joint overrides.

use populace::model::math::{quat, vec3};
use populace::{Affine, ClipPlayback, Error, JointOverride, Placement, Space, Trs};

use crate::fixture::{distance, everywhere, joint, skeleton, turn_deg};

fn given(name: &str, space: Space, weight: f32) -> JointOverride {
    let rotation = quat::normalize_or([0.2, -0.4, 0.1, 0.8], quat::identity());
    let transform = Trs { translation: [0.1, 1.2, 0.3], rotation, scale: [1.0, 1.1, 0.9] };
    JointOverride { joint: joint(name), space, transform, weight }
}

fn is_descendant(mut at: populace::JointIndex, above: populace::JointIndex) -> bool {
    let skeleton = skeleton();
    loop {
        if at == above {
            return true;
        }
        match skeleton.parent(at) {
            Some(parent) => at = parent,
            None => return false,
        }
    }
}

#[test]
fn overridden_joint_moves_with_its_descendants() {
    everywhere(|scene| {
        for space in [Space::Local, Space::Model] {
            let [member, twin] = [(); 2].map(|()| scene.member(Placement::at([0.0; 3])));
            let clip = scene.clip("sway");
            for member in [member, twin] {
                scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
            }
            let o = given("chest", space, 1.0);
            scene.edit(member).override_joints(&[o]).expect("an override");
            scene.update(0.4);
            let (with, without) = (scene.models(member), scene.models(twin));
            let at = joint("chest");
            let wanted = Affine::from_trs(&o.transform);
            let wanted = if space == Space::Local {
                with[joint("spine").index()].mul(&wanted)
            } else {
                wanted
            };
            let apart = with[at.index()].rows.as_flattened().iter().zip(wanted.rows.as_flattened());
            assert!(apart.clone().all(|(a, b)| (a - b).abs() < 1e-6), "{space:?}: {apart:?}");
            for other in skeleton().joints() {
                let same = with[other.index()] == without[other.index()];
                assert_eq!(same, !is_descendant(other, at), "{space:?} joint {other:?}");
                if is_descendant(other, at) {
                    // No descendant collapses into the overridden joint.
                    let to = |models: &[Affine]| {
                        distance(models[other.index()].origin(), models[at.index()].origin())
                    };
                    assert!(other == at || to(&with) > 0.0 && to(&without) > 0.0);
                }
            }
            // A released joint follows its clips again.
            scene.edit(member).release_joints(space, &[at]).expect("a member");
            scene.update(0.1);
            assert_eq!(scene.models(member), scene.models(twin), "{space:?}");
            scene.crowd.despawn(member).expect("a member");
            scene.crowd.despawn(twin).expect("a member");
        }
    });
}

#[test]
fn weight_interpolates_from_clip_to_override() {
    everywhere(|scene| {
        for space in [Space::Local, Space::Model] {
            let member = scene.member(Placement::at([0.0; 3]));
            scene.update(0.0);
            let at = joint("leftUpperArm").index();
            let (from, mut last) = (scene.models(member)[at], None::<Affine>);
            scene
                .edit(member)
                .override_joints(&[given("leftUpperArm", space, 1.0)])
                .expect("an override");
            scene.update(0.0);
            let to = scene.models(member)[at];
            for step in 0..=16_u8 {
                let o = given("leftUpperArm", space, f32::from(step) / 16.0);
                scene.edit(member).override_joints(&[o]).expect("an override");
                scene.update(0.0);
                let now = scene.models(member)[at];
                if step == 0 {
                    assert!(
                        distance(now.origin(), from.origin()) < 1e-6
                            && turn_deg(&now, &from) < 1e-3
                    );
                }
                let part =
                    distance(from.origin(), now.origin()) / distance(from.origin(), to.origin());
                assert!(
                    (part - o.weight).abs() < 1e-3,
                    "{space:?}: {part} of the distance at weight {}",
                    o.weight
                );
                if let Some(last) = last {
                    let turned = turn_deg(&last, &now);
                    assert!(
                        (0.5..20.0).contains(&turned),
                        "{space:?}: {turned} degrees in a step of 1/16"
                    );
                }
                let sizes = [0, 1, 2]
                    .map(|c| vec3::length([now.rows[0][c], now.rows[1][c], now.rows[2][c]]));
                assert!(
                    sizes.iter().all(|s| (0.89..1.11).contains(s)),
                    "{space:?}: axes have the lengths {sizes:?}"
                );
                last = Some(now);
            }
            assert_eq!(last, Some(to), "{space:?}");
            scene.crowd.despawn(member).expect("a member");
        }
    });
}

#[test]
fn bad_overrides_are_refused_and_change_nothing() {
    everywhere(|scene| {
        let member = scene.member(Placement::at([0.0; 3]));
        let good = given("head", Space::Model, 1.0);
        scene.edit(member).override_joints(&[good]).expect("an override");
        scene.update(0.0);
        let before = scene.models(member);
        let mut nan = good;
        nan.transform.translation[1] = f32::NAN;
        let mut long = good;
        long.transform.rotation = [1.0, 2.0, 3.0, 4.0];
        let mut absent = good;
        absent.joint = populace::JointIndex(99);
        let heavy = JointOverride { weight: 1.5, ..good };
        for bad in [nan, long, absent, heavy] {
            let error = scene
                .crowd
                .member_mut(member)
                .and_then(|mut m| m.override_joints(&[good, bad]))
                .expect_err("a bad override");
            assert!(matches!(error, Error::Tables(_)), "{error}");
        }
        scene.update(0.0);
        assert_eq!(scene.models(member), before);
        scene.edit(member).release_all_joints().expect("a member");
        scene.crowd.despawn(member).expect("a member");
        assert!(
            scene.crowd.member_mut(member).and_then(|mut m| m.override_joints(&[good])).is_err(),
            "a despawned member took an override"
        );
    });
}

/// Local poses have what comes before Transform, and nothing that comes after it.
#[test]
fn local_pose_is_the_pose_before_constraints() {
    everywhere(|scene| {
        let member = scene.member(Placement::at([0.0; 3]));
        let clip = scene.clip("sway");
        scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
        let factors = vec![1.3; skeleton().joint_count()];
        scene.edit(member).set_proportions(&factors).expect("proportions");
        for (space, is_before) in [(Space::Local, true), (Space::Model, false)] {
            let given = [given("chest", space, 1.0)];
            scene.edit(member).override_joints(&given).expect("an override");
            scene.update(0.1);
            let mut models: Vec<Affine> = Vec::new();
            let locals = scene.edit(member).local_pose().expect("an evaluated member");
            for (joint, local) in skeleton().joints().zip(&locals) {
                let parent = skeleton().parent(joint);
                let parent = parent.map_or(Affine::IDENTITY, |parent| models[parent.index()]);
                models.push(parent.mul(&Affine::from_trs(local)));
            }
            let pairs = models.iter().zip(scene.models(member));
            let off = pairs.map(|(a, b)| distance(a.origin(), b.origin())).fold(0.0, f32::max);
            assert_eq!(off < 1e-4, is_before, "{space:?}: {off} m");
        }
    });
}
