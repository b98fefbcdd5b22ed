//! `populace inspect`

mod gaits;
mod recording;
mod rows;

use std::path::PathBuf;
use std::sync::Arc;

use populace::character::Character;
use populace::clip::Clip;
use populace::model::{RoleMap, Skeleton};
use populace_assets::Imported;
use serde_json::{Value, json};

use crate::cli::InspectArgs;
use crate::failure::Failure;
use crate::report;
use crate::trajectory::is_trajectory;
use rows::ClipSizes;

/// Points between two rows at which the error is measured.
const ERROR_POINTS: usize = 4;

pub(crate) fn run(args: &InspectArgs) -> Result<(), Failure> {
    if !args.files.iter().any(|file| is_trajectory(file)) {
        args.read.refuse_unused()?;
    }
    if args.rows {
        return run_rows(args);
    }
    if args.json && args.files.len() > 1 {
        return Err(Failure::usage("--json describes one file; give several only with --rows"));
    }
    for file in &args.files {
        let name = file.display().to_string();
        if is_trajectory(file) {
            let recording = args.read.load(file)?;
            if args.json {
                let trajectory = recording::as_json(&recording);
                report::json(&json!({"schema": 1, "file": name, "trajectory": trajectory}))?;
            } else {
                report::text(&format!("{name}\n{}", recording::as_text(&recording)))?;
            }
            continue;
        }
        let document = describe(args.input.load(file)?, &name);
        if args.json { report::json(&document)? } else { report::text(&as_text(&document))? }
    }
    Ok(())
}

/// Shows the sizes of clips.
fn run_rows(args: &InspectArgs) -> Result<(), Failure> {
    if let Some(file) = args.files.iter().find(|file| is_trajectory(file)) {
        let name = file.display();
        return Err(Failure::usage(format!(
            "--rows is for characters; {name} is a trajectory file"
        )));
    }
    let load = |file: &PathBuf| Ok(ClipSizes::new(file, &args.input.load(file)?));
    let sizes = args.files.iter().map(load).collect::<Result<Vec<_>, Failure>>()?;
    if args.json {
        report::json(&rows::as_json(&sizes))
    } else {
        report::text(&rows::as_table(&sizes))
    }
}

fn describe(imported: Imported, file: &str) -> Value {
    let character = &Arc::new(imported.character);
    let skeleton = &character.skeleton;
    let describe_clip = |clip| describe_clip(clip, character);
    let clips: Vec<_> = character.clips.iter().map(describe_clip).collect();
    let skins: Vec<_> = character
        .skins
        .iter()
        .map(|s| json!({"skin": s.skin, "node": s.node, "joints": s.joints.len()}))
        .collect();
    let notes: Vec<_> =
        imported.notes.iter().map(|n| json!({"place": n.place, "what": n.what})).collect();
    json!({
        "schema": 1,
        "file": file,
        "height_m": character.height_m(),
        "joints": skeleton.joint_count(),
        "depth": skeleton.levels().len(),
        "palette_entries": character.palette.len(),
        "skins": skins,
        "roles": describe_roles(skeleton),
        "parts": describe_parts(character, &imported.vertex_counts),
        "materials": describe_materials(character),
        "images": describe_images(character),
        "clips": clips,
        "notes": notes,
    })
}

/// Describes the naming convention and the joint of each humanoid role; null if the body is not
/// humanoid.
fn describe_roles(skeleton: &Skeleton) -> Value {
    RoleMap::detect(skeleton).map_or(Value::Null, |roles| {
        let joints: serde_json::Map<_, _> = roles
            .iter()
            .map(|(role, joint)| (role.to_string(), skeleton.name(joint).into()))
            .collect();
        json!({"naming": roles.naming(), "joints": joints})
    })
}

fn describe_clip(clip: &Arc<Clip>, character: &Arc<Character>) -> Value {
    let stats = clip.stats();
    json!({
        "name": clip.name(),
        "start_secs": clip.start_secs(),
        "duration_secs": clip.duration_secs(),
        "tracks": clip.source().tracks.len(),
        "rows": stats.row_count,
        "evenly_spaced": stats.evenly_spaced,
        "row_bytes": stats.row_bytes,
        "key_bytes": stats.key_bytes,
        "worst_error_m": clip.measured_error_m(&character.skeleton, ERROR_POINTS),
        "error_bound_m": stats.error_bound_m,
        "tolerance_m": stats.tolerance_m,
        "gait": gaits::as_json(character, clip),
    })
}

fn describe_parts(character: &Character, vertex_counts: &[usize]) -> Vec<Value> {
    let describe = |(part, vertex_count): (&populace::character::Part, &usize)| {
        json!({
            "node": part.node,
            "name": part.node_name,
            "primitive": part.primitive,
            "vertices": vertex_count,
            "triangles": part.mesh.indices.len() / 3,
            "influences": part.mesh.influences.per_vertex,
            "material": part.material,
        })
    };
    character.parts.iter().zip(vertex_counts).map(describe).collect()
}

fn describe_materials(character: &Character) -> Vec<Value> {
    let describe = |material: &populace::character::Material| {
        json!({
            "name": material.name,
            "base_color": material.base_color,
            "image": material.base_color_texture.map(|t| t.image),
            "alpha": format!("{:?}", material.alpha),
            "double_sided": material.double_sided,
        })
    };
    character.materials.iter().map(describe).collect()
}

fn describe_images(character: &Character) -> Vec<Value> {
    let images = character.images.iter();
    images.map(|image| json!({"width": image.width, "height": image.height})).collect()
}

fn as_text(d: &Value) -> String {
    let list = |name: &str| d[name].as_array().cloned().unwrap_or_default();
    let mut text = format!(
        "{}\n  {:.3} m high, {} joints in {} levels, {} palette entries\n",
        d["file"].as_str().unwrap_or_default(),
        d["height_m"].as_f64().unwrap_or_default(),
        d["joints"],
        d["depth"],
        d["palette_entries"]
    );
    for s in list("skins") {
        text += &format!("  skin {} on node {}: {} joints\n", s["skin"], s["node"], s["joints"]);
    }
    if let Some(roles) = d["roles"]["joints"].as_object() {
        let naming = d["roles"]["naming"].as_str().unwrap_or_default();
        text += &format!("  humanoid: {} roles found by {naming} names\n", roles.len());
    }
    for p in list("parts") {
        text += &format!(
            "  part {} (node {}, primitive {}): {} vertices, {} triangles, {} influences each, \
             material {}\n",
            p["name"],
            p["node"],
            p["primitive"],
            p["vertices"],
            p["triangles"],
            p["influences"],
            p["material"]
        );
    }
    for (index, m) in list("materials").iter().enumerate() {
        text += &format!(
            "  material {index} {}: colour {}, image {}, {}{}\n",
            m["name"],
            m["base_color"],
            m["image"],
            m["alpha"].as_str().unwrap_or_default(),
            if m["double_sided"] == true { ", double-sided" } else { "" }
        );
    }
    for (index, i) in list("images").iter().enumerate() {
        text += &format!("  image {index}: {} x {} pixels\n", i["width"], i["height"]);
    }
    for (index, c) in list("clips").iter().enumerate() {
        text += &clip_line(index, c);
    }
    for n in list("notes") {
        let part = |name: &str| n[name].as_str().unwrap_or_default().to_owned();
        text += &format!("  note: {}: {}\n", part("place"), part("what"));
    }
    text
}

fn clip_line(index: usize, c: &Value) -> String {
    let number = |name: &str| c[name].as_f64().unwrap_or_default();
    format!(
        "  clip {index} {}: {:.3} s from {:.3} s, {} rows{}, worst error {:.3} mm of {:.3} \
         mm\n{}",
        c["name"],
        number("duration_secs"),
        number("start_secs"),
        c["rows"],
        if c["evenly_spaced"] == true { " evenly spaced" } else { "" },
        number("worst_error_m") * 1e3,
        number("tolerance_m") * 1e3,
        gaits::as_text(&c["gait"]),
    )
}
