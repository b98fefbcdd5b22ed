//! Tests of films in parts: `plan`, chunks that are drawn apart, and `film`, which joins them.

use std::path::Path;

use serde_json::{Value, json};

use crate::post::Folder;
use crate::{json_of, populace, refused};

/// Writes "walk.csv": two people who walk past each other for 0.46 s, 12 frames at 25 a second.
fn walk(folder: &Folder) -> String {
    let mut text = "id,t,x,y\n".to_owned();
    for row in 0..24 {
        let secs = f64::from(row) * 0.02;
        text += &format!("1,{secs},{},0\n2,{secs},{},1\n", secs - 1.0, 1.0 - 1.3 * secs);
    }
    std::fs::write(folder.path("walk.csv"), text).expect("written");
    folder.text("walk.csv")
}

fn ranges(plan: &Value) -> Vec<[u64; 2]> {
    let bound = |chunk: &Value, name: &str| chunk[name].as_u64().expect("a number");
    let chunks = plan["chunks"].as_array().expect("a list").iter();
    chunks.map(|chunk| [bound(chunk, "first"), bound(chunk, "last")]).collect()
}

#[test]
fn plan_divides_the_whole_trajectory() {
    let folder = Folder::new();
    let file = walk(&folder);
    let d = json_of(&["plan", &file, "--chunk", "5", "--json"]);
    assert_eq!((&d["schema"], &d["frame_count"]), (&json!(1), &json!(12)));
    assert_eq!(ranges(&d), [[0, 4], [5, 9], [10, 11]]);
    assert_eq!(d.as_object().expect("an object").len(), 3);
    // Characters are no trajectories, in any order.
    let d = json_of(&["plan", "@child", &file, "--fps", "50", "--json"]);
    assert_eq!((&d["frame_count"], ranges(&d)), (&json!(24), vec![[0, 23]]));
    let d = json_of(&["plan", &file, "--fps", "30000/1001", "--json"]);
    assert_eq!(d["frame_count"], 14);
    let lines = populace(&["plan", &file, "--chunk", "8"]).stdout;
    assert_eq!(String::from_utf8_lossy(&lines), "--frames 0..7\n--frames 8..11\n");
}

#[test]
fn plan_takes_the_number_of_frames_where_no_file_says_it() {
    let folder = Folder::new();
    let post = folder.text("post.gltf");
    let words = ["trajectory file", "--frames N"];
    refused(&["plan", &post, "@people", "--json"], 2, &words);
    let d = json_of(&["plan", &post, "--frames", "7", "--chunk", "4", "--json"]);
    assert_eq!((&d["frame_count"], ranges(&d)), (&json!(7), vec![[0, 3], [4, 6]]));
    let d = json_of(&["plan", &walk(&folder), "--frames", "3..9", "--chunk", "4", "--json"]);
    assert_eq!((&d["frame_count"], ranges(&d)), (&json!(7), vec![[3, 6], [7, 9]]));
}

#[test]
fn plan_divides_the_film_of_a_scene() {
    let folder = Folder::new();
    let text = "schema = 1\n\n[output]\nfps = 24\nseconds = 5\n";
    std::fs::write(folder.path("scene.toml"), text).expect("written");
    let scene = folder.text("scene.toml");
    let d = json_of(&["plan", &scene, "--chunk", "100", "--json"]);
    assert_eq!((&d["frame_count"], ranges(&d)), (&json!(120), vec![[0, 99], [100, 119]]));
    let d = json_of(&["plan", &scene, "--fps", "10", "--json"]);
    assert_eq!(d["frame_count"], 50, "as many seconds at another rate");
    std::fs::write(folder.path("scene.toml"), text.replace("fps", "fpz")).expect("written");
    refused(&["plan", &scene], 1, &["line 4", "fpz"]);
}

#[test]
fn plan_refuses_what_it_cannot_read_or_divide() {
    let folder = Folder::new();
    let missing = folder.text("missing.csv");
    refused(&["plan", &missing], 1, &["cannot read", "missing.csv"]);
    refused(&["plan", &missing, "--frames", "3"], 1, &["missing.csv"]);
    std::fs::write(folder.path("broken.csv"), "id,t,x,y\nno,row,is,good\n").expect("written");
    refused(&["plan", &folder.text("broken.csv")], 1, &["broken.csv"]);
    let file = walk(&folder);
    refused(&["plan", &file, "--chunk", "0"], 2, &["--chunk"]);
    refused(&["plan"], 2, &["FILE"]);
}

/// Draws frames of the trajectory as PNGs.
fn draw(file: &str, out: &str, more: &[&str]) -> Value {
    std::fs::create_dir_all(Path::new(out).parent().expect("a folder")).expect("a folder");
    let args = ["render", file, "@child", "--size", "160x90", "--device", "native", "--json"];
    json_of(&[&args[..], &["--out", out], more].concat())
}

fn frames(folder: &Folder, name: &str) -> Vec<Vec<u8>> {
    let path = |frame| folder.path(&format!("{name}/f_{frame:04}.png"));
    (0..12).map(|frame| std::fs::read(path(frame)).expect("a frame")).collect()
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn chunks_in_any_order_hold_the_bytes_of_one_run_and_join_into_a_film() {
    let folder = Folder::new();
    let file = walk(&folder);
    let d = draw(&file, &folder.text("whole/f.png"), &["--frames", "12"]);
    assert_eq!((&d["frames"], &d["skipped"]), (&json!(12), &json!(0)));
    assert!(d["position_error"]["max_raw_m"].as_f64().is_some(), "{d}");
    let mut chunks = ranges(&json_of(&["plan", &file, "--chunk", "5", "--json"]));
    chunks.reverse();
    let out = folder.text("parts/f.png");
    for [first, last] in &chunks {
        draw(&file, &out, &["--frames", &format!("{first}..{last}")]);
    }
    let whole = frames(&folder, "whole");
    assert!(whole == frames(&folder, "parts"), "a chunk differs from the whole");
    assert!(whole.windows(2).all(|pair| pair[0] != pair[1]), "people stand still");

    std::fs::remove_file(folder.path("parts/f_0006.png")).expect("removed");
    let d = draw(&file, &out, &["--frames", "5..9", "--skip-existing"]);
    assert_eq!(d["skipped"], 4);
    assert!(whole == frames(&folder, "parts"), "a frame that was drawn again differs");

    let film = folder.text("film.mp4");
    let output = populace(&["film", &out, "--fps", "25", "--out", &film]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout), format!("{film}\n"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("joining 12 pictures, 0 to 11"), "{stderr}");
    let direct = folder.text("direct.mp4");
    draw(&file, &direct, &["--frames", "12"]);
    let [joined, direct] = [film, direct].map(|film| std::fs::read(film).expect("a film"));
    assert!(joined == direct, "a film of pictures differs from one that is drawn at once");
}

/// Writes pictures of one colour each, of 8x6 pixels, "NAME_0003.png" and so on.
fn pictures(folder: &Folder, name: &str, frames: impl Iterator<Item = u8>) {
    for frame in frames {
        let picture = image::RgbImage::from_pixel(8, 6, image::Rgb([20 * frame, 100, 0]));
        picture.save(folder.path(&format!("{name}_{frame:04}.png"))).expect("written");
    }
}

/// Joins pictures into a GIF, and returns its bytes.
fn joined(folder: &Folder, pictures: &str, more: &[&str]) -> Vec<u8> {
    let out = folder.text("joined.gif");
    let args = ["film", pictures, "--fps", "10", "--out", &out];
    let output = populace(&[&args[..], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let film = std::fs::read(&out).expect("a film");
    std::fs::remove_file(out).expect("removed");
    film
}

#[test]
fn film_takes_pictures_in_the_order_of_their_numbers() {
    let folder = Folder::new();
    pictures(&folder, "a", 0..6);
    std::fs::create_dir(folder.path("alone")).expect("a folder");
    for (from, to) in [(2, 9_999), (3, 10_000), (4, 10_001)] {
        let [from, to] = [format!("a_{from:04}.png"), format!("alone/b_{to:04}.png")];
        std::fs::copy(folder.path(&from), folder.path(&to)).expect("copied");
    }
    std::fs::write(folder.path("alone/b_9999.depth.png"), "beside a picture").expect("written");
    let middle = joined(&folder, &folder.text("a.png"), &["--frames", "2..4"]);
    assert!(middle == joined(&folder, &folder.text("alone"), &[]), "numbers in another order");
    assert!(middle == joined(&folder, &folder.text("alone/b.png"), &[]));
    assert!(middle != joined(&folder, &folder.text("a.png"), &["--frames", "1..3"]));
    assert!(middle.len() < joined(&folder, &folder.text("a.png"), &[]).len());
}

#[test]
fn film_names_what_is_missing_or_wrong() {
    let folder = Folder::new();
    pictures(&folder, "a", [0, 1, 4, 6].into_iter());
    let (a, out) = (folder.text("a.png"), folder.text("film.gif"));
    let film = |pictures: &str, code: i32, more: &[&str], words: &[&str]| {
        let args = ["film", pictures, "--fps", "10", "--out", &out];
        refused(&[&args[..], more].concat(), code, words);
        assert!(!folder.path("film.gif").exists());
        // What was joined before a picture that cannot be read stays, as in other runs that fail.
        let part = folder.path("film.part.gif");
        assert_eq!(part.exists(), words.contains(&"film.part.gif holds"));
        let _ = std::fs::remove_file(part);
    };
    let gaps = ["3 pictures are missing", "a_0002.png to ", "a_0003.png", "a_0005.png", "2..3"];
    film(&a, 1, &[], &gaps);
    film(&a, 1, &["--frames", "3"], &["1 picture is missing", "a_0002.png", "--frames 2..2"]);
    film(&a, 1, &["--frames", "6..8"], &["a_0007.png to ", "a_0008.png"]);
    film(&folder.text("b.png"), 1, &[], &["b.png", "b_0000.png", "--frames N"]);
    film(&folder.text("none/b.png"), 1, &[], &["none"]);
    pictures(&folder, "b", 0..1);
    film(&folder.text(""), 2, &[], &["several series", "a.png", "b.png"]);
    let part = "film.part.gif holds";
    let larger = image::RgbImage::new(9, 6);
    larger.save(folder.path("b_0001.png")).expect("written");
    film(&folder.text("b.png"), 1, &[], &[part, "b_0001.png has 9x6 pixels", "b_0000.png 8x6"]);
    std::fs::write(folder.path("b_0001.png"), "no picture").expect("written");
    film(&folder.text("b.png"), 1, &[], &[part, "b_0001.png", "no picture in PNG"]);
    refused(&["film", &a, "--out", &out], 2, &["--fps"]);
    refused(&["film", &a, "--fps", "10", "--out", &a], 2, &["a.png", ".mp4 or .gif"]);
}

#[cfg(unix)]
#[test]
fn film_never_replaces_a_picture() {
    let folder = Folder::new();
    pictures(&folder, "a", 0..2);
    let out = folder.text("film.gif");
    std::os::unix::fs::symlink("a_0001.png", &out).expect("a link");
    let args = ["film", &folder.text("a.png"), "--fps", "10", "--out", &out];
    refused(&args, 2, &["would destroy", "a_0001.png"]);
}
