//! Tests of input files and standard input, and of their limits.

use std::io::Write;
use std::process::{Command, Output, Stdio};

use serde_json::json;

use super::post::{Folder, post};
use super::{json_of, populace, refused};

/// Runs the program with bytes on its standard input.
fn run_with_input(args: &[&str], bytes: &[u8]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_populace"));
    program.args(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = program.spawn().expect("the program starts");
    // Fails if the program closes its end early.
    let _ = running.stdin.take().expect("a pipe").write_all(bytes);
    running.wait_with_output().expect("the program ends")
}

#[test]
fn outside_files_need_allow_outside() {
    let folder = Folder::new();
    let mut file = post();
    let length = file["buffers"][0]["byteLength"].as_u64().expect("a length");
    file["buffers"][0]["uri"] = "../secret".into();
    std::fs::create_dir(folder.path("model")).expect("a folder");
    std::fs::write(folder.path("model/post.gltf"), file.to_string()).expect("written");
    let secret = vec![0; usize::try_from(length).expect("small")];
    let (path, picture) = (folder.text("model/post.gltf"), folder.text("out.png"));
    let commands: [&[&str]; 4] = [
        &["inspect", &path],
        &["pose", &path],
        &["render", &path, "--members", "1", "--out", &picture],
        &["pose", &folder.text("post.gltf"), "--clips", &path],
    ];
    for command in commands {
        std::fs::write(folder.path("secret"), &secret).expect("written");
        let existing = populace(command).stderr;
        refused(command, 1, &["buffers[0].uri", "\"../secret\"", "--allow-outside"]);
        std::fs::remove_file(folder.path("secret")).expect("removed");
        assert_eq!(
            populace(command).stderr,
            existing,
            "{command:?} must not reveal whether the file exists"
        );
        refused(&[command, &["--allow-outside"]].concat(), 1, &["cannot be read"]);
    }
}

#[test]
fn files_above_the_memory_limit_are_refused_with_the_flag() {
    let folder = Folder::new();
    let mut file = post();
    // An accessor without data consists of zeros, so a small file can claim a large one.
    let accessors = file["accessors"].as_array_mut().expect("accessors");
    accessors.push(json!({"componentType": 5125, "count": 16 << 20, "type": "SCALAR"}));
    file["meshes"][0]["primitives"][0]["indices"] = 7.into();
    std::fs::write(folder.path("large.gltf"), file.to_string()).expect("written");
    let large = folder.text("large.gltf");
    let limit = ["--memory-limit", "8"];
    let words =
        ["large.gltf", "accessors[7]: needs 64 MiB", "memory limit is 8 MiB", "--memory-limit"];
    for command in
        [&["inspect", &large][..], &["pose", &large], &["render", &large, "--out", "never.png"]]
    {
        refused(&[command, &limit].concat(), 1, &words);
    }
    refused(&["inspect", &large, "--memory-limit", "0"], 2, &["--memory-limit"]);
}

#[test]
fn dash_reads_standard_input() {
    let file = post().to_string();
    let inspected = run_with_input(&["inspect", "-", "--json"], file.as_bytes());
    let document: serde_json::Value =
        serde_json::from_slice(&inspected.stdout).expect("a document");
    assert_eq!((&document["joints"], &document["file"]), (&json!(2), &json!("-")));
    let folder = Folder::new();
    let posed = run_with_input(
        &["pose", &folder.text("post.gltf"), "--clips", "-", "--clip", "1"],
        file.as_bytes(),
    );
    assert_eq!(posed.status.code(), Some(0), "{posed:?}");
    for (args, bytes, code, words) in [
        (&["inspect", "-"][..], &b"GIF89a"[..], 1, "standard input is refused"),
        (&["render", "-", "--out", "x.png"], b"id,frame,x,y\n", 1, "scenes are read by their path"),
        (&["inspect", "-", "-"], file.as_bytes(), 2, "- is given twice"),
        (&["pose", "-", "--memory-limit", "1"], &[b' '; 2 << 20], 1, "--memory-limit"),
    ] {
        let output = run_with_input(args, bytes);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && stderr.contains(words), "{args:?}: {stderr}");
    }
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_without_blocking() {
    let folder = Folder::new();
    let pipe = folder.text("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    for file in [pipe.as_str(), "/dev/zero", &folder.text("")] {
        for command in [&["inspect", file][..], &["pose", file], &["bench", "--from", file]] {
            refused(command, 1, &["it is not a regular file"]);
        }
    }
}

#[test]
fn files_of_no_known_kind_are_told_what_is_read() {
    let folder = Folder::new();
    let (file, out) = (folder.text("a.png"), folder.text("b.png"));
    let picture = &b"\x89PNG\r\n\x1a\n\0\0"[..];
    for (bytes, words) in [
        (picture, ["a PNG picture", "positions of people"]),
        (&b"\x01\x02\0\0"[..], ["a binary file", "--format NAME"]),
    ] {
        std::fs::write(&file, bytes).expect("written");
        let words = [&words[..], &[".glb, .gltf, .vrm", "scenes end in .toml"]].concat();
        refused(&["render", &file, "--out", &out], 1, &words);
        refused(&["inspect", &file], 1, &words);
    }
}

#[test]
fn vertices_use_the_indices_of_the_file() {
    let folder = Folder::new();
    let mut file = post();
    // Some triangles of this strip are degenerate and have other normals, so the importer appends
    // vertices for them.
    file["meshes"][0]["primitives"][0]["mode"] = 5.into();
    file["meshes"][0]["primitives"][0].as_object_mut().expect("an object").remove("indices");
    std::fs::write(folder.path("strip.gltf"), file.to_string()).expect("written");
    let strip = folder.text("strip.gltf");
    let pose = ["pose", &strip, "--vertices", "--json"];
    let d = json_of(&pose);
    let vertices = d["vertices"].as_array().expect("vertices");
    let numbers: Vec<_> = vertices.iter().map(|v| v[2].as_u64().expect("a number")).collect();
    assert_eq!(numbers, (0..8).collect::<Vec<_>>());
    assert_eq!(json_of(&["inspect", &strip, "--json"])["parts"][0]["vertices"], 8);
    refused(&[&pose[..], &["--vertex", "0,0,8"]].concat(), 2, &["no vertex 8"]);
}
