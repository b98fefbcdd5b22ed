//! Expected results for files that do not load without problems or particular notes.

/// Expected result of loading a file.
#[derive(Clone, Copy)]
pub(crate) enum Expected {
    /// It loads.
    Loads,
    /// It loads, and one of the notes contains this text.
    LoadsWithNote(&'static str),
    /// It is refused, and each of these texts is contained in one of the problems.
    Refused(&'static [&'static str]),
}

use Expected::{Loads, LoadsWithNote, Refused};

const TIMES_WITHOUT_DATA: Expected = LoadsWithNote("animations[0].channels[0]: has no key times");

/// Expected results by path. All files in `gltf_bad/` must be listed. Other files are expected to
/// load unless listed.
const TABLE: &[(&str, Expected)] = &[
    (
        "gltf_bad/asset_generator/Mesh_NoPosition/Mesh_NoPosition_00.gltf",
        LoadsWithNote("meshes[0].primitives[0]: has no POSITION"),
    ),
    (
        "gltf_bad/asset_generator/Mesh_NoPosition/Mesh_NoPosition_01.gltf",
        LoadsWithNote("meshes[0].primitives[0]: has no POSITION"),
    ),
    (
        "gltf_bad/assimp/IndexOutOfRange/AllIndicesOutOfRange.gltf",
        Refused(&[
            "accessors[0]: holds index 65535 in element 0",
            "36 of 36 indices are out of range",
        ]),
    ),
    (
        "gltf_bad/assimp/IndexOutOfRange/IndexOutOfRange.gltf",
        Refused(&["accessors[0]: holds index 255", "1 of 36 indices are out of range"]),
    ),
    (
        "gltf_bad/assimp/MissingBin/BoxTextured.gltf",
        Refused(&["buffers[0].uri: refers to \"BoxTextured0.bin\", which cannot be read"]),
    ),
    (
        "gltf_bad/assimp/SchemaFailures/sceneWrongType.gltf",
        Refused(&["scene: must be a whole number, but is a string"]),
    ),
    ("gltf_bad/magnum/scene-default-oob.gltf", Refused(&["scene: refers to scene 0"])),
    (
        "gltf_bad/magnum/scene-invalid-child-not-root.gltf",
        Refused(&["scenes[0].nodes[1]: refers to node 1, which is a child of node 0"]),
    ),
    (
        "gltf_bad/magnum/scene-invalid-child-oob.gltf",
        Refused(&["nodes[4].children[0]: refers to node 7"]),
    ),
    (
        "gltf_bad/magnum/scene-invalid-children-property.gltf",
        Refused(&["nodes[1].children: must be an array"]),
    ),
    ("gltf_bad/magnum/scene-invalid-cycle-deep.gltf", Refused(&["nodes[0]: is its own ancestor"])),
    ("gltf_bad/magnum/scene-invalid-cycle.gltf", Refused(&["nodes[0]: is its own ancestor"])),
    ("gltf_bad/magnum/scene-invalid-extras-property.gltf", Refused(&["is not valid JSON"])),
    (
        "gltf_bad/magnum/scene-invalid-multiple-parents.gltf",
        Refused(&["nodes[1].children: lists node 2 as a child"]),
    ),
    ("gltf_bad/magnum/scene-invalid-nested-extras-property.gltf", Refused(&["is not valid JSON"])),
    (
        "gltf_bad/magnum/scene-invalid-node-oob.gltf",
        Refused(&["scenes[0].nodes[0]: refers to node 7"]),
    ),
    (
        "gltf_bad/magnum/scene-invalid-nodes-property.gltf",
        Refused(&["scenes[1].nodes: must be an array"]),
    ),
    (
        "gltf_bad/magnum/scene-invalid.gltf",
        Refused(&[
            "meshes[0].primitives[0].material: refers to material 4",
            "meshes[1].primitives[1].material: refers to material 5",
            "meshes[4].primitives[1].material: is -1",
            "nodes[3].camera: refers to camera 1",
            "nodes[7].mesh: refers to mesh 5",
            "nodes[8].skin: refers to skin 3",
            "nodes[9].skin: refers to skin 3",
            "nodes[10].mesh: is -1",
            "nodes[12].camera: is -1",
            "nodes[13].skin: is -1",
            "nodes[14].extensions: must be an object",
            "nodes[17].translation: must be an array of 3 numbers",
            "nodes[18].translation: has 2 numbers",
            "nodes[19].rotation: must be an array of 4 numbers",
            "nodes[20].rotation: has 3 numbers",
            "nodes[21].scale: must be",
            "nodes[22].scale: has 2 numbers",
            "nodes[23].matrix: must be",
            "nodes[24].matrix: has 4 numbers",
        ]),
    ),
    (
        "gltf_bad/tinygltf/BoundsChecking/integer-out-of-bounds.gltf",
        Refused(&["bufferViews[0].byteLength: is 1e+300"]),
    ),
    (
        "gltf_bad/tinygltf/BoundsChecking/invalid-buffer-index.gltf",
        Refused(&["bufferViews[1].buffer: refers to buffer 1"]),
    ),
    (
        "gltf_bad/tinygltf/BoundsChecking/invalid-buffer-view-index.gltf",
        Refused(&[
            "bufferViews[0].buffer: refers to buffer 0",
            "accessors[0].bufferView: refers to buffer view 1",
        ]),
    ),
    (
        "gltf_bad/tinygltf/BoundsChecking/invalid-primitive-indices.gltf",
        Refused(&[
            "meshes[0].primitives[0].indices: refers to accessor 1",
            "accessors[0].bufferView: refers to buffer view 1",
        ]),
    ),
    (
        "gltf_bad/validator/accessor/alignment.gltf",
        Refused(&[
            "accessors[0]: starts at byte 1",
            "accessors[1]: starts at byte 4",
            "accessors[2]: starts at byte 32",
            "accessors[2]: has 1 elements of 12 bytes from byte 32 on, which do not fit",
            "accessors[3]: has 10 elements of 6 bytes from byte 0 on, which do not fit",
        ]),
    ),
    (
        "gltf_bad/validator/accessor/byteoffset_no_bufferview.gltf",
        Refused(&["accessors[0]: has a byteOffset, but no bufferView"]),
    ),
    ("gltf_bad/validator/accessor/custom_property.gltf", Loads),
    ("gltf_bad/validator/accessor/empty_array.gltf", LoadsWithNote("accessors: is empty")),
    (
        "gltf_bad/validator/accessor/empty_object.gltf",
        Refused(&[
            "accessors[0].componentType: is missing",
            "accessors[0].count: is missing",
            "accessors[0].type: is missing",
        ]),
    ),
    (
        "gltf_bad/validator/accessor/float_normalized.gltf",
        Refused(&["accessors[0]: is normalised"]),
    ),
    (
        "gltf_bad/validator/accessor/invalid_sparse_count_and_stride.gltf",
        Refused(&["accessors[0].sparse.count: is 2"]),
    ),
    (
        "gltf_bad/validator/accessor/matrix_alignment.gltf",
        Refused(&[
            "accessors[0]: starts at byte 1",
            "accessors[4]: starts at byte 2",
            "accessors[0]: has 2 elements of 8 bytes",
            "accessors[4]: has 2 elements of 32 bytes",
        ]),
    ),
    (
        "gltf_bad/validator/accessor/small_stride.gltf",
        Refused(&[
            "accessors[0]: has elements of 16 bytes, but bufferViews[0] has a byteStride of 4",
        ]),
    ),
    (
        "gltf_bad/validator/accessor/unknown_type.gltf",
        Refused(&["accessors[0].type: is \"NotaVEC3\"", "accessors[1].type: is"]),
    ),
    (
        "gltf_bad/validator/accessor/unresolved_bufferviews.gltf",
        Refused(&[
            "accessors[0].bufferView: refers to",
            "accessors[0].sparse.indices.bufferView: refers to",
            "accessors[0].sparse.values.bufferView: refers to",
        ]),
    ),
    ("gltf_bad/validator/accessor/valid.gltf", Loads),
    (
        "gltf_bad/validator/animation/channel_duplicate_targets.gltf",
        Refused(&["animations[0].channels[1]: drives the same property of node 0 as \
                   animations[0].channels[0]"]),
    ),
    (
        "gltf_bad/validator/animation/channel_node_matrix.gltf",
        Refused(&["animations[0].channels[0].target: drives node 0, which has a matrix"]),
    ),
    (
        "gltf_bad/validator/animation/channel_node_no_morphs.gltf",
        LoadsWithNote("drives morph targets, which are ignored"),
    ),
    ("gltf_bad/validator/animation/custom_property.gltf", Loads),
    ("gltf_bad/validator/animation/empty_array.gltf", LoadsWithNote("animations: is empty")),
    (
        "gltf_bad/validator/animation/empty_objects.gltf",
        Refused(&[
            "animations[2].samplers[0].input: is missing",
            "animations[2].samplers[0].output: is missing",
            "animations[2].channels[0].sampler: is missing",
            "animations[2].channels[0].target: is missing",
            "animations[2].channels[1].sampler: is missing",
            "animations[2].channels[1].target.path: is missing",
        ]),
    ),
    (
        "gltf_bad/validator/animation/sampler_bufferview_bytestride.gltf",
        Refused(&["buffers[0]: has no uri"]),
    ),
    (
        "gltf_bad/validator/animation/sampler_input_format_invalid.gltf",
        Refused(&["accessors[0]: is SCALAR of 32-bit unsigned; key times must be SCALAR of float"]),
    ),
    (
        "gltf_bad/validator/animation/sampler_input_no_bounds.gltf",
        LoadsWithNote("animations[0].samplers[0]: has key times without min and max"),
    ),
    (
        "gltf_bad/validator/animation/sampler_output_count_invalid.gltf",
        Refused(&["animations[0].channels[0]: has 1 keys and 2 values"]),
    ),
    (
        "gltf_bad/validator/animation/sampler_output_format_invalid.gltf",
        Refused(&["accessors[1]: is VEC4 of float; values of scale must be VEC3"]),
    ),
    (
        "gltf_bad/validator/animation/sampler_too_few_cubic_frames.gltf",
        Refused(&["animations[0].samplers[0]: has 1 keys; a cubic spline needs at least 2"]),
    ),
    (
        "gltf_bad/validator/animation/unresolved_channel_sampler.gltf",
        Refused(&["animations[0].channels[0].sampler: refers to sampler 1"]),
    ),
    (
        "gltf_bad/validator/animation/unresolved_channel_target.gltf",
        Refused(&["animations[0].channels[0].target.node: refers to node 0"]),
    ),
    (
        "gltf_bad/validator/animation/unresolved_sampler_input.gltf",
        Refused(&["animations[0].samplers[0].input: refers to accessor 1"]),
    ),
    (
        "gltf_bad/validator/animation/unresolved_sampler_output.gltf",
        Refused(&["animations[0].samplers[0].output: refers to accessor 1"]),
    ),
    ("gltf_bad/validator/animation/valid.gltf", TIMES_WITHOUT_DATA),
    ("gltf_bad/validator/buffer/custom_property.gltf", Loads),
    ("gltf_bad/validator/buffer/data_uri.glb", Loads),
    ("gltf_bad/validator/buffer/empty_array.gltf", LoadsWithNote("buffers: is empty")),
    (
        "gltf_bad/validator/buffer/empty_object.gltf",
        Refused(&["buffers[0].byteLength: is missing"]),
    ),
    (
        "gltf_bad/validator/buffer/extra_padding.glb",
        LoadsWithNote("buffers[0]: is shorter than the BIN chunk"),
    ),
    (
        "gltf_bad/validator/buffer/invalid_object.gltf",
        Refused(&["buffers[0]: must be an object, but is an array"]),
    ),
    (
        "gltf_bad/validator/buffer/invalid_uri_data.glb",
        Refused(&["buffers[0].uri: is a data: URI without a comma"]),
    ),
    (
        "gltf_bad/validator/buffer/invalid_uri_data.gltf",
        Refused(&["buffers[0].uri: is a data: URI with a parameter"]),
    ),
    (
        "gltf_bad/validator/buffer/invalid_uri_data_bytelength.gltf",
        Refused(&[
            "buffers[0]: has 1 bytes, but 2 are declared",
            "buffers[1].byteLength: is missing",
        ]),
    ),
    (
        "gltf_bad/validator/buffer/invalid_uri_data_mime.gltf",
        LoadsWithNote("buffers[0].uri: has the media type \"application/octet-stream2\""),
    ),
    (
        "gltf_bad/validator/buffer/invalid_uri_scheme.gltf",
        Refused(&["buffers[0].uri: is a \":\" URI"]),
    ),
    (
        "gltf_bad/validator/buffer/no_bin_chunk.glb",
        LoadsWithNote("buffers[0]: has no uri; nothing that is drawn or animated uses it"),
    ),
    (
        "gltf_bad/validator/buffer/non_relative_uri.gltf",
        Refused(&["buffers[0].uri: is a \"http:\" URI"]),
    ),
    ("gltf_bad/validator/buffer/not_found.gltf", LoadsWithNote("buffers[0]: is not opened")),
    ("gltf_bad/validator/buffer/valid.glb", Loads),
    ("gltf_bad/validator/buffer/valid.gltf", Loads),
    ("gltf_bad/validator/buffer/valid_placeholder.glb", Loads),
    (
        "gltf_bad/validator/buffer/wrong_bytelength.glb",
        Refused(&["buffers[0]: has 16 bytes, but 17 are declared"]),
    ),
    ("gltf_bad/validator/buffer/zero_bytelength.gltf", Refused(&["buffers[0].byteLength: is 0"])),
    ("gltf_bad/validator/glb/bom.glb", Refused(&["chunk 0: begins with a byte order mark"])),
    ("gltf_bad/validator/glb/chunk_too_big.glb", Refused(&["header: says the file has 13 bytes"])),
    ("gltf_bad/validator/glb/empty_file.glb", Refused(&["file: is empty"])),
    ("gltf_bad/validator/glb/empty_json_chunk.glb", Refused(&["chunk 0: is empty"])),
    ("gltf_bad/validator/glb/empty_json_object.glb", Refused(&["asset: is missing"])),
    ("gltf_bad/validator/glb/extra_data.glb", LoadsWithNote("the rest is ignored")),
    ("gltf_bad/validator/glb/invalid_json_chunk.glb", Refused(&["is not valid JSON"])),
    ("gltf_bad/validator/glb/invalid_magic.glb", Refused(&["file: is not a glTF file"])),
    ("gltf_bad/validator/glb/invalid_version.glb", Refused(&["header: says container version 0"])),
    (
        "gltf_bad/validator/glb/json_and_two_buffers.glb",
        Refused(&["chunk 2: is a second BIN chunk"]),
    ),
    (
        "gltf_bad/validator/glb/length_mismatch.glb",
        Refused(&["header: says the file has 49 bytes, but it ends after 48"]),
    ),
    (
        "gltf_bad/validator/glb/misplaced_bin_chunk.glb",
        Refused(&["chunk 2: is BIN, which must be the second chunk"]),
    ),
    ("gltf_bad/validator/glb/no_header.glb", Refused(&["file: is not a glTF file"])),
    (
        "gltf_bad/validator/glb/only_bin_chunk.glb",
        Refused(&["chunk 0: is of kind 0x004e4942; the first chunk must be JSON"]),
    ),
    (
        "gltf_bad/validator/glb/only_header.glb",
        Refused(&["header: says the file has 12 bytes, too few"]),
    ),
    (
        "gltf_bad/validator/glb/truncated_chunk_data.glb",
        Refused(&["header: says the file has 48 bytes, but it ends after 47"]),
    ),
    (
        "gltf_bad/validator/glb/truncated_chunk_header.glb",
        Refused(&["header: says the file has 13 bytes"]),
    ),
    ("gltf_bad/validator/glb/two_bin_chunks.glb", Refused(&["chunk 0: is of kind 0x004e4942"])),
    (
        "gltf_bad/validator/glb/two_empty_bin_chunks.glb",
        Refused(&["chunk 0: is of kind 0x004e4942"]),
    ),
    (
        "gltf_bad/validator/glb/two_empty_json_chunks.glb",
        Refused(&["chunk 0: is empty", "chunk 1: is a second JSON chunk"]),
    ),
    ("gltf_bad/validator/glb/two_images.glb", Loads),
    (
        "gltf_bad/validator/glb/two_valid_json_chunks.glb",
        Refused(&["chunk 1: is a second JSON chunk"]),
    ),
    (
        "gltf_bad/validator/glb/unaligned_chunk.glb",
        Refused(&["chunk 0: has 27 bytes; chunks must be padded"]),
    ),
    ("gltf_bad/validator/glb/unknown_chunk.glb", Refused(&["chunk 0: is of kind 0x4e4b4e55"])),
    ("gltf_bad/validator/glb/valid.glb", Loads),
    ("gltf_bad/validator/glb/valid_buffer.glb", Loads),
    ("gltf_bad/validator/glb/zero_chunk_header.glb", Refused(&["chunk 0: is of kind 0x00000000"])),
    ("gltf_bad/validator/glb/zero_length.glb", Refused(&["header: says the file has 0 bytes"])),
    (
        "gltf_bad/validator/skin/buffer_view_bytestride.gltf",
        LoadsWithNote("skins[0]: has inverse bind matrices in a buffer view with a byteStride"),
    ),
    ("gltf_bad/validator/skin/custom_property.gltf", Loads),
    ("gltf_bad/validator/skin/empty_array.gltf", LoadsWithNote("skins: is empty")),
    ("gltf_bad/validator/skin/empty_joints_array.gltf", Refused(&["skins[0].joints: is empty"])),
    ("gltf_bad/validator/skin/empty_object.gltf", Refused(&["skins[0].joints: is missing"])),
    (
        "gltf_bad/validator/skin/ibm_invalid_count.gltf",
        Refused(&["skins[2]: has 3 joints, but only 2 inverse bind matrices"]),
    ),
    (
        "gltf_bad/validator/skin/ibm_invalid_format.gltf",
        Refused(&["accessors[0]: is MAT3 of float; inverse bind matrices must be MAT4 of float"]),
    ),
    ("gltf_bad/validator/skin/ignored_animated_transform.gltf", TIMES_WITHOUT_DATA),
    ("gltf_bad/validator/skin/ignored_local_transform.gltf", Loads),
    ("gltf_bad/validator/skin/ignored_parent_transform.gltf", Loads),
    (
        "gltf_bad/validator/skin/no_common_root.gltf",
        LoadsWithNote("skins[0]: has joints without a common root"),
    ),
    (
        "gltf_bad/validator/skin/no_joints_in_scene.gltf",
        LoadsWithNote("skins[0]: has joints that are not in the scene"),
    ),
    (
        "gltf_bad/validator/skin/skeleton_invalid.gltf",
        LoadsWithNote("skins[0].skeleton: is not an ancestor of all joints"),
    ),
    (
        "gltf_bad/validator/skin/unresolved_ibm.gltf",
        Refused(&["skins[0].inverseBindMatrices: refers to accessor 0"]),
    ),
    (
        "gltf_bad/validator/skin/unresolved_joint.gltf",
        Refused(&["skins[0].joints[0]: refers to node 0"]),
    ),
    (
        "gltf_bad/validator/skin/unresolved_skeleton.gltf",
        Refused(&["skins[0].skeleton: refers to node 1"]),
    ),
    ("gltf_bad/validator/skin/valid.gltf", Loads),
    (
        "gltf_edge/asset_generator/Compatibility/Compatibility_04.gltf",
        LoadsWithNote("asset.minVersion: asks for version 2.1"),
    ),
    (
        "gltf_edge/asset_generator/Compatibility/Compatibility_05.gltf",
        LoadsWithNote("uses FAKE_materials_quantumRendering, which is ignored"),
    ),
    (
        "gltf_edge/khronos/interpolation_test_missing_image.gltf",
        LoadsWithNote("images[0]: refers to \"l.jpg\", which cannot be read"),
    ),
    (
        "gltf_edge/magnum/animation.gltf",
        LoadsWithNote("animations[1].channels[0]: has no key times"),
    ),
    (
        "gltf_edge/magnum/scene-transformation.gltf",
        LoadsWithNote("nodes[0]: has both a matrix and translation"),
    ),
    (
        "gltf_edge/synthetic/channel_without_node.glb",
        LoadsWithNote("animations[0].channels[0].target: has no node"),
    ),
    ("gltf_edge/synthetic/default_scene_1.glb", LoadsWithNote("has 2 scenes; scene 1 is imported")),
    (
        "gltf_edge/variants/girl_draco.glb",
        Refused(&["extensionsRequired[0]: requires KHR_draco_mesh_compression"]),
    ),
    (
        "gltf_edge/variants/girl_meshopt.glb",
        Refused(&["extensionsRequired[1]: requires EXT_meshopt_compression"]),
    ),
];

/// Returns the expected result for a path relative to the data folder. Returns `None` for a file in
/// `gltf_bad/` that is not listed.
pub(crate) fn of(name: &str) -> Option<Expected> {
    let listed = TABLE.iter().find(|(listed, _)| *listed == name);
    match listed {
        Some((_, expected)) => Some(*expected),
        None if name.starts_with("gltf_bad/") => None,
        None => Some(Loads),
    }
}
