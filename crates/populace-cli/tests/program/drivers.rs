//! Tests of incomplete OpenCL drivers: they are reported, and the program works without them.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::post::Folder;

/// The default folder of the files that name OpenCL drivers.
const VENDORS: &str = "/etc/OpenCL/vendors";

fn populace_with(variables: &[(&str, &str)], args: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_populace"));
    program.args(args).envs(variables.iter().copied()).output().expect("the program starts")
}

/// Returns the listed devices, and the descriptions of unusable ones.
fn list_devices(variables: &[(&str, &str)]) -> (Vec<Value>, String) {
    let output = populace_with(variables, &["devices", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value =
        serde_json::from_slice(&output.stdout).expect("stdout is one JSON document");
    let devices = document["devices"].as_array().expect("a list").clone();
    let missing = devices.iter().filter(|d| d["device"].is_null());
    let faults = missing.map(|d| format!("{}: {}\n", d["name"], d["detail"])).collect();
    (devices, faults)
}

/// Asserts that a fault of PoCL is reported by `devices` and by runs that name the device, and that
/// other runs fall back to the native device.
#[track_caller]
fn assert_falls_back(variables: &[(&str, &str)], words: &[&str]) {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let assert_reported = |faults: &str| {
        for word in words {
            assert!(faults.contains(word), "no {word:?} in: {faults}");
        }
    };
    let (devices, faults) = list_devices(variables);
    assert_reported(&faults);
    let best: Vec<_> = devices.iter().filter(|d| d["best"] == true).map(|d| &d["device"]).collect();
    assert_eq!(best, ["native"]);
    let named = populace_with(variables, &["pose", &file, "--device", "opencl"]);
    assert_eq!(named.status.code(), Some(3));
    assert_reported(&String::from_utf8_lossy(&named.stderr));
    let unnamed = populace_with(variables, &["pose", &file, "--json"]);
    assert!(unnamed.status.success());
    let document: Value =
        serde_json::from_slice(&unnamed.stdout).expect("stdout is one JSON document");
    assert_eq!(document["device"], "native");
    let stderr = String::from_utf8_lossy(&unnamed.stderr);
    assert!(stderr.contains("using the native device"), "{stderr}");
    assert_reported(&stderr);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn pocl_without_a_linker_falls_back_to_native() {
    let folder = Folder::new();
    let kernels = folder.text("kernels");
    assert_falls_back(&[("PATH", ""), ("POCL_CACHE_DIR", &kernels)], &["ld", "PATH", "binutils"]);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn pocl_without_a_cache_folder_falls_back_to_native() {
    let folder = Folder::new();
    let file = folder.text("post.gltf"); // a file cannot contain a folder
    let kernels = format!("{file}/kernels");
    assert_falls_back(
        &[("POCL_CACHE_DIR", &kernels)],
        &[&kernels, "cannot write", "POCL_CACHE_DIR"],
    );
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn unloadable_drivers_are_named_with_the_reason() {
    let folder = Folder::new();
    let vendors = folder.text("vendors");
    std::fs::create_dir(&vendors).unwrap();
    let absent = Path::new(&vendors).join("absent.icd");
    std::fs::write(&absent, "libpopulace_absent.so.1\n").unwrap();
    let variables = [("OCL_ICD_VENDORS", vendors.as_str())];
    let words = ["libpopulace_absent.so.1", "absent.icd", "No such file"];
    assert_falls_back(&variables, &words);
    // The fault is also reported if another driver loads.
    for file in std::fs::read_dir(VENDORS).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), Path::new(&vendors).join(file.file_name())).unwrap();
    }
    let (devices, faults) = list_devices(&variables);
    assert!(devices.iter().any(|d| d["device"] == "opencl:0"), "{devices:?}");
    for word in words {
        assert!(faults.contains(word), "no {word:?} in: {faults}");
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn devices_builds_no_kernel() {
    let folder = Folder::new();
    let [kernels, programs] = ["kernels", "programs"].map(|name| folder.text(name));
    let (devices, _) =
        list_devices(&[("POCL_CACHE_DIR", &kernels), ("POPULACE_CACHE_DIR", &programs)]);
    assert!(devices.iter().any(|d| d["device"] == "opencl:0"), "{devices:?}");
    // PoCL creates a folder for each program that it builds.
    let built: Vec<_> =
        std::fs::read_dir(&kernels).unwrap().flatten().filter(|e| e.path().is_dir()).collect();
    assert!(built.is_empty() && !Path::new(&programs).exists(), "{built:?}");
}
