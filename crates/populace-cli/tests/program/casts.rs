//! Tests of characters that play the people of recordings and scenes.

use std::fmt::Write;

use serde_json::json;

use crate::clipless::humanoid;
use crate::post::{Folder, post};
use crate::{json_of, populace, refused};

/// Writes two people who walk beside each other for 2 s, and returns the path.
fn recording(folder: &Folder) -> String {
    let mut rows = "# framerate: 25 fps\n# id frame x/m y/m z/m\n".to_owned();
    for (id, frame) in [1, 2].into_iter().flat_map(|id| (0..=50).map(move |frame| (id, frame))) {
        let x = 0.05 * f64::from(frame);
        writeln!(rows, "{id} {frame} {x:.2} {id} 1.75").expect("written");
    }
    std::fs::write(folder.path("walk.txt"), rows).expect("written");
    folder.text("walk.txt")
}

/// Evaluates ten frames of the recording, and returns the speed of planted feet in m/s.
fn skate(recording: &str, cast: &str) -> f64 {
    let args = ["render", recording, "--cast", cast, "--no-draw", "--frames", "10..20"];
    let d = json_of(&[&args[..], &["--fps", "25", "--device", "native"]].concat());
    d["foot_skate"]["mean_m_s"].as_f64().expect("a speed")
}

#[test]
fn feet_beside_their_legs_hang_on_them_to_walk() {
    let folder = Folder::new();
    let mut loose = humanoid();
    let root = loose["nodes"].as_array().expect("nodes").len();
    for (shin, foot, x) in [(12, 13, 0.1), (16, 17, -0.1)] {
        loose["nodes"][shin].as_object_mut().expect("a node").remove("children");
        loose["nodes"][foot]["translation"] = json!([x, 0.05, 0.0]);
    }
    let nodes = loose["nodes"].as_array_mut().expect("nodes");
    nodes.push(json!({"name": "root", "children": [0, 13, 17]}));
    loose["scenes"][0]["nodes"] = json!([root]);
    let files = [("loose.gltf", &loose), ("fast.gltf", &humanoid())];
    let [loose, fast] = files.map(|(name, file)| {
        std::fs::write(folder.path(name), file.to_string()).expect("written");
        skate(&recording(&folder), &folder.text(name))
    });
    assert!((loose - fast).abs() < 1e-3, "{loose} m/s in place of {fast} m/s");
}

#[cfg_attr(no_test_data, ignore = "POPULACE_TEST_DATA does not name a folder of test data")]
#[test]
fn a_robot_with_loose_feet_plays_people() {
    let folder = Folder::new();
    let data = std::env::var("POPULACE_TEST_DATA").expect("ignored without it");
    let robot = format!("{data}/characters/quaternius_robot.glb");
    let speed = skate(&recording(&folder), &robot);
    assert!(speed < 0.05, "{speed} m/s");
}

#[test]
fn characters_whose_legs_are_unknown_are_refused_by_file() {
    let folder = Folder::new();
    let (walk, post, out) = (recording(&folder), folder.text("post.gltf"), folder.text("x.png"));
    let words = ["post.gltf: its joints have no names that are known", "leave it out", "VRM"];
    let cast = ["--cast", "@child", &post, "--out", &out, "--device", "native"];
    refused(&[&["render", &walk, "--at", "1"], &cast[..]].concat(), 1, &words);
}

/// People of a scene need legs only where they walk.
#[cfg_attr(any(skip_gl, no_test_data), ignore = "no test data, or POPULACE_SKIP names gl")]
#[test]
fn characters_whose_legs_are_unknown_stand_but_do_not_stroll() {
    let folder = Folder::new();
    let data = std::env::var("POPULACE_TEST_DATA").expect("ignored without it");
    let file = format!("{data}/characters/kenney_platformer/character.glb");
    let (scene, out) = (folder.text("scene.toml"), folder.text("x.png"));
    let text = format!(
        "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [{file:?}]\n[[crowd]]\ncast = \"a\"\n\
         count = 2\ndoes.stand = {{ clip = \"idle\" }}\n"
    );
    std::fs::write(&scene, text).expect("written");
    let small = ["--out", &out, "--size", "64x36", "--device", "native"];
    let drawn = populace(&[&["render", &scene], &small[..]].concat());
    assert!(drawn.status.success(), "{}", String::from_utf8_lossy(&drawn.stderr));
    let street = ["demo", "--cast", &file, "--members", "6", "--at", "1"];
    let words = ["\"character\": its joints have no names that are known", "leave it out"];
    refused(&[&street[..], &small].concat(), 1, &words);
}

#[test]
fn heads_without_a_name_cannot_look() {
    let folder = Folder::new();
    let mut file = post();
    file["nodes"][2]["name"] = json!("top");
    std::fs::write(folder.path("top.gltf"), file.to_string()).expect("written");
    let args = ["pose", &folder.text("top.gltf"), "--look-at", "1,1,1", "--device", "native"];
    refused(&args, 2, &["\"top\"", "name one \"head\"", "leave out --look-at"]);
    let said = populace(&args).stderr;
    assert!(!String::from_utf8_lossy(&said).contains("CharacterMut"), "names of the library");
}
