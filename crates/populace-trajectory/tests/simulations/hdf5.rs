use populace_trajectory::{Format, HeadingSource, ReadSettings, Unit, parse};
use rust_hdf5::{CompoundType, DatatypeMessage, H5Dataset, H5File};

use super::{column, compressed, problem, problem_with, read, rows_of, warnings};

/// A value of a table.
#[derive(Clone, Copy)]
enum Value {
    Int(i32),
    Long(i64),
    Float(f32),
    Double(f64),
}

use Value::{Double, Float, Int, Long};

/// Writes a file by a function, and returns its bytes.
fn file(write: impl Fn(&H5File)) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("file.h5");
    let file = H5File::create(&path).expect("a file");
    write(&file);
    file.close().expect("a file");
    std::fs::read(&path).expect("a file")
}

/// Adds a table: names of members, and rows.
fn table(file: &H5File, name: &str, members: &[&str], rows: &[&[Value]]) -> H5Dataset {
    let mut compound = CompoundType { members: Vec::new(), total_size: 0 };
    for (member, value) in members.iter().zip(rows[0]) {
        let (datatype, bytes) = match value {
            Int(_) => (DatatypeMessage::i32_type(), 4),
            Long(_) => (DatatypeMessage::i64_type(), 8),
            Float(_) => (DatatypeMessage::f32_type(), 4),
            Double(_) => (DatatypeMessage::f64_type(), 8),
        };
        compound.members.push(((*member).to_owned(), datatype, compound.total_size));
        compound.total_size += bytes;
    }
    let bytes: Vec<u8> = (rows.iter().flat_map(|row| row.iter()))
        .flat_map(|value| match value {
            Int(v) => v.to_le_bytes().to_vec(),
            Long(v) => v.to_le_bytes().to_vec(),
            Float(v) => v.to_le_bytes().to_vec(),
            Double(v) => v.to_le_bytes().to_vec(),
        })
        .collect();
    let builder = file.new_dataset::<u8>().datatype(compound.to_datatype()).shape([rows.len()]);
    let dataset = builder.create(name).expect("a dataset");
    dataset.write_raw_bytes(&bytes).expect("rows");
    dataset
}

fn set_fps(dataset: &H5Dataset, fps: f64) {
    let attribute = dataset.new_attr::<f64>().shape(()).create("fps").expect("an attribute");
    attribute.write_numeric(&fps).expect("an attribute");
}

/// A file as PeTrack writes it: three persons' rows, directions of view, heights and markers.
pub(super) fn petrack() -> Vec<u8> {
    file(|file| {
        let row = |id, frame, x| [Int(id), Int(frame), Float(x), Float(2.0), Float(1.7)];
        let rows = [row(1, 4, 1.0), row(1, 5, 1.5), row(2, 4, 3.0), row(2, 5, 3.5)];
        let rows: Vec<&[Value]> = rows.iter().map(|row| &row[..]).collect();
        let dataset = table(file, "trajectory", &["id", "frame", "x", "y", "z"], &rows);
        set_fps(&dataset, 10.0);
        let view = |id, frame, x, y| [Int(id), Int(frame), Float(x), Float(y), Float(0.5)];
        let rows = [view(2, 5, 0.0, -1.0), view(1, 4, 1.0, 0.0), view(1, 5, 0.0, 0.0)];
        let rows: Vec<&[Value]> = rows.iter().map(|row| &row[..]).collect();
        let names = ["id", "frame", "view_dir_x", "view_dir_y", "view_angle"];
        table(file, "petrack_data", &names, &rows);
        let rows: [&[Value]; 2] = [&[Int(1), Int(17), Float(1.82)], &[Int(3), Int(18), Float(1.6)]];
        table(file, "personal_details", &["id", "marker_id", "height"], &rows);
    })
}

/// A file as JuPedSim writes it when the walkable area changes.
pub(super) fn jupedsim() -> Vec<u8> {
    file(|file| {
        let row = |frame, id, x, ox| {
            [Int(frame), Int(id), Double(x), Double(2.0), Double(0.25), Double(ox), Double(0.0)]
        };
        let rows = [row(0, 7, 1.0, 0.0), row(1, 7, 1.1, 1.0), row(2, 7, 1.2, -1.0)];
        let rows: Vec<&[Value]> = rows.iter().map(|row| &row[..]).collect();
        let names = ["frame", "id", "x", "y", "z", "ox", "oy"];
        set_fps(&table(file, "trajectory", &names, &rows), 10.0);
        file.set_attr_string("producer", "JuPedSim").expect("an attribute");
        file.set_attr_string("wkt_geometry", "POLYGON ((0 0, 9 0, 9 9))").expect("an attribute");
        let group = file.create_group("geometry").expect("a group");
        let texts = ["POLYGON ((0 0, 9 0, 9 9))", "POLYGON ((0 0, 5 0, 5 5, 0 5))"];
        group.write_vlen_strings("wkt", &texts).expect("texts");
        let hashes = group.new_dataset::<i64>().shape([2]).create("hash").expect("a dataset");
        hashes.write_raw(&[5_i64, -6]).expect("hashes");
        table(file, "frame_geometry", &["frame", "geometry_hash"], &[&[Int(2), Long(-6)]]);
    })
}

#[test]
fn petrack_brings_views_heights_and_markers() {
    let recording = read(petrack());
    assert_eq!(recording.source.format, Format::Hdf5);
    assert_eq!((recording.source.unit.value, recording.source.fps.value), (Unit::Metres, 10.0));
    assert_eq!(rows_of(&recording, "1"), [(0.4, [1.0, 2.0]), (0.5, [1.5, 2.0])]);
    let heights: Vec<_> = recording.agents.iter().map(|agent| agent.height_m).collect();
    assert_eq!(heights, [Some(1.82), Some(1.7)], "details come before the heads' height");
    let first = recording.track(&recording.agents[0]);
    assert_eq!(first.views[0], 0.0);
    assert!(first.views[1].is_nan(), "the vector 0, 0 is no direction");
    let second = recording.track(&recording.agents[1]);
    assert!(second.views[0].is_nan(), "no row for this frame");
    assert_eq!(second.views[1], -std::f32::consts::FRAC_PI_2);
    assert!(first.elevations.is_empty(), "heads are no floor");
    assert_eq!(column(&recording, "marker_id"), ["17", "17", "NaN", "NaN"]);
}

#[test]
fn jupedsim_brings_headings_elevations_and_changing_areas() {
    let recording = read(jupedsim());
    assert_eq!(recording.source.version, "JuPedSim");
    assert_eq!(recording.source.heading.value, HeadingSource::Data);
    let track = recording.track(&recording.agents[0]);
    assert!(track.headings[0].is_nan());
    assert_eq!(track.headings[1..], [0.0, std::f32::consts::PI]);
    assert_eq!(track.elevations, [0.25; 3]);
    let corners = |secs| recording.place.walkable_at(secs)[0].outline.len();
    assert_eq!([corners(0.0), corners(0.19), corners(0.2)], [3, 3, 4]);
    assert!(recording.warnings.is_empty(), "{:?}", warnings(&recording));
    assert_eq!(read(compressed(&jupedsim())).row_count(), 3);
}

#[test]
fn rows_that_are_left_out_raise_no_height() {
    let bytes = file(|file| {
        let row = |frame, x, z| [Int(1), Int(frame), Float(x), Float(2.0), Float(z)];
        let rows = [row(0, 1.0, 1.6), row(1, f32::NAN, 2.4), row(2, 1.5, 1.7)];
        let rows: Vec<&[Value]> = rows.iter().map(|row| &row[..]).collect();
        set_fps(&table(file, "trajectory", &["id", "frame", "x", "y", "z"], &rows), 10.0);
    });
    assert_eq!(read(bytes).agents[0].height_m, Some(1.7));
}

#[test]
fn odd_values_are_left_out_with_their_row() {
    let bytes = file(|file| {
        let row = |id, frame, x| [Double(id), Double(frame), Double(x), Double(0.0), Long(3)];
        let rows = [row(1.0, 0.0, 0.0), row(1.5, 0.0, 0.0), row(1.0, 1.0, f64::NAN)];
        let more = [row(1.0, 2.0, 2.0), row(1.0, f64::INFINITY, 0.0), row(1.0, 3.0, 3.0)];
        let rows: Vec<&[Value]> = rows.iter().chain(&more).map(|row| &row[..]).collect();
        let names = ["ID", "Frame", "X", "Y", "group"];
        set_fps(&table(file, "trajectory", &names, &rows), 1.0);
    });
    let recording = read(&*bytes);
    let times: Vec<_> = rows_of(&recording, "1").iter().map(|row| row.0).collect();
    assert_eq!(times, [0.0, 2.0, 3.0]);
    assert_eq!(column(&recording, "group"), ["3", "3", "3"]);
    assert_eq!(
        warnings(&recording),
        [
            "rows without a whole number as id were left out (row 2)",
            "rows without a number as time or position were left out (2 rows, the first in row 3)",
        ]
    );
}

#[test]
fn missing_facts_name_a_remedy() {
    let rows: [&[Value]; 1] = [&[Int(1), Int(0), Float(1.0), Float(1.0)]];
    let members = ["id", "frame", "x", "y"];
    let no_rate = file(|file| {
        table(file, "trajectory", &members, &rows);
    });
    assert!(problem(&*no_rate).contains("--data-fps"));
    let settings = ReadSettings { fps: Some(2.0), ..ReadSettings::default() };
    let recording = parse("file".as_ref(), no_rate, &settings).expect("a row");
    assert_eq!(recording.source.fps.value, 2.0);
    let other = file(|file| {
        table(file, "points", &members, &rows);
    });
    let text = problem(other);
    assert!(text.contains("but points") && text.contains("h5py"), "{text}");
    let flat = file(|file| {
        let dataset = file.new_dataset::<f64>().shape([4, 5]).create("trajectory").expect("data");
        dataset.write_raw(&[0.0; 20]).expect("data");
    });
    assert!(problem_with(flat, &settings).to_string().contains("named members"));
    let unnamed =
        file(|file| set_fps(&table(file, "trajectory", &["a", "b", "x", "y"], &rows), 1.0));
    assert!(problem(unnamed).contains("it has a, b, x, y"));
}

#[test]
fn rows_in_other_files_are_refused() {
    let bytes = file(|file| {
        file.create_external_link("trajectory", "other.h5", "trajectory").expect("a link");
    });
    assert!(problem(bytes).contains("in another file"));
}

#[test]
fn sizes_far_beyond_the_file_are_refused() {
    let compound = CompoundType {
        members: ["id", "frame", "x", "y"]
            .map(|name| (name.to_owned(), DatatypeMessage::f64_type(), 0))
            .to_vec(),
        total_size: 8,
    };
    let with = |rows: usize, part: usize| {
        file(|file| {
            let builder = file.new_dataset::<u8>().datatype(compound.to_datatype());
            let builder = builder.shape([rows]).chunk(&[part]).max_shape(&[None]).deflate(1);
            set_fps(&builder.create("trajectory").expect("a dataset"), 1.0);
        })
    };
    assert!(problem(with(1 << 40, 100)).contains("far beyond"));
    assert!(problem(with(100, 1 << 25)).contains("far beyond"));
    assert_eq!(read(with(100, 100)).row_count(), 1, "all rows are the same");
}

#[test]
fn truncated_files_are_refused() {
    let bytes = jupedsim();
    for part in [8, 60, bytes.len() / 2, bytes.len() - 10] {
        let text = problem(&bytes[..part]);
        assert!(text.contains("h5py"), "{part}: {text}");
    }
}

#[test]
fn a_unit_that_is_told_holds_for_the_area() {
    let settings = ReadSettings { unit: Some(Unit::Centimetres), ..ReadSettings::default() };
    let recording = parse("file".as_ref(), jupedsim(), &settings).expect("rows");
    assert_eq!(rows_of(&recording, "7")[0].1, [0.01, 0.02]);
    assert_eq!(recording.place.walkable_at(0.0)[0].outline[2], [0.09; 2]);
}

#[test]
fn known_heights_are_in_metres_whatever_unit_is_told() {
    let settings = ReadSettings { unit: Some(Unit::Centimetres), ..ReadSettings::default() };
    let recording = parse("file".as_ref(), petrack(), &settings).expect("rows");
    let heights: Vec<_> = recording.agents.iter().map(|agent| agent.height_m).collect();
    assert_eq!(heights, [Some(1.82), None], "z is in the unit that is told");
}
