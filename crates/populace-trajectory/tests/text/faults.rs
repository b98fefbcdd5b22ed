//! Broken files: an error with its line and a remedy, or a warning and a sensible reading.

use populace_trajectory::{
    Error, Fact, HeadingSource, Kind, Location, ReadSettings, Recording, Unit, parse,
};

use super::fixtures::{self, CSV, PETRACK, error, menge, read, recording, track};
use super::formats::numbers;

#[test]
fn one_broken_row_of_any_family_is_a_warning_with_its_line() {
    for fixture in fixtures::all() {
        let Ok(text) = String::from_utf8(fixture.bytes) else { continue };
        if text.contains('\0') {
            continue;
        }
        let line = text.lines().count() + 1;
        let recording = recording(format!("{text}rubbish\n"));
        let warning = recording.warnings.last().expect("a warning");
        assert_eq!(warning.first, Some(Location::Line(line as u64)), "{}", fixture.name);
        assert_eq!(warning.rows, 1);
        assert_eq!(recording.agents.len(), 2, "{}", fixture.name);
    }
}

#[test]
fn strict_settings_refuse_a_broken_row() {
    let settings = ReadSettings { strict: true, ..ReadSettings::default() };
    let result = parse("file".as_ref(), format!("{PETRACK}1 x\n").into(), &settings);
    assert!(matches!(result, Err(Error::Strict { .. })));
}

#[test]
fn a_file_of_mostly_broken_rows_is_an_error_with_the_first_of_them() {
    let message = error("# id frame x/m y/m z/m\n1 0 1 2 1.7\n1 one 1 2 1.7\n1 two 1 2 1.7\n");
    assert!(message.contains("line 3") && message.contains("2 of 3 rows"), "{message}");
    assert!(message.contains("--format"), "{message}");
}

#[test]
fn an_empty_file_and_one_without_rows_are_errors() {
    assert!(matches!(read(""), Err(Error::Empty { .. })));
    assert!(matches!(read(" \n\n"), Err(Error::Empty { .. })));
    assert!(error("# recorded in May\n").contains("comments alone"));
    assert!(matches!(read("# id frame x/m y/m z/m\n"), Err(Error::Empty { .. })));
    assert!(matches!(read("id,frame,x,y\n"), Err(Error::Empty { .. })));
}

#[test]
fn missing_values_are_left_out() {
    let recording = recording("id,t,x,y,v\n1,0,0,0,\n1,1,,0,1\n1,2,2,0,nan\n1,3,3,0,2\n,4,4,0,2\n");
    assert_eq!(track(&recording, "1").times, [0.0, 2.0, 3.0]);
    let texts: Vec<_> = recording.warnings.iter().map(ToString::to_string).collect();
    assert!(texts[0].contains("line 3") && texts[1].contains("without an id"), "{texts:?}");
}

#[test]
fn rows_twice_and_times_running_backwards_are_sorted_out() {
    let recording = recording("id,t,x,y\n1,1,1,0\n1,0,0,0\n1,1,9,9\n");
    assert_eq!(track(&recording, "1").positions, [[0.0, 0.0], [1.0, 0.0]]);
    assert_eq!(recording.warnings.len(), 2);
}

#[test]
fn numbers_out_of_any_range_do_not_count_as_positions() {
    let recording = recording(
        "id,t,x,y\n1,0,0,0\n1,1,1e300,0\n1,inf,1,0\n1,1e99,1,0\n1,2,1,0\n1,3,2,0\n1,4,3,0\n",
    );
    assert_eq!(recording.row_count(), 4);
    assert_eq!(recording.warnings[0].rows, 3);
}

#[test]
fn impossible_frame_rates_are_errors() {
    for rate in ["0", "0.0000001", "99999999999"] {
        let file = PETRACK.replace("12.5", rate);
        let message = error(file);
        assert!(message.contains("frame rate") && message.contains("--data-fps"), "{message}");
    }
}

#[test]
fn a_line_without_end_is_an_error() {
    let message = error(format!("id,frame,x,y\n{}", "1".repeat(3 << 20)));
    assert!(message.contains("line 2") && message.contains("longer"), "{message}");
}

#[test]
fn menge_that_ends_early_loses_its_last_frame_only() {
    let bytes = menge("2.1", 4);
    let recording = recording(&bytes[..bytes.len() - 1]);
    assert_eq!(recording.row_count(), 2);
    let warning = recording.warnings[0].to_string();
    assert!(warning.contains("cut off") && warning.contains("byte 52"), "{warning}");
    let message = error(&bytes[..14]);
    assert!(message.contains("byte 12") && message.contains("classes"), "{message}");
}

#[test]
fn menge_with_an_impossible_header_is_an_error() {
    for (at, with, hint) in [(0, b'7', "not a trajectory"), (11, 0xff, "frames of")] {
        let mut bytes = menge("2.1", 4);
        bytes[at] = with;
        assert!(error(bytes).contains(hint));
    }
}

#[test]
fn rows_that_are_left_out_say_nothing_about_their_agent() {
    let recording = recording(
        "id,t,x,y,height,type,yaw,v\n1,0,0,0,1.7,ped,1.5,0.5\n1,nan,1,0,2.1,car,270,fast\n\
         id,t,x,y,height,type,yaw,v\n1,2,2,0,1.6,ped,1.5,0.75\n",
    );
    let agent = &recording.agents[0];
    assert_eq!((agent.kind, agent.height_m), (Kind::Person, Some(1.7)));
    assert_eq!(track(&recording, "1").headings, [1.5, 1.5], "in radians");
    assert_eq!(numbers(&recording, "v"), [0.5, 0.75]);
    assert_eq!(recording.warnings[0].rows, 2);
}

#[test]
fn people_slower_than_any_are_a_warning_with_a_remedy() {
    let walk = |header: &str, step: f64| {
        let row = |nth: u32| format!("1,{},{},0\n", f64::from(nth) * step, f64::from(nth) * 0.05);
        recording(format!("{header}\n{}", (0..40).map(row).collect::<String>()))
    };
    let milliseconds = walk("id,timestamp,x,y", 40.0);
    let warning = milliseconds.warnings.first().expect("a warning").to_string();
    assert!(warning.contains("slower than 0.01 m/s") && warning.contains("t_ms"), "{warning}");
    let frames = walk("id,frame,x,y", 1000.0);
    let warning = frames.warnings.first().expect("a warning").to_string();
    assert!(warning.contains("--data-fps"), "{warning}");
    assert_eq!(walk("id,timestamp_ms,x,y", 40.0).warnings, []);
    assert_eq!(walk("id,t,x,y", 1.0).warnings, [], "0.05 m/s");
    // Somebody who stands, though tracking is not exact, and somebody who waits after walking.
    let stands = (0..50).map(|nth| format!("1,{nth},{},0\n", f64::from(nth % 2) * 1e-4));
    let stands = format!("id,t,x,y\n{}", stands.collect::<String>());
    assert_eq!(recording(&*stands).warnings, []);
    assert_eq!(recording(format!("{stands}1,51,3,0\n")).warnings, []);
    // Ids that come again on another day.
    let days = "id,t,x,y\n1,0,0,0\n1,1,1,0\n1,2,2,0\n1,90000,0,0\n1,90001,1,0\n1,90002,2,0\n";
    assert_eq!(recording(days).warnings, []);
}

#[test]
fn the_first_of_many_broken_rows_is_told_with_its_column_and_value() {
    for (file, words) in [
        ("id,t,x,y\n1,2024-01-01T00:00:01,0,0\n", "\"2024-01-01T00:00:01\" in the column \"t\""),
        ("id,time,x,y\n1,NaN,0,0\n", "\"NaN\" in the column \"time\"; check it"),
        ("id,t,pos x,y\n1,0,one,0\n", "\"one\" in the column \"pos x\"; check it"),
        ("id,frame,x,y\n1,0,0\n", "nothing in the column \"y\""),
        ("id,frame,x,y\n,0,0,1\n", "nothing in the column \"id\""),
        ("id,t,x,y\n1,0,1e12,1\n", "\"1e12\" in the column \"x\""),
        ("# id frame x/m y/m z/m\n1 one 1 2 1.7\n", "\"one\" in the column \"frame\"; check it"),
    ] {
        let message = error(file);
        assert!(message.contains(words) && message.contains("line 2"), "{message}");
        assert!(message.contains("1 of 1 rows"), "{message}");
    }
    let date = error("id,t,x,y\n1,2024-01-01T00:00:01,0,0\n");
    assert!(date.contains("seconds") && date.contains("t_ms"), "{date}");
}

/// Returns the texts of the warnings of a file that is read with settings.
fn warnings(file: &str, settings: &ReadSettings) -> (Recording, Vec<String>) {
    let recording = parse("file".as_ref(), file.into(), settings).expect("a recording");
    let texts = recording.warnings.iter().map(ToString::to_string).collect();
    (recording, texts)
}

#[test]
fn body_heights_that_no_body_has_are_one_warning() {
    let of = |heights: &[&str]| {
        let mut file = "id,frame,x,y,height\n".to_owned();
        for (id, height) in heights.iter().enumerate() {
            file += &format!("p{id},0,0,{id},{height}\n");
        }
        warnings(&file, &ReadSettings::default()).1
    };
    let [warning] = &of(&["0.2", "5", "1.1", "-1", "2.3", "175"])[..] else { panic!("warnings") };
    for words in ["4 agents", "0.5 to 2.6 m", "0.20 m of agent \"p0\""] {
        assert!(warning.contains(words), "{warning}");
    }
    assert!(!warning.contains("centimetres"), "{warning}");
    let [warning] = &of(&["1.7", "175", "0.2", "182"])[..] else { panic!("warnings") };
    assert!(warning.contains("3 agents") && warning.contains("height_cm"), "{warning}");
    assert!(warning.contains("175.00 m of agent \"p1\""), "{warning}");
    // Unknown heights are not warned of, nor are heights of vehicles.
    assert_eq!(of(&["1.7", "0", "nan", ""]), [""; 0]);
    let street = "id,frame,x,y,height,type\n1,0,0,0,3.5,bus\n2,0,0,5,1.7,ped\n";
    assert_eq!(warnings(street, &ReadSettings::default()).1, [""; 0]);
}

#[test]
fn headings_that_the_file_lacks_are_warned_of() {
    let settings = ReadSettings { heading: Some(HeadingSource::Data), ..ReadSettings::default() };
    let (recording, texts) = warnings("id,t,x,y\n1,0,0,0\n1,1,1,0\n", &settings);
    assert_eq!(recording.source.heading, Fact::assumed(HeadingSource::Motion));
    assert_eq!(texts.len(), 1, "{texts:?}");
    assert!(texts[0].contains("no headings") && texts[0].contains("--heading data"), "{texts:?}");
    let (recording, texts) = warnings("id,t,x,y,yaw_rad\n1,0,0,0,1\n1,1,1,0,1\n", &settings);
    assert_eq!(recording.source.heading, Fact::of_file(HeadingSource::Data));
    assert_eq!(texts, [""; 0]);
}

#[test]
fn a_frame_rate_without_effect_is_warned_of() {
    let settings = ReadSettings { fps: Some(10.0), ..ReadSettings::default() };
    for (file, count) in [(fixtures::VISWALK, 1), (CSV, 1), (PETRACK, 0)] {
        let (_, texts) = warnings(file, &settings);
        assert_eq!(texts.len(), count, "{texts:?}");
        assert!(texts.iter().all(|text| text.contains("--data-fps has no effect")), "{texts:?}");
    }
    assert_eq!(recording(fixtures::VISWALK).warnings, []);
}

const PIXELS: &str = "id,frame,x_px,y_px\n1,0,100,200\n1,1,101,200\n";

fn in_unit(unit: Unit) -> ReadSettings {
    ReadSettings { unit: Some(unit), ..ReadSettings::default() }
}

#[test]
fn pixels_need_a_unit_which_the_refusal_names() {
    let refusal = error(PIXELS);
    assert!(refusal.contains("pixels") && refusal.contains("--unit 0.02"), "{refusal}");
    assert!(!refusal.contains("not a trajectory file"), "{refusal}");
    let (recording, warnings) = warnings(PIXELS, &in_unit("0.02".parse().expect("a unit")));
    assert_eq!(track(&recording, "1").positions, [[2.0, 4.0], [2.02, 4.0]]);
    assert_eq!((recording.source.unit.value.to_string(), warnings), ("0.02 m".to_owned(), vec![]));
}

#[test]
fn pixels_that_are_taken_for_centimetres_are_warned_of_with_a_remedy() {
    let (_, warnings) =
        warnings("id,frame,x,y\n1,0,100,200\n1,1,101,200\n", &ReadSettings::default());
    assert!(warnings[0].contains("centimetres are assumed; --unit"), "{warnings:?}");
    assert!(warnings[0].contains("pixel"), "{warnings:?}");
}

#[test]
fn impossible_units_are_refused() {
    for text in ["0", "-1", "nan", "inf", "1e7", "px", ""] {
        assert!(text.parse::<Unit>().is_err(), "{text}");
    }
    for metres in [0.0, f64::NAN, f64::INFINITY] {
        let refusal = parse("file".as_ref(), PIXELS.into(), &in_unit(Unit::OfMetres(metres)));
        assert!(refusal.expect_err("a refusal").to_string().contains("--unit N"));
    }
}

#[test]
fn missing_elevations_are_those_between_the_rows_of_the_same_person() {
    let file = "id,t,x,y,z\na,0,0,0,\na,1,1,0,3\na,2,2,0,\na,4,4,0,nan\na,5,5,0,7\na,6,6,0,\n\
                b,0,0,5,1\nb,1,1,5,1\nc,0,0,9,\n";
    let (recording, texts) = warnings(file, &ReadSettings::default());
    assert_eq!(track(&recording, "a").elevations, [3.0, 3.0, 4.0, 6.0, 7.0, 7.0]);
    assert_eq!(track(&recording, "b").elevations, [1.0, 1.0]);
    assert_eq!(track(&recording, "c").elevations, [1.0]);
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert!(texts[0].contains("4 rows have no elevation"), "{texts:?}");
    assert!(texts[1].contains("1 person has no elevation"), "{texts:?}");
    // A file whose column of elevations is empty has none.
    let (recording, texts) = warnings("id,t,x,y,z\na,0,0,0,\na,1,1,0,\n", &ReadSettings::default());
    assert_eq!(recording.summary().elevations_m, None);
    assert_eq!(texts, [""; 0]);
}

#[test]
fn longitudes_and_latitudes_without_a_name_are_doubted() {
    let walk = |ids: &[&str], at: [f64; 2], step: f64| {
        let rows = ids.iter().zip(0..).flat_map(|(id, nth)| {
            let y = at[1] + 10.0 * step * f64::from(nth);
            (0..20).map(move |t| format!("{id},{t},{:.7},{y:.7}\n", at[0] + step * f64::from(t)))
        });
        let file = format!("id,t,x,y\n{}", rows.collect::<String>());
        warnings(&file, &ReadSettings::default()).1
    };
    for ids in [&["a"][..], &["a", "b", "c"]] {
        let texts = walk(ids, [11.5, 48.1], 0.000_013);
        assert!(texts.len() == 1 && texts[0].contains("latitudes"), "{ids:?} {texts:?}");
    }
    // People who walk, and one who stands and sways.
    assert_eq!(walk(&["a", "b"], [11.5, 48.1], 1.3), [""; 0]);
    assert_eq!(walk(&["a"], [11.5, 48.1], 0.000_5), [""; 0]);
    assert_eq!(walk(&["a"], [11.5, 48.1], 0.0), [""; 0]);
    assert_eq!(walk(&["a"], [0.5, 0.1], 0.000_013), [""; 0]);
}
