//! Scenes: the street of `demo`, scene files, and what is wrong in them.

use crate::post::Folder;
use crate::{json_of, populace, refused};

const SMALL: [&str; 6] = ["--size", "64x36", "--device", "native", "--members", "8"];

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn the_street_says_what_happened() {
    let folder = Folder::new();
    let out = folder.text("street.png");
    let d = json_of(&[&["demo", "--json", "--at", "1", "--out", &out][..], &SMALL].concat());
    assert_eq!(d["members"], 8, "people, without vehicles and things: {d}");
    let levels = d["levels"].as_array().expect("a list").iter().filter_map(|n| n.as_u64());
    let in_view: u64 = levels.sum();
    assert_eq!(d["drawn_members"], in_view, "{d}");
    let others = ["shadow_only", "hidden"].map(|key| d[key].as_u64().expect("a number"));
    assert_eq!(in_view + others[0] + others[1], 8, "{d}");
    assert!(d["counts"]["crossed"].is_u64() && d["counts"]["sat"].is_u64(), "{d}");
    let [crowd] = &d["crowds"].as_array().expect("a list")[..] else { panic!("{d}") };
    assert_eq!([&crowd["first"], &crowd["count"]], [0, 8], "{crowd}");
    assert!(d["ms_median"]["behave"].as_f64() > Some(0.0), "{d}");
    assert!(std::path::Path::new(&out).is_file(), "--at writes the file that was named");
}

/// Draws a scene file with this text, and returns the path of the picture.
fn draw(folder: &Folder, text: &str, args: &[&str]) -> String {
    let [scene, out] = ["scene.toml", "out.png"].map(|name| folder.text(name));
    std::fs::write(&scene, format!("schema = 1\n{text}")).expect("a file");
    let drawn = populace(&[&["render", &scene, "--out", &out], args].concat());
    assert!(drawn.status.success(), "{}", String::from_utf8_lossy(&drawn.stderr));
    out
}

/// Draws a scene whose camera looks down from 10 m above 0, and returns the depth of its middle in
/// centimetres.
fn depth_below(text: &str) -> u16 {
    let folder = Folder::new();
    let camera = "[[camera]]\nname = \"a\"\nkey = [{ from = [0, 10, 0.1], to = [0, 0, 0] }]\n";
    let text = format!("[output]\nsize = [48, 32]\n{text}\n{camera}");
    draw(&folder, &text, &["--images", "depth", "--device", "native"]);
    let depth = image::open(folder.path("out.depth.png")).expect("a picture").to_luma16();
    assert_eq!(depth.dimensions(), (48, 32), "the size is that of the file");
    depth.get_pixel(24, 16).0[0]
}

/// The plain ground lies at its height, unless a prop covers it.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn the_ground_of_a_scene_lies_at_its_height() {
    let bollard = "[[prop]]\nkind = \"bollard\"\nat = [3, 0, 0]\n";
    let earth = "[[prop]]\nkind = \"earth\"\nat = [40, -0.1, 0]\nsize_m = [10]\n";
    for (text, wanted_cm) in [
        (bollard.to_owned(), 1000),
        (format!("[ground]\nheight_m = -1\n{bollard}"), 1100),
        (format!("{bollard}{earth}"), 1040),
    ] {
        let found = depth_below(&text);
        assert!(found.abs_diff(wanted_cm) <= 2, "{found} cm in place of {wanted_cm}: {text}");
    }
}

/// A knight of 2.5 m in a scene is drawn as high as people, or as its cast says.
#[cfg_attr(any(skip_gl, no_test_data), ignore = "no test data, or POPULACE_SKIP names gl")]
#[test]
fn characters_of_scenes_are_as_high_as_people() {
    let folder = Folder::new();
    let data = std::env::var("POPULACE_TEST_DATA").expect("ignored without it");
    let scene = folder.text("scene.toml");
    for height in ["", "height_m = 2.5\n"] {
        let text = format!(
            "schema = 1\n[output]\nsize = [32, 32]\n[[cast]]\nname = \"knights\"\n\
             from = ['{data}/characters/kaykit_knight.glb']\n{height}[[crowd]]\n\
             cast = \"knights\"\ncount = 1\ndoes.stand = {{ clip = \"Idle\" }}\n"
        );
        std::fs::write(&scene, text).expect("a file");
        let drawn = populace(&["render", &scene, "--out", &folder.text("out.png")]);
        let stderr = String::from_utf8_lossy(&drawn.stderr);
        assert!(drawn.status.success(), "{stderr}");
        let said =
            "which suits no scene of people; it is drawn 1.75 m high, and height_m of its cast";
        assert_eq!(stderr.contains(said), height.is_empty(), "{stderr}");
    }
}

/// People on raised ground have the shadows that they have at height 0.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn contact_shadows_lie_on_raised_ground() {
    let picture_at = |height: u8| {
        let folder = Folder::new();
        let text = format!(
            "[output]\nsize = [64, 48]\n[light]\nsky = \"overcast\"\n\
             [ground]\nheight_m = {height}\n\
             [[cast]]\nname = \"people\"\nfrom = [\"@man\"]\nvaried = false\n\
             [[crowd]]\ncast = \"people\"\ncount = 1\ndoes = {{ stand = {{}} }}\n\
             [[camera]]\nname = \"a\"\nkey = [{{ from = [0, {}, 2], to = [0, {height}, 0] }}]\n",
            height + 3
        );
        image::open(draw(&folder, &text, &["--device", "native"])).expect("a picture").to_rgb8()
    };
    let [low, high] = [0, 2].map(picture_at);
    let apart = low.iter().zip(high.iter()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart < Some(8), "{apart:?} of 255");
}

/// The demo writes its scene, and the scene draws the same picture.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_written_scene_draws_the_same_picture() {
    let folder = Folder::new();
    let [scene, a, b] = ["street.toml", "a.png", "b.png"].map(|name| folder.text(name));
    let written = populace(&["demo", "--members", "8", "--write-scene", &scene]);
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let of_demo = populace(&[&["demo", "--out", &a][..], &SMALL].concat());
    assert!(of_demo.status.success(), "{}", String::from_utf8_lossy(&of_demo.stderr));
    let of_file = populace(&[&["render", &scene, "--out", &b][..], &SMALL[..4]].concat());
    assert!(of_file.status.success(), "{}", String::from_utf8_lossy(&of_file.stderr));
    assert!(std::fs::read(a).unwrap() == std::fs::read(b).unwrap(), "two different pictures");
}

/// A post has no legs, and "Bend" is its only clip.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn who_stands_needs_no_walk() {
    let text = "[output]\nsize = [32, 32]\n[[cast]]\nname = \"posts\"\nfrom = [\"post.gltf\"]\n\
                [[crowd]]\ncast = \"posts\"\ncount = 2\ndoes.stand = { clip = \"Bend\" }\n";
    draw(&Folder::new(), text, &["--device", "native"]);
}

#[test]
fn who_must_walk_and_cannot_is_named_with_the_cast() {
    let folder = Folder::new();
    let [scene, out] = ["scene.toml", "out.png"].map(|name| folder.text(name));
    let text = "schema = 1\n[[footway]]\nname = \"f\"\npoints = [[0, 0], [9, 0]]\nwidth_m = 3\n\
                [[cast]]\nname = \"posts\"\nfrom = [\"@man\", \"post.gltf\"]\n\
                [[crowd]]\ncast = \"posts\"\ncount = 2\ndoes.stand = { clip = \"Bend\" }\n\
                [[crowd]]\ncast = \"posts\"\ncount = 2\ndoes.stroll = {}\n";
    std::fs::write(&scene, text).expect("a file");
    let wanted = [
        "scene.toml",
        "the cast \"posts\"",
        "a [[crowd]] of it does `stroll`: \"post\"",
        "no names that are known",
    ];
    refused(&["render", &scene, "--out", &out, "--device", "native"], 1, &wanted);
}

/// The cast of a written scene is the one that was given, wherever the file lies.
#[test]
fn a_written_scene_has_the_cast_that_was_given() {
    let folder = Folder::new();
    let scene = folder.text("street.toml");
    let post = folder.text("post.gltf");
    let written = ["demo", "--cast", "@woman", &post, "--write-scene", &scene];
    let written = populace(&written);
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let text = std::fs::read_to_string(&scene).expect("a scene");
    let plan = populace_scene::plan::ScenePlan::parse(&text).expect("a scene");
    assert!(plan.casts.iter().all(|cast| cast.from == ["@woman", &post]), "{:?}", plan.casts);
}

/// Errors about values of a scene file begin with the name of the file.
#[test]
fn values_of_scene_files_are_refused_with_the_file() {
    let folder = Folder::new();
    let scene = folder.text("wrong.toml");
    let crowd = "[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\ncast = \"a\"\ncount = 1\n";
    for (text, word) in [
        ("[light]\nsky = \"night\"\n".to_owned(), "night"),
        (format!("{crowd}does.stand = {{ at = [nan, 0] }}\n"), "NaN"),
        (format!("{crowd}does.stand = {{ clip = \"Swim\" }}\n"), "Swim"),
    ] {
        std::fs::write(&scene, format!("schema = 1\n{text}")).expect("a file");
        let out = folder.text("x.png");
        refused(
            &["render", &scene, "--out", &out, "--device", "native"],
            1,
            &["wrong.toml: ", word],
        );
    }
}

/// A scene without people shows its things, from all around.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn things_without_people_are_in_the_picture() {
    let folder = Folder::new();
    let text = "[[prop]]\nkind = \"bench\"\nat = [40, 0, 3]\n[output]\nfps = 29.97\n";
    let args = ["--size", "64x64", "--images", "depth,alpha", "--device", "native"];
    let out = draw(&folder, text, &args);
    let open = |kind: &str| image::open(out.replace(".png", kind)).expect("a picture");
    let depth = open(".depth.png").to_luma16();
    // The ground has one depth in a row, but for rounding.
    let is_bench = |(_, y, pixel): &(u32, u32, &image::Luma<u16>)| {
        pixel.0[0].abs_diff(depth.get_pixel(0, *y).0[0]) > 3
    };
    let seen = depth.enumerate_pixels().filter(is_bench).count();
    assert!(open(".alpha.png").to_luma8().pixels().all(|pixel| pixel.0[0] == 0), "nobody");
    assert!((50..2000).contains(&seen), "{seen} of 4096 pixels show the bench");
}

/// Pixels of a box in somebody's hands have the number of who holds it.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn things_in_hands_have_the_number_of_their_holder() {
    let numbered = |holds: &str| {
        let folder = Folder::new();
        let text = format!(
            "[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n{holds}\n\
             [[crowd]]\ncast = \"a\"\ncount = 1\ndoes.stand = {{ clip = \"Carry\" }}\n"
        );
        let args = ["--size", "90x90", "--images", "id,alpha", "--camera", "0,1.3,2.5,0,1,0"];
        let out = draw(&folder, &text, &args);
        let open = |kind: &str| image::open(out.replace(".png", kind)).expect("a picture");
        let (ids, alpha) = (open(".id.png").to_rgb8(), open(".alpha.png").to_luma8());
        let whole = ids.pixels().zip(alpha.pixels()).filter(|(_, alpha)| alpha.0[0] == 255);
        let (of_first, others): (Vec<_>, Vec<_>) =
            whole.map(|(id, _)| id.0).partition(|id| *id == [0, 0, 1]);
        assert_eq!(others.len(), 0, "{holds:?}");
        of_first.len()
    };
    let (alone, with_box) = (numbered(""), numbered("holds = [\"box\"]"));
    assert!(with_box > alone + 50, "{alone} and {with_box} pixels");
}

/// Draws a meadow of a size under an evening sky, and returns its colour 3 m before the camera.
fn meadow(size_m: u32, args: &[&str]) -> [u8; 3] {
    let folder = Folder::new();
    let text = format!(
        "[light]\nsky = \"evening\"\n[[prop]]\nkind = \"meadow\"\nat = [0, 0, 0]\n\
         size_m = [{size_m}]\n[[camera]]\nname = \"a\"\n\
         key = [{{ from = [0, 3, 3], to = [0, 0, 0] }}]\n"
    );
    let out = draw(&folder, &text, &[&SMALL[..4], args].concat());
    let picture = image::open(out).expect("a picture").to_rgb8();
    picture.get_pixel(picture.width() / 2, picture.height() / 2).0
}

/// Haze depends on the distance of what is seen, not on that of the corners of its triangles.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_large_meadow_is_as_clear_as_a_small_one() {
    let [small, large] = [20, 600].map(|size_m| meadow(size_m, &[]));
    let far = small.iter().zip(large).map(|(a, b)| a.abs_diff(b)).max().unwrap();
    assert!(far < 12, "{small:?} and {large:?}");
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn the_sky_of_the_command_line_takes_the_place_of_the_scenes() {
    let evening = meadow(20, &[]);
    assert_eq!(evening, meadow(20, &["--sky", "evening"]));
    let day = meadow(20, &["--sky", "day"]);
    assert!(day[1] > day[0] && day[2] > evening[2], "{day:?}");
}

/// A file stands in a scene as a prop, where the scene says.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_file_is_a_prop() {
    let folder = Folder::new();
    let [scene, out] = ["scene.toml", "out.png"].map(|name| folder.text(name));
    let camera = "[[camera]]\nname = \"a\"\nkey = [{ from = [0, 1, 6], to = [0, 1, 0] }]\n";
    let drawn = |x: &str| {
        let prop = format!("[[prop]]\nfile = \"post.gltf\"\nat = [{x}, 0, 0]\n");
        std::fs::write(&scene, format!("schema = 1\n{camera}{prop}")).unwrap();
        let done = populace(&["render", &scene, "--size", "64x36", "--out", &out]);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        std::fs::read(&out).unwrap()
    };
    assert!(drawn("0") != drawn("900"), "the post is not seen");
}

#[test]
fn wrong_scenes_are_refused_with_line_and_key() {
    let folder = Folder::new();
    let scene = folder.text("scene.toml");
    let good = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n";
    for (text, words) in [
        ("sceme = 1\n", "line 1: there is no key `sceme` here; did you mean \"schema\""),
        ("schema = 7\n", "line 1: `schema` must be 1"),
        ("schema = 1\n[[prop]]\nkind = \"benhc\"\nat = [0, 0, 0]\n", "did you mean \"bench\""),
        (
            "schema = 1\n[[prop]]\nat = [0, 0, 0]\nfile = \"none.glb\"\n",
            "line 4: `file` of a [[prop]]",
        ),
        ("schema = 1\n[light]\nsky = \"dya\"\n", "`sky` of [light]"),
    ] {
        std::fs::write(&scene, text).unwrap();
        refused(&["render", &scene, "--out", "x.png"], 1, &[words]);
    }
    let layer = "{ clip = \"Wave\" }";
    let crowd = format!(
        "{good}[[crowd]]\ncast = \"a\"\ncount = 1\nlayers = [{layer}, {layer}]\n\
         does.fight = {{ at = [0, 0], facing_deg = 0, rank = 5 }}\n"
    );
    std::fs::write(&scene, crowd).unwrap();
    refused(&["render", &scene, "--out", "x.png"], 1, &["2 `layers`", "give at most 1"]);
    std::fs::write(&scene, good).unwrap();
    let cast = ["render", &scene, "--cast", "@woman", "--out", "x.png"];
    refused(&cast, 2, &["names its own characters", "@woman in `from` of a [[cast]]"]);
    let two = "[[cast]]\nname = \"b\"\nfrom = [\"@woman\"]\n";
    std::fs::write(&scene, format!("{good}{two}")).unwrap();
    refused(&["render", &scene, "--hide", "xyz", "--out", "x.png"], 2, &["no node \"xyz\""]);
    std::fs::write(&scene, good).unwrap();
    refused(&["render", &scene, "--members", "5", "--out", "x.png"], 2, &["the scene file says"]);
    refused(
        &["render", &scene, "--camera", "pitch", "--out", "x.png"],
        2,
        &["no camera \"pitch\""],
    );
    refused(&["render", &scene, "--clip", "Run", "--out", "x.png"], 2, &["no meaning for a scene"]);
    refused(&["render", "@man", "--camera", "pitch", "--out", "x.png"], 2, &["only scene files"]);
    let missing = folder.text("none.toml");
    refused(&["render", &missing, "--out", "x.png"], 1, &["none.toml"]);
}

/// Clips that nobody has are named with their line, and with what is like them or where they are.
#[cfg_attr(no_test_data, ignore = "no test data")]
#[test]
fn missing_clips_are_named_with_their_line_and_a_cure() {
    let folder = Folder::new();
    let data = std::env::var("POPULACE_TEST_DATA").expect("ignored without it");
    let [scene, out] = ["scene.toml", "out.png"].map(|name| folder.text(name));
    let cast = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = ['{}']\n[[crowd]]\ncast = \"a\"\n";
    let robot = "quaternius_robot.glb";
    let human = "m2m_human_base.glb";
    for (file, crowd, wanted) in [
        (
            robot,
            "does.stand.clip = \"Dance\"",
            &["line 8: `clip` of `does.stand` of a [[crowd]]", "did you mean \"Robot_Dance\""][..],
        ),
        (
            human,
            "does.stand = { clip = \"Idle_Loop\" }\nlayers = [{ clip = \"Carry\" }]",
            &["line 9: `clip` of `layers` of a [[crowd]]", "`clips_from = [\"@people\"]`"],
        ),
    ] {
        let cast = cast.replace("{}", &format!("{data}/characters/{file}"));
        std::fs::write(&scene, format!("{cast}count = 1\n{crowd}\n")).expect("a file");
        let args = ["render", &scene, "--out", &out, "--device", "native"];
        refused(&args, 1, &[&["scene.toml: line"], wanted].concat());
    }
}

/// Habits that nobody can have are warned of, with the cure, if the scene asks for them.
#[cfg_attr(any(skip_gl, no_test_data), ignore = "no test data, or POPULACE_SKIP names gl")]
#[test]
fn habits_that_nobody_can_have_are_warned_of() {
    let data = std::env::var("POPULACE_TEST_DATA").expect("ignored without it");
    let warned = |keys: &str, habits: &str| {
        let folder = Folder::new();
        let [scene, out] = ["scene.toml", "out.png"].map(|name| folder.text(name));
        let text = format!(
            "schema = 1\n[output]\nsize = [32, 32]\n[[cast]]\nname = \"mixed\"\n\
             from = ['{data}/characters/kaykit_knight.glb']\n{keys}\n[[footway]]\nname = \"f\"\n\
             points = [[0, 0], [20, 0]]\nwidth_m = 3\n[[crowd]]\ncast = \"mixed\"\ncount = 2\n\
             does.stroll = {{ {habits} }}\n"
        );
        std::fs::write(&scene, text).expect("a file");
        let drawn = populace(&["render", &scene, "--out", &out, "--device", "native"]);
        let stderr = String::from_utf8_lossy(&drawn.stderr).into_owned();
        assert!(drawn.status.success(), "{stderr}");
        stderr.lines().find(|line| line.contains("`stroll`")).unwrap_or_default().to_owned()
    };
    let warning = warned("", "talk = 2, phone = 1, carry = 0.2");
    for words in [
        "warning: ",
        "scene.toml: nobody of the cast \"mixed\" can do `talk`, `phone` and `carry`",
        "\"Talk\", \"Talk_Listen\", \"Phone\" and \"Carry\"",
        "`clips_from = [\"@people\"]`",
    ] {
        assert!(warning.contains(words), "no {words} in: {warning}");
    }
    assert_eq!(warned("", ""), "", "usual habits are asked for by nobody");
    assert_eq!(warned("clips_from = [\"@people\"]", "talk = 2, phone = 1, carry = 0.2"), "");
}
