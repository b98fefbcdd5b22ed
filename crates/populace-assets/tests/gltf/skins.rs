use populace_model::Affine;
use serde_json::json;

use super::builder::{F32, File, U16, moved_up, skinned};
use super::{assert_note, assert_problem, loaded};

fn replace_attribute(file: &mut File, name: &str, accessor: usize) {
    file.primitive()["attributes"][name] = accessor.into();
}

#[test]
fn vertices_are_bound_to_joints_by_inverse_bind_matrices() {
    let character = loaded(&skinned().glb()).character;
    let skeleton = &character.skeleton;
    let influences = &character.parts[0].mesh.influences;
    assert_eq!(influences.per_vertex, 4);
    assert_eq!(influences.weights[8..10], [0.25, 0.75]);
    let entry = |at: usize| &character.palette[usize::from(influences.entries[at])];
    assert_eq!(Some(entry(4).joint), skeleton.find("head"));
    assert_eq!(entry(4).joint_from_bind, Affine::from_cols_array(&moved_up(-1.0)));
    assert_eq!(Some(entry(8).joint), skeleton.find("hips"));
    assert_eq!(character.palette.len(), 2);
    let skin = &character.skins[0];
    assert_eq!((skin.skin, skin.node, skin.joints.len()), (0, 0, 2));
    assert_eq!(Some(skin.joints[1].joint), skeleton.find("head"));
}

#[test]
fn node_from_joint_and_skin_info_are_filled() {
    let imported = loaded(&skinned().glb());
    assert_eq!(imported.node_from_joint, [Some(1), Some(2)]);
    assert_eq!(loaded(&File::new().glb()).node_from_joint, [None]);
    assert_eq!(imported.skins[0].name, "skin");
    assert_eq!(imported.skins[0].joint_count, 2);
}

#[test]
fn missing_inverse_bind_matrices_are_identities() {
    let mut file = skinned();
    file.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    let character = loaded(&file.glb()).character;
    assert!(character.palette.iter().all(|e| e.joint_from_bind == Affine::IDENTITY));
    // The head is one metre up and now moves its vertices by that.
    assert_eq!(character.rest_bounds().unwrap().high, [1.0, 1.75, 0.0]);
}

#[test]
fn integer_weights_and_joints_load() {
    let mut file = skinned();
    let floats = loaded(&file.glb()).character;
    let joints = file.shorts("VEC4", &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    replace_attribute(&mut file, "JOINTS_0", joints);
    let weights = file.bytes("VEC4", &[255, 0, 0, 0, 255, 0, 0, 0, 64, 191, 0, 0]);
    file.json["accessors"][weights]["normalized"] = true.into();
    replace_attribute(&mut file, "WEIGHTS_0", weights);
    let bytes = loaded(&file.glb()).character;
    assert_eq!(bytes.parts[0].mesh.influences.entries, floats.parts[0].mesh.influences.entries);
    for (a, b) in
        bytes.parts[0].mesh.influences.weights.iter().zip(&floats.parts[0].mesh.influences.weights)
    {
        assert!((a - b).abs() < 0.5 / 255.0, "{a} {b}");
    }
    file.json["accessors"][weights]["normalized"] = false.into();
    assert_problem(
        &file.glb(),
        &format!("accessors[{weights}]: is VEC4 of 8-bit unsigned; WEIGHTS_0 must be"),
    );
}

#[test]
fn second_set_gives_eight_influences_and_must_be_complete() {
    let mut file = skinned();
    let joints = file.bytes("VEC4", &[1; 12]);
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
    replace_attribute(&mut file, "JOINTS_1", joints);
    assert_problem(&file.glb(), "meshes[0].primitives[0]: must have both JOINTS_1 and WEIGHTS_1");
    replace_attribute(&mut file, "WEIGHTS_1", weights);
    let character = loaded(&file.glb()).character;
    let influences = &character.parts[0].mesh.influences;
    assert_eq!(influences.per_vertex, 8);
    assert_eq!(influences.weights[..8], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    replace_attribute(&mut file, "JOINTS_2", joints);
    replace_attribute(&mut file, "WEIGHTS_2", weights);
    assert_note(&file.glb(), "meshes[0].primitives[0]: has more than 8 influences");
}

#[test]
fn unusual_weights_are_kept_or_repaired_with_notes() {
    let mut file = skinned();
    let weights =
        file.floats("VEC4", &[0.0, 0.0, 0.0, 0.0, 2.0, 6.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0]);
    replace_attribute(&mut file, "WEIGHTS_0", weights);
    let influences = loaded(&file.glb()).character.parts[0].mesh.influences.clone();
    assert_eq!(influences.weights, [1.0, 0.0, 0.0, 0.0, 2.0, 6.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    assert_note(&file.glb(), "meshes[0].primitives[0]: has vertices whose weights are all zero");
    assert_note(&file.glb(), "meshes[0].primitives[0]: has negative weights");
    assert_note(&file.glb(), "meshes[0].primitives[0]: has vertices whose weights do not sum to 1");
}

#[test]
fn vertex_joint_out_of_range_is_refused() {
    let mut file = skinned();
    let joints = file.bytes("VEC4", &[0, 9, 9, 9, 2, 0, 0, 0, 0, 1, 0, 0]);
    replace_attribute(&mut file, "JOINTS_0", joints);
    assert_problem(
        &file.glb(),
        "meshes[0].primitives[0]: binds vertex 1 to joint 2, but the skin has only 2",
    );
}

#[test]
fn invalid_inverse_bind_matrices_are_refused() {
    let mut file = skinned();
    let binds = file.floats("MAT4", &moved_up(0.0));
    file.json["skins"][0]["inverseBindMatrices"] = binds.into();
    assert_problem(&file.glb(), "skins[0]: has 2 joints, but only 1 inverse bind matrices");
    let mut projective = [moved_up(0.0), moved_up(-1.0)].concat();
    projective[19] = 0.5;
    let binds = file.floats("MAT4", &projective);
    file.json["skins"][0]["inverseBindMatrices"] = binds.into();
    assert_problem(&file.glb(), "skins[0]: has an inverse bind matrix 1 with a last row");
    let vectors = file.floats("VEC4", &projective);
    file.json["skins"][0]["inverseBindMatrices"] = vectors.into();
    assert_problem(
        &file.glb(),
        &format!("accessors[{vectors}]: is VEC4 of float; inverse bind matrices must be MAT4"),
    );
    file.json["skins"][0]["inverseBindMatrices"] = 99.into();
    assert_problem(&file.glb(), "skins[0].inverseBindMatrices: refers to accessor 99");
}

#[test]
fn two_skins_may_bind_a_joint_differently() {
    let mut file = skinned();
    let binds = file.floats("MAT4", &[moved_up(-0.5), moved_up(-1.0)].concat());
    file.add("skins", json!({"joints": [1, 2], "inverseBindMatrices": binds}));
    file.add("nodes", json!({"name": "coat", "mesh": 0, "skin": 1}));
    let character = loaded(&file.glb()).character;
    assert_eq!(character.parts.len(), 2);
    assert_eq!(
        character.palette.len(),
        3,
        "the skins share the pair of the head, but not that of the hips"
    );
    assert_eq!(character.skins.len(), 2);
    let last = &character.parts[1].mesh.influences;
    assert_eq!(character.palette[usize::from(last.entries[0])].joint_from_bind.rows[1][3], -0.5);
}

#[test]
fn mesh_without_joints_ignores_its_skin() {
    let mut file = skinned();
    let attributes = file.primitive()["attributes"].as_object_mut().unwrap();
    attributes.remove("JOINTS_0");
    attributes.remove("WEIGHTS_0");
    assert_note(
        &file.glb(),
        "meshes[0].primitives[0]: has no joints and weights, although its node has a skin",
    );
    let character = loaded(&file.glb()).character;
    assert_eq!(Some(character.palette[0].joint), character.skeleton.find("body"));
}

#[test]
fn joints_may_lack_a_common_root_or_the_scene() {
    let mut file = skinned();
    file.json["nodes"][1].as_object_mut().unwrap().remove("children");
    assert_note(&file.glb(), "skins[0]: has joints without a common root");
    file.json["scenes"] = json!([{"nodes": [0]}]);
    assert_note(&file.glb(), "skins[0]: has joints that are not in the scene");
    file.json["skins"][0]["joints"] = json!([]);
    assert_problem(&file.glb(), "skins[0].joints: is empty");
}

#[test]
fn invalid_joint_formats_are_refused() {
    let mut file = skinned();
    let joints = file.floats("VEC4", &[0.0; 12]);
    replace_attribute(&mut file, "JOINTS_0", joints);
    assert_problem(
        &file.glb(),
        &format!("accessors[{joints}]: is VEC4 of float; JOINTS_0 must be"),
    );
    let joints = file.accessor(&[0; 24], U16, 4, "VEC3");
    replace_attribute(&mut file, "JOINTS_0", joints);
    assert_problem(&file.glb(), &format!("accessors[{joints}]: is VEC3 of 16-bit unsigned"));
    let joints = file.accessor(&[0; 32], F32, 2, "VEC4");
    replace_attribute(&mut file, "JOINTS_0", joints);
    assert!(!super::problems(&file.glb()).is_empty());
}
