use populace_model::{Interpolation, Property};
use serde_json::json;

use super::builder::{File, skinned};
use super::{assert_note, assert_problem, loaded};

/// Returns the skinned file with the given keys in the only sampler of its clip.
fn with_keys(times: &[f32], kind: &str, values: &[f32], path: &str, interpolation: &str) -> File {
    let mut file = skinned();
    let input = file.floats("SCALAR", times);
    let output = file.floats(kind, values);
    let animation = &mut file.json["animations"][0];
    animation["samplers"][0] =
        json!({"input": input, "output": output, "interpolation": interpolation});
    animation["channels"][0]["target"]["path"] = path.into();
    file
}

#[test]
fn channels_become_tracks_of_named_joints() {
    let imported = loaded(&skinned().glb());
    let clip = &imported.character.clips[0];
    assert_eq!(clip.name(), "turn");
    assert_eq!((clip.start_secs(), clip.duration_secs()), (0.5, 1.0));
    let track = &clip.source().tracks[0];
    assert_eq!((track.joint.as_str(), track.property), ("head", Property::Rotation));
    assert_eq!(track.interpolation, Interpolation::Linear);
    assert_eq!(track.times, [0.5, 1.5]);
    assert_eq!(track.values[..4], [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn steps_splines_translations_and_scales_are_read() {
    let steps =
        with_keys(&[0.0, 1.0], "VEC3", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "translation", "STEP");
    let track = loaded(&steps.glb()).character.clips[0].source().tracks[0].clone();
    assert_eq!((track.property, track.interpolation), (Property::Translation, Interpolation::Step));
    assert_eq!(track.value(1), [4.0, 5.0, 6.0]);
    let values: Vec<f32> = (0..18).map(|v| v as f32).collect();
    let spline = with_keys(&[0.0, 1.0], "VEC3", &values, "scale", "CUBICSPLINE");
    let track = loaded(&spline.glb()).character.clips[0].source().tracks[0].clone();
    assert_eq!(
        (track.property, track.interpolation),
        (Property::Scale, Interpolation::CubicSpline)
    );
    assert_eq!((track.value(0), track.value(1)), (&[3.0, 4.0, 5.0][..], &[12.0, 13.0, 14.0][..]));
}

#[test]
fn rotations_may_be_normalised_integers() {
    let mut file = skinned();
    let turns: Vec<u8> =
        [0i8, 0, 0, 127, 0, 90, 0, -128].iter().map(|v| v.cast_unsigned()).collect();
    let output = file.accessor(&turns, 5120, 2, "VEC4");
    file.json["animations"][0]["samplers"][0]["output"] = output.into();
    assert_problem(
        &file.glb(),
        &format!("accessors[{output}]: is VEC4 of 8-bit signed; values of rotation must be"),
    );
    file.json["accessors"][output]["normalized"] = true.into();
    let track = loaded(&file.glb()).character.clips[0].source().tracks[0].clone();
    assert_eq!(track.values, [0.0, 0.0, 0.0, 1.0, 0.0, 90.0 / 127.0, 0.0, -1.0]);
}

#[test]
fn invalid_key_times_and_values_are_refused() {
    let same = with_keys(&[1.0, 1.0], "VEC3", &[0.0; 6], "scale", "LINEAR");
    assert_problem(&same.glb(), "animations[0].samplers[0]: has key 1 at 1 s after key 0 at 1 s");
    let few = with_keys(&[0.0, 1.0], "VEC3", &[0.0; 9], "scale", "LINEAR");
    assert_problem(&few.glb(), "animations[0].channels[0]: has 2 keys and 3 values");
    let single = with_keys(&[0.0], "VEC3", &[0.0; 9], "scale", "CUBICSPLINE");
    assert_problem(
        &single.glb(),
        "animations[0].samplers[0]: has 1 keys; a cubic spline needs at least 2",
    );
    let zero = with_keys(
        &[0.0, 1.0],
        "VEC4",
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        "rotation",
        "LINEAR",
    );
    assert_problem(
        &zero.glb(),
        "animations[0].samplers[0]: has a rotation of length zero in element 1",
    );
    let kind = with_keys(&[0.0], "VEC4", &[0.0; 4], "scale", "LINEAR");
    assert!(
        super::problems(&kind.glb())[0].contains("is VEC4 of float; values of scale must be VEC3")
    );
    let word = with_keys(&[0.0], "VEC3", &[1.0; 3], "scale", "BEZIER");
    assert_problem(&word.glb(), "animations[0].samplers[0].interpolation: is \"BEZIER\"");
}

#[test]
fn rotation_tangents_may_have_length_zero() {
    let mut values = [0.0; 24];
    (values[7], values[19]) = (1.0, 1.0);
    loaded(&with_keys(&[0.0, 1.0], "VEC4", &values, "rotation", "CUBICSPLINE").glb());
}

#[test]
fn unsupported_channels_are_noted_and_the_clip_kept() {
    let mut file = skinned();
    let target =
        |file: &mut File, target| file.json["animations"][0]["channels"][0]["target"] = target;
    let place = "animations[0].channels[0].target: ";
    for (value, note) in [
        (json!({"path": "rotation"}), "has no node"),
        (json!({"node": 2, "path": "weights"}), "drives morph targets"),
        (json!({"path": "pointer"}), "drives a pointer"),
        (json!({"node": 2, "path": "colour"}), "has the unknown path \"colour\""),
    ] {
        target(&mut file, value);
        assert_note(&file.glb(), &format!("{place}{note}"));
        let imported = loaded(&file.glb());
        assert!(imported.character.clips[0].source().tracks.is_empty());
        assert_eq!(imported.character.clips[0].name(), "turn");
    }
    file.json["animations"][0] = json!({"channels": [], "samplers": []});
    assert_eq!(loaded(&file.glb()).character.clips.len(), 1);
}

#[test]
fn duplicate_targets_and_matrix_nodes_are_refused() {
    let mut file = skinned();
    let again = file.json["animations"][0]["channels"][0].clone();
    file.json["animations"][0]["channels"].as_array_mut().unwrap().push(again);
    assert_problem(&file.glb(), "animations[0].channels[1]: drives the same property of node 2");
    let mut file = skinned();
    file.json["nodes"][2].as_object_mut().unwrap().remove("translation");
    file.json["nodes"][2]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]);
    assert_problem(
        &file.glb(),
        "animations[0].channels[0].target: drives node 2, which has a matrix",
    );
}

#[test]
fn channels_share_a_sampler() {
    let mut file = skinned();
    let animation = &mut file.json["animations"][0];
    let channels = animation["channels"].as_array_mut().unwrap();
    channels.push(json!({"sampler": 0, "target": {"node": 1, "path": "rotation"}}));
    let clip = loaded(&file.glb()).character.clips[0].clone();
    let joints: Vec<_> = clip.source().tracks.iter().map(|t| t.joint.as_str()).collect();
    assert_eq!(joints, ["head", "hips"]);
    assert_eq!(clip.source().tracks[0].values, clip.source().tracks[1].values);
}

#[test]
fn clips_of_a_file_without_meshes_bind_by_name() {
    let mut clips = skinned();
    for list in ["meshes", "skins"] {
        clips.json.as_object_mut().unwrap().remove(list);
    }
    clips.json["nodes"][0] = json!({"name": "tail"});
    clips.json["animations"][0]["channels"]
        .as_array_mut()
        .unwrap()
        .push(json!({"sampler": 0, "target": {"node": 0, "path": "rotation"}}));
    let clips = loaded(&clips.glb()).character;
    assert!(clips.parts.is_empty());
    let body = loaded(&skinned().glb()).character;
    let binding = populace_retarget::Binding::new(&clips.clips[0], &body.skeleton);
    assert_eq!(binding.bound_joint_count(), 1, "the body has a head and no tail");
}

#[test]
fn product_of_keys_and_joints_is_limited() {
    let mut file = skinned();
    let times: Vec<f32> = (0..20_000).map(|t| t as f32).collect();
    let input = file.floats("SCALAR", &times);
    let output = file.floats("VEC3", &vec![1.0; 60_000]);
    file.json["animations"][0]["samplers"][0] = json!({"input": input, "output": output});
    file.json["animations"][0]["channels"][0]["target"]["path"] = "scale".into();
    let first = file.json["nodes"].as_array().unwrap().len();
    for _ in 0..5_000 {
        file.add("nodes", json!({}));
    }
    file.json["nodes"][2]["children"] = (first..first + 5_000).collect::<Vec<_>>().into();
    assert_problem(
        &file.glb(),
        "animations[0]: needs rows of 5002 joints at 20000 key times; together with",
    );
}
