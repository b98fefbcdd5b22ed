//! Tests of films: formats, frames by number, cameras, and what an interruption leaves.

use std::collections::BTreeMap;
use std::path::Path;

use crate::post::Folder;
use crate::{json_of, populace, refused};

const SMALL: [&str; 4] = ["--size", "96x54", "--device", "native"];

fn run(args: &[&str]) {
    let output = populace(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Returns the letters and sizes of the boxes of an MP4 file, which they fill.
fn boxes(file: &[u8]) -> Vec<(String, usize)> {
    let (mut found, mut rest) = (Vec::new(), file);
    while !rest.is_empty() {
        let short = u32::from_be_bytes(rest[..4].try_into().expect("4 bytes"));
        let long = || u64::from_be_bytes(rest[8..16].try_into().expect("8 bytes"));
        let size = if short == 1 { long() } else { u64::from(short) };
        let size = usize::try_from(size).expect("a small film");
        found.push((String::from_utf8_lossy(&rest[4..8]).into_owned(), size));
        rest = rest.get(size..).expect("boxes are whole");
    }
    found
}

fn names(file: &[u8]) -> Vec<String> {
    boxes(file).into_iter().map(|(name, _)| name).collect()
}

/// Returns the other files of a folder by their names.
fn files(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder.path("")).expect("a folder");
    let named = entries.map(|entry| entry.expect("a file").path());
    named
        .filter(|path| !path.ends_with("post.gltf"))
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            (name, std::fs::read(path).expect("a file"))
        })
        .collect()
}

#[cfg(feature = "mp4")]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn films_have_the_format_of_their_extension() {
    let folder = Folder::new();
    for name in ["film.mp4", "film.GIF"] {
        let out = folder.text(name);
        let args = ["render", "@child", "--members", "2", "--frames", "7", "--fps", "12.5"];
        let d = json_of(&[&args[..], &SMALL, &["--json", "--out", &out]].concat());
        assert_eq!((&d["frames"], &d["skipped"]), (&7.into(), &0.into()));
        assert_eq!(d["out"], out.as_str());
    }
    let files = files(&folder);
    assert_eq!(files.keys().collect::<Vec<_>>(), ["film.GIF", "film.mp4"]);
    assert_eq!(names(&files["film.mp4"]), ["ftyp", "moov", "mdat"]);
    assert!(files["film.GIF"].starts_with(b"GIF89a"));
}

/// Cameras that move change the levels of detail, which depend on those of the frame before.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_frame_is_the_same_whichever_frames_are_drawn() {
    let folder = Folder::new();
    let keys = "key = [{time = 0, from = [0, 2, 30], to = [0, 1, 0]}, \
                {time = 0.7, from = [3, 1.6, 3], to = [0, 1, -3], fov = 60}]";
    std::fs::write(folder.path("keys.toml"), keys).expect("written");
    let keys = folder.text("keys.toml");
    let common = ["--members", "20", "--fps", "10", "--detail", "3"];
    for (people, camera, shutter) in [
        ("@people", "close", "0"),
        ("@woman", "crowd", "0"),
        ("@man", "orbit", "90"),
        ("@woman", "follow:3", "0"),
        ("@man", &*keys, "90"),
    ] {
        let draw = |frames: &[&str], name: &str| {
            let out = folder.text(name);
            let film = ["--camera", camera, "--shutter", shutter, "--out", &out];
            run(&[&["render", people], &common[..], &SMALL, &film, frames].concat());
        };
        draw(&["--frames", "0..7"], "play.png");
        draw(&["--frames", "7..7"], "seek.png");
        draw(&["--at", "0.7"], "at.png");
        draw(&["--at", "0.65"], "between.png");
        let files = files(&folder);
        let play = &files["play_0007.png"];
        assert!(*play == files["seek_0007.png"], "{camera}, shutter {shutter}");
        assert!(*play == files["at.png"], "{camera}, shutter {shutter}");
        assert!(*play != files["play_0000.png"] && *play != files["between.png"]);
    }
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn existing_frames_are_left_out() {
    let folder = Folder::new();
    let out = folder.text("f.png");
    let args = ["render", "@child", "--members", "2", "--frames", "2..5", "--out", &out];
    let args = [&args[..], &SMALL].concat();
    run(&args);
    let before = files(&folder);
    assert_eq!(before.len(), 4);
    std::fs::remove_file(folder.path("f_0004.png")).expect("removed");
    std::fs::write(folder.path("f_0003.png"), "mine").expect("written");
    let d = json_of(&[&args[..], &["--skip-existing", "--json"]].concat());
    assert_eq!((&d["frames"], &d["skipped"]), (&4.into(), &3.into()));
    let after = files(&folder);
    assert!(after["f_0004.png"] == before["f_0004.png"]);
    assert_eq!(after["f_0003.png"], b"mine");
    let none = json_of(&[&args[..], &["--skip-existing", "--json"]].concat());
    assert_eq!(none["skipped"], 4);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_shutter_blurs_what_moves() {
    let folder = Folder::new();
    let draw = |shutter: &str| {
        let out = folder.text("f.png");
        let film = ["--frames", "5..5", "--fps", "10", "--shutter", shutter, "--out", &out];
        let man = ["render", "@man", "--members", "1", "--clip", "Run"];
        run(&[&man[..], &film, &SMALL].concat());
        image::open(folder.path("f_0005.png")).expect("a PNG").to_rgb8()
    };
    let [sharp, blurred] = ["0", "360"].map(draw);
    let differs = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 4)
    };
    let count = sharp.pixels().zip(blurred.pixels()).filter(|pair| differs(*pair)).count();
    let all = sharp.pixels().count();
    assert!(count > 20 && count < all / 2, "{count} of {all} pixels differ");
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn images_beside_a_picture_agree_with_it() {
    let folder = Folder::new();
    let out = folder.text("f.png");
    let images = ["--frames", "3..3", "--images", "depth,id,alpha", "--out", &out];
    let view = ["--camera", "0,1.6,6,0,0.9,0"];
    run(&[&["render", "@people", "--members", "5"], &view[..], &images, &SMALL].concat());
    let open = |name: &str| image::open(folder.path(name)).expect("a PNG");
    let depth = open("f_0003.depth.png");
    let depth = depth.as_luma16().expect("16 bits");
    let alpha = open("f_0003.alpha.png");
    let alpha = alpha.as_luma8().expect("8 bits");
    let id = open("f_0003.id.png").to_rgb8();
    let (mut seen, mut uncovered) = ([0; 6], 0);
    for (x, y, pixel) in id.enumerate_pixels() {
        let [0, 0, number] = pixel.0 else { panic!("{pixel:?} is the number of nobody") };
        seen[usize::from(number)] += 1;
        let (covered, units) = (alpha.get_pixel(x, y).0[0], depth.get_pixel(x, y).0[0]);
        if number > 0 {
            assert!((200..3000).contains(&units), "{covered}, {units} cm");
            uncovered += usize::from(covered == 0);
        } else if y == 0 {
            assert_eq!((covered, units), (0, 0), "the sky");
        }
    }
    assert!(seen[1..].iter().filter(|count| **count > 10).count() >= 2, "{seen:?}");
    // Slivers cross the middle of a pixel between the samples of the picture.
    assert!(uncovered < 5, "{uncovered} pixels of people are not covered");
    // The ground at the bottom of the picture, below a camera at 1.6 m.
    let ground = depth.get_pixel(0, 53).0[0];
    assert!((100..800).contains(&ground), "{ground} cm");
    assert!(folder.path("f_0003.png").exists());
}

#[cfg(all(unix, feature = "mp4"))]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn an_interrupted_film_leaves_a_part_that_is_named() {
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    let mut command = Command::new(env!("CARGO_BIN_EXE_populace"));
    command.args(["render", "@child", "--members", "2", "--frames", "100000", "--fps", "5"]);
    command.args(["--out", "film.mp4"]).args(SMALL).current_dir(folder.path(""));
    let mut child =
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let part = folder.path("film.part.mp4");
    while part.metadata().map_or(0, |metadata| metadata.len()) < 4000 {
        assert!(child.try_wait().expect("a child").is_none(), "the program ended early");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status();
    assert!(sent.expect("a shell").success());
    let output = child.wait_with_output().expect("it ends");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("of 100000 frames are complete; film.part.mp4 holds"), "{stderr}");
    assert_eq!(files(&folder).keys().collect::<Vec<_>>(), ["film.part.mp4"]);
    let names = names(&std::fs::read(part).expect("a part"));
    assert_eq!(names[..4], ["ftyp", "moov", "moof", "mdat"]);
    assert!(names[2..].chunks(2).all(|pair| pair == ["moof", "mdat"]), "{names:?}");
}

/// A file size limit simulates a full disk.
#[cfg(all(unix, feature = "mp4"))]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_full_disk_keeps_the_old_film_and_names_the_part() {
    let folder = Folder::new();
    std::fs::write(folder.path("film.mp4"), "good").expect("written");
    let mut command = std::process::Command::new("sh");
    let script = "ulimit -f 16; exec \"$0\" \"$@\"";
    command.args(["-c", script, env!("CARGO_BIN_EXE_populace"), "render", "@people"]);
    command.args(["--frames", "1000", "--fps", "2", "--out", "film.mp4"]).args(SMALL);
    let output = command.current_dir(folder.path("")).output().expect("a shell");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(stderr.contains("cannot write film.part.mp4: "), "{stderr}");
    assert!(stderr.contains("film.part.mp4 holds the film"), "{stderr}");
    let files = files(&folder);
    assert_eq!(files["film.mp4"], b"good");
    assert_eq!(names(&files["film.part.mp4"])[..3], ["ftyp", "moov", "moof"]);
}

/// A cut within the time of an open shutter leaves no second picture in the frame.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn frames_with_motion_blur_belong_to_one_shot() {
    let folder = Folder::new();
    let key = |secs: &str, x: f32| {
        format!("[[key]]\ntime = {secs}\nfrom = [{x}, 1.5, 4]\nto = [{x}, 1, 0]\n")
    };
    let film = |name: &str, keys: String| {
        let camera = folder.text(&format!("{name}.toml"));
        std::fs::write(&camera, keys).expect("written");
        let out = folder.text(&format!("{name}.png"));
        let args = ["render", "@child", "--members", "4", "--frames", "3", "--fps", "4"];
        let view = ["--shutter", "360", "--full-detail", "--camera", &camera, "--out", &out];
        run(&[&args[..], &view, &SMALL].concat());
        let frame = |n: usize| std::fs::read(folder.path(&format!("{name}_{n:04}.png")));
        [1, 2].map(|n| frame(n).expect("a frame"))
    };
    let first = film("first", key("0", 0.0));
    let second = film("second", key("0", 0.5));
    let cut = film("cut", [key("0", 0.0), key("0.3", 0.0), key("0.3", 0.5)].concat());
    assert!(cut[0] == first[0], "the frame with the cut differs from that of the first shot");
    assert!(cut[1] == second[1] && second[1] != first[1], "the second shot begins at the cut");
}

#[test]
fn films_that_cannot_be_made_are_refused_at_once() {
    let folder = Folder::new();
    let keys = "[[key]]\ntime = 0\nfrom = [0, 1, 2]\nto = [0, 1, 2]\n";
    std::fs::write(folder.path("keys.toml"), keys).expect("written");
    let keys = folder.text("keys.toml");
    let refuse = |out: &str, args: &[&str], words: &[&str]| {
        let out = folder.text(out);
        let common = ["render", "@child", "--members", "3", "--out", &out];
        refused(&[&common[..], args, &SMALL].concat(), 2, words);
    };
    refuse("f.mp4", &[], &["f.mp4", "--frames N"]);
    refuse("f.avi", &["--frames", "2"], &["f.avi", ".png, .mp4 or .gif"]);
    refuse("f.gif", &["--frames", "2", "--fps", "60"], &["1/655 to 50"]);
    refuse("f.gif", &["--frames", "2", "--skip-existing"], &["numbered PNG files"]);
    // What is left of an interrupted film stays.
    std::fs::write(folder.path("kept.part.mp4"), "part").expect("written");
    refuse("kept.mp4", &["--frames", "2", "--skip-existing"], &["numbered PNG files"]);
    assert_eq!(std::fs::read(folder.path("kept.part.mp4")).expect("kept"), b"part");
    std::fs::remove_file(folder.path("kept.part.mp4")).expect("removed");
    refuse("f.png", &["--frames", "9..3"], &["--frames", "50..99"]);
    refuse("f.png", &["--frames", "2", "--at", "1"], &["--at", "--frames"]);
    refuse("f.png", &["--frames", "2", "--fps", "1/0"], &["--fps", "30000/1001"]);
    refuse("f.png", &["--shutter", "361"], &["--shutter", "0 to 360"]);
    refuse("f.png", &["--images", "depth,normals"], &["--images", "depth, id or alpha"]);
    refuse("f.png", &["--encoder", "x264"], &["openh264 or ffmpeg"]);
    refuse("f.png", &["--encoder", "ffmpeg"], &["--encoder is for MP4 films"]);
    refuse("f.gif", &["--frames", "2", "--encoder", "ffmpeg"], &["--out FILE.mp4"]);
    refuse("f.png", &["--camera", "follow:3"], &["numbers from 0 to 2"]);
    refuse("f.png", &["--camera", &keys], &["keys.toml", "line 4", "`to` must differ"]);
    refuse("f.png", &["--camera", "missing.toml"], &["missing.toml"]);
    let left: Vec<_> = files(&folder).into_keys().collect();
    assert_eq!(left, ["keys.toml"]);
    assert!(!Path::new("f.part.mp4").exists());
}
