use populace_trajectory::{Format, HeadingSource, Kind, ReadSettings, parse};

use super::{column, compressed, problem, problem_with, read, rows_of, warnings};

pub(super) fn small() -> String {
    r#"<?xml version="1.0" encoding="UTF-8"?>
<!-- generated <fcd-output.geo value="false"/> -->
<fcd-export xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
    <timestep time="0.00">
        <vehicle id="1" x="10" y="5" angle="90.00" type="bus" speed="5.00" lane="e_0"/>
        <person id="1" x="1.5" y="2" z="0.5" angle="0.00" speed="1.2" edge="7"/>
        <container id="c" x="0" y="0"/>
    </timestep>
    <timestep time="0.50">
        <vehicle id="1" x="12.5" y="5" angle="90.00" type="bus" speed="5.00" lane="e_0">
            <person id="a &amp; b" x="12" y="5" z="0.5" angle="90.00" speed="5.00"/>
        </vehicle>
        <person id="1" x="1.5" y="2.6" z="0.5" angle="270.00" speed="1.2" edge="8"/>
    </timestep>
</fcd-export>
"#
    .to_owned()
}

#[test]
fn persons_and_vehicles_are_apart() {
    let recording = read(small());
    assert_eq!(recording.source.format, Format::Sumo);
    assert_eq!(recording.source.fps.value, 2.0);
    assert_eq!(recording.source.heading.value, HeadingSource::Data);
    let agents: Vec<_> =
        recording.agents.iter().map(|agent| (agent.id.as_str(), agent.kind)).collect();
    assert_eq!(agents, [("1", Kind::Vehicle), ("1", Kind::Person), ("a & b", Kind::Person)]);
    let person = recording.track(&recording.agents[1]);
    assert_eq!(person.positions, [[1.5, 2.0], [1.5, 2.6]]);
    assert_eq!(person.elevations, [0.5, 0.5]);
    // North is up; angles are clockwise from it.
    assert_eq!(person.headings, [std::f32::consts::FRAC_PI_2, -std::f32::consts::PI]);
    assert_eq!(recording.track(&recording.agents[0]).headings, [0.0, 0.0]);
    assert_eq!(column(&recording, "edge"), ["", "", "7", "8", ""]);
    assert_eq!(column(&recording, "type"), ["bus", "bus", "", "", ""]);
    assert_eq!(column(&recording, "vehicle"), ["", "", "", "", "1"]);
    assert_eq!(column(&recording, "speed"), ["5", "5", "1.2", "1.2", "5"]);
    assert!(recording.warnings.is_empty(), "{:?}", warnings(&recording));
    assert_eq!(read(compressed(small().as_bytes())).row_count(), 5);
}

#[test]
fn everything_but_ids_and_positions_is_optional() {
    let recording = read(
        "<fcd-export><timestep time=\"00:01:00\"><person id=\"p\" x=\"1\" y=\"2\"/></timestep>\
         <timestep time=\"00:01:01\"><person id=\"p\" x=\"2\" y=\"2\"/></timestep></fcd-export>",
    );
    assert_eq!(rows_of(&recording, "p"), [(60.0, [1.0, 2.0]), (61.0, [2.0, 2.0])]);
    assert_eq!(recording.source.heading.value, HeadingSource::Motion);
    assert!(recording.columns.is_empty());
}

#[test]
fn longitudes_and_latitudes_are_refused() {
    let told = small().replace("geo value=\"false\"", "geo value=\"true\"");
    assert!(problem(told).contains("--fcd-output.geo"));
    // A person who walks north in Cologne.
    let mut text = "<fcd-export>".to_owned();
    for secs in 0..20 {
        text += &format!(
            "<timestep time=\"{secs}\"><person id=\"p\" x=\"6.95\" y=\"{}\" speed=\"1.2\"/>\
             </timestep>",
            50.93 + f64::from(secs) * 1.08e-5
        );
    }
    assert!(problem(text + "</fcd-export>").contains("longitudes"));
}

#[test]
fn faults_are_warnings_with_their_line() {
    let text = small().replace("x=\"10\"", "").replace("id=\"a &amp; b\"", "id=\"\"");
    let recording = read(text);
    assert_eq!(
        warnings(&recording),
        [
            "rows without a number as time or position were left out (line 5)",
            "persons and vehicles without an id were left out (line 11)",
        ]
    );
    let untimed = small().replace("time=\"0.50\"", "time=\"soon\"");
    assert!(problem(untimed).contains("3 of 5 rows"));
    let strict = ReadSettings { strict: true, ..ReadSettings::default() };
    let text = small().replace("x=\"10\"", "x=\"NaN\"");
    assert!(problem_with(text, &strict).to_string().contains("line 5"));
}

#[test]
fn files_that_are_cut_off_are_read_up_to_there() {
    let text = small();
    for end in
        ["angle=\"270.00\"", "</timestep>\n</fcd", "</fcd-export>", "<vehicle id=\"1\" x=\"12"]
    {
        let cut = &text[..text.find(end).expect("there")];
        let recording = read(cut);
        assert!(recording.row_count() >= 2, "{end}");
        assert!(warnings(&recording)[0].contains("cut off in line"), "{:?}", warnings(&recording));
        let packed = compressed(text.as_bytes());
        let name = std::path::Path::new("cut.gz");
        let settings = ReadSettings::default();
        let half = packed[..packed.len() - 12].to_vec();
        // Nothing but an end or an error with words.
        if let Err(error) = parse(name, half, &settings) {
            assert!(error.to_string().contains("cut.gz"), "{error}");
        }
    }
}

#[test]
fn broken_xml_and_other_roots_are_refused_with_their_line() {
    let text = small().replacen("</timestep>", "</timestop>", 1);
    assert!(problem(text).contains("line 8"));
    let settings = ReadSettings { format: Some(Format::Sumo), ..ReadSettings::default() };
    let text = problem_with("<net>\n</net>", &settings).to_string();
    assert!(text.contains("line 1") && text.contains("\"net\""), "{text}");
    let text = problem_with("", &settings).to_string();
    assert!(text.contains("no element fcd-export"), "{text}");
    assert!(problem("<fcd-export></fcd-export>").contains("no positions"));
}
