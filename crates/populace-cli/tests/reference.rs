//! Compares `populace pose` with vertices that were computed independently from the glTF 2.0
//! specification.
//!
//! There is one test per device and file of `reference/skinned_vertices.json` in the folder that
//! `POPULACE_TEST_DATA` names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};
use serde_json::Value;

/// Allowed error of float data in units of the model's height.
const TOLERANCE: f64 = 1e-4;
/// Allowed error of 8-bit keys in units of the model's height.
const TOLERANCE_8_BIT: f64 = 2e-3;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(2);
    let trials = match std::env::var_os("POPULACE_TEST_DATA") {
        Some(folder) => trials(Path::new(&folder)),
        None => {
            let name = "reference (POPULACE_TEST_DATA does not name a folder of test data)";
            vec![Trial::test(name, || Ok(())).with_ignored_flag(true)]
        }
    };
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trials(folder: &Path) -> Vec<Trial> {
    let path = folder.join("reference/skinned_vertices.json");
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|e| panic!("cannot read {}: {e}", path.display()));
    let entries: BTreeMap<String, Value> =
        serde_json::from_str(&text).expect("the reference is JSON");
    let mut trials = Vec::new();
    for device in ["native", "opencl"] {
        for (file, entry) in &entries {
            let (path, entry) = (folder.join(file), entry.clone());
            let trial =
                Trial::test(format!("{device}: {file}"), move || check_file(&path, &entry, device));
            trials.push(trial.with_ignored_flag(device == "opencl" && cfg!(skip_opencl)));
        }
    }
    trials
}

fn check_file(path: &PathBuf, entry: &Value, device: &str) -> Result<(), Failed> {
    let rest = &entry["rest"];
    let height = number(&rest["hi"][1]) - number(&rest["lo"][1]);
    let quantised = path.to_string_lossy().contains("quantized");
    let allowed = height * if quantised { TOLERANCE_8_BIT } else { TOLERANCE };
    let clips = entry["clips"].as_array().into_iter().flatten();
    for pose in std::iter::once(rest).chain(clips) {
        check_pose(path, pose, device, allowed)?;
    }
    Ok(())
}

fn check_pose(path: &PathBuf, pose: &Value, device: &str, allowed: f64) -> Result<(), Failed> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_populace"));
    command.arg("pose").arg(path).args(["--json", "--vertices", "--device", device]);
    if pose["clip"].is_number() {
        command.args(["--clip", &pose["clip"].to_string(), "--time", &pose["t"].to_string()]);
    }
    let wanted = pose["verts"].as_array().expect("vertices");
    for row in wanted {
        command.args(["--vertex", &format!("{},{},{}", row[0], row[1], row[2])]);
    }
    let output = command.output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let document: Value = serde_json::from_slice(&output.stdout).map_err(|e| e.to_string())?;
    let found = document["vertices"].as_array().expect("vertices");
    if found.len() != wanted.len() {
        return Err(format!("{} vertices instead of {}", found.len(), wanted.len()).into());
    }
    for (found, wanted) in found.iter().zip(wanted) {
        let off =
            (3..6).map(|i| (number(&found[i]) - number(&wanted[i])).abs()).fold(0.0, f64::max);
        if off > allowed {
            let at = format!("clip {} at {} s", pose["clip"], pose["t"]);
            return Err(format!(
                "{at}: {found} is off by {off:.6}, {allowed:.6} is allowed; expected {wanted}"
            )
            .into());
        }
    }
    Ok(())
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}
