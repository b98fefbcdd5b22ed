use serde_json::json;

use super::builder::{File, TRIANGLE, rigid, skinned};
use super::{assert_note, assert_problem, loaded};

fn joint_names(file: &File) -> Vec<String> {
    let imported = loaded(&file.glb());
    let skeleton = &imported.character.skeleton;
    skeleton.joints().map(|j| skeleton.name(j).to_owned()).collect()
}

#[test]
fn skeleton_has_joints_with_ancestors_and_descendants() {
    let mut file = skinned();
    // 0 is the skinned mesh, 1 hips, 2 head.
    let hat = file.add("nodes", json!({"name": "hat"}));
    file.json["nodes"][2]["children"] = json!([hat]);
    file.add("nodes", json!({"name": "armature", "children": [1, 0], "scale": [2, 2, 2]}));
    let lamp = file.add("nodes", json!({"name": "lamp"}));
    assert_eq!(joint_names(&file), ["armature", "hips", "head", "hat"]);
    file.json["animations"][0]["channels"][0]["target"]["node"] = lamp.into();
    assert_eq!(joint_names(&file), ["armature", "lamp", "hips", "head", "hat"]);
}

#[test]
fn missing_and_duplicate_names_become_unique() {
    let mut file = skinned();
    file.json["nodes"][1]["name"] = "".into();
    file.json["nodes"][2]["name"] = "x".into();
    let twin = file.add("nodes", json!({"name": "x"}));
    file.json["skins"][0]["joints"] = json!([1, 2, twin]);
    file.json["skins"][0]["inverseBindMatrices"].take();
    file.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    assert_eq!(joint_names(&file), ["node1", "x#2", "x"]);
    assert_note(&file.glb(), "nodes[3]: has the name \"x\" of an earlier node");
}

#[test]
fn transform_of_a_skinned_mesh_node_is_ignored() {
    let mut file = skinned();
    let still = loaded(&file.glb()).character.rest_bounds();
    file.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    file.add("nodes", json!({"name": "far", "children": [0], "translation": [0, 100, 0]}));
    assert_eq!(loaded(&file.glb()).character.rest_bounds(), still);
}

#[test]
fn matrix_equals_its_translation_rotation_and_scale() {
    let mut with_matrix = rigid();
    with_matrix.json["nodes"][0]["matrix"] =
        json!([0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 5, 6, 7, 1]);
    let bounds = loaded(&with_matrix.glb()).character.rest_bounds().unwrap();
    assert_eq!((bounds.low, bounds.high), ([2.0, 6.0, 7.0], [5.0, 8.0, 7.0]));
    with_matrix.json["nodes"][0]["matrix"][4] = 9.into();
    with_matrix.json["nodes"][0]["matrix"][5] = 9.into();
    assert_problem(&with_matrix.glb(), "nodes[0].matrix: is sheared");
}

#[test]
fn invalid_transforms_are_refused() {
    let mut file = rigid();
    file.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    assert_problem(&file.glb(), "nodes[0]: has a rotation of length zero");
    file.json["nodes"][0]["rotation"] = json!([0, 0, 0, 2]);
    assert_note(&file.glb(), "nodes[0]: has a rotation that is not a unit quaternion");
    file.json["nodes"][0]["scale"] = json!([1, 1e300, 1]);
    assert_problem(&file.glb(), "nodes[0].scale[1]: is");
}

#[test]
fn nodes_must_form_a_forest() {
    let mut file = rigid();
    file.add("nodes", json!({"children": [2]}));
    file.add("nodes", json!({"children": [1]}));
    assert_problem(&file.glb(), "nodes[1]: is its own ancestor");
    file.json["nodes"][2]["children"] = json!([0]);
    file.json["nodes"][1]["children"] = json!([0]);
    assert_problem(
        &file.glb(),
        "nodes[2].children: lists node 0 as a child, but it is already a child of node 1",
    );
    file.json["nodes"][2]["children"] = json!([7]);
    assert_problem(&file.glb(), "nodes[2].children[0]: refers to node 7");
}

#[test]
fn default_scene_else_first_else_all_nodes_are_imported() {
    let mut file = rigid();
    file.add("nodes", json!({"name": "other", "mesh": 0}));
    let shown = |file: &File| -> Vec<usize> {
        loaded(&file.glb()).character.parts.iter().map(|p| p.node).collect()
    };
    assert_eq!(shown(&file), [0, 1]);
    file.json["scenes"] = json!([{"nodes": [1]}, {"nodes": [0]}]);
    assert_eq!(shown(&file), [1]);
    assert_note(&file.glb(), "file: has 2 scenes; scene 0 is imported");
    file.json["scene"] = 1.into();
    assert_eq!(shown(&file), [0]);
    file.json["scene"] = 2.into();
    assert_problem(&file.glb(), "scene: refers to scene 2");
    file.json["scene"] = 0.into();
    file.json["nodes"][0]["children"] = json!([1]);
    assert_problem(&file.glb(), "scenes[0].nodes[0]: refers to node 1, which is a child of node 0");
}

#[test]
fn mirrored_rigid_mesh_keeps_its_winding_and_is_known_as_mirrored() {
    let mut file = rigid();
    let is_mirrored = |file: &File| {
        let character = loaded(&file.glb()).character;
        assert_eq!(character.parts[0].mesh.indices, [0, 1, 2]);
        character.is_mirrored(0)
    };
    assert!(!is_mirrored(&file));
    file.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    assert!(is_mirrored(&file));
    file.add("nodes", json!({"children": [0], "scale": [1, 1, -2]}));
    assert!(!is_mirrored(&file));
}

#[test]
fn mesh_used_by_two_nodes_gives_two_parts() {
    let mut file = rigid();
    file.add("nodes", json!({"name": "twin", "mesh": 0, "translation": [0, 0, 5]}));
    let character = loaded(&file.glb()).character;
    let names: Vec<_> = character.parts.iter().map(|p| (p.node, p.node_name.as_str())).collect();
    assert_eq!(names, [(0, "body"), (1, "twin")]);
    assert_eq!(character.palette.len(), 2);
    assert_eq!(character.rest_bounds().unwrap().high, [1.0, 1.0, 5.0]);
    assert_eq!(character.parts[1].mesh.positions.concat(), TRIANGLE);
}
