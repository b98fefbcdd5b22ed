//! Warnings and refusals of trajectory files and of options that go with them.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{SMALL, rows, stderr_of, write};
use crate::post::Folder;
use crate::{json_of, populace, refused};

/// A wall height without walls is said to have no effect, and what looks wrong is said too.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn doubts_are_warnings_of_render_and_inspect() {
    let folder = Folder::new();
    let (file, out) = (write(&folder, "walk.txt", &rows()), folder.text("x.png"));
    let args = ["render", &file, "--at", "1", "--walls", "2", "--out", &out];
    let stderr = stderr_of(&[&args[..], &SMALL].concat());
    assert!(stderr.contains("warning: there is no walkable area, so --walls"), "{stderr}");
    let far = write(&folder, "far.wkt", "POLYGON ((90 90, 99 90, 99 99, 90 99, 90 90))");
    let warnings = |geometry: &[&str]| {
        let d = json_of(&[&["inspect", &file, "--json"], geometry].concat());
        d["trajectory"]["warnings"].as_array().expect("warnings").len()
    };
    let elsewhere = ["--geometry", far.as_str()];
    assert_eq!([warnings(&[]), warnings(&elsewhere)], [0, 1]);
    let strict = [&["inspect", &file, "--strict"], &elsewhere[..]].concat();
    refused(&strict, 1, &["walk.txt", "0 % of the positions are within the walkable area"]);
    let stderr = stderr_of(&[&args[..4], &args[6..], &SMALL, &elsewhere].concat());
    assert!(stderr.contains("warning: 0 % of the positions"), "{stderr}");
}

/// An area that `render` cannot draw counts for nobody.
#[test]
fn areas_without_an_inside_are_left_out_of_inspect() {
    let folder = Folder::new();
    let file = write(&folder, "walk.txt", &rows());
    let square = "((-9 -9, 12 -9, 12 9, -9 9), (1 1, 2 2, 3 3))";
    let text = format!("MULTIPOLYGON ({square}, ((0 0, 5 0, 9 0)), ((0 0, 1000000 0, 0 1000000)))");
    let areas = write(&folder, "areas.wkt", &text);
    let inspect = ["inspect", &file, "--geometry", &areas];
    let d = json_of(&[&inspect[..], &["--json"]].concat());
    let place = &d["trajectory"]["place"];
    let found = ["areas", "holes", "walkable_m2"].map(|key| place[key].as_f64());
    assert_eq!(found, [1.0, 0.0, 378.0].map(Some));
    assert_eq!(
        d["trajectory"]["warnings"],
        json!([
            "a hole of the place was left out: it has no area",
            "an outline of the place was left out: it has no area",
            "an outline of the place was left out: it has points beyond 100 km; check the unit"
        ])
    );
    refused(&[&inspect[..], &["--strict"]].concat(), 1, &["walk.txt", "it has no area"]);
}

/// Coordinates of the file are not those of cameras where positions are moved.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn cameras_in_coordinates_of_a_moved_file_are_warned_of() {
    let folder = Folder::new();
    let out = folder.text("x.png");
    let draw = |[x, y]: [u32; 2], camera: &str| {
        let rows = format!("id,t,x,y\n1,0,{x},{y}\n1,1,{},{y}\n", x + 1);
        let file = write(&folder, "walk.csv", &rows);
        let args = ["render", &file, "--cast", "@child", "--at", "0.5", "--out", &out];
        let size = ["--size", "32x18", "--device", "native", "--camera", camera];
        stderr_of(&[&args[..], &size].concat())
    };
    let far = [458_300, 5_428_100];
    let stderr = draw(far, "458300,2,-5428095,458300,0,-5428100");
    let warning = "warning: the camera sees nobody in any frame; positions were moved by -458000, \
                   -5428000 m, and cameras are in moved coordinates: those of the file need \
                   -458000 m in X and +5428000 m in Z";
    assert!(stderr.contains(warning), "{stderr}");
    for (at, camera) in [(far, "300,2,-95,300,0,-100"), ([3, 1], "90,2,5,90,0,0")] {
        let stderr = draw(at, camera);
        assert!(!stderr.contains("sees nobody"), "{camera}: {stderr}");
    }
}

/// The floor of the recording is at 3 m, and the ground of a crowd at 0.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn cameras_below_the_ground_are_warned_of() {
    let folder = Folder::new();
    let (file, out) =
        (write(&folder, "a.csv", "id,t,x,y,z\n1,0,0,0,3\n1,1,1,0,3\n"), folder.text("x.png"));
    let size = ["--size", "32x18", "--device", "native", "--out", &out, "--camera"];
    let crowd = ["@child", "--members", "1"];
    let recording = [file.as_str(), "--cast", "@child"];
    for (input, camera, ground) in [
        (&crowd[..], "0,-2,5,0,1,0", Some("0.00, -2.00, 5.00 m, where the ground is at 0.00 m")),
        (&crowd, "0,2,5,0,1,0", None),
        (&recording, "0,2,5,0,4,0", Some("0.00, 2.00, 5.00 m, where the ground is at 3.00 m")),
        (&recording, "0,4,5,0,4,0", None),
    ] {
        let stderr = stderr_of(&[&["render"][..], input, &size, &[camera]].concat());
        let warning = "warning: the camera is below the ground: it is at ";
        match ground {
            Some(ground) => assert!(stderr.contains(&format!("{warning}{ground}")), "{stderr}"),
            None => assert!(!stderr.contains(warning), "{stderr}"),
        }
    }
}

/// A picture of a time within a gap or after the file's end shows nobody, and the program says so.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn times_without_people_are_warned_of() {
    let folder = Folder::new();
    let (file, out) = (write(&folder, "a.csv", &rows()), folder.text("x.png"));
    let at = |secs: &str| {
        let size = ["--size", "32x18", "--device", "native"];
        stderr_of(&[&["render", &file, "--at", secs, "--out", &out], &size[..]].concat())
    };
    let after = at("500");
    assert!(
        after.contains("nobody is there at 500.00 s; somebody is there until 5.00 s"),
        "{after}"
    );
    let gap = at("3");
    assert!(gap.contains("at 3.00 s; somebody is there until 2.00 s, and from 4.00 s on"), "{gap}");
    assert!(!at("0.1").contains("nobody is there"));
}

#[test]
fn wrong_usage_with_recordings_exits_with_2() {
    let folder = Folder::new();
    let (file, out) = (write(&folder, "walk.txt", &rows()), folder.text("x.png"));
    let other = write(&folder, "other.txt", &rows());
    let post = folder.text("post.gltf");
    let draw = ["render", &file, "--out", &out];
    let drawn = |args: &[&'static str]| [&draw[..], args].concat();
    refused(&drawn(&["--members", "5"]), 2, &["--members", "the file says how many people"]);
    let two = ["render", &file, &other, "--out", &out];
    refused(&two, 2, &["walk.txt", "other.txt", "both trajectory files"]);
    refused(&["render", &file, &file, "--no-draw"], 2, &["both trajectory files"]);
    let formats = ["\"petrak\" is not a format", "petrack, jpscore, jupedsim"];
    refused(&drawn(&["--format", "petrak"]), 2, &formats);
    refused(&["inspect", &file, "--format", "petrak"], 2, &formats);
    refused(&["inspect", &file, "--unit", "inch"], 2, &["m, cm, mm or ft"]);
    refused(&["inspect", &file, "--data-fps", "0"], 2, &["--data-fps", "0.001"]);
    refused(&drawn(&["--no-draw"]), 2, &["--no-draw draws nothing", "--out"]);
    let images = ["render", &file, "--no-draw", "--images", "id"];
    refused(&images, 2, &["--no-draw draws nothing", "--images"]);
    refused(&["render", &post, "--no-draw"], 2, &["--no-draw needs a trajectory file"]);
    let needs = ["--unit", "need a trajectory file"];
    refused(&["render", &post, "--unit", "cm", "--out", &out], 2, &needs);
    refused(&["inspect", &post, "--unit", "cm"], 2, &needs);
    refused(&["inspect", &file, "--rows"], 2, &["--rows is for characters", "walk.txt"]);
    refused(&["inspect", &file, &post, "--json"], 2, &["one file"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn cameras_that_follow_nobody_say_who_is_there() {
    let folder = Folder::new();
    let (file, out) = (write(&folder, "walk.txt", &rows()), folder.text("x.png"));
    for camera in ["follow:7", "eye:Anna"] {
        let args = ["render", &file, "--cast", "@child", "--out", &out, "--camera", camera];
        let words = [&camera[camera.find(':').map_or(0, |at| at + 1)..], "4 agents", "1, 2, 3, 4"];
        refused(&[&args[..], &SMALL].concat(), 2, &words);
    }
    assert!(!folder.path("x.png").exists());
    let args = ["render", &file, "--cast", "@child", "--out", &out, "--camera", "follow:4"];
    stderr_of(&[&args[..], &SMALL].concat());
}

#[test]
fn broken_recordings_are_refused_with_their_place() {
    let folder = Folder::new();
    let empty = write(&folder, "empty.txt", "");
    refused(&["inspect", &empty], 1, &["empty.txt"]);
    refused(&["render", &empty, "--no-draw"], 1, &["empty.txt"]);
    let missing = folder.text("missing.sqlite");
    refused(&["inspect", &missing], 1, &["missing.sqlite"]);
    refused(&["render", &missing, "--no-draw"], 1, &["missing.sqlite"]);
    let database = write(&folder, "cut.sqlite", "SQLite format 3\0and no more");
    refused(&["inspect", &database], 1, &["cut.sqlite"]);
    refused(&["render", &database, "--no-draw"], 1, &["cut.sqlite"]);
    let pixels = write(&folder, "pixels.csv", "id,frame,x_px,y_px\n1,0,5,5\n1,1,6,5\n");
    refused(&["inspect", &pixels], 1, &["pixels.csv", "pixel"]);
    let rateless = rows().replace("25 fps", "0 fps");
    let rateless = write(&folder, "rateless.txt", &rateless);
    refused(&["inspect", &rateless], 1, &["rateless.txt", "--data-fps N sets it"]);
    let d = json_of(&["inspect", &rateless, "--data-fps", "25", "--json"]);
    assert_eq!(d["trajectory"]["duration_s"], 5.0);
    // A row that the end of the file cuts short is one without a position.
    let rows = rows();
    let file = write(&folder, "cut.txt", &rows[..rows.len() - 11]);
    let d = json_of(&["inspect", &file, "--json"]);
    assert_eq!(d["trajectory"]["agents"], 4);
}

#[test]
fn broken_rows_are_warnings_with_their_line_or_errors_if_strict() {
    let folder = Folder::new();
    let mut table = "id,frame,x,y\n".to_owned();
    for frame in 0..30 {
        let x = if frame == 6 { "?".to_owned() } else { format!("{:.2}", 0.05 * f64::from(frame)) };
        writeln!(table, "1,{frame},{x},0").expect("written");
    }
    let file = write(&folder, "rows.csv", &table);
    let d = json_of(&["inspect", &file, "--json"]);
    let warnings = d["trajectory"]["warnings"].as_array().expect("warnings");
    let lines = warnings.iter().filter_map(Value::as_str);
    assert_eq!(lines.filter(|line| line.contains("line 8")).count(), 1, "{warnings:?}");
    let text = String::from_utf8(populace(&["inspect", &file]).stdout).expect("text");
    assert!(text.contains("  warning: ") && text.contains("line 8"), "{text}");
    let render = ["render", &file, "--no-draw", "--frames", "3", "--device", "native"];
    let stderr = stderr_of(&render);
    assert!(stderr.contains("populace: warning: ") && stderr.contains("line 8"), "{stderr}");
    refused(&["inspect", &file, "--strict"], 1, &["rows.csv", "line 8", "warnings are refused"]);
    refused(&[&render[..], &["--strict"]].concat(), 1, &["rows.csv", "line 8"]);
}
