//! Spheres around members, by which they are hidden and get their levels of detail.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]

use std::sync::Arc;

use populace::character::{Character, CharacterSource};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track};
use populace::{ClipPlayback, Crowd, Device, Placement, Schedule, Trs};

/// A root of a scale, with hips at a height of 1 m and a head at 1.7 m, and a clip "Go" of one track.
fn scaled(scale: f32, joint: &str, property: Property, values: Vec<f32>) -> Character {
    let joint_at = |name: &str, parent, y: f32, scale| JointSource {
        name: name.into(),
        parent,
        rest: Trs { translation: [0.0, y, 0.0], scale: [scale; 3], ..Trs::IDENTITY },
    };
    let joints = [
        joint_at("root", None, 0.0, scale),
        joint_at("hips", Some(0), 1.0 / scale, 1.0),
        joint_at("head", Some(1), 0.7 / scale, 1.0),
    ];
    let skeleton = Skeleton::new(&joints).unwrap();
    let (joint, times) = (joint.into(), vec![0.0, 1.0]);
    let track = Track { joint, property, interpolation: Interpolation::Linear, times, values };
    let source = ClipSource { name: "Go".into(), tracks: vec![track] };
    let clips = vec![Arc::new(Clip::new(source, &skeleton).unwrap())];
    let (palette, parts, materials, images, skins) = (vec![], vec![], vec![], vec![], vec![]);
    let name = "scaled".into();
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    Character::new(source).unwrap()
}

/// Levels and visibility go by the sphere around a member: one that is too small hides members in
/// view, and one that is too large neither hides them nor makes them coarser.
#[test]
fn spheres_hold_scaled_bodies_and_are_not_much_larger() {
    use Property::{Scale, Translation};
    let grows = vec![1.0, 1.0, 1.0, 10.0, 10.0, 10.0];
    let to_side =
        |unit: f32, metres: f32| vec![0.0, 1.0 / unit, 0.0, metres / unit, 1.0 / unit, 0.0];
    for (device, schedule) in [
        (Device::native(), Schedule::Staged),
        (Device::native(), Schedule::Fused),
        (Device::opencl(0), Schedule::Staged),
        (Device::opencl(0), Schedule::FusedWide),
        (Device::opencl(0), Schedule::FusedGrouped),
    ] {
        for (scale, joint, property, values, largest_m) in [
            (1.0, "hips", Scale, grows.clone(), 10.0),
            (1.0, "root", Scale, grows.clone(), 30.0),
            (100.0, "hips", Translation, to_side(100.0, 5.0), 20.0),
            (0.01, "hips", Translation, to_side(0.01, 5.0), 20.0),
            (0.01, "hips", Translation, to_side(0.01, 0.05), 3.5),
        ] {
            let mut crowd = Crowd::builder().device(device).schedule(schedule).build().unwrap();
            let case = format!("{schedule}: {property:?} of {joint} of a body of scale {scale}");
            let id = crowd.add_character(scaled(scale, joint, property, values)).unwrap();
            let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
            let go = crowd.clip(id, "Go").unwrap();
            crowd.member_mut(member).unwrap().play(go, ClipPlayback::once()).unwrap();
            for _ in 0..4 {
                crowd.update(0.25).unwrap();
                let (center, radius_m) = crowd.member(member).unwrap().bounding_sphere();
                assert!(radius_m < largest_m, "{case}: {radius_m} m");
                for joint in crowd.member_mut(member).unwrap().model_from_joints().unwrap() {
                    let [x, y, z] = [0, 1, 2].map(|i: usize| joint.origin()[i] - center[i]);
                    let away_m = x.hypot(y).hypot(z);
                    assert!(away_m < radius_m, "{case}: {away_m} m in {radius_m} m");
                }
            }
        }
    }
}
