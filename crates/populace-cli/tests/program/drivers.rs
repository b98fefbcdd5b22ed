//! OpenCL drivers that lack something: what the program says of them, and that it goes on without.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::post::Folder;

/// Where loaders look for the files that name drivers, unless told otherwise.
const VENDORS: &str = "/etc/OpenCL/vendors";

fn populace_with(variables: &[(&str, &str)], args: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_populace"));
    program.args(args).envs(variables.iter().copied()).output().expect("the program starts")
}

/// The devices listed, and what is said of those that cannot be used.
fn faults(variables: &[(&str, &str)]) -> (Vec<Value>, String) {
    let output = populace_with(variables, &["devices", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value =
        serde_json::from_slice(&output.stdout).expect("stdout is one JSON document");
    let devices = document["devices"].as_array().expect("a list").clone();
    let missing = devices.iter().filter(|d| d["device"].is_null());
    let said = missing.map(|d| format!("{}: {}\n", d["name"], d["detail"])).collect();
    (devices, said)
}

/// What is wrong with PoCL is told by `devices` and where it was asked for, and the native device
/// stands in for it where it was not.
#[track_caller]
fn passed_over(variables: &[(&str, &str)], words: &[&str]) {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let said_all = |said: &str| {
        for word in words {
            assert!(said.contains(word), "no {word:?} in: {said}");
        }
    };
    let (devices, said) = faults(variables);
    said_all(&said);
    let best: Vec<_> = devices.iter().filter(|d| d["best"] == true).map(|d| &d["device"]).collect();
    assert_eq!(best, ["native"]);
    let asked = populace_with(variables, &["pose", &file, "--device", "opencl"]);
    assert_eq!(asked.status.code(), Some(3));
    said_all(&String::from_utf8_lossy(&asked.stderr));
    let unasked = populace_with(variables, &["pose", &file, "--json"]);
    assert!(unasked.status.success());
    let document: Value =
        serde_json::from_slice(&unasked.stdout).expect("stdout is one JSON document");
    assert_eq!(document["device"], "native");
    let talk = String::from_utf8_lossy(&unasked.stderr);
    assert!(talk.contains("on the native device"), "{talk}");
    said_all(&talk);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn pocl_without_a_linker_is_passed_over() {
    let folder = Folder::new();
    let kernels = folder.text("kernels");
    passed_over(&[("PATH", ""), ("POCL_CACHE_DIR", &kernels)], &["ld", "PATH", "binutils"]);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn pocl_without_a_folder_for_its_kernels_is_passed_over() {
    let folder = Folder::new();
    let file = folder.text("post.gltf"); // no folder can be made in a file
    let kernels = format!("{file}/kernels");
    passed_over(&[("POCL_CACHE_DIR", &kernels)], &[&kernels, "cannot write", "POCL_CACHE_DIR"]);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn drivers_that_do_not_load_are_named_with_the_reason() {
    let folder = Folder::new();
    let vendors = folder.text("vendors");
    std::fs::create_dir(&vendors).unwrap();
    let absent = Path::new(&vendors).join("absent.icd");
    std::fs::write(&absent, "libpopulace_absent.so.1\n").unwrap();
    let variables = [("OCL_ICD_VENDORS", vendors.as_str())];
    let words = ["libpopulace_absent.so.1", "absent.icd", "No such file"];
    passed_over(&variables, &words);
    // Beside a driver that loads, too.
    for file in std::fs::read_dir(VENDORS).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), Path::new(&vendors).join(file.file_name())).unwrap();
    }
    let (devices, said) = faults(&variables);
    assert!(devices.iter().any(|d| d["device"] == "opencl:0"), "{devices:?}");
    for word in words {
        assert!(said.contains(word), "no {word:?} in: {said}");
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn devices_are_listed_without_building_a_kernel() {
    let folder = Folder::new();
    let [kernels, programs] = ["kernels", "programs"].map(|name| folder.text(name));
    let (devices, _) = faults(&[("POCL_CACHE_DIR", &kernels), ("POPULACE_CACHE_DIR", &programs)]);
    assert!(devices.iter().any(|d| d["device"] == "opencl:0"), "{devices:?}");
    // PoCL makes a folder for each program that it builds.
    let built: Vec<_> =
        std::fs::read_dir(&kernels).unwrap().flatten().filter(|e| e.path().is_dir()).collect();
    assert!(built.is_empty() && !Path::new(&programs).exists(), "{built:?}");
}
