use serde_json::json;

use super::builder::{File, U32, rigid};
use super::{assert_note, assert_problem, loaded};

fn mesh(file: &File) -> populace_character::Mesh {
    loaded(&file.glb()).character.parts[0].mesh.clone()
}

/// A square of two triangles, folded or flat, without normals.
fn square(fold: f32) -> File {
    let mut file = File::new();
    let positions =
        file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, fold]);
    file.add("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}}]}));
    file.add("nodes", json!({"name": "square", "mesh": 0}));
    file
}

#[test]
fn topologies_are_triangulated_and_points_and_lines_ignored() {
    let mut file = square(0.0);
    let indices = file.shorts("SCALAR", &[0, 1, 2, 3]);
    file.primitive()["indices"] = indices.into();
    let mut triangles = |mode: u32| {
        file.primitive()["mode"] = mode.into();
        mesh(&file).indices
    };
    assert_eq!(triangles(4), [0, 1, 2]);
    assert_eq!(triangles(5), [0, 1, 2, 1, 3, 2]);
    // In this order the fan folds over, so the second triangle gets copies of its vertices.
    assert_eq!(triangles(6), [1, 2, 0, 4, 3, 5]);
    for mode in 0..4 {
        file.primitive()["mode"] = mode.into();
        assert_note(&file.glb(), "meshes[0].primitives[0]: consists of points or lines");
    }
    file.primitive()["mode"] = 7.into();
    assert_problem(&file.glb(), "meshes[0].primitives[0].mode: is 7");
    file.primitive()["mode"] = 5.into();
    file.primitive().as_object_mut().unwrap().remove("indices");
    assert_eq!(
        mesh(&file).indices,
        [0, 1, 2, 1, 3, 2],
        "without indices, vertices are used in order"
    );
}

#[test]
fn vertex_counts_exclude_copies() {
    for (mode, indexed) in [(4, false), (5, false), (6, false), (5, true), (6, true)] {
        let mut file = square(1.0);
        file.primitive()["mode"] = mode.into();
        if indexed {
            let indices = file.shorts("SCALAR", &[3, 2, 1, 0]);
            file.primitive()["indices"] = indices.into();
        }
        let imported = loaded(&file.glb());
        let positions = &imported.character.parts[0].mesh.positions;
        assert_eq!(imported.vertex_counts, [4], "mode {mode}");
        assert_eq!(positions[..4], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]]);
        assert_eq!(
            positions.len() > 4,
            mode != 4,
            "the second triangle of the folded square has other normals"
        );
    }
}

#[test]
fn indices_out_of_range_are_refused() {
    let mut file = rigid();
    let indices = file.accessor(&[0, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0], U32, 3, "SCALAR");
    file.primitive()["indices"] = indices.into();
    assert_problem(
        &file.glb(),
        &format!(
            "accessors[{indices}]: holds index 3 in element 2, but meshes[0].primitives[0] has"
        ),
    );
    let floats = file.floats("SCALAR", &[0.0, 1.0, 2.0]);
    file.primitive()["indices"] = floats.into();
    assert_problem(
        &file.glb(),
        &format!("accessors[{floats}]: is SCALAR of float; indices must be"),
    );
}

#[test]
fn flat_normals_keep_the_vertices_of_the_file_first() {
    let mut file = square(1.0);
    let indices = file.bytes("SCALAR", &[0, 1, 2, 1, 3, 2]);
    file.primitive()["indices"] = indices.into();
    let folded = mesh(&file);
    assert_eq!(folded.positions.len(), 6);
    assert_eq!(folded.positions[3], [1.0, 1.0, 1.0]);
    assert_eq!(folded.positions[4..], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(folded.indices, [0, 1, 2, 4, 3, 5]);
    assert_eq!(folded.normals[0], [0.0, 0.0, 1.0]);
    assert_eq!(folded.normals[3], folded.normals[4]);
    assert!(folded.normals[3][0] < -0.5);
    assert_eq!(folded.influences.weights.len(), 24);
    assert_note(&file.glb(), "meshes[0].primitives[0]: has no NORMAL");
}

#[test]
fn normals_are_scaled_to_unit_length() {
    let mut file = rigid();
    let normals = file.floats("VEC3", &[0.0, 0.0, 9.0, 0.0, -0.5, 0.0, 0.0, 0.0, 0.0]);
    file.primitive()["attributes"]["NORMAL"] = normals.into();
    assert_eq!(mesh(&file).normals, [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn primitive_without_positions_is_ignored() {
    let mut file = rigid();
    file.primitive()["attributes"].as_object_mut().unwrap().remove("POSITION");
    assert_note(&file.glb(), "meshes[0].primitives[0]: has no POSITION");
    assert!(loaded(&file.glb()).character.parts.is_empty());
}

#[test]
fn attributes_must_have_one_element_per_vertex() {
    let mut file = rigid();
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(2));
    let uvs = file.floats("VEC2", &[0.0; 8]);
    file.primitive()["attributes"]["NORMAL"] = normals.into();
    file.primitive()["attributes"]["TEXCOORD_0"] = uvs.into();
    assert_eq!(
        super::problems(&file.glb()),
        [
            "meshes[0].primitives[0]: has 2 elements of NORMAL, but 3 of POSITION; all \
             attributes must have the same number",
            "meshes[0].primitives[0]: has 4 elements of TEXCOORD_0, but 3 of POSITION; all \
             attributes must have the same number",
        ]
    );
}

#[test]
fn colours_with_three_or_four_components_load() {
    let mut file = rigid();
    let colors = file.floats("VEC3", &[0.5, 0.25, 1.0].repeat(3));
    file.primitive()["attributes"]["COLOR_0"] = colors.into();
    assert_eq!(mesh(&file).colors, [[0.5, 0.25, 1.0, 1.0]; 3]);
    let colors = file.bytes("VEC4", &[0, 51, 255, 102].repeat(3));
    file.json["accessors"][colors]["normalized"] = true.into();
    file.primitive()["attributes"]["COLOR_0"] = colors.into();
    assert_eq!(mesh(&file).colors, [[0.0, 0.2, 1.0, 0.4]; 3]);
    file.json["accessors"][colors]["normalized"] = false.into();
    assert_problem(
        &file.glb(),
        &format!("accessors[{colors}]: is VEC4 of 8-bit unsigned; COLOR_0 must be"),
    );
}

#[test]
fn morph_targets_are_noted_once() {
    let mut file = rigid();
    file.primitive()["targets"] = json!([{"POSITION": 0}]);
    assert_note(&file.glb(), "meshes[0].primitives[0]: has morph targets, which are ignored");
}

#[test]
fn unused_mesh_is_checked_only_for_accessor_indices() {
    let mut file = rigid();
    file.add("meshes", json!({"primitives": [{"attributes": {"JOINTS_7": 0}}]}));
    loaded(&file.glb());
    file.add("meshes", json!({"primitives": [{"attributes": {"POSITION": 77}}]}));
    assert_problem(
        &file.glb(),
        "meshes[2].primitives[0].attributes.POSITION: refers to accessor 77",
    );
}

#[test]
fn product_of_nodes_and_empty_primitives_is_limited() {
    let mut file = rigid();
    file.primitive()["mode"] = 0.into();
    let points = file.primitive().clone();
    file.json["meshes"][0]["primitives"] = vec![points; 2_000].into();
    file.json["nodes"] = vec![json!({"mesh": 0}); 20_000].into();
    let listed = super::problems(&file.glb());
    assert!(listed.iter().all(|p| p.contains("out of proportion")), "{listed:?}");
}
