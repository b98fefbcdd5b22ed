//! Values of scene files: each number has a range, and what is out of it is named with its line.

use std::collections::BTreeSet;
use std::ops::Range;

use populace_scene::plan::ScenePlan;
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

/// A file with each number that there is, on a line of its own where a test changes it.
const FULL: &str = include_str!("full.toml");

/// Checks that `FULL` with another value of a key is refused at the key's line. The key is the
/// first one after the line `after`.
#[track_caller]
fn refused(after: &str, key: &str, value: &str, words: &str) {
    let mut lines: Vec<&str> = FULL.lines().collect();
    let first = lines.iter().position(|line| *line == after).expect("the line before");
    let starts = |line: &&str| line.strip_prefix(key).is_some_and(|rest| rest.starts_with(" = "));
    let at = first + lines[first..].iter().position(starts).expect("the key");
    let changed = format!("{key} = {value}");
    lines[at] = &changed;
    let error = ScenePlan::parse(&lines.join("\n")).expect_err("a refusal");
    assert_eq!(error.line, at + 1, "{changed}: {error}");
    assert!(error.message.contains(words), "{changed}: no {words:?} in: {error}");
}

#[test]
fn numbers_without_meaning_are_refused() {
    for (table, key, value, words) in [
        ("[light]", "sun_height_deg", "nan", "of [light] must be from -90 to 90 degrees, not NaN"),
        ("[light]", "sun_facing_deg", "1e9", "from -3600 to 3600 degrees, not 1000000000"),
        ("[output]", "size", "[0, 9]", "`size` of [output] must be of numbers from 1 to 16384"),
        ("[output]", "fps", "nan", "from 0.001 to 1000 frames in a second, not NaN"),
        ("[output]", "seconds", "-1", "from 0 to 10000 seconds, not -1"),
        ("[output]", "lead_in_s", "-5", "`lead_in_s` of [output] must be from 0 to 10000"),
        ("[output]", "lead_in_s", "nan", "not NaN"),
        ("[ground]", "height_m", "inf", "`height_m` of [ground] must be from -1000000"),
        ("[[cast]]", "top", "[0, 1, 2]", "`top` of a [[cast]] must be of numbers from 0 to 1"),
        ("[[crowd]]", "layers", "[{ clip = \"Wave\", share = 7 }]", "`share` of `layers`"),
        ("[[crowd]]", "layers", "[{ clip = \"Wave\", weight = nan }]", "not NaN"),
        ("[crowd.gaze]", "weight", "2", "`weight` of `gaze` of a [[crowd]] must be from 0 to 1"),
        ("[crowd.does.stroll]", "look_in", "nan", "from 0 to 120 times in a minute, not NaN"),
        ("[crowd.does.stroll]", "cross", "-4", "`cross` of `does.stroll` of a [[crowd]]"),
        ("[crowd.does.stroll]", "carry", "1.5", "from 0 to 1, not 1.5"),
        ("[crowd.does.stroll]", "together", "-0.1", "from 0 to 1, not -0.1"),
        ("[crowd.does.stroll]", "speed", "0", "from 0.1 to 10 metres in a second, not 0"),
        ("[crowd.does.spectate]", "wave_speed", "0", "from 0.1 to 1000"),
        ("[crowd.does.fight]", "rank", "0", "from 1 to 10000000 members, not 0"),
        ("[crowd.does.fight]", "spacing_m", "[1, 0]", "of numbers from 0.1 to 1000 metres"),
        ("[crowd.does.stand]", "row", "0", "`row` of `does.stand` of a [[crowd]] must be from 1"),
        ("[[crossing]]", "width_m", "-4", "`width_m` of a [[crossing]] must be from 0.2"),
        ("[[crossing]]", "ends", "[[0, nan], [0, 5]]", "metres, not NaN"),
        ("[[crossing]]", "ends", "[[0, 5], [0, 5]]", "two different points"),
        ("[[lane]]", "speed", "-5", "from 0.1 to 40 metres in a second, not -5"),
        ("[[lane]]", "speed", "nan", "not NaN"),
        ("[[lane]]", "vehicles", "1000000", "from 0 to 20 vehicles, one for each 6 metres"),
        ("[[lane]]", "ends", "[[1, 2], [1, 2]]", "two points 1 metre apart or more"),
    ] {
        refused(table, key, value, words);
    }
}

#[test]
fn lines_without_length_are_refused() {
    for (table, value, words) in [
        ("[[footway]]", "[[0, 0], [0, 0]]", "at least two points, not all of them equal"),
        ("[[footway]]", "[[5, 5]]", "at least two points"),
        ("[[footway]]", "[]", "at least two points"),
        ("[[wall]]", "[[0, 0], [0, 0]]", "that differ from the one before"),
        ("[[wall]]", "[[0, 0], [5, 0], [5, 5], [0, 0]]", "of a closed wall if it is the first"),
        ("[[wall]]", "[]", "at least two points"),
    ] {
        refused(table, "points", value, words);
    }
}

/// Returns the spans of the lists of numbers and of points within a value, with their keys.
fn lists(value: &DeValue<'_>, key: &str, found: &mut Vec<(String, Range<usize>)>) {
    match value {
        DeValue::Table(table) => {
            for (key, value) in table {
                let is_list = value.get_ref().as_array().is_some_and(|all| {
                    all.iter().all(|one| !one.get_ref().is_table() && !one.get_ref().is_str())
                });
                // Lists of any length.
                if is_list && !["points", "size_m"].contains(&key.get_ref().as_ref()) {
                    found.push((key.get_ref().to_string(), value.span()));
                }
                lists(value.get_ref(), key.get_ref(), found);
            }
        }
        DeValue::Array(all) => {
            for one in all {
                if one.get_ref().is_array() {
                    found.push((key.to_owned(), one.span()));
                }
                lists(one.get_ref(), key, found);
            }
        }
        _ => {}
    }
}

#[test]
fn lists_of_another_length_are_refused() {
    let root = DeTable::parse(FULL).expect("TOML");
    let mut found = Vec::new();
    lists(&DeValue::Table(root.into_inner()), "", &mut found);
    let keys: BTreeSet<&str> = found.iter().map(|(key, _)| key.as_str()).collect();
    let known = ["at", "ends", "from", "look_at", "points", "size", "spacing_m", "to", "top"];
    assert_eq!(keys.into_iter().collect::<Vec<_>>(), known);
    for (key, span) in found {
        let list = &FULL[span.clone()];
        let inside = &list[1..list.len() - 1];
        // The last item once more, and all but the last.
        let last = inside.rfind(if inside.ends_with(']') { ", [" } else { ", " }).expect("two");
        for changed in [format!("[{inside}{}]", &inside[last..]), format!("[{}]", &inside[..last])]
        {
            let text = format!("{}{changed}{}", &FULL[..span.start], &FULL[span.end..]);
            let error = ScenePlan::parse(&text).expect_err(&format!("{key} = {changed}"));
            let line = FULL[..span.start].lines().count();
            assert_eq!(error.line, line, "{key} = {changed}: {error}");
            let begin = format!("`{key}` must be a list of ");
            assert!(error.message.starts_with(&begin), "{key} = {changed}: {error}");
        }
    }
}

#[test]
fn a_misspelt_use_of_a_clip_is_refused() {
    let words = "`sitt` of `clips` of a [[cast]] must be a use of clips, and none is \"sitt\"; \
                 did you mean \"sit\"";
    refused("[[cast]]", "clips", "{ sitt = \"Nope\" }", words);
    refused(
        "[[cast]]",
        "clips",
        "{ xyz = \"Nope\" }",
        "there are sit_down, sit, stand_up, look_in",
    );
}

#[test]
fn an_unknown_sky_is_refused() {
    refused("[light]", "sky", "\"dya\"", "`sky` of [light] must be one of the skies");
    for sky in populace_render::Preset::ALL {
        let text = format!("schema = 1\n[light]\nsky = \"{sky}\"\n");
        assert_eq!(ScenePlan::parse(&text).expect("a sky").light.sky, sky.name());
    }
}

#[test]
fn sizes_to_which_props_are_cut_are_refused() {
    for (kind, sizes, words) in [
        ("stand", "[30, 40]", "at most 512 seats in all, not 30 rows of 40"),
        ("stand", "[20]", "not 20 rows of 40"),
        ("stand", "[0, 40]", "a number of rows from 1 to 512, not 0"),
        ("stand", "[2.5, 40]", "whole numbers"),
        ("road", "[1001]", "a length from 4 to 1000 metres, not 1001"),
        ("road", "[60, 1]", "a footway from 2 to 20 metres, not 1"),
        ("road", "[60, 4, 7]", "a parking strip from 0 to 6 metres, not 7"),
        ("shopfront", "[4.9]", "a width from 5 to 12 metres, not 4.9"),
        ("shopfront", "[7, 7]", "no more than the width"),
        ("lawn", "[2001]", "a side from 1 to 2000 metres, not 2001"),
        ("meadow", "[nan]", "metres, not NaN"),
        ("earth", "[0]", "metres, not 0"),
        ("bench", "[2]", "left out: only grounds, roads"),
    ] {
        let prop = format!("schema = 1\n[[prop]]\nkind = \"{kind}\"\nat = [0, 0, 0]\n");
        assert!(ScenePlan::parse(&prop).is_ok(), "the usual size of a {kind}");
        let text = format!("{prop}size_m = {sizes}\n");
        let error = ScenePlan::parse(&text).expect_err(kind);
        assert_eq!(error.line, 5, "{kind}: {error}");
        let named = error.message.starts_with("`size_m` of a [[prop]] must be ");
        assert!(named && error.message.contains(words), "{kind} {sizes}: {error}");
    }
    for (kind, sizes) in
        [("stand", "[32, 16]"), ("road", "[1000, 20, 6]"), ("shopfront", "[12]"), ("lawn", "[2e3]")]
    {
        let text =
            format!("schema = 1\n[[prop]]\nkind = \"{kind}\"\nat = [0, 0, 0]\nsize_m = {sizes}\n");
        assert!(ScenePlan::parse(&text).is_ok(), "{kind} {sizes}");
    }
}

#[test]
fn cameras_that_cannot_be_chosen_are_refused() {
    for name in ["top", "crowd", "close", "iso", "orbit", "follow", "eye"] {
        let words = format!("not \"{name}\": `--camera` takes those for other cameras");
        refused("[[camera]]", "name", &format!("\"{name}\""), &words);
    }
    for name in ["", "1st", "a:b", "a,b", "a/b", "a.b"] {
        refused("[[camera]]", "name", &format!("\"{name}\""), "begins with a letter");
    }
    let second = FULL.replace("name = \"second\"", "name = \"first\"");
    let error = ScenePlan::parse(&second).expect_err("two cameras of a name");
    assert!(error.message.contains("unique, and another is \"first\""), "{error}");
}

#[test]
fn keys_of_cameras_are_in_order_and_look_somewhere() {
    let (first, last) = ("[[camera.key]]", "# The last key.");
    for (after, key, value, words) in [
        (first, "time", "nan", "`time` of `key` of a [[camera]] must be from 0 to 1000000 seconds"),
        (first, "time", "-1", "seconds, not -1"),
        (last, "time", "1", "not before that of the key before"),
        (first, "from", "[nan, 1, 2]", "metres, not NaN"),
        (first, "to", "[0, inf, 2]", "metres, not inf"),
        (first, "to", "[0, 1, 2]", "another point than `from`"),
        (first, "fov", "0", "from 1 to 170 degrees, not 0"),
    ] {
        refused(after, key, value, words);
    }
}

/// A step from a table or a list to what is in it.
#[derive(Clone, Debug)]
enum Step {
    Key(String),
    Nth(usize),
}

/// Adds the ways to all numbers of a value, and those to the numbers of lists.
fn add_numbers(value: &Value, way: &[Step], numbers: &mut Vec<Vec<Step>>) {
    let mut add = |value, step| add_numbers(value, &[way, &[step]].concat(), numbers);
    match value {
        Value::Table(table) => {
            table.iter().for_each(|(key, value)| add(value, Step::Key(key.clone())));
        }
        Value::Array(all) => {
            all.iter().enumerate().for_each(|(nth, value)| add(value, Step::Nth(nth)));
        }
        Value::Integer(_) | Value::Float(_) => numbers.push(way.to_vec()),
        _ => {}
    }
}

fn at<'a>(mut value: &'a mut Value, way: &[Step]) -> &'a mut Value {
    for step in way {
        value = match step {
            Step::Key(key) => &mut value[key.as_str()],
            Step::Nth(nth) => &mut value[*nth],
        };
    }
    value
}

/// Every number of the plan has a range, those that are added later too. All kinds of behaviours
/// and of tables are in the file; the plan that is written has all their keys.
#[test]
fn no_number_is_without_a_range() {
    let plan = ScenePlan::parse(FULL).expect("a good file");
    let written: Table = plan.to_toml().expect("a good plan").parse().expect("TOML");
    let all = Value::Table(written);
    let mut numbers = Vec::new();
    add_numbers(&all, &[], &mut numbers);
    assert!(numbers.len() > 120, "{} numbers", numbers.len());
    for way in &numbers {
        if matches!(way.last(), Some(Step::Key(key)) if key == "seed") {
            continue;
        }
        let wrong = [f64::NAN, f64::INFINITY, 1e20, -1e20].map(Value::Float);
        let whole = [i64::MAX, i64::MIN].map(Value::Integer);
        for value in wrong.into_iter().chain(whole) {
            let mut all = all.clone();
            *at(&mut all, way) = value.clone();
            let text = toml::to_string(&all).expect("TOML");
            assert!(ScenePlan::parse(&text).is_err(), "{way:?} = {value} is accepted");
        }
    }
}
