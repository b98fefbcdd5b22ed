//! What SIGINT and SIGTERM leave behind.

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::post::Folder;

fn started(folder: &Folder, args: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_populace"));
    command.args(args).current_dir(folder.path("")).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

/// Sends a signal, and gives the exit code and stderr.
fn ended_by(signal: &str, child: Child) -> (Option<i32>, String) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status();
    assert!(sent.expect("a shell").success());
    let output = child.wait_with_output().expect("it ends");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_film_that_is_interrupted_leaves_whole_frames_and_their_number() {
    interrupted("native");
}

/// Drivers that bring a compiler have handlers of their own.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn a_film_from_an_opencl_device_is_interrupted_alike() {
    interrupted("opencl");
}

fn interrupted(device: &str) {
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let folder = Folder::new();
        let film =
            ["render", "@child", "--members", "2", "--frames", "100000", "--out", "film.png"];
        let mut child =
            started(&folder, &[&film[..], &["--size", "64x64", "--device", device]].concat());
        while !folder.path("film_0002.png").exists() {
            assert!(child.try_wait().expect("a child").is_none(), "it ended by itself");
            std::thread::sleep(Duration::from_millis(5));
        }
        let (found, talk) = ended_by(signal, child);
        assert_eq!(found, Some(code), "{talk}");
        let mut frames = 0;
        for entry in std::fs::read_dir(folder.path("")).expect("a folder") {
            let name = entry.expect("a file").file_name().into_string().expect("a name");
            if name != "post.gltf" {
                assert!(name.starts_with("film_"), "{name} is left");
                image::open(folder.path(&name)).expect("a whole PNG");
                frames += 1;
            }
        }
        assert!(
            talk.contains(&format!("interrupted; {frames} of 100000 frames are complete")),
            "{talk}"
        );
    }
}

/// Under a limit on addresses that the program can start under, but not stage a crowd.
#[cfg(target_os = "linux")]
#[test]
fn memory_that_runs_out_is_exit_code_4() {
    let folder = Folder::new();
    let script = "ulimit -v 200000; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_populace"), "bench", "--members", "100000"]);
    let command = command.args(["--device", "native:1"]).current_dir(folder.path(""));
    let output = command.output().expect("a shell");
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{talk}");
    assert!(talk.contains("memory"), "{talk}");
}

/// As a driver does that runs out of memory.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn an_abort_is_exit_code_4_and_leaves_whole_frames() {
    let folder = Folder::new();
    let film = ["render", "@child", "--members", "2", "--frames", "3000", "--out", "film.png"];
    let mut child =
        started(&folder, &[&film[..], &["--size", "64x64", "--device", "opencl"]].concat());
    while !folder.path("film_0002.png").exists() {
        assert!(child.try_wait().expect("a child").is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    let (code, talk) = ended_by("ABRT", child);
    assert_eq!(code, Some(4), "{talk}");
    assert!(talk.contains("memory ran out, or a driver gave up"), "{talk}");
    let mut frames = std::fs::read_dir(folder.path("")).expect("a folder");
    assert!(frames.all(|entry| image_or_model(&folder, &entry.expect("a file").file_name())));
}

/// Whether a file is one that is whole.
fn image_or_model(folder: &Folder, name: &std::ffi::OsStr) -> bool {
    name == "post.gltf" || image::open(folder.path("").join(name)).is_ok()
}

#[test]
fn what_writes_no_film_is_interrupted_too() {
    let folder = Folder::new();
    let bench = ["bench", "--members", "50", "--frames", "10000", "--device", "native"];
    let mut child = started(&folder, &bench);
    // It talks once it listens to signals.
    let mut first = [0];
    std::io::Read::read_exact(child.stderr.as_mut().expect("piped"), &mut first).expect("it talks");
    let (code, talk) = ended_by("TERM", child);
    assert_eq!(code, Some(143), "{talk}");
    assert!(talk.ends_with("populace: interrupted\n"), "{talk}");
}
