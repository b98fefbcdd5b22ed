//! Tests of `populace bench`: its document, its loads, and refused arguments.

use std::path::Path;

use serde_json::{Value, json};

use crate::post::{Folder, post};
use crate::{json_of, populace, refused};

const NATIVE: [&str; 5] = ["bench", "--frames", "2", "--device", "native"];

fn runs_of(args: &[&str]) -> Vec<Value> {
    let d = json_of(&[args, &["--json"]].concat());
    assert_eq!(d["schema"], 1);
    assert!(d["machine"].as_str().is_some_and(|machine| machine.contains("threads")));
    d["runs"].as_array().expect("runs").clone()
}

/// Returns the only run with the given field values.
#[track_caller]
fn only<'a>(runs: &'a [Value], fields: &[(&str, Value)]) -> &'a Value {
    let nearly_equal = |run: &&Value| fields.iter().all(|(name, value)| run[name] == *value);
    let found: Vec<_> = runs.iter().filter(nearly_equal).collect();
    assert_eq!(found.len(), 1, "{fields:?}");
    found[0]
}

#[test]
fn bench_reports_times_and_errors() {
    let runs = runs_of(&[&NATIVE[..], &["--members", "40"]].concat());
    let stage = |schedule: &str, stage: &str| {
        only(&runs, &[("schedule", json!(schedule)), ("stage", json!(stage))])
    };
    let floor = stage("floor", "all");
    assert_eq!((&floor["max_error"], &floor["bytes_per_joint"]), (&Value::Null, &json!(48.0)));
    for schedule in ["staged", "fused"] {
        let all = stage(schedule, "all");
        assert!(all["max_error"].as_f64() > Some(0.0), "single precision has some error");
        assert!(
            all["ms_min"].as_f64() > Some(0.0)
                && all["ms_min"].as_f64() <= all["ms_median"].as_f64()
        );
        assert!(all["wall_ms_median"].as_f64() >= all["ms_min"].as_f64());
        // Ten of each skeleton: 24, 54, 67 and 128 joints.
        assert_eq!(
            (&all["members"], &all["joints"], &all["slots"]),
            (&json!(40), &json!(2730), &json!(2))
        );
        let ns = all["ms_median"].as_f64().expect("a time") * 1e6 / 2730.0;
        assert!((all["ns_per_joint"].as_f64().expect("a time") - ns).abs() < 1e-6);
    }
    for name in ["evaluate", "pose", "transform", "write_back"] {
        assert_eq!(stage("staged", name)["max_error"], Value::Null);
    }
    let baked = stage("baked", "all");
    let (error, bytes) = (baked["max_error"].as_f64(), baked["baked"]["bytes"].as_u64());
    assert!(
        error > Some(0.0) && error < Some(0.1),
        "interpolated matrices are near the oracle's, not equal: {error:?}"
    );
    assert!(baked["slots"] == 1 && bytes > baked["baked"]["row_bytes"].as_u64(), "{baked}");
}

#[test]
fn help_says_what_is_not_for_given_characters() {
    let help = String::from_utf8(populace(&["bench", "--help"]).stdout).expect("text");
    let words: Vec<&str> = help.split_whitespace().collect();
    assert!(words.join(" ").contains("A list, or repeated; not with FILE"), "{help}");
}

#[test]
fn baked_tables_of_clips_of_one_pose_hold_that_pose() {
    let folder = Folder::new();
    let mut still = post();
    for accessor in [5, 6] {
        still["accessors"][accessor]["count"] = json!(1);
    }
    still["accessors"][5]["max"] = json!([0.5]);
    std::fs::write(folder.path("still.gltf"), still.to_string()).expect("written");
    let args = [&folder.text("still.gltf"), "--members", "3", "--schedule", "baked"];
    let runs = runs_of(&[&NATIVE[..], &args].concat());
    let baked = only(&runs, &[("schedule", json!("baked"))]);
    assert!(baked["max_error"].as_f64().is_some_and(|error_m| error_m < 1e-5), "{baked}");
}

#[test]
fn bench_measures_every_size_and_load() {
    let args = ["--members", "40,9", "--members", "20", "--retarget", "--changing", "10"];
    let runs = runs_of(&[&NATIVE[..], &["--schedule", "fused", "--slots", "1"], &args].concat());
    assert_eq!(runs.len(), 3 * 4);
    for members in [40, 9, 20] {
        only(&runs, &[("members", json!(members)), ("schedule", json!("floor"))]);
        for load in ["plain", "retargeted", "changing 10 %"] {
            let run = only(
                &runs,
                &[("members", json!(members)), ("schedule", json!("fused")), ("load", json!(load))],
            );
            assert!(run["max_error"].as_f64() > Some(0.0));
            assert_eq!(run["change_ms_median"].is_f64(), load == "changing 10 %");
        }
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn member_with_four_slots_takes_at_most_256_device_bytes() {
    let args = ["bench", "--frames", "2", "--members", "100", "--slots", "4", "--device", "opencl"];
    let runs = runs_of(&[&args[..], &["--schedule", "fused", "--retarget"]].concat());
    for load in ["plain", "retargeted"] {
        let run = only(&runs, &[("schedule", json!("fused")), ("load", json!(load))]);
        let bytes = run["bytes_per_member_beyond_palettes"].as_f64();
        assert!(bytes > Some(48.0 * 4.0) && bytes <= Some(256.0), "{bytes:?}");
        assert!(run["host_ms_median"].as_f64() <= run["wall_ms_median"].as_f64());
    }
}

#[test]
fn invalid_values_are_refused() {
    for members in ["0", "10,x", "", "10,0", "99999999"] {
        refused(&["bench", "--members", members], 2, &["--members"]);
    }
    for percent in ["0", "101", "-1", "NaN", "x"] {
        refused(
            &["bench", &format!("--changing={percent}")],
            2,
            &["--changing", "above 0 and up to 100"],
        );
    }
    refused(&["bench", "--schedule", "magic"], 2, &["no schedule \"magic\"", "or baked"]);
    refused(&["bench", "--schedule", "baked", "--device", "opencl"], 2, &["native device only"]);
    refused(&["bench", "--slots", "9"], 2, &["--slots"]);
    refused(&["bench", "--device", "cuda"], 2, &["native, opencl"]);
}

#[test]
fn crowds_too_large_for_memory_are_skipped() {
    // A terabyte of palettes, and another of data between stages.
    let args = [&NATIVE[..], &["--members", "10000000", "--joints", "2000"]].concat();
    let words = [
        "skipped: staged of 10000000 members on native",
        "skipped: baked",
        "all subjects were skipped",
    ];
    refused(&args, 4, &words);
}

/// Returns the names of all elements, and asserts that they are nested correctly.
fn elements(svg: &str) -> Vec<&str> {
    let (mut open, mut elements) = (Vec::new(), Vec::new());
    for tag in svg.split('<').skip(1) {
        let (tag, text) = tag.split_once('>').expect("the end of a tag");
        let name = tag.split([' ', '/']).find(|word| !word.is_empty()).expect("a name");
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closed without being open");
        } else {
            elements.push(name);
            open.extend((!tag.ends_with('/')).then_some(name));
        }
        assert!(
            text.trim().is_empty() || open.last() == Some(&"text"),
            "{text:?} is not in a label"
        );
    }
    assert!(open.is_empty(), "{open:?} are still open");
    elements
}

#[test]
fn chart_shows_every_series() {
    let folder = Folder::new();
    let chart = folder.text("chart.svg");
    let output = populace(
        &[&NATIVE[..], &["--members", "10,100,20", "--retarget", "--chart", &chart]].concat(),
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = String::from_utf8(output.stdout).expect("text");
    assert!(table.contains("| 100 | native | fused | all | retargeted |"), "{table}");
    assert!(!table.contains("write_back"), "with several sizes the table has no stages");
    let svg = std::fs::read_to_string(&chart).expect("a chart");
    let elements = elements(&svg);
    let count = |name: &str| elements.iter().filter(|element| **element == name).count();
    let names = [
        "native floor",
        "native staged",
        "native staged, retargeted",
        "native fused",
        "native fused, retargeted",
        "native baked",
    ];
    for name in names {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
    // Each series has a line through three points, and one through a point in the legend. Both
    // lines of the floor are dashed.
    assert_eq!((count("path"), count("circle")), (2 * names.len(), 4 * names.len()));
    assert_eq!(svg.matches("stroke-dasharray").count(), 2);
    for line in svg.split("d=\"M").skip(1) {
        let numbers =
            line.split('"').next().expect("the end").split([' ', 'L']).filter(|p| !p.is_empty());
        let inside = |place: &str| place.parse::<f64>().is_ok_and(|at| (0.0..1000.0).contains(&at));
        assert!(numbers.clone().count() >= 4 && numbers.into_iter().all(inside), "{line}");
    }
    assert!(svg.contains("nanoseconds per joint") && svg.contains(">members"), "axes are labelled");
}

/// Returns whether documents are equal except for the last digits of numbers.
fn nearly_equal(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            (a - b).abs() <= 1e-12 * a.abs()
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| nearly_equal(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter().all(|(name, a)| b.get(name).is_some_and(|b| nearly_equal(a, b)))
        }
        _ => a == b,
    }
}

#[test]
fn saved_document_reproduces_table_and_chart() {
    let folder = Folder::new();
    let (data, chart) = (folder.text("data.json"), folder.text("chart.svg"));
    let args = [&NATIVE[..], &["--members", "20", "--changing", "5", "--json", "--chart", &chart]]
        .concat();
    let document = json_of(&args);
    let drawn = std::fs::read_to_string(&chart).expect("a chart");
    std::fs::write(&data, document.to_string()).expect("written");
    assert!(nearly_equal(
        &json_of(&["bench", "--from", &data, "--json", "--chart", &chart]),
        &document
    ));
    let again = std::fs::read_to_string(&chart).expect("a chart");
    assert_eq!(elements(&again), elements(&drawn));
    let table = String::from_utf8(populace(&["bench", "--from", &data]).stdout).expect("text");
    let words = [
        "| 20 | native | staged | pose | plain |",
        "changing 5 %, fused of 20",
        "pairs of model and clip",
    ];
    words.iter().for_each(|word| assert!(table.contains(word), "{word}: {table}"));

    refused(&["bench", "--from", &data, "--members", "5"], 2, &["--from"]);
    refused(&["bench", "--from", &folder.text("nothing.json")], 1, &["nothing.json"]);
    let mut broken = document;
    broken["runs"][2]["ms_median"] = Value::Null;
    std::fs::write(&data, broken.to_string()).expect("written");
    refused(&["bench", "--from", &data], 1, &["data.json", "runs[2] has no ms_median"]);
    std::fs::write(&data, "[]").expect("written");
    refused(&["bench", "--from", &data], 1, &["schema 1"]);
}

#[test]
fn unwritable_chart_is_refused() {
    let folder = Folder::new();
    refused(&["bench", "--chart", &folder.text("chart.png")], 2, &["does not end in .svg"]);
    refused(&["bench", "--chart", &folder.text("no/chart.svg")], 4, &["cannot write"]);
}

#[test]
fn benchmarks_page_matches_its_data() {
    let folder = Folder::new();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let (data, chart) = (docs.join("data/benchmark.json"), folder.text("chart.svg"));
    let output = populace(&["bench", "--from", &data.to_string_lossy(), "--chart", &chart]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |path: &Path| std::fs::read_to_string(path).expect("text");
    let page = read(&docs.join("benchmarks.md"));
    let table = String::from_utf8(output.stdout).expect("text");
    for line in table.lines().skip(2) {
        assert!(page.contains(line), "docs/benchmarks.md lacks: {line}");
    }
    assert!(
        read(Path::new(&chart)) == read(&docs.join("pictures/benchmark.svg")),
        "the chart differs from docs/pictures/benchmark.svg"
    );
}

/// Writes a program that stands in for one of `--against`, and returns its path.
#[cfg(unix)]
fn rival(folder: &Folder, name: &str, script: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.text(name);
    std::fs::write(&path, format!("#!/bin/sh\n{script}")).expect("written");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("a program");
    path
}

#[test]
#[cfg(unix)]
fn another_program_takes_turns_and_times_are_compared() {
    let folder = Folder::new();
    let args = |program: &str| -> Vec<String> {
        let more = ["--schedule", "fused", "--members", "20,40", "--slots", "3", "--joints", "2"];
        let all = [&NATIVE[..], &more, &["--against", program]].concat();
        all.into_iter().map(str::to_owned).collect()
    };
    let run = |program: &str, more: &[&str]| {
        let args = args(program);
        let args: Vec<&str> = args.iter().map(String::as_str).chain(more.iter().copied()).collect();
        json_of(&args)
    };
    // The scene ends with a line for each member. Frames to warm up take longer, and are not
    // counted: three of five. All joints stay at the origin.
    let scene = r#"until [ "$line" = "20 3" ] || [ "$line" = "40 3" ]; do read -r line; done
        echo "$line" >> "$0.told"; n=${line% *}
        while [ $n -gt 0 ]; do read -r line; n=$((n - 1)); done; echo ready
        "#;
    let counts = r#"while read -r line; do n=$((n + 1))
        if [ "$line" ]; then echo 1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1 0
        elif [ $n -gt 3 ]; then echo 0.$n; else echo 100; fi; done"#;
    let program = rival(&folder, "counts", &(scene.to_owned() + counts));
    let document = run(&program, &["--json"]);
    let told = std::fs::read_to_string(folder.path("counts.told")).expect("what it was told");
    assert_eq!(told, "20 3\n40 3\n");
    let runs = document["runs"].as_array().expect("runs");
    let against = document["against"].as_array().expect("a list");
    assert_eq!(against.len(), 2);
    for (one, members) in against.iter().zip([20, 40]) {
        assert_eq!((&one["members"], &one["slots"]), (&json!(members), &json!(3)));
        assert_eq!((&one["ms_median"], &one["ms_min"]), (&json!(0.5), &json!(0.4)));
        let own = only(
            runs,
            &[("schedule", json!("fused")), ("stage", json!("all")), ("members", json!(members))],
        );
        let ratio = own["ms_median"].as_f64().expect("a time") / 0.5;
        assert!((one["ratio_median"].as_f64().expect("a ratio") - ratio).abs() < 1e-9);
        assert!(one["error_m"].as_f64().expect("an error") > 0.1, "{one}");
    }

    let refuses = |name: &str, script: &str, code: i32, words: &[&str]| {
        let args = args(&rival(&folder, name, script));
        refused(&args.iter().map(String::as_str).collect::<Vec<_>>(), code, words);
    };
    refuses("talks", "echo hello; cat > /dev/null", 1, &["talks", "hello"]);
    refuses("deaf", "exec < /dev/null; sleep 1", 1, &["deaf", "ended early"]);
    refuses("ends", &(scene.to_owned() + "read -r _; echo 1"), 4, &["ended early"]);
    let short = scene.to_owned()
        + r#"while read -r line; do if [ "$line" ]; then echo 1 2 3 4; else echo 1; fi; done"#;
    refuses("short", &short, 4, &["member", "4 numbers"]);
    let nothing = folder.text("nothing");
    refused(&["bench", "--against", &nothing], 1, &["nothing"]);
}

#[test]
fn given_characters_are_measured_with_their_own_clips() {
    let folder = Folder::new();
    let more = ["--schedule", "fused", "--members", "30", "--changing", "10"];
    // A post has two joints.
    let runs = runs_of(&[&NATIVE[..], &[&folder.text("post.gltf")], &more].concat());
    for load in ["plain", "changing 10 %"] {
        let fields = [("load", json!(load)), ("stage", json!("all")), ("schedule", json!("fused"))];
        assert_eq!(only(&runs, &fields)["joints"], json!(60), "{load}");
    }

    let mut still = post();
    still.as_object_mut().expect("an object").remove("animations");
    let bare = folder.text("bare.gltf");
    std::fs::write(&bare, still.to_string()).expect("written");
    refused(&["bench", &bare], 1, &["bare", "no clips of its own"]);
    refused(&["bench", &folder.text("nobody.glb")], 1, &["nobody.glb"]);
    refused(&["bench", "@child", "--joints", "5"], 2, &["--joints"]);
    refused(&["bench", "@child", "--load", "full"], 2, &["--load"]);
    refused(&["bench", "@child", "--retarget"], 2, &["--retarget"]);
}
