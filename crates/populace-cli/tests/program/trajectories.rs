//! Tests of `populace inspect` and `render` with trajectory files that the tests write.

mod warnings;

use std::fmt::Write;

use serde_json::json;

use crate::post::Folder;
use crate::{json_of, populace};

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
