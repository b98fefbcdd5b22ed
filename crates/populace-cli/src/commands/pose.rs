//! `populace pose`

use std::sync::Arc;

use populace::character::{Character, Part, SkinInstance};
use populace::model::{Affine, JointIndex};
use populace::{ClipId, Crowd, Placement};
use populace_assets::Imported;
use serde_json::{Value, json};

use crate::aim;
use crate::cli::{PoseArgs, VertexId, build};
use crate::failure::Failure;
use crate::mix::{self, SlotArg};
use crate::report::{self, as_typed};
use crate::roles;
use crate::skin::skinned;

pub(crate) fn run(args: &PoseArgs) -> Result<(), Failure> {
    if !args.time.is_finite() {
        return Err(Failure::usage(format!(
            "the time is {}; it must be a finite number of seconds",
            args.time
        )));
    }
    mix::check(&args.slot, &args.layer)?;
    let imported = args.input.load(&args.file)?;
    let document = evaluate(&imported, args)?;
    if args.json { report::json(&document) } else { report::text(&as_text(&document)) }
}

fn evaluate(imported: &Imported, args: &PoseArgs) -> Result<Value, Failure> {
    let character = Arc::new(imported.character.clone());
    // --clip and --time describe one slot.
    let named = args.clip.as_deref().map(|clip| SlotArg::alone(clip, args.time));
    let slots = named.as_ref().map_or(args.slot.as_slice(), std::slice::from_ref);
    let mut crowd = build(args.device.crowd().capacity(1).slots_per_member(slots.len().max(1)))?;
    #[cfg(unix)]
    crate::aborts::exit_on_abort();
    let id = crowd.add_character(Arc::clone(&character))?;
    if let Some(file) = &args.clips {
        for clip in roles::load_clips(&mut roles::Loader::new(&args.input), file)? {
            crowd.character_mut(id)?.add_clip(&clip)?;
        }
    }
    let member = crowd.spawn(id, Placement::at([0.0; 3]))?;
    let find = |crowd: &Crowd, name: &str| find_clip(crowd, id, name);
    let (mixed, layers) = mix::apply(&mut crowd, (id, member), (slots, &args.layer), find)?;
    let [looks_at, reaches] = aim::apply(&mut crowd, (id, member), args.look_at, &args.reach)?;
    crowd.update(0.0)?;
    let palette = crowd.member_mut(member)?.palette()?;
    let models = crowd.member_mut(member)?.model_from_joints()?;
    let skins: Vec<_> = character
        .skins
        .iter()
        .map(|skin| skin_palette(skin, &character, &palette, &models))
        .collect();
    let vertices = if args.vertices {
        skinned_vertices(imported, &palette, &args.vertex)?
    } else {
        Vec::new()
    };
    Ok(json!({
        "schema": 1,
        "file": args.file.display().to_string(),
        "clip": if named.is_some() { mixed[0]["clip"].clone() } else { Value::Null },
        "time": if args.slot.is_empty() { json!(as_typed(args.time)) } else { Value::Null },
        "slots": mixed,
        "layers": layers,
        "look_at": looks_at,
        "reach": reaches,
        "device": crowd.device_info().devices.to_string(),
        "schedule": crowd.device_info().schedule.name(),
        "joints": joints(imported, &models),
        "skins": skins,
        "vertices": vertices,
    }))
}

/// Finds a clip by name or, failing that, by index.
fn find_clip(
    crowd: &Crowd,
    id: populace::CharacterId,
    name: &str,
) -> Result<(ClipId, String), Failure> {
    let unknown = match roles::clip(crowd, id, name) {
        Ok(clip) => return Ok((clip, name.to_owned())),
        Err(failure) => failure,
    };
    let clips = crowd.character(id)?.clips();
    match name.parse::<usize>().ok().map(|index| clips.get(index)) {
        Some(Some((clip, known))) => Ok((*clip, known.name().to_owned())),
        Some(None) => {
            let count = clips.len();
            Err(Failure::usage(format!("there is no clip {name}; the file has {count} clips")))
        }
        None => Err(unknown),
    }
}

fn joints(imported: &Imported, models: &[Affine]) -> Vec<Value> {
    let skeleton = &imported.character.skeleton;
    let describe = |joint: JointIndex| {
        json!({
            "name": skeleton.name(joint),
            "node": imported.node_from_joint[joint.index()],
            "parent": skeleton.parent(joint).map(|p| p.0),
            "model_from_joint": models[joint.index()].to_cols_array(),
        })
    };
    skeleton.joints().map(describe).collect()
}

/// Returns a skin's palette in the order of the file's joints. A joint that moves no vertex has no
/// palette entry on the device, so its matrix is computed here.
fn skin_palette(
    skin: &SkinInstance,
    character: &Character,
    palette: &[Affine],
    models: &[Affine],
) -> Value {
    let matrices = skin.joints.iter().map(|wanted| {
        let entry = character.palette.iter().position(|entry| entry == wanted);
        entry.map_or_else(
            || models[wanted.joint.index()].mul(&wanted.joint_from_bind),
            |e| palette[e],
        )
    });
    let rows: Vec<Vec<f32>> = matrices.map(|m| m.rows.concat()).collect();
    json!({"skin": skin.skin, "node": skin.node, "palette": rows})
}

/// Skins the vertices of the file. Vertices that the importer appended to a part are skipped.
fn skinned_vertices(
    imported: &Imported,
    palette: &[Affine],
    wanted: &[VertexId],
) -> Result<Vec<Value>, Failure> {
    let parts = || imported.character.parts.iter().zip(&imported.vertex_counts);
    let row = |part: &Part, vertex: usize| {
        let [x, y, z] = skinned(part, vertex, palette);
        json!([part.node, part.primitive, vertex, x, y, z])
    };
    if wanted.is_empty() {
        return Ok(parts()
            .flat_map(|(part, count)| (0..*count).map(move |v| row(part, v)))
            .collect());
    }
    let find = |id: &VertexId| {
        let part = parts().find(|(p, _)| p.node == id.node && p.primitive == id.primitive);
        let (part, _) = part.filter(|(_, count)| id.vertex < **count).ok_or_else(|| {
            let VertexId { node, primitive, vertex } = id;
            Failure::usage(format!(
                "the file has no vertex {vertex} of primitive {primitive} of node {node}"
            ))
        })?;
        Ok(row(part, id.vertex))
    };
    wanted.iter().map(find).collect()
}

fn as_text(d: &Value) -> String {
    let slot = |slot: &Value| {
        let clip = slot["clip"].as_str().unwrap_or_default();
        let weight = if slot["weight"] == 1.0 {
            String::new()
        } else {
            format!(" with weight {}", slot["weight"])
        };
        let layer =
            if slot["layer"] == 0 { String::new() } else { format!(" in layer {}", slot["layer"]) };
        format!("\"{clip}\" at {} s{weight}{layer}", slot["time"])
    };
    let slots: Vec<_> = d["slots"].as_array().into_iter().flatten().map(slot).collect();
    let clip = if slots.is_empty() { "rest pose".to_owned() } else { slots.join(", ") };
    let part = |name: &str| d[name].as_str().unwrap_or_default().to_owned();
    let mut text =
        format!("{clip} on {}, {}; joints in model space:\n", part("device"), part("schedule"));
    for joint in d["joints"].as_array().into_iter().flatten() {
        let m = |i: usize| joint["model_from_joint"][i].as_f64().unwrap_or_default();
        text += &format!(
            "  {:<32} {:9.4} {:9.4} {:9.4}\n",
            joint["name"].as_str().unwrap_or(""),
            m(12),
            m(13),
            m(14)
        );
    }
    for v in d["vertices"].as_array().into_iter().flatten() {
        let at = |i: usize| v[i].as_f64().unwrap_or_default();
        let place = format!("node {} primitive {} vertex {}", v[0], v[1], v[2]);
        text += &format!("  {place:<32} {:9.4} {:9.4} {:9.4}\n", at(3), at(4), at(5));
    }
    text
}
