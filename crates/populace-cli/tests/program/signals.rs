//! Tests of runs that are ended by signals.

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::post::Folder;

fn start(folder: &Folder, args: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_populace"));
    command.args(args).current_dir(folder.path("")).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

/// Sends a signal and returns the exit code and stderr.
fn end_by(signal: &str, child: Child) -> (Option<i32>, String) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status();
    assert!(sent.expect("a shell").success());
    let output = child.wait_with_output().expect("it ends");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn interrupted_render_leaves_complete_frames_and_counts_them() {
    check_interrupted("native");
}

/// Drivers with a compiler install signal handlers of their own.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn interrupted_render_on_opencl_leaves_complete_frames() {
    check_interrupted("opencl");
}

fn check_interrupted(device: &str) {
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let folder = Folder::new();
        let film =
            ["render", "@child", "--members", "2", "--frames", "100000", "--out", "film.png"];
        let mut child =
            start(&folder, &[&film[..], &["--size", "64x64", "--device", device]].concat());
        while !folder.path("film_0002.png").exists() {
            assert!(child.try_wait().expect("a child").is_none(), "the program ended early");
            std::thread::sleep(Duration::from_millis(5));
        }
        let (found, stderr) = end_by(signal, child);
        assert_eq!(found, Some(code), "{stderr}");
        let mut frames = 0;
        for entry in std::fs::read_dir(folder.path("")).expect("a folder") {
            let name = entry.expect("a file").file_name().into_string().expect("a name");
            if name != "post.gltf" {
                assert!(name.starts_with("film_"), "{name} remains");
                image::open(folder.path(&name)).expect("a whole PNG");
                frames += 1;
            }
        }
        assert!(
            stderr.contains(&format!("interrupted; {frames} of 100000 frames are complete")),
            "{stderr}"
        );
    }
}

/// The address space limit allows the program to start, but not to build the crowd.
#[cfg(target_os = "linux")]
#[test]
fn out_of_memory_exits_with_4() {
    let folder = Folder::new();
    let script = "ulimit -v 200000; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_populace"), "bench", "--members", "100000"]);
    let command = command.args(["--device", "native:1"]).current_dir(folder.path(""));
    let output = command.output().expect("a shell");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(stderr.contains("memory"), "{stderr}");
}

/// A driver that runs out of memory aborts.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn abort_exits_with_4_and_leaves_complete_frames() {
    let folder = Folder::new();
    let film = ["render", "@child", "--members", "2", "--frames", "3000", "--out", "film.png"];
    let mut child =
        start(&folder, &[&film[..], &["--size", "64x64", "--device", "opencl"]].concat());
    while !folder.path("film_0002.png").exists() {
        assert!(child.try_wait().expect("a child").is_none(), "the program ended early");
        std::thread::sleep(Duration::from_millis(5));
    }
    let (code, stderr) = end_by("ABRT", child);
    assert_eq!(code, Some(4), "{stderr}");
    assert!(stderr.contains("memory ran out, or a driver gave up"), "{stderr}");
    let mut frames = std::fs::read_dir(folder.path("")).expect("a folder");
    assert!(frames.all(|entry| image_or_model(&folder, &entry.expect("a file").file_name())));
}

/// Returns whether a file is the model or a complete picture.
fn image_or_model(folder: &Folder, name: &std::ffi::OsStr) -> bool {
    name == "post.gltf" || image::open(folder.path("").join(name)).is_ok()
}

#[test]
fn bench_can_be_interrupted() {
    let folder = Folder::new();
    let bench = ["bench", "--members", "50", "--frames", "10000", "--device", "native"];
    let mut child = start(&folder, &bench);
    // The first message appears after the signal handlers are installed.
    let mut first = [0];
    std::io::Read::read_exact(child.stderr.as_mut().expect("piped"), &mut first)
        .expect("a message");
    let (code, stderr) = end_by("TERM", child);
    assert_eq!(code, Some(143), "{stderr}");
    assert!(stderr.ends_with("populace: interrupted\n"), "{stderr}");
}
