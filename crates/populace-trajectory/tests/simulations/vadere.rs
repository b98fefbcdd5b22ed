use populace_trajectory::{Format, HeadingSource, ReadSettings, Unit, load};

use super::{column, problem, problem_with, read, rows_of, warnings};

const HEADER: &str = "#IDXCOL=2,DATACOL=6,SEP=' '\npedestrianId simTime endTime-PID1 startX-PID1 \
                      startY-PID1 endX-PID1 endY-PID1 targetId-PID2";

pub(super) fn small() -> String {
    format!(
        "{HEADER}\n1 0.4 1 2 7 2 6.5 8\n2 0.4 1.1 4 7 4 6 8\n1 1 1.5 2 6.5 2 6.5 8\n\
         1 1.5 2 2 6.5 2.5 6 9\n"
    )
}

#[test]
fn steps_are_kept_and_rows_lie_at_their_ends() {
    let recording = read(small());
    assert_eq!(recording.source.format, Format::Vadere);
    assert_eq!(recording.source.unit.value, Unit::Metres);
    assert_eq!(recording.source.heading.value, HeadingSource::Motion);
    let expected = [(0.4, [2.0, 7.0]), (1.0, [2.0, 6.5]), (1.5, [2.0, 6.5]), (2.0, [2.5, 6.0])];
    assert_eq!(rows_of(&recording, "1"), expected);
    let steps = recording.track(&recording.agents[0]).steps;
    assert_eq!(steps.len(), 3);
    assert_eq!(steps[0].secs, [0.4, 1.0]);
    assert_eq!(steps[0].at, [[2.0, 7.0], [2.0, 6.5]]);
    assert_eq!(steps[1].at[0], steps[1].at[1], "the agent stands");
    assert_eq!(column(&recording, "targetId"), ["8", "8", "8", "9", "8", "8"]);
    assert!(recording.warnings.is_empty(), "{:?}", warnings(&recording));
}

#[test]
fn other_names_and_orders_of_columns_are_read() {
    let text = "id startX startY endX endY startTime endTime\n5 1 2 3 4 10 11\n";
    assert_eq!(rows_of(&read(text), "5"), [(10.0, [1.0, 2.0]), (11.0, [3.0, 4.0])]);
}

#[test]
fn waits_between_steps_have_rows_at_both_ends() {
    let recording = read(format!("{HEADER}\n1 0 1 0 0 1 0 8\n1 3 4 1 0 2 0 8\n"));
    let times: Vec<_> = rows_of(&recording, "1").iter().map(|row| row.0).collect();
    assert_eq!(times, [0.0, 1.0, 3.0, 4.0]);
}

#[test]
fn faults_are_warnings_with_their_line() {
    let recording = read(format!(
        "{HEADER}\n1 1 2 1 0 2 0 8\n1 0 1 0 0 1 0 8\n1 2 3 5 0 6 0 8\n1 2.5 3.5 0 0 1 0 8\n\
         1 3 3 6 0 6 0 8\n1 3 x 6 0 7 0 8\n1 3 4\n1 3 4 6 0 7 0 8\n1 4 5 7 0 8 0 8\n"
    ));
    let times: Vec<_> = rows_of(&recording, "1").iter().map(|row| row.0).collect();
    assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(
        warnings(&recording),
        [
            "steps without an id or a number as time or position were left out (2 rows, the first \
             in line 8)",
            "steps begin elsewhere than the last one ended (line 5)",
            "steps that begin before the last one ends were left out (line 6)",
            "steps that end before they begin were left out (line 7)",
        ]
    );
    let strict = ReadSettings { strict: true, ..ReadSettings::default() };
    let text = format!("{HEADER}\n1 0 1 0 0 1 0 8\n1 1 2 3 0 4 0 8\n");
    assert!(problem_with(text, &strict).to_string().contains("line 4"));
}

#[test]
fn files_without_footsteps_are_refused() {
    let settings = ReadSettings { format: Some(Format::Vadere), ..ReadSettings::default() };
    let text = problem_with("timeStep pedestrianId x y\n1 1 2 3\n", &settings).to_string();
    assert!(text.contains("line 1") && text.contains("FootStepProcessor"), "{text}");
    assert!(problem_with("", &settings).to_string().contains("no positions"));
    assert!(problem(HEADER).contains("no positions"));
    assert!(
        problem(format!("{HEADER}\na b c\nd e f\ng\n1 0 1 0 0 1 0 8\n")).contains("3 of 5 rows")
    );
}

#[test]
fn the_only_scenario_beside_a_file_is_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("postvis.traj");
    std::fs::write(&path, small()).expect("a file");
    let place = || load(&path, &ReadSettings::default()).expect("steps");
    assert!(place().place.changes.is_empty());
    let scenario = r#"{"topography": {"attributes": {"bounds":
        {"x": 0, "y": 0, "width": 8, "height": 10}}, "obstacles": []}}"#;
    std::fs::write(folder.path().join("a.scenario"), scenario).expect("a file");
    assert_eq!(place().place.walkable_at(0.0)[0].outline[2], [8.0, 10.0]);
    std::fs::write(folder.path().join("b.scenario"), "{}").expect("a file");
    assert!(warnings(&place())[0].contains("several scenarios"));
    let geometry = Some(folder.path().join("a.scenario"));
    let settings = ReadSettings { geometry, ..ReadSettings::default() };
    let recording = load(&path, &settings).expect("steps");
    assert!(recording.warnings.is_empty());
    assert_eq!(recording.place.walkable_at(0.0).len(), 1);
    std::fs::remove_file(folder.path().join("a.scenario")).expect("a file");
    assert!(warnings(&place())[0].contains("b.scenario: no topography"));
}

#[test]
fn a_unit_that_is_told_holds_for_steps_and_the_scenario() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("postvis.traj");
    let text =
        format!("{HEADER}\n1 0 0.5 500000 700 500050 650 8\n1 0.5 1 500050 650 500050 600 8\n");
    std::fs::write(&path, text).expect("a file");
    let scenario = r#"{"topography": {"attributes": {"bounds":
        {"x": 500000, "y": 0, "width": 800, "height": 1000}}, "obstacles": [{"shape":
        {"type": "RECTANGLE", "x": 500100, "y": 100, "width": 200, "height": 50}}]}}"#;
    let scenario_path = folder.path().join("a.scenario");
    std::fs::write(&scenario_path, scenario).expect("a file");
    let settings = ReadSettings { unit: Some(Unit::Centimetres), ..ReadSettings::default() };
    let recording = load(&path, &settings).expect("steps");
    assert_eq!(recording.origin_m, [5000.0, 0.0]);
    let track = recording.track(&recording.agents[0]);
    assert_eq!(track.positions, [[0.0, 7.0], [0.5, 6.5], [0.5, 6.0]]);
    let steps: Vec<_> = track.steps.iter().map(|step| step.at).collect();
    assert_eq!(steps, [[[0.0, 7.0], [0.5, 6.5]], [[0.5, 6.5], [0.5, 6.0]]]);
    assert_eq!(recording.place.walkable_at(0.0)[0].outline[2], [8.0, 10.0]);
    assert_eq!(recording.place.obstacles[0].outline[0], [1.0, 1.0]);
    // A file that the settings name is in metres.
    let settings = ReadSettings { geometry: Some(scenario_path), ..settings };
    let recording = load(&path, &settings).expect("steps");
    assert_eq!(recording.place.walkable_at(0.0)[0].outline[2], [495_800.0, 1000.0]);
}

#[test]
fn steps_to_places_that_are_left_out_are_left_out_too() {
    let recording =
        read(format!("{HEADER}\n1 0 1 0 0 1 0 8\n1 1 2 1 0 1e30 0 8\n1 3 4 2 0 3 0 8\n"));
    let steps = recording.track(&recording.agents[0]).steps;
    assert_eq!(steps.len(), 2, "{steps:?}");
    assert!(!recording.warnings.is_empty());
}
