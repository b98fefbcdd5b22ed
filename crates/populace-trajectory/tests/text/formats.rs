//! Each format: units, rates, headings, heights and extra columns.

use std::f32::consts::{FRAC_PI_2, PI};

use populace_trajectory::{
    Fact, HeadingSource, Origin, ReadSettings, Recording, Unit, Values, parse,
};

use super::fixtures::{
    self, CROWD_IT, JPSCORE, OBSMAT, PATHFINDER, PETRACK, TRAJNET, TRAJNET_PLUS_PLUS, VISWALK,
    menge, recording, track,
};

/// Returns the numbers of an extra column.
pub(crate) fn numbers<'a>(recording: &'a Recording, name: &str) -> &'a [f32] {
    match recording.column(name).map(|column| &column.values) {
        Some(Values::Numbers(numbers)) => numbers,
        other => panic!("{name} is {other:?}"),
    }
}

/// Returns the words of an extra column.
pub(crate) fn words<'a>(recording: &'a Recording, name: &str) -> Vec<Option<&'a str>> {
    match recording.column(name).map(|column| &column.values) {
        Some(Values::Words { words, indices }) => {
            indices.iter().map(|index| words.get(*index as usize).map(String::as_str)).collect()
        }
        other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn every_family_is_recognised_and_has_two_agents() {
    for fixture in fixtures::all() {
        let recording = recording(fixture.bytes);
        assert_eq!(recording.source.format, fixture.format, "{}", fixture.name);
        assert_eq!(recording.agents.len(), 2, "{}", fixture.name);
    }
}

#[test]
fn petrack_takes_unit_rate_heights_and_views() {
    let recording = recording(PETRACK);
    assert_eq!(recording.source.unit, Fact::of_file(Unit::Centimetres));
    assert_eq!(recording.source.fps, Fact::of_file(12.5));
    assert_eq!(recording.agents[0].height_m, Some(1.78));
    let first = track(&recording, "1");
    assert_eq!(first.positions, [[1.0, 2.0], [1.05, 2.0]]);
    assert_eq!(first.times, [0.8, 0.88]);
    assert_eq!(first.views[0], FRAC_PI_2);
    assert!(first.views[1].is_nan(), "the vector 0, 0 is no direction");
    assert!(first.elevations.is_empty(), "z is a height of the body");
    assert_eq!(numbers(&recording, "markerID"), [999.0, 999.0, 7.0, 7.0]);
}

#[test]
fn petrack_headers_of_all_kinds_are_read() {
    let rows = "1\t0\t1.0\t2.0\t1.76\n1\t1\t1.1\t2.0\t1.76\n";
    for (header, unit) in [
        ("# framerate: 25\n# PersID\tFrame\tX\tY\tZ\n", Fact::assumed(Unit::Metres)),
        ("# id frame x/m y/m z/m\n", Fact::of_file(Unit::Metres)),
        ("# <number> <frame> <x> [in m] <y> [in m] <z> [in m]\n", Fact::of_file(Unit::Metres)),
    ] {
        let recording = recording(format!("{header}{rows}"));
        assert_eq!(recording.source.unit, unit, "{header}");
        assert_eq!(recording.source.fps.value, 25.0, "{header}");
        assert_eq!(recording.agents[0].height_m, Some(1.76), "{header}");
        assert_eq!(recording.track(&recording.agents[0]).positions[1], [1.1, 2.0]);
    }
}

#[test]
fn petrack_takes_the_first_comment_that_names_columns() {
    let names = "# id frame x/m y/m z/m heading";
    let rows = "1 0 0 0 1.7 1.5\n1 1 0 0.1 1.7 1.5\n";
    for comments in [
        format!("{names}\n# all frames: 3"),
        format!("# first frame: 0\n{names}\n# id frame of the leader\n# id frame x y z a"),
    ] {
        let recording = recording(format!("{comments}\n{rows}"));
        assert_eq!(track(&recording, "1").headings, [1.5, 1.5], "{comments}");
        assert!(recording.columns.is_empty(), "{comments}");
    }
    let loose = "# <number> <frame> <x> <y> <z> <group>\n# all frames: 3 and so on";
    assert_eq!(numbers(&recording(format!("{loose}\n{rows}")), "<group>"), [1.5, 1.5]);
}

#[test]
fn petrack_without_header_is_in_the_unit_of_its_heights() {
    let of = |z| recording(format!("1 43 79.0 774.0 {z}\n1 44 79.5 774.0 {z}\n"));
    let cm = of("183.02");
    assert_eq!(cm.source.unit, Fact::assumed(Unit::Centimetres));
    assert_eq!(cm.source.fps, Fact::assumed(16.0));
    assert_eq!(cm.agents[0].height_m, Some(1.8302));
    assert_eq!(of("1.8302").source.unit, Fact::assumed(Unit::Metres));
}

#[test]
fn petrack_ignores_heights_that_no_body_has() {
    let recording = recording("# id frame x/m y/m z/m\n1 0 0 0 0\n2 0 0 1 3.5\n3 0 0 2 1.6\n");
    let heights: Vec<_> = recording.agents.iter().map(|agent| agent.height_m).collect();
    assert_eq!(heights, [None, None, Some(1.6)]);
}

#[test]
fn settings_overrule_the_file() {
    let settings = ReadSettings {
        unit: Some(Unit::Metres),
        fps: Some(2.0),
        heading: Some(HeadingSource::Motion),
        ..ReadSettings::default()
    };
    let recording = parse("file".as_ref(), JPSCORE.into(), &settings).expect("a recording");
    let source = recording.source.clone();
    assert_eq!((source.unit.origin, source.fps.origin), (Origin::Settings, Origin::Settings));
    let first = track(&recording, "1");
    assert_eq!(first.times, [0.0, 0.5]);
    assert!(first.headings.is_empty());
}

#[test]
fn jpscore_has_elevations_and_angles() {
    let recording = recording(JPSCORE);
    assert_eq!(recording.source.fps, Fact::of_file(8.0));
    assert_eq!(recording.source.heading, Fact::of_file(HeadingSource::Data));
    let second = track(&recording, "2");
    assert_eq!(second.elevations, [1.5, 1.6]);
    assert_eq!(second.headings, [-FRAC_PI_2; 2]);
    assert_eq!(track(&recording, "1").headings, [PI; 2]);
    assert_eq!(numbers(&recording, "COLOR"), [0.0, 20.0, 255.0, 255.0]);
    assert_eq!(numbers(&recording, "A"), [0.18; 4]);
}

#[test]
fn jpscore_without_ellipses_has_no_headings() {
    let recording = recording("#framerate: 16\n#ID FR X Y Z\n1 0 1 2 3\n1 16 2 2 3\n");
    assert_eq!(recording.source.heading.value, HeadingSource::Motion);
    assert_eq!(recording.secs(), [0.0, 1.0]);
    assert_eq!(track(&recording, "1").elevations, [3.0, 3.0]);
}

#[test]
fn viswalk_takes_columns_by_name() {
    let recording = recording(VISWALK);
    assert_eq!(recording.source.unit, Fact::of_file(Unit::Metres));
    assert!((recording.source.fps.value - 5.0).abs() < 1e-9);
    let second = track(&recording, "2");
    assert_eq!((second.times, second.elevations), (&[0.4, 0.6][..], &[3.5, 3.5][..]));
    assert_eq!(second.positions, [[8.5, 2.5], [8.5, 2.6]]);
    assert_eq!(words(&recording, "PEDTYPE\\NAME")[4], Some("Woman"));
}

#[test]
fn crowd_it_leaves_absent_people_out_without_a_warning() {
    let recording = recording(CROWD_IT);
    assert_eq!(recording.warnings, []);
    assert_eq!(track(&recording, "1").times, [0.5, 1.0]);
}

#[test]
fn pathfinder_hides_inactive_people_and_keeps_rooms() {
    let recording = recording(PATHFINDER);
    let first = track(&recording, "0");
    assert_eq!((first.times, first.elevations), (&[1.0, 2.0][..], &[3.2, 3.0][..]));
    assert_eq!(words(&recording, "location")[..2], [Some("Hall, north"), Some("Stairs 1")]);
    assert_eq!(words(&recording, "terrain type")[1], Some("stairs"));
    assert_eq!(words(&recording, "name")[0], Some("00000, first"));
    assert_eq!(numbers(&recording, "v"), [1.1, 1.1, 1.2, 1.2]);
    assert_eq!(recording.warnings, []);
}

#[test]
fn pathfinder_in_feet_is_turned_into_metres() {
    let recording = recording(PATHFINDER.replace("\"m\"", "\"ft\""));
    assert_eq!(recording.source.unit, Fact::of_file(Unit::Feet));
    assert_eq!(track(&recording, "0").positions[0], [5.0 * 0.3048, 0.3048]);
}

#[test]
fn obsmat_counts_frames_of_a_video_at_six_times_its_rows() {
    let recording = recording(OBSMAT);
    assert_eq!(recording.source.fps, Fact::of_file(15.0));
    assert_eq!(recording.warnings, []);
    let second = track(&recording, "2");
    assert_eq!(second.positions[0], [13.64021, 5.802]);
    assert!((second.times[1] - second.times[0] - 0.4).abs() < 1e-9);
    assert_eq!(numbers(&recording, "vx")[0], 1.671_32);
}

#[test]
fn obsmat_whose_velocities_disagree_with_its_rate_is_doubted() {
    let faster = OBSMAT.replace("1.671320e+00", "4.5").replace("-1.936000e+00", "-5.5");
    let recording = recording(faster);
    assert_eq!(recording.source.fps, Fact::assumed(15.0));
    let warning = recording.warnings[0].to_string();
    assert!(warning.contains("velocities") && warning.contains("--data-fps"), "{warning}");
}

#[test]
fn trajnet_counts_frames_by_its_steps_and_skips_question_marks() {
    let recording = recording(TRAJNET);
    assert_eq!(recording.source.fps, Fact::assumed(25.0));
    assert_eq!(track(&recording, "2").times, [31.6, 32.0]);
    assert_eq!(recording.warnings, []);
}

#[test]
fn trajnet_plus_plus_takes_the_rate_of_rows_and_skips_predictions() {
    let recording = recording(TRAJNET_PLUS_PLUS);
    assert_eq!(recording.source.fps, Fact::of_file(15.0));
    assert_eq!(track(&recording, "254").positions, [[1.2, 5.85], [1.5, 5.35]]);
    assert!(recording.warnings[0].text.contains("predictions"));
}

#[test]
fn menge_is_read_in_every_version() {
    for (version, numbers_of_agent) in
        [("1.0", 3), ("2.0", 3), ("2.1", 4), ("2.2", 8), ("2.3", 4), ("2.4", 4)]
    {
        let recording = recording(menge(version, numbers_of_agent));
        let second = track(&recording, "1");
        let y = if version == "2.4" { 10.5 } else { 10.25 };
        assert_eq!(second.positions[0], [10.0, y], "{version}");
        let fps = if version == "1.0" { Fact::assumed(10.0) } else { Fact::of_file(20.0) };
        assert!((recording.source.fps.value - fps.value).abs() < 1e-3, "{version}");
        assert_eq!(recording.source.fps.origin, fps.origin, "{version}");
        let heading = match version {
            "2.3" => 10.75_f32.atan2(10.5),
            "2.4" => 10.75,
            _ => 10.5,
        };
        assert!((second.headings[0] - heading).abs() < 1e-6, "{version}");
        assert_eq!(second.elevations.is_empty(), version != "2.4");
        assert_eq!(numbers(&recording, "class"), [4.0, 4.0, 9.0, 9.0]);
        assert_eq!(recording.source.version, format!("version {version}"));
    }
    assert_eq!(numbers(&recording(menge("2.2", 8)), "vy")[3], 12.75);
}
