//! Settings that would do nothing, or nothing good, are refused.

use populace::{
    ClipPlayback, Device, Gaze, GazeLimits, LayerSettings, Placement, Schedule, Weight,
};

use super::fixture::{Scene, joint, scene};

fn native() -> Scene {
    scene(Device::native(), Schedule::Fused)
}

#[test]
fn the_lowest_layer_has_no_settings() {
    let mut scene = native();
    let member = scene.member(Placement::at([0.0; 3]));
    for (layer, given) in [(0, "0"), (4, "4")] {
        let refused = scene.edit(member).set_layer(layer, LayerSettings::default(), None);
        let words = refused.expect_err("a layer without settings").to_string();
        assert!(words.contains(given), "{words}");
    }
    let refused = scene.edit(member).set_layer(0, LayerSettings::default(), None);
    let words = refused.expect_err("the lowest layer").to_string();
    assert!(words.contains("from 1 to 3"), "{words}");
    scene.edit(member).set_layer(1, LayerSettings::default(), None).expect("a layer");
}

#[test]
fn a_gaze_faces_somewhere() {
    let mut scene = native();
    let member = scene.member(Placement::at([0.0; 3]));
    let mut gaze = Gaze {
        chain: vec![(joint("neck"), 0.4), (joint("head"), 0.6)],
        facing: [0.0; 3],
        limits: GazeLimits::default(),
    };
    let refused = scene.edit(member).look_at_with(&gaze, [1.0, 1.6, 2.0], Weight::FULL);
    let words = refused.expect_err("a gaze that faces nowhere").to_string();
    assert!(words.contains("facing direction") && words.contains("+Z"), "{words}");
    gaze.facing = [0.0, 0.0, 1e-20];
    scene
        .edit(member)
        .look_at_with(&gaze, [1.0, 1.6, 2.0], Weight::FULL)
        .expect("a direction of any length");
    scene.update(0.1);
}

#[test]
fn usual_limits_are_those_of_a_look() {
    assert_eq!(GazeLimits::default(), GazeLimits::HEAD);
    let degrees = [GazeLimits::HEAD.yaw_rad, GazeLimits::HEAD.up_rad, GazeLimits::HEAD.down_rad];
    assert_eq!(degrees.map(|rad| rad.to_degrees().round()), [85.0, 45.0, 50.0]);
}

#[test]
fn phases_count_whole_cycles_as_none() {
    let mut scene = native();
    let (member, clip) = (scene.member(Placement::at([0.0; 3])), scene.clip("walk"));
    let mut pose_at = |phase: f32| {
        scene.edit(member).play(clip, ClipPlayback::looping().phase(phase)).expect("a clip");
        scene.update(0.0);
        scene.models(member)
    };
    let quarter = pose_at(0.25);
    assert_eq!([pose_at(1.25), pose_at(-0.75)], [quarter.clone(), quarter]);
}
