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
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let folder = Folder::new();
        let film = ["render", "@child", "--members", "2", "--frames", "100000", "--out", "film.png"];
        let mut child = started(&folder, &[&film[..], &["--size", "64x64", "--device", "native"]].concat());
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
        assert!(talk.contains(&format!("interrupted; {frames} of 100000 frames are complete")), "{talk}");
    }
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
