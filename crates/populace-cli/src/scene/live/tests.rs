use clap::{Args, FromArgMatches};
use populace::Device;
use populace_scene::plan::ScenePlan;

use super::*;
use crate::cli::PictureArgs;

/// The frames of a second.
const FRAMES: u8 = 30;

/// Films a scene by a camera for a second. Returns how far the camera went, and how far it moved at
/// most by evaluations alone, in metres.
fn filmed_m(plan: &str, view: View) -> [f32; 2] {
    let matches = PictureArgs::augment_args(clap::Command::new("render"))
        .try_get_matches_from(["render"])
        .expect("arguments");
    let picture = &PictureArgs::from_arg_matches(&matches).expect("arguments");
    let plan = ScenePlan::parse(plan).expect("a scene");
    let source = SceneSource { plan, file: None, cast: &[], picture };
    let [capacity, slots] = source.sizes();
    let builder = Crowd::builder().device(Device::native());
    let mut crowd = builder.capacity(capacity).slots_per_member(slots).build().expect("a crowd");
    let (live, _) = source.live(&mut crowd).expect("the scene");
    let mut scene = FilmedScene::new(live, view);
    scene.set_aspect(1.0).expect("cameras");
    scene.advance(&mut crowd, 0.0).expect("frame 0");
    let eye = |scene: &FilmedScene, frame: u8| {
        let camera = scene.camera(f64::from(frame) / f64::from(FRAMES));
        Vec3::from(camera.expect("a camera").eye)
    };
    let first = eye(&scene, 0);
    let mut evaluated_m = 0.0_f32;
    for frame in 1..=FRAMES {
        let left = scene.behave(&mut crowd, 1.0 / f32::from(FRAMES)).expect("a step");
        let before = eye(&scene, frame);
        scene.evaluate(&mut crowd, left).expect("a frame");
        evaluated_m = evaluated_m.max(before.distance(eye(&scene, frame)));
    }
    [first.distance(eye(&scene, FRAMES)), evaluated_m]
}

#[test]
fn cameras_go_with_people_before_they_are_evaluated() {
    let driver = r#"schema = 1
cast = [{ name = "people", from = ["@man"], varied = false }]
crowd = [{ cast = "people", count = 1, does.stroll.drive = 120 }]
footway = [{ name = "walk", points = [[-20, 6], [60, 6]], width_m = 2 }]
lane = [{ name = "lane", ends = [[-20, 1.6], [60, 1.6]], vehicles = 1, speed = 9 }]
"#;
    let walker = r#"schema = 1
cast = [{ name = "people", from = ["@man"], varied = false }]
crowd = [{ cast = "people", count = 1, does.stroll = {} }]
footway = [{ name = "walk", points = [[-20, 6], [60, 6]], width_m = 2 }]
"#;
    let id = || String::from("0");
    for (plan, view, far_m) in [
        (driver, View::Eye { id: id() }, 6.0),
        (driver, View::Follow { id: id() }, 6.0),
        (walker, View::Follow { id: id() }, 0.8),
    ] {
        let [way_m, evaluated_m] = filmed_m(plan, view);
        assert!(way_m > far_m, "{way_m} m");
        assert!(evaluated_m < 0.01, "{evaluated_m} m of {way_m} m");
    }
}
