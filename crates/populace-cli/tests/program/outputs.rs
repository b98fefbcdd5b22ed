//! Tests of outputs of `render`, `demo` and `bench`: inputs are never overwritten, and files are
//! written atomically.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::post::{Folder, post};
use crate::{json_of, populace, refused};

const SMALL: [&str; 6] = ["--members", "2", "--size", "64x64", "--device", "native"];

/// Returns the names of the files in a folder.
fn names(folder: &Folder) -> BTreeSet<OsString> {
    let entries = std::fs::read_dir(folder.path("")).expect("a folder");
    entries.map(|entry| entry.expect("a file").file_name()).collect()
}

/// Asserts that the program refuses `args` and changes no file.
#[track_caller]
fn refused_unchanged(folder: &Folder, args: &[&str], words: &[&str]) {
    let files = || {
        names(folder)
            .into_iter()
            .map(|name| std::fs::read(folder.path("").join(name)).ok())
            .collect::<Vec<_>>()
    };
    let before = (names(folder), files());
    refused(args, 2, words);
    assert!(before == (names(folder), files()), "{args:?} changed a file");
}

#[cfg(unix)]
#[test]
fn output_that_is_an_input_is_refused() {
    let folder = Folder::new();
    let model = folder.text("model.png"); // the content decides the file type
    std::fs::copy(folder.path("post.gltf"), &model).expect("copied");
    let [link, hard, frame, film] =
        ["link.png", "hard.png", "film_0001.png", "film.png"].map(|name| folder.text(name));
    std::os::unix::fs::symlink("model.png", &link).expect("a link");
    std::fs::hard_link(&model, &hard).expect("a link");
    std::fs::hard_link(&model, &frame).expect("a link");
    let words = ["would destroy", "model.png"];
    for out in [&model, &link, &hard] {
        refused_unchanged(&folder, &["render", &model, "--out", out], &words);
        refused_unchanged(&folder, &["render", "@child", "--clips", &model, "--out", out], &words);
        refused_unchanged(&folder, &["demo", "--clips", &model, "--out", out], &words);
    }
    refused_unchanged(&folder, &["render", &model, "--frames", "3", "--out", &film], &words);

    let chart = folder.text("chart.svg");
    std::os::unix::fs::symlink("post.gltf", &chart).expect("a link");
    let data = folder.text("post.gltf");
    refused_unchanged(
        &folder,
        &["bench", "--from", &data, "--chart", &chart],
        &["would destroy", "post.gltf"],
    );
}

#[test]
fn output_that_a_model_refers_to_is_refused() {
    let folder = Folder::new();
    let mut model = post();
    model["images"] = json!([{"uri": "skin%201.png"}, {"uri": "data:image/png;base64,AA=="}]);
    let bytes = model["buffers"][0]["byteLength"].as_u64().expect("a length");
    model["buffers"]
        .as_array_mut()
        .expect("buffers")
        .push(json!({"byteLength": bytes, "uri": "data.png"}));
    for name in ["skin 1.png", "data.png"] {
        std::fs::write(folder.path(name), vec![0; usize::try_from(bytes).expect("few")])
            .expect("written");
    }
    std::fs::write(folder.path("model.gltf"), model.to_string()).expect("written");
    let file = folder.text("model.gltf");
    for name in ["skin 1.png", "data.png"] {
        let args = ["render", &file, "--device", "native", "--out", &folder.text(name)];
        refused_unchanged(&folder, &args, &["would destroy", name]);
    }
}

#[cfg(unix)]
#[test]
fn only_regular_files_are_replaced() {
    let folder = Folder::new();
    std::os::unix::fs::symlink("/dev/null", folder.path("null.png")).expect("a link");
    std::fs::create_dir(folder.path("folder.png")).expect("a folder");
    for (name, words) in [("null.png", "not a regular file"), ("folder.png", "it is a folder")] {
        refused(&["render", "@child", "--out", &folder.text(name)], 4, &["cannot write", words]);
    }
}

/// A file size limit simulates a full disk.
#[cfg(unix)]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn full_disk_keeps_the_old_file_and_leaves_no_partial_file() {
    let folder = Folder::new();
    std::fs::write(folder.path("film_0000.png"), "good").expect("written");
    let before = names(&folder);
    let script = "ulimit -f 1; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args([
        "-c",
        script,
        env!("CARGO_BIN_EXE_populace"),
        "render",
        "@child",
        "--frames",
        "2",
    ]);
    command.args([
        "--out",
        "film.png",
        "--members",
        "2",
        "--size",
        "400x400",
        "--device",
        "native",
    ]);
    let output = command.current_dir(folder.path("")).output().expect("a shell");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(stderr.contains("cannot write film_0000.png: "), "{stderr}");
    assert_eq!(std::fs::read(folder.path("film_0000.png")).expect("a file"), b"good");
    assert_eq!(names(&folder), before, "no other file remains");
}

#[cfg(unix)]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn replaced_files_keep_their_mode_and_links_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = Folder::new();
    let mode =
        |name: &str| folder.path(name).metadata().expect("a file").permissions().mode() & 0o777;
    std::fs::write(folder.path("plain"), "a file with default permissions").expect("written");
    std::fs::write(folder.path("mine.png"), "old").expect("written");
    std::fs::set_permissions(folder.path("mine.png"), PermissionsExt::from_mode(0o600))
        .expect("a mode");
    symlink("mine.png", folder.path("link.png")).expect("a link");
    symlink("later.png", folder.path("dangling.png")).expect("a link");
    for name in ["link.png", "dangling.png"] {
        let output =
            populace(&[&["render", "@child", "--out", &folder.text(name)], &SMALL[..]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(folder.path(name).symlink_metadata().expect("the link").is_symlink());
    }
    for name in ["mine.png", "later.png"] {
        image::open(folder.path(name)).expect("a PNG");
    }
    assert_eq!((mode("mine.png"), mode("later.png")), (0o600, mode("plain")));
}

#[cfg(unix)]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn non_utf8_paths_work() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    let path = |name: &[u8]| folder.path("").join(OsStr::from_bytes(name));
    let model = path(b"m\xFF.gltf");
    std::fs::copy(folder.path("post.gltf"), &model).expect("copied");
    let run = |args: &[&OsStr]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_populace"));
        command.args(["render"]).args(args).args(SMALL).output().expect("the program starts")
    };
    let out = path(b"o\xFE.png");
    let args = [
        model.as_os_str(),
        "--clips".as_ref(),
        model.as_os_str(),
        "--out".as_ref(),
        out.as_os_str(),
    ];
    let film = run(&[&args[..], &["--frames".as_ref(), "2".as_ref()]].concat());
    assert!(film.status.success(), "{}", String::from_utf8_lossy(&film.stderr));
    for name in [&b"o\xFE_0000.png"[..], b"o\xFE_0001.png"] {
        image::open(path(name)).expect("a PNG");
    }
    let first = path(b"o\xFE_0000.png");
    assert_eq!(film.stdout, [first.as_os_str().as_bytes(), b"\n"].concat());
}

/// Returns the field names of a document.
fn fields(document: &Value) -> BTreeSet<&str> {
    document.as_object().expect("an object").keys().map(String::as_str).collect()
}

/// The fields of a document about pictures.
fn fields_of_pictures() -> BTreeSet<&'static str> {
    BTreeSet::from([
        "schema",
        "device",
        "schedule",
        "members",
        "frames",
        "ms_median",
        "drawn_members",
        "triangles",
        "shadow",
        "draw_calls",
        "levels",
        "shadow_only",
        "hidden",
        "out",
        "skipped",
    ])
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn documents_of_pictures_and_films_have_the_same_fields() {
    let folder = Folder::new();
    let (file, out) = (folder.text("post.gltf"), folder.text("x.png"));
    let common = [&SMALL[..], &["--json", "--out", &out]].concat();
    let wanted = fields_of_pictures();
    let hidden = [
        "render",
        "@people",
        "--frames",
        "2",
        "--clip",
        "Run",
        "--fps",
        "10",
        "--height",
        "1",
        "--hide",
        "body",
        "--plain",
        "--full-detail",
    ];
    for (args, frames, triangles) in [
        (&["render", &file][..], 1, Some(8)),
        (&["render", &file, "--frames", "3"], 3, Some(8)),
        (&hidden, 2, None),
    ] {
        let args = [args, &common].concat();
        let d = json_of(&args);
        assert_eq!(fields(&d), wanted);
        let times =
            ["total", "behave", "animate", "view", "draw", "shadow", "members", "surroundings"];
        assert_eq!(fields(&d["ms_median"]), BTreeSet::from(times));
        assert_eq!((&d["schema"], &d["device"]), (&json!(1), &json!("native")));
        assert_eq!((&d["schedule"], &d["members"]), (&json!("fused"), &json!(2)));
        assert_eq!((&d["frames"], &d["drawn_members"]), (&json!(frames), &json!(2)));
        let ms = |name: &str| d["ms_median"][name].as_f64().expect("a number");
        assert!(ms("animate") > 0.0 && ms("draw") > 0.0, "{d}");
        assert_eq!(fields(&d["shadow"]), BTreeSet::from(["members", "triangles"]));
        let passes = BTreeSet::from(["shadow", "members", "surroundings"]);
        assert_eq!(fields(&d["draw_calls"]), passes);
        let ms = |name: &str| d["ms_median"][name].as_f64().expect("a number");
        assert!(
            passes.iter().all(|pass| ms(pass) <= ms("total")),
            "a pass is part of a picture: {d}"
        );
        assert!(passes.iter().all(|pass| d["draw_calls"][pass].as_u64() > Some(0)), "{d}");
        match triangles {
            Some(count) => assert_eq!(d["triangles"], json!(count), "{args:?}"),
            None => assert!(d["triangles"].as_u64() > Some(100), "people have many triangles"),
        }
        assert!(Path::new(d["out"].as_str().expect("a path")).exists());
    }
}

/// A post of 200 m, as of a file in centimetres, would stand in the haze.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn character_in_another_unit_than_metres_is_drawn_at_a_plausible_height() {
    let folder = Folder::new();
    let mut post = post();
    post["nodes"][1]["scale"] = json!([100.0, 100.0, 100.0]);
    let (small, high) = (folder.text("post.gltf"), folder.text("high.gltf"));
    std::fs::write(&high, post.to_string()).expect("written");
    let picture = |file: &str, more: &[&str]| {
        let out = folder.text("x.png");
        let output = populace(&[&["render", file, "--out", &out], &SMALL[..], more].concat());
        let said = "is 200.00 m high, which is hardly meant in metres; it is drawn 1.75 m high";
        let said = String::from_utf8_lossy(&output.stderr).contains(said);
        (std::fs::read(out).expect("a picture"), said)
    };
    let [(as_it_is, said), (wanted, silent)] =
        [&[][..], &["--height", "1.75"]].map(|more| picture(&high, more));
    assert!(said && !silent && as_it_is == wanted);
    assert!(!picture(&small, &[]).1, "2 m are plausible");
}

/// A thing without a height has no scale to a plausible one.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn post_that_lies_flat_is_drawn_as_long_as_it_is() {
    let folder = Folder::new();
    let (file, out) = (folder.text("flat.gltf"), folder.text("flat.png"));
    let (mut post, half) = (post(), std::f32::consts::FRAC_1_SQRT_2);
    post["nodes"][1]["rotation"] = json!([half, 0.0, 0.0, half]);
    std::fs::write(&file, post.to_string()).expect("written");
    for more in [&[][..], &["--height", "1"]] {
        let args = [&["render", &file, "--out", &out], &SMALL[..], more].concat();
        let output = populace(&args);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !said.contains("hardly meant"), "{said}");
    }
}

/// A knight with a sword longer than the knight is no four-legged animal.
#[cfg_attr(any(skip_gl, no_test_data), ignore = "no test data, or POPULACE_SKIP names gl")]
#[test]
fn humanoids_stand_upright_among_others_whatever_they_hold() {
    let folder = Folder::new();
    let data = std::env::var("POPULACE_TEST_DATA").expect("ignored without it");
    let (knight, out) = (format!("{data}/characters/kaykit_knight.glb"), folder.text("x.png"));
    let args = ["render", &knight, "@man", "--full-detail", "--out", &out];
    let output = populace(&[&args[..], &SMALL].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("it is drawn 1.75 m high"), "{stderr}");
}

/// The camera stands among the members, so that some are behind it and some are far.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn far_members_have_fewer_triangles_and_others_are_hidden() {
    let folder = Folder::new();
    let out = folder.text("x.png");
    let common = ["render", "@man", "--members", "100", "--json", "--out", &out, "--device"];
    let args = [&common[..], &["native", "--camera", "0,1.7,4,6,1,-10"]].concat();
    let seen = json_of(&args);
    let number = |document: &Value, key: &str| document[key].as_u64().expect("a number");
    let levels = seen["levels"].as_array().expect("a list");
    let in_view: u64 = levels.iter().filter_map(Value::as_u64).sum();
    assert!(levels.len() > 2, "{seen}");
    assert!(number(&seen, "hidden") > 5, "{seen}");
    assert_eq!(in_view + number(&seen, "shadow_only") + number(&seen, "hidden"), 100);
    assert_eq!(number(&seen, "drawn_members"), in_view);
    let full = json_of(&[&args[..], &["--full-detail"]].concat());
    assert_eq!((number(&full, "hidden"), number(&full, "drawn_members")), (0, 100));
    assert!(number(&full, "triangles") > 4 * number(&seen, "triangles"));
    let text = populace(&args).stderr;
    let words = format!("{in_view} of 100 members drawn");
    assert!(String::from_utf8_lossy(&text).contains(&words), "no {words:?}");
    let finer = json_of(&[&args[..], &["--detail", "0.1"]].concat());
    assert!(number(&finer, "triangles") > number(&seen, "triangles"));
}

/// Haze ends the view of this sky after 150 m, and the cameras stand up to 500 m away.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn haze_hides_nobody_from_cameras_that_show_all() {
    let folder = Folder::new();
    let out = folder.text("x.png");
    for camera in ["crowd", "top", "iso", "orbit"] {
        let common = ["--sky", "overcast", "--size", "320x180", "--device", "native"];
        let among = ["render", "@man", "--members", "2000", "--camera", camera, "--out", &out];
        let output = populace(&[&among[..], &common[..]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let picture = image::open(&out).expect("a PNG").to_luma8();
        let middle = picture.enumerate_pixels().filter(|(_, y, _)| (60..120).contains(y));
        let values: Vec<u8> = middle.map(|(_, _, pixel)| pixel.0[0]).collect();
        let contrast = values.iter().max().zip(values.iter().min()).map(|(high, low)| high - low);
        assert!(contrast > Some(60), "{camera}: {contrast:?}");
    }
}

/// A coarser level would shade a surface that is seen from near.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn near_members_throw_the_shadows_of_the_level_that_is_seen() {
    let folder = Folder::new();
    let out = folder.text("x.png");
    let common = ["--size", "640x360", "--device", "native", "--json", "--out", &out];
    let near = json_of(
        &[&["render", "@man", "--members", "1", "--camera", "close"], &common[..]].concat(),
    );
    assert_eq!(near["shadow"]["triangles"], near["triangles"], "{near}");
    let among = ["render", "@man", "--members", "100", "--camera", "0,1.7,4,6,1,-10"];
    let many = json_of(&[&among[..], &common[..]].concat());
    let [shadows, seen] = [&many["shadow"], &many].map(|d| d["triangles"].as_u64());
    assert!(shadows < seen, "{many}");
}

/// `script` provides a terminal. The run is far too long, and is ended once the bar has shown.
#[cfg(target_os = "linux")]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn terminal_shows_the_remaining_time() {
    use std::io::Read;
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_populace");
    let line =
        format!("exec {program} render @child --frames 3000 --out film.png {}", SMALL.join(" "));
    let mut script = Command::new("script");
    script.args(["-qec", &line, "/dev/null"]).current_dir(folder.path(""));
    let script = script.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut script = script.spawn().expect("script of util-linux");
    let mut shown = Vec::new();
    let mut piece = [0; 256];
    let mut output = script.stdout.take().expect("piped");
    while !String::from_utf8_lossy(&shown).contains(" left") {
        let count = output.read(&mut piece).expect("read");
        assert!(count > 0, "no bar in: {}", String::from_utf8_lossy(&shown));
        shown.extend_from_slice(&piece[..count]);
    }
    drop(output);
    script.kill().expect("killed");
    script.wait().expect("ended");
    assert!(
        String::from_utf8_lossy(&shown).contains("of 3000"),
        "{}",
        String::from_utf8_lossy(&shown)
    );
}
