use populace_trajectory::{Format, ReadSettings};

use super::{column, compressed, problem, problem_with, read, rows_of, warnings};

pub(super) fn small() -> String {
    r#"{
  "0": {
    "0.0": {"name": "Ann", "isActive": false, "position": {"x": 0, "y": 0, "z": 0}},
    "0.5": {"name": "Ann", "isActive": true, "position": {"x": 1.5, "y": 2, "z": 3},
      "velocity": {"x": 1, "y": 0, "z": 0, "magnitude": 1.25}, "location": "101",
      "tags": ["a", "b"], "nested": {"deep": {"deeper": 1}}},
    "1.0": {"name": "Ann", "isActive": true, "position": {"x": 2, "y": 2, "z": 3},
      "velocity": {"x": 1, "y": 0, "z": 0, "magnitude": 1}, "location": "stairs \"B\""}
  },
  "3": {"1.0": {"position": {"x": "7.5", "y": 8, "z": 0}, "terrainType": "level"}}
}"#
    .to_owned()
}

#[test]
fn agents_times_and_columns_are_read() {
    let recording = read(small());
    assert_eq!(recording.source.format, Format::PathfinderJson);
    assert_eq!(rows_of(&recording, "0"), [(0.5, [1.5, 2.0]), (1.0, [2.0, 2.0])]);
    assert_eq!(rows_of(&recording, "3"), [(1.0, [7.5, 8.0])]);
    assert_eq!(recording.track(&recording.agents[0]).elevations, [3.0, 3.0]);
    assert_eq!(column(&recording, "name"), ["Ann", "Ann", ""]);
    assert_eq!(column(&recording, "location"), ["101", "stairs \"B\"", ""]);
    assert_eq!(column(&recording, "velocity"), ["1.25", "1", "NaN"]);
    assert_eq!(column(&recording, "terrainType"), ["", "", "level"]);
    assert!(recording.warnings.is_empty(), "{:?}", warnings(&recording));
    assert_eq!(read(compressed(small().as_bytes())).row_count(), 3);
}

#[test]
fn faults_are_warnings_with_their_entry() {
    let text =
        small().replace("\"x\": 2,", "").replace("\"1.0\": {\"position\"", "\"x\": {\"position\"");
    let text = text.replace(
        "\"3\": {",
        "\"2\": {\"0\": {\"position\": {\"x\": 1, \"y\": 1, \"z\": 0}}, \
                             \"1\": {\"position\": {\"x\": 1, \"y\": 1, \"z\": 0}}}, \"3\": {",
    );
    let recording = read(text);
    let expected =
        "rows without a number as time or position were left out (2 rows, the first in row 3)";
    assert_eq!(warnings(&recording), [expected]);
    let nulls = r#"{"1": {"0": {"position": {"x": 1, "y": 1}}, "1": null, "2": {"position": null},
        "3": {"position": {"x": 1, "y": 2}}, "4": {"position": {"x": 1, "y": 2}}}}"#;
    assert_eq!(read(nulls).row_count(), 3);
}

#[test]
fn files_that_are_cut_off_are_read_up_to_there() {
    let text = small();
    let cut = &text[..text.find("stairs").expect("there")];
    let recording = read(cut);
    assert_eq!(recording.row_count(), 1);
    assert_eq!(warnings(&recording), ["the file is cut off in line 8"]);
    let strict = ReadSettings { strict: true, ..ReadSettings::default() };
    assert!(problem_with(cut, &strict).to_string().contains("line 8"));
}

#[test]
fn other_json_is_refused_with_its_line() {
    let text = problem("{\"position\":\n5\n}");
    assert!(text.contains("line 3"), "{text}");
    assert!(problem("{\"1\": {\"0\":\n{\"position\": 5}}}").contains("row 1: 1 of 1 rows"));
    assert!(problem("{\"1\": {\n\"0\": {\"position\": {\"x\" 1}}}}").contains("line 2"));
    let settings = ReadSettings { format: Some(Format::PathfinderJson), ..ReadSettings::default() };
    assert!(problem_with("[1, 2]", &settings).to_string().contains("line 1"));
    assert!(problem_with("{}", &settings).to_string().contains("no positions"));
    let deep = "{\"1\":".repeat(100_000);
    assert!(problem_with(deep, &settings).to_string().contains("line 1"));
}

#[test]
fn a_byte_order_mark_is_skipped() {
    assert_eq!(read(format!("\u{feff}{}", small())).row_count(), 3);
    assert_eq!(read(compressed(format!("\u{feff}{}", small()).as_bytes())).row_count(), 3);
}
