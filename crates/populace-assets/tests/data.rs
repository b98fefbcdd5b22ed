//! One test for each file in the folder `POPULACE_TEST_DATA` (environment variable). Bad files must
//! be refused with the expected problems, unusual ones must load, and the rest pose of characters
//! must agree with an independent computation.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};
use libtest_mimic::{Arguments, Failed, Trial};
use populace_assets::{Error, Imported, load};
use populace_character::Character;
use populace_model::Affine;
use serde_json::Value;

mod expectations;

use expectations::Expected;

const VARIABLE: &str = "POPULACE_TEST_DATA";
const FOLDERS: [&str; 4] = ["gltf_bad", "gltf_edge", "characters", "animals"];

fn main() {
    let mut arguments = Arguments::from_args();
    let trials = std::env::var_os(VARIABLE).map_or_else(ignored, |root| trials(Path::new(&root)));
    // Decoding needs much memory, so not every core of a large machine runs a test.
    arguments.test_threads = arguments.test_threads.or(Some(2));
    libtest_mimic::run(&arguments, trials).exit();
}

fn ignored() -> Vec<Trial> {
    let name =
        format!("files (set {VARIABLE} to the folder of test data to run one test per file)");
    vec![Trial::test(name, || Ok(())).with_ignored_flag(true)]
}

fn trials(root: &Path) -> Vec<Trial> {
    let reference = read_reference(root);
    let mut files = Vec::new();
    for folder in FOLDERS {
        collect(&root.join(folder), &mut files);
    }
    files.sort();
    let mut trials = vec![Trial::test("the folder holds files and reference vertices", {
        let found = (files.len(), reference.as_object().map_or(0, serde_json::Map::len));
        move || check(found.0 > 100 && found.1 > 10, || format!("only {found:?} were found"))
    })];
    for path in files {
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let expected = reference.get(&name).cloned();
        trials.push(Trial::test(name.clone(), move || run(&name, &path, expected.as_ref())));
    }
    trials
}

fn read_reference(root: &Path) -> Value {
    let text = std::fs::read(root.join("reference/skinned_vertices.json")).unwrap_or_default();
    serde_json::from_slice(&text).unwrap_or_default()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            files.push(path);
        }
    }
}

fn check(holds: bool, message: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(message().into()) }
}

fn run(name: &str, path: &Path, reference: Option<&Value>) -> Result<(), Failed> {
    let expected = expectations::of(name)
        .ok_or("this file of `gltf_bad` is not in tests/expectations; add the expected result")?;
    match (expected, load(path)) {
        (Expected::Loads, Ok(imported)) => check_loaded(name, &imported, reference),
        (Expected::LoadsWithNote(what), Ok(imported)) => {
            let notes: Vec<_> = imported.notes.iter().map(ToString::to_string).collect();
            check(notes.iter().any(|n| n.contains(what)), || {
                format!("no note says `{what}`: {notes:#?}")
            })?;
            check_loaded(name, &imported, reference)
        }
        (Expected::Refused(reasons), Err(Error::Rejected { problems, .. })) => {
            let problems: Vec<_> = problems.iter().map(ToString::to_string).collect();
            for reason in reasons {
                check(problems.iter().any(|p| p.contains(reason)), || {
                    format!("no problem says `{reason}`: {problems:#?}")
                })?;
            }
            Ok(())
        }
        (Expected::Refused(_), Ok(imported)) => {
            Err(format!("loads, with {:#?}", imported.notes).into())
        }
        (_, Err(error)) => Err(error.to_string().into()),
    }
}

fn check_loaded(name: &str, imported: &Imported, reference: Option<&Value>) -> Result<(), Failed> {
    if let Some(reference) = reference {
        check_rest(name, imported, reference)?;
    }
    let skeleton = &imported.character.skeleton;
    for clip in &imported.character.clips {
        let stats = clip.stats();
        check(stats.error_bound_m <= stats.tolerance_m, || {
            format!("clip \"{}\" has an error bound of {} m", clip.name(), stats.error_bound_m)
        })?;
        if reference.is_some() && stats.row_count * skeleton.joint_count() <= 5000 {
            let error = clip.measured_error_m(skeleton, 5);
            check(error <= stats.tolerance_m, || {
                format!(
                    "clip \"{}\" is off by {error} m, more than {} m",
                    clip.name(),
                    stats.tolerance_m
                )
            })?;
        }
    }
    Ok(())
}

/// Compares the bounds of the rest pose, the clip names and single vertices with the reference.
fn check_rest(name: &str, imported: &Imported, reference: &Value) -> Result<(), Failed> {
    let rest = &reference["rest"];
    let corner = |key: &str| -> Vec<f64> {
        rest[key].as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
    };
    let (low, high) = (corner("lo"), corner("hi"));
    let bounds = imported.character.rest_bounds().ok_or("there are no bounds")?;
    let part_of_height = if name.contains("quantized") { 2e-3 } else { 1e-4 };
    let tolerance = part_of_height * (high[1] - low[1]);
    for axis in 0..3 {
        let off = (f64::from(bounds.low[axis]) - low[axis])
            .abs()
            .max((f64::from(bounds.high[axis]) - high[axis]).abs());
        check(off <= tolerance, || {
            format!("bounds {bounds:?} are off by {off}, wanted {low:?} to {high:?}")
        })?;
    }
    let clips = reference["clips"].as_array().into_iter().flatten();
    for clip in clips {
        let index = clip["clip"]
            .as_u64()
            .and_then(|i| usize::try_from(i).ok())
            .ok_or("a clip has no index")?;
        let named = imported.character.clips.get(index).map(|c| c.name());
        check(named == clip["name"].as_str(), || {
            format!("clip {index} is named {named:?}, not {}", clip["name"])
        })?;
    }
    for vertex in rest["verts"].as_array().into_iter().flatten() {
        check_vertex(&imported.character, vertex, tolerance)?;
    }
    Ok(())
}

/// Compares a vertex in the rest pose with a row `[node, primitive, vertex, x, y, z]`.
fn check_vertex(character: &Character, row: &Value, tolerance: f64) -> Result<(), Failed> {
    let index = |i: usize| row[i].as_u64().and_then(|v| usize::try_from(v).ok());
    let part = character
        .parts
        .iter()
        .find(|p| Some(p.node) == index(0) && Some(p.primitive) == index(1))
        .ok_or_else(|| format!("there is no part for {row}"))?;
    let vertex =
        index(2).filter(|v| *v < part.mesh.positions.len()).ok_or("there are too few vertices")?;
    let skeleton = &character.skeleton;
    let mut models: Vec<DAffine3> = Vec::new();
    for joint in skeleton.joints() {
        let local = affine(&Affine::from_trs(skeleton.rest(joint)));
        models.push(skeleton.parent(joint).map_or(local, |p| models[p.index()] * local));
    }
    let position = DVec3::from_array(part.mesh.positions[vertex].map(f64::from));
    let width = part.mesh.influences.per_vertex;
    let mut sum = DVec3::ZERO;
    for at in vertex * width..(vertex + 1) * width {
        let entry = &character.palette[usize::from(part.mesh.influences.entries[at])];
        let moved = (models[entry.joint.index()] * affine(&entry.joint_from_bind))
            .transform_point3(position);
        sum += moved * f64::from(part.mesh.influences.weights[at]);
    }
    let wanted = DVec3::from_array([3, 4, 5].map(|i| row[i].as_f64().unwrap_or(f64::NAN)));
    let off = (sum - wanted).abs().max_element();
    check(off <= tolerance, || format!("{row} is off by {off}"))
}

fn affine(m: &Affine) -> DAffine3 {
    let [x, y, z] = m.rows.map(|row| row.map(f64::from));
    DAffine3::from_cols_array_2d(&[0, 1, 2, 3].map(|c| [x[c], y[c], z[c]]))
}
