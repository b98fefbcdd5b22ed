//! Tables with named columns.

use std::f32::consts::FRAC_PI_2;

use populace_trajectory::{Fact, Format, HeadingSource, Kind, Origin, Unit, Values};

use super::fixtures::{CSV, SUMO, error, recording, track};
use super::formats::words;

#[test]
fn decimal_commas_units_and_angles_are_understood() {
    let recording = recording(CSV);
    assert_eq!(recording.source.unit, Fact::of_file(Unit::Centimetres));
    let first = track(&recording, "A");
    assert_eq!(first.positions, [[1.005, 0.2], [1.005, 0.25]]);
    assert_eq!((first.times, first.headings), (&[0.0, 0.04][..], &[FRAC_PI_2; 2][..]));
    assert_eq!(words(&recording, "zone"), [Some("hall"), Some("door"), Some("hall"), None]);
}

#[test]
fn a_column_that_turns_out_to_hold_words_keeps_its_numbers_as_words() {
    let recording = recording(CSV);
    assert_eq!(words(&recording, "group"), [Some("1"), Some("1"), Some("2"), Some("staff")]);
}

#[test]
fn infinity_makes_no_column_of_words() {
    let recording = recording("id,t,x,y,gap\n1,0,0,0,inf\n1,1,1,0,2.5\n1,2,2,0,-inf\n");
    let Some(Values::Numbers(gaps)) = recording.column("gap").map(|column| &column.values) else {
        panic!("no numbers");
    };
    assert_eq!((gaps[0].is_nan(), gaps[1], gaps[2].is_nan()), (true, 2.5, true));
}

#[test]
fn separators_are_found() {
    for separator in [",", ";", "\t", "|", " ", " | "] {
        let text = "id,frame,x,y,speed\n1,0,2.5,3,1.1\n1,1,2.6,3,1.1\n".replace(',', separator);
        let recording = recording(text);
        assert_eq!(recording.source.format, Format::Csv);
        assert_eq!(recording.source.fps, Fact::assumed(25.0));
        assert_eq!(track(&recording, "1").positions[0], [2.5, 3.0], "{separator:?}");
    }
}

#[test]
fn a_line_that_names_the_separator_is_skipped() {
    let recording = recording("sep=;\nid;t;x;y\n1;0;2,5;3\n1;1;2,6;3\n");
    assert_eq!(recording.source.format, Format::Csv);
    assert_eq!(track(&recording, "1").positions, [[2.5, 3.0], [2.6, 3.0]]);
}

#[test]
fn times_of_a_clock_are_seconds() {
    let text = "id;time;x;y\n1;00:00:01;0;0\n1;00:01:02,5;1;0\n1;1:00:00.25;2;0\n";
    assert_eq!(track(&recording(text), "1").times, [1.0, 62.5, 3600.25]);
    // Only plain numbers are in the unit of the name.
    let text = "id,t_ms,x,y\n1,500,0,0\n1,00:01.000,1,0\n";
    assert_eq!(track(&recording(text), "1").times, [0.5, 1.0]);
}

#[test]
fn names_of_many_programs_are_known() {
    for header in [
        "TIME,ID,POS_X,POS_Y",
        "timestamp,trackId,xCenter,yCenter",
        "t [s],agent_id,x [m],y [m]",
        "Time,PersID,X,Y",
        "simTime,pedestrianId,x/m,y/m",
    ] {
        let recording = recording(format!("{header}\n0.0,7.0,1,2\n0.5,7.0,1.5,2\n"));
        assert_eq!(track(&recording, "7").positions, [[1.0, 2.0], [1.5, 2.0]], "{header}");
        assert_eq!(recording.source.fps, Fact::of_file(2.0));
    }
}

#[test]
fn milliseconds_are_turned_into_seconds() {
    let recording = recording("id,time_ms,x,y\n1,0,0,0\n1,40,0.05,0\n");
    assert!((track(&recording, "1").times[1] - 0.04).abs() < 1e-12);
}

#[test]
fn the_size_of_angles_tells_their_unit() {
    let of = |angles: [&str; 2]| {
        let [a, b] = angles;
        recording(format!("id,t,x,y,yaw\n1,0,0,0,{a}\n1,1,1,0,{b}\n"))
    };
    assert_eq!(track(&of(["0.5", "6.2"]), "1").headings, [0.5, 6.2]);
    assert_eq!(track(&of(["0", "90"]), "1").headings, [0.0, FRAC_PI_2]);
}

#[test]
fn headings_whose_unit_only_their_size_tells_are_assumed() {
    for (name, value, heading) in [
        ("yaw", "3", Fact::assumed(HeadingSource::Data)),
        ("yaw", "170", Fact::assumed(HeadingSource::Data)),
        ("yaw", "0", Fact::of_file(HeadingSource::Data)),
        ("yaw_deg", "3", Fact::of_file(HeadingSource::Data)),
        ("yaw_rad", "3", Fact::of_file(HeadingSource::Data)),
    ] {
        let recording = recording(format!("id,t,x,y,{name}\n1,0,0,0,{value}\n"));
        assert_eq!(recording.source.heading, heading, "{name} {value}");
    }
}

#[test]
fn headings_by_vector_leave_rows_without_one() {
    let recording = recording("id,t,x,y,ori_x,ori_y\n1,0,0,0,0,1\n1,1,1,0,0,0\n");
    let headings = track(&recording, "1").headings;
    assert_eq!(headings[0], FRAC_PI_2);
    assert!(headings[1].is_nan());
}

#[test]
fn kinds_make_vehicles() {
    let recording = recording("frame,id,x,y,type\n0,1,0,0,ped\n0,2,5,5,Veh\n1,1,0,0,ped\n");
    let kinds: Vec<_> = recording.agents.iter().map(|agent| agent.kind).collect();
    assert_eq!(kinds, [Kind::Person, Kind::Vehicle]);
    assert_eq!(words(&recording, "type")[2], Some("Veh"));
}

#[test]
fn ids_of_vehicles_make_vehicles() {
    let recording = recording("time,vehicle_id,x,y\n0,a,0,0\n1,a,8,0\n");
    assert_eq!(recording.agents[0].kind, Kind::Vehicle);
}

#[test]
fn a_column_without_a_name_is_no_extra_column() {
    let recording = recording(",id,t,x,y,v\n0,1,0,0,0,1\n1,1,1,1,0,1\n");
    let names: Vec<_> = recording.columns.iter().map(|column| &*column.name).collect();
    assert_eq!(names, ["v"]);
}

#[test]
fn sumo_tables_hold_people_and_vehicles_with_compass_angles() {
    let recording = recording(SUMO);
    let agents: Vec<_> = recording.agents.iter().map(|agent| (&*agent.id, agent.kind)).collect();
    assert_eq!(agents, [("0", Kind::Person), ("0", Kind::Vehicle)]);
    let [person, vehicle] = [0, 1].map(|index| recording.track(&recording.agents[index]));
    assert_eq!(person.positions, [[1.0, 2.0], [2.3, 2.0]]);
    assert!(person.headings.iter().all(|angle| angle.abs() < 1e-6));
    assert_eq!(vehicle.headings, [FRAC_PI_2; 2]);
    assert_eq!(recording.warnings, []);
}

#[test]
fn comments_say_unit_and_rate() {
    let recording =
        recording("# framerate: 10\n# positions in cm\nid,frame,x,y\n1,0,100,0\n1,10,200,0\n");
    assert_eq!(recording.source.unit, Fact::of_file(Unit::Centimetres));
    assert_eq!((recording.secs(), recording.source.fps.origin), ([0.0, 1.0], Origin::File));
}

#[test]
fn a_missing_column_is_named_with_those_there_are() {
    let message = error("id,frame,x,speed\n1,0,0,0\n");
    assert!(message.contains("no column has y") && message.contains("id, frame, x, speed"));
}

#[test]
fn a_row_of_units_holds_for_times_too() {
    let recording = recording("t,id,x,y\nms,,cm,cm\n0,1,0,0\n40,1,5,0\n");
    assert_eq!(recording.source.unit, Fact::of_file(Unit::Centimetres));
    assert_eq!(track(&recording, "1").times, [0.0, 0.04]);
}

#[test]
fn heights_and_elevations_may_have_a_unit_of_their_own() {
    let text = "id,t,x,y,z_cm,height_cm\n1,0,0,0,250,172\n1,1,1,0,260,172\n";
    for text in [text.to_owned(), text.replace("x,y", "x_m,y_m")] {
        let recording = recording(text);
        assert_eq!(recording.agents[0].height_m, Some(1.72));
        assert_eq!(track(&recording, "1").elevations, [2.5, 2.6]);
    }
    let recording = recording("id,t,x_cm,y_cm,z_cm,height_m\n1,0,0,0,250,1.72\n");
    assert_eq!(recording.agents[0].height_m, Some(1.72));
    assert_eq!(track(&recording, "1").elevations, [2.5]);
}

#[test]
fn rows_of_agents_who_are_not_active_are_hidden() {
    for (no, yes) in [("0", "1"), ("0.0", "1.0"), ("False", "True"), ("no", "yes")] {
        let recording = recording(format!("id,t,x,y,active\n1,0,0,0,{no}\n1,1,0,1,{yes}\n"));
        assert_eq!(track(&recording, "1").times, [1.0], "{no}");
    }
}
