use serde_json::json;

use super::builder::rigid;
use super::{assert_note, assert_problem, loaded};

#[test]
fn unsupported_required_extensions_are_refused() {
    for name in [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
        "KHR_texture_basisu",
        "ACME_joints_of_another_kind",
    ] {
        let mut file = rigid();
        file.json["extensionsUsed"] = json!([name]);
        assert_note(&file.glb(), &format!("extensionsUsed[0]: uses {name}, which is ignored"));
        file.json["extensionsRequired"] = json!(["KHR_texture_transform", name]);
        assert_problem(&file.glb(), &format!("extensionsRequired[1]: requires {name}"));
    }
}

#[test]
fn appearance_extensions_are_ignored_with_a_note() {
    for name in ["KHR_materials_unlit", "KHR_materials_clearcoat", "KHR_lights_punctual"] {
        let mut file = rigid();
        file.json["extensionsUsed"] = json!([name]);
        file.json["extensionsRequired"] = json!([name]);
        assert_note(&file.glb(), &format!("extensionsUsed[0]: uses {name}, which is ignored"));
    }
    let mut file = rigid();
    for supported in ["KHR_mesh_quantization", "KHR_texture_transform", "EXT_texture_webp"] {
        file.json["extensionsUsed"] = json!([supported]);
        file.json["extensionsRequired"] = json!([supported]);
        assert!(loaded(&file.glb()).notes.is_empty(), "{supported}");
    }
    file.json["extensionsRequired"] = json!([7]);
    assert_problem(&file.glb(), "extensionsRequired[0]: must be a string");
}
