//! Extensions: supported, ignored and refused ones.

use crate::json::Cursor;
use crate::log::Checked;

/// Materials with diffuse and specular colours.
pub(crate) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// Supported extensions.
const SUPPORTED: [&str; 6] = [
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_materials_emissive_strength",
    SPECULAR_GLOSSINESS,
    "EXT_texture_webp",
    "MSFT_lod",
];

/// Extensions that can be ignored even if a file requires them: they change the appearance of a
/// character or its surroundings, not its motion. Material extensions of all vendors are harmless
/// too (see [`is_material`]).
const HARMLESS: [&str; 4] =
    ["KHR_lights_punctual", "KHR_xmp", "KHR_xmp_json_ld", "KHR_node_visibility"];

/// Well-known extensions that are refused if a file requires them, with the reason and the remedy.
const REFUSED: [(&str, &str); 4] = [
    (
        "KHR_draco_mesh_compression",
        "meshes compressed by Draco cannot be read; export without compression",
    ),
    (
        "EXT_meshopt_compression",
        "data compressed by meshopt cannot be read; export without compression",
    ),
    (
        "KHR_meshopt_compression",
        "data compressed by meshopt cannot be read; export without compression",
    ),
    ("KHR_texture_basisu", "Basis Universal textures cannot be read; export PNG, JPEG or WebP"),
];

/// Extensions of a file that affect later stages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extensions {
    /// Whether vertex data may be stored as integers.
    pub(crate) mesh_quantization: bool,
}

/// Refuses required extensions that are not supported, and notes ignored ones (glTF 2.0, section
/// 3.12).
pub(crate) fn check(root: &Cursor) -> Checked<Extensions> {
    let mut failed = None;
    let mut mesh_quantization = false;
    for at in root.list("extensionsRequired") {
        let Ok(name) = at.text() else { continue };
        mesh_quantization |= name == "KHR_mesh_quantization";
        if !SUPPORTED.contains(&name) && !is_harmless(name) {
            let why = REFUSED.iter().find(|(refused, _)| *refused == name);
            let why = why.map_or("it is not supported; export without it", |(_, why)| why);
            failed = Some(at.problem(format!("requires {name}: {why}")));
        }
    }
    for at in root.list("extensionsUsed") {
        let Ok(name) = at.text() else { continue };
        mesh_quantization |= name == "KHR_mesh_quantization";
        if !SUPPORTED.contains(&name) {
            at.note(format!("uses {name}, which is ignored: {}", why_ignored(name)));
        }
    }
    failed.map_or(Ok(Extensions { mesh_quantization }), Err)
}

fn is_harmless(name: &str) -> bool {
    is_material(name) || HARMLESS.contains(&name)
}

/// Returns whether an extension concerns materials. Names consist of vendor, subject and feature,
/// such as `KHR_materials_unlit`.
fn is_material(name: &str) -> bool {
    name.contains("_materials_")
}

fn why_ignored(name: &str) -> &'static str {
    match name {
        "KHR_animation_pointer" => "only translation, rotation and scale of nodes are animated",
        "KHR_lights_punctual" => "characters have no lights",
        "KHR_texture_basisu" => "the PNG or JPEG alternative is used",
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "the uncompressed alternative is used"
        }
        _ if is_material(name) => {
            "colour, metal, roughness, normals, occlusion and emission of materials are read, \
             nothing else"
        }
        _ => "it is not supported, and the file does not require it",
    }
}
