//! Tests of `populace inspect` and `render` with trajectory files that the tests write.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::post::Folder;
use crate::{json_of, populace, refused};

const SMALL: [&str; 4] = ["--size", "160x90", "--device", "native"];

/// Three people who walk beside each other from 0 to 2 s, and a fourth from 4 to 5 s.
fn rows() -> String {
    let mut rows = "# framerate: 25 fps\n# id frame x/m y/m z/m\n".to_owned();
    let mut walk = |id: u32, frames: std::ops::RangeInclusive<u32>| {
        for frame in frames {
            let x = 0.05 * f64::from(frame % 100);
            writeln!(rows, "{id} {frame} {x:.2} {id} 1.7{id}").expect("written");
        }
    };
    (1..=3).for_each(|id| walk(id, 0..=50));
    walk(4, 100..=125);
    rows
}

/// Writes a file beside others and returns its path.
fn write(folder: &Folder, name: &str, text: &str) -> String {
    std::fs::write(folder.path(name), text).expect("written");
    folder.text(name)
}

fn stderr_of(args: &[&str]) -> String {
    let output = populace(args);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {stderr}");
    stderr
}

#[test]
fn inspect_describes_a_recording() {
    let folder = Folder::new();
    let file = write(&folder, "walk.txt", &rows());
    let d = json_of(&["inspect", &file, "--json"]);
    assert_eq!((&d["schema"], &d["file"]), (&json!(1), &json!(file)));
    let t = &d["trajectory"];
    for (name, value) in [
        ("format", json!("petrack")),
        ("agents", json!(4)),
        ("people", json!(4)),
        ("vehicles", json!(0)),
        ("peak_agents", json!(3)),
        ("rows", json!(3 * 51 + 26)),
        ("frames", json!(51 + 26)),
        ("fps", json!(25.0)),
        ("rows_per_s", json!(25.0)),
        ("secs", json!([0.0, 5.0])),
        ("duration_s", json!(5.0)),
        ("unit", json!("m")),
        ("heading", json!("motion")),
        ("assumed", json!([])),
        ("told", json!([])),
        ("extent_m", json!([[0.0, 1.0], [2.5, 4.0]])),
        ("elevations_m", json!(null)),
        ("heights_m", json!([1.71, 1.74])),
        ("warnings", json!([])),
    ] {
        assert_eq!(t[name], value, "{name}");
    }
    let speed = t["median_speed_m_s"].as_f64().expect("a number");
    assert!((speed - 1.25).abs() < 1e-3, "{speed}");
    let text = String::from_utf8(populace(&["inspect", &file]).stdout).expect("text");
    for line in [
        "  PeTrack text\n",
        "  4 people, at most 3 at a time\n",
        "  5.0 s, from 0 to 5 s, in 77 frames and 179 rows\n",
        "  25 rows a second, positions in m, headings from motion\n",
        "  speeds of 1.25 m/s in the median, 1.25 m/s at the 95th percentile, 1.25 m/s at most\n",
        "  x from 0.00 to 2.50 m, y from 1.00 to 4.00 m\n",
        "  no gaps\n",
        "  body heights from 1.71 to 1.74 m\n",
        "  place unknown\n",
    ] {
        assert!(text.contains(line), "no {line:?} in: {text}");
    }
}

#[test]
fn inspect_takes_what_it_is_told() {
    let folder = Folder::new();
    let rows = rows().replace("# framerate: 25 fps\n", "").replace("x/m y/m", "x y");
    let file = write(&folder, "walk.txt", &rows);
    let area = "POLYGON ((-1 -1, 9 -1, 9 5, -1 5), (3 0, 4 0, 4 1, 3 1))";
    let area = write(&folder, "hall.wkt", area);
    let assumed = json_of(&["inspect", &file, "--json"]);
    assert_eq!(assumed["trajectory"]["assumed"], json!(["unit", "fps"]));
    assert_eq!(assumed["trajectory"]["place"]["areas"], 0);
    let told = ["--data-fps", "50", "--unit", "cm", "--geometry", &area, "--heading", "motion"];
    let d = json_of(&[&["inspect", &file, "--json"], &told[..]].concat());
    let t = &d["trajectory"];
    assert_eq!((&t["fps"], &t["unit"]), (&json!(50.0), &json!("cm")));
    assert_eq!((&t["assumed"], &t["told"]), (&json!([]), &json!(["unit", "fps", "heading"])));
    assert_eq!((&t["duration_s"], &t["extent_m"][1]), (&json!(2.5), &json!([0.025, 0.04])));
    let place = &t["place"];
    assert_eq!((&place["walkable_m2"], &place["holes"]), (&json!(59.0), &json!(1)));
    let text = populace(&[&["inspect", &file], &told[..]].concat()).stdout;
    let text = String::from_utf8(text).expect("text");
    assert!(text.contains("50 rows a second (as told), positions in cm (as told)"), "{text}");
    assert!(text.contains("place: 1 walkable area of 59.0 m², 1 obstacle\n"), "{text}");
    let petrack = json_of(&["inspect", &file, "--format", "petrack", "--json"]);
    assert_eq!(petrack["trajectory"], assumed["trajectory"]);
}

#[test]
fn inspect_shows_columns_gaps_and_vehicles() {
    let folder = Folder::new();
    let mut table = "id;time;x;y;type;group\n".to_owned();
    for tenth in (0..10).chain(30..40) {
        let secs = f64::from(tenth) / 10.0;
        writeln!(table, "p;{secs};{secs};0;pedestrian;A\nc;{secs};{};5;car;B", 8.0 * secs)
            .expect("written");
    }
    let file = write(&folder, "street.csv", &table);
    let d = json_of(&["inspect", &file, "--json"]);
    let t = &d["trajectory"];
    assert_eq!(t["format"], "csv");
    assert_eq!((&t["people"], &t["vehicles"]), (&json!(1), &json!(1)));
    assert_eq!(t["gaps"]["agents"], 2);
    let longest = t["gaps"]["longest_s"].as_f64().expect("a number");
    assert!((longest - 2.1).abs() < 1e-6, "{longest}");
    let group = json!({"name": "group", "kind": "words", "words": 2});
    assert!(t["columns"].as_array().expect("columns").contains(&group), "{t}");
    let text = String::from_utf8(populace(&["inspect", &file]).stdout).expect("text");
    assert!(text.contains("  1 person and 1 vehicle, at most 2 at a time\n"), "{text}");
    assert!(text.contains("  gaps: 2 agents away between rows, for 2.10 s at most\n"), "{text}");
    assert!(text.contains("  column \"group\": 2 words\n"), "{text}");
}

fn colours(path: &str) -> image::RgbImage {
    image::open(path).expect("a PNG").to_rgb8()
}

/// Returns the number of pixels that differ by more than rounding.
fn differing(a: &image::RgbImage, b: &image::RgbImage) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    let differs = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 16)
    };
    a.pixels().zip(b.pixels()).filter(|pair| differs(*pair)).count()
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn pictures_show_the_people_of_a_recording() {
    let folder = Folder::new();
    let file = write(&folder, "walk.txt", &rows());
    let draw = |name: &str, args: &[&str]| {
        let out = folder.text(name);
        let stderr = stderr_of(&[&["render", &file, "--out", &out], &SMALL[..], args].concat());
        (colours(&out), stderr)
    };
    let (empty, stderr) = draw("empty.png", &["--at", "3", "--cast", "@woman"]);
    assert_eq!(empty.dimensions(), (160, 90));
    assert!(stderr.contains("PeTrack text: 4 people, 5.0 s, 25 rows a second"), "{stderr}");
    let (walked, _) = draw("walked.png", &["--at", "1", "--cast", "@woman"]);
    let people = differing(&empty, &walked);
    assert!(people > 300, "only {people} pixels differ from those of the empty ground");
    // By default, the picture is that of a moment when most people are there.
    let (busiest, _) = draw("busiest.png", &[]);
    assert!(differing(&empty, &busiest) > people / 2);
    let (fourth, _) = draw("fourth.png", &["--at", "4.5", "--cast", "@woman"]);
    let alone = differing(&empty, &fourth);
    assert!((60..people).contains(&alone), "{alone} pixels for one person, {people} for three");
}

/// An underground platform and an upper floor look as the same place at height 0 does.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn people_stand_on_a_ground_at_their_least_elevation() {
    let folder = Folder::new();
    let area = write(&folder, "area.wkt", "POLYGON ((-2 -2, 4 -2, 4 3, -2 3, -2 -2))");
    let draw = |z: f64, more: &[&str]| {
        let mut rows = "id,t,x,y,z\n".to_owned();
        for (t, x) in [(0, 0.0), (1, 1.2), (2, 2.4)] {
            writeln!(rows, "a,{t},{x},0,{z}\nb,{t},{x},1,{}", z + 0.4).expect("written");
        }
        let (file, out) = (write(&folder, "walk.csv", &rows), folder.text("walk.png"));
        let args = ["render", &file, "--at", "1", "--cast", "@woman", "--out", &out];
        let stderr = stderr_of(&[&args[..], &SMALL, more].concat());
        (colours(&out), stderr)
    };
    for more in [&[][..], &["--geometry", &area]] {
        let (level, stderr) = draw(0.0, more);
        assert!(!stderr.contains("elevation"), "{stderr}");
        for z in [-2.0, 7.5] {
            let (found, stderr) = draw(z, more);
            let off = differing(&level, &found);
            assert!(off < 40, "{off} pixels differ at {z} m, {more:?}");
            assert!(stderr.contains(&format!("ground is at {z:.2} m")), "{stderr}");
        }
    }
}

#[cfg(feature = "mp4")]
/// Labels stand above the heads of bodies, however high those are.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn ids_stand_above_heads() {
    let folder = Folder::new();
    let file = write(&folder, "a.csv", &rows());
    let top = |height: &str| {
        let [plain, labelled] = [&[][..], &["--ids"]].map(|more| {
            let out = folder.text("x.png");
            let args = ["render", &file, "--at", "1", "--height", height, "--out", &out];
            let camera = ["--camera", "1,2,8,1,1,-2"];
            stderr_of(&[&args[..], &camera, &SMALL, more].concat());
            colours(&out)
        });
        let rows = plain.enumerate_pixels().zip(labelled.pixels());
        rows.filter(|((.., a), b)| a != b).map(|((_, y, _), _)| y).min().expect("labels")
    };
    let [child, adult] = ["0.8", "1.8"].map(top);
    assert!(child > adult + 5, "labels begin in rows {child} and {adult}");
}

/// Floor and walls cover nothing, hide whoever is behind them, and are nobody.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn images_beside_a_picture_know_people_and_their_ids() {
    let folder = Folder::new();
    // The third of the file is the first in the plan.
    let rows = "id,t,x,y\nq7,0,9,1\nq7,1,9,1\n12,0,1,1\n12,1,1,1\n12,2,1,1\nA,0,0,1\nA,2,0,1\n";
    let file = write(&folder, "stand.csv", rows);
    let area = write(&folder, "area.wkt", "POLYGON ((-9 -9, 12 -9, 12 9, -9 9, -9 -9))");
    let draw = |name: &str, more: &[&str]| {
        let out = folder.text(name);
        let args =
            ["render", &file, "--at", "1.5", "--json", "--out", &out, "--images", "alpha,id"];
        let d = json_of(&[&args[..], &["--camera", "0.5,4,6,0.5,1,-1"], &SMALL, more].concat());
        let open = |kind: &str| image::open(out.replace(".png", kind)).expect("a PNG");
        (open(".alpha.png").to_luma8(), open(".id.png").to_rgb8(), d)
    };
    let (open, _, _) = draw("open.png", &[]);
    let (alpha, ids, d) = draw("area.png", &["--geometry", &area]);
    assert!(open.pixels().zip(alpha.pixels()).all(|(a, b)| a.0[0].abs_diff(b.0[0]) < 80));
    let covered = alpha.pixels().filter(|pixel| pixel.0[0] > 0).count();
    assert!((50..3000).contains(&covered), "{covered} of 14400 pixels");
    let values: std::collections::BTreeSet<u8> = ids.pixels().map(|pixel| pixel.0[2]).collect();
    assert_eq!(values.into_iter().collect::<Vec<_>>(), [0, 2, 3]);
    assert_eq!(d["ids"], json!({"1": "q7", "2": "12", "3": "A"}));
    assert_eq!((&d["members"], &d["drawn_members"]), (&json!(2), &json!(2)), "the place is nobody");
}

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

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn films_show_the_people_of_a_recording() {
    let folder = Folder::new();
    let file = write(&folder, "walk.txt", &rows());
    let film = |name: &str, args: &[&str]| {
        let out = folder.text(name);
        let film = ["render", &file, "--cast", "@child", "--json", "--out", &out];
        let args = [&film[..], &SMALL, args].concat();
        let d = json_of(&args);
        assert_eq!(d["out"], out.as_str());
        (d["frames"].clone(), std::fs::read(&out).expect("a film"), d)
    };
    for (extension, start) in [("mp4", &b"ftyp"[..]), ("gif", b"GIF89a")] {
        let name = |stem: &str| format!("{stem}.{extension}");
        // The whole recording, with both its ends.
        let (frames, whole, d) = film(&name("whole"), &["--fps", "5"]);
        assert_eq!(frames, 26);
        assert!(whole[..16].windows(start.len()).any(|bytes| bytes == start), "{extension}");
        assert!(d["position_error"]["max_m"].as_f64() < Some(0.02), "{d}");
        assert!(d["foot_skate"]["mean_m_s"].as_f64() < Some(0.02), "{d}");
        // People who walk take more bytes than ground that rests.
        let (frames, walked, _) = film(&name("walked"), &["--frames", "20..27"]);
        assert_eq!(frames, 8);
        let (_, empty, _) = film(&name("empty"), &["--frames", "70..77"]);
        let sizes = [walked.len(), empty.len()];
        assert!(2 * sizes[0] > 3 * sizes[1], "{extension}: {sizes:?} bytes");
    }
}

/// People are measured wherever the camera looks, and how far away it is: those out of view from
/// the beginning, and those of coarse levels.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn foot_skate_does_not_depend_on_the_camera() {
    let folder = Folder::new();
    let (file, out) = (write(&folder, "walk.txt", &rows()), folder.text("x.gif"));
    let film = ["render", &file, "--cast", "@woman", "--frames", "0..20"];
    let native = ["--device", "native"];
    let expected = json_of(&[&film[..], &["--no-draw"], &native].concat());
    let expected = &expected["foot_skate"];
    assert!(expected["mean_m_s"].as_f64() > Some(0.0), "{expected}");
    for camera in ["eye:1", "9,1.5,-3,9,1.5,-60", "0,90,90,0,0,0"] {
        let drawn = ["--size", "32x18", "--json", "--out", &out, "--camera", camera];
        let d = json_of(&[&film[..], &drawn, &native].concat());
        assert_eq!(d["foot_skate"], *expected, "{camera}");
    }
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
