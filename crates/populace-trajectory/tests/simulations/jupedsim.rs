use std::path::Path;

use populace_trajectory::{Format, HeadingSource, ReadSettings, Unit, load, parse};
use rusqlite::Connection;

use super::{column, compressed, problem, problem_with, read, rows_of, warnings};

const V2: &str = "
    CREATE TABLE trajectory_data(frame INTEGER NOT NULL, id INTEGER NOT NULL, pos_x REAL NOT NULL,
        pos_y REAL NOT NULL, ori_x REAL NOT NULL, ori_y REAL NOT NULL);
    CREATE TABLE metadata(key TEXT NOT NULL UNIQUE PRIMARY KEY, value TEXT NOT NULL);
    CREATE TABLE geometry(hash INTEGER NOT NULL, wkt TEXT NOT NULL);
    CREATE TABLE frame_data(frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL);
    INSERT INTO metadata VALUES ('version', '2'), ('fps', '10.0');
    INSERT INTO trajectory_data VALUES (0, 7, 1, 2, 0, 0), (0, 9, 5, 5, 0, 1),
        (1, 7, 1.1, 2, 1, 0), (1, 9, 5, 5.1, 0, 1), (2, 7, 1.2, 2, 1, 0);
    INSERT INTO geometry VALUES (-5, 'POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))'),
        (77, 'POLYGON ((0 0, 9 0, 9 9, 0 9), (3 3, 4 3, 4 4))');
    INSERT INTO frame_data VALUES (0, -5), (1, -5), (2, 77);
";

/// Returns the bytes of a database.
pub(super) fn bytes(sql: &str) -> Vec<u8> {
    let mut connection = Connection::open_in_memory().expect("memory");
    connection.execute_batch(sql).expect("good SQL");
    connection.serialize("main").expect("memory").to_vec()
}

pub(super) fn small() -> Vec<u8> {
    bytes(V2)
}

#[test]
fn rows_headings_and_changing_areas_of_version_2_are_read() {
    let recording = read(small());
    assert_eq!(recording.source.format, Format::JuPedSim);
    assert_eq!(recording.source.version, "version 2");
    assert_eq!(recording.source.fps.value, 10.0);
    assert_eq!(rows_of(&recording, "7"), [(0.0, [1.0, 2.0]), (0.1, [1.1, 2.0]), (0.2, [1.2, 2.0])]);
    assert_eq!(recording.source.heading.value, HeadingSource::Data);
    let headings = recording.track(&recording.agents[0]).headings;
    assert!(headings[0].is_nan(), "the vector 0, 0 is no heading");
    assert_eq!(headings[1..], [0.0, 0.0]);
    assert_eq!(recording.track(&recording.agents[1]).headings, [std::f32::consts::FRAC_PI_2; 2]);
    let times: Vec<_> = recording.place.changes.iter().map(|change| change.from_secs).collect();
    assert_eq!(times, [0.0, 0.2]);
    assert_eq!(recording.place.walkable_at(0.1)[0].holes.len(), 0);
    assert_eq!(recording.place.walkable_at(0.2)[0].holes.len(), 1);
    assert!(recording.warnings.is_empty());
}

#[test]
fn columns_are_found_by_name_in_versions_1_and_3() {
    let data = "INSERT INTO metadata VALUES ('version', '3'), ('fps', '2');";
    let table = "CREATE TABLE trajectory_data(pos_y REAL, pos_x REAL, id INTEGER, frame INTEGER);
        CREATE TABLE metadata(key TEXT, value TEXT);
        INSERT INTO trajectory_data VALUES (20, 10, 1, 0), (20, 11, 1, 1);";
    let recording = read(bytes(&format!(
        "{table} {data} CREATE TABLE geometry(wkt TEXT, hash INTEGER);
         INSERT INTO geometry VALUES ('POLYGON ((0 0, 30 0, 30 30))', 4);"
    )));
    assert_eq!(rows_of(&recording, "1"), [(0.0, [10.0, 20.0]), (0.5, [11.0, 20.0])]);
    assert_eq!(recording.source.heading.value, HeadingSource::Motion);
    assert_eq!(recording.place.walkable_at(0.0).len(), 1);
    let recording = read(bytes(&format!(
        "{table} {data} CREATE TABLE geometry(wkt TEXT);
         INSERT INTO geometry VALUES ('POLYGON ((0 0, 30 0, 30 30))');"
    )));
    assert_eq!(recording.place.walkable_at(0.0).len(), 1);
}

#[test]
fn values_of_other_types_are_read_or_left_out_with_their_row() {
    let sql = "CREATE TABLE trajectory_data(frame, id, pos_x, pos_y, grp, speed);
        CREATE TABLE metadata(key, value);
        INSERT INTO metadata VALUES ('fps', 10.0);
        INSERT INTO trajectory_data VALUES (0, 1, 1, 1, 'a', 1.5), (1.0, '1', '1.5', 1, 'b', NULL),
            (2, 1, NULL, 1, 'c', 2), (3, NULL, 1, 1, 'd', 3), (4, 1.0, 2, 1, 5, 'x'),
            (5, 'left', 2, 1, NULL, 4), (6, 1, x'00', 1, 'a', 2);";
    let recording = read(bytes(sql));
    assert_eq!(rows_of(&recording, "1"), [(0.0, [1.0, 1.0]), (0.1, [1.5, 1.0]), (0.4, [2.0, 1.0])]);
    assert_eq!(rows_of(&recording, "left").len(), 1);
    assert_eq!(column(&recording, "grp"), ["a", "b", "5", ""]);
    assert_eq!(column(&recording, "speed"), ["1.5", "", "x", "4"]);
    assert_eq!(
        warnings(&recording),
        [
            "rows without a number as time or position were left out (2 rows, the first in row 3)",
            "rows without an id were left out (row 4)",
        ]
    );
    let strict = ReadSettings { strict: true, ..ReadSettings::default() };
    assert!(problem_with(bytes(sql), &strict).to_string().contains("row 3"));
}

#[test]
fn missing_facts_name_a_remedy() {
    let text = problem(bytes("CREATE TABLE points(x, y);"));
    assert!(text.contains("no table trajectory_data") && text.contains("points"), "{text}");
    let table = "CREATE TABLE trajectory_data(frame, id, pos_x, pos_y);";
    assert!(problem(bytes(table)).contains("--data-fps"));
    let settings = ReadSettings { fps: Some(5.0), ..ReadSettings::default() };
    assert!(problem_with(bytes(table), &settings).to_string().contains("no positions"));
    let text = problem_with(bytes("CREATE TABLE trajectory_data(frame, id);"), &settings);
    assert!(text.to_string().contains("it has frame, id"), "{text}");
    let rows = format!("{table} INSERT INTO trajectory_data VALUES (1, 1, 2, 3), (11, 1, 3, 3);");
    let recording = parse(Path::new("file"), bytes(&rows), &settings).expect("rows");
    assert_eq!(recording.secs(), [0.2, 2.2]);
}

#[test]
fn a_view_that_never_ends_is_not_read() {
    let sql = "CREATE VIEW trajectory_data AS WITH RECURSIVE n(frame) AS
        (SELECT 0 UNION ALL SELECT frame + 1 FROM n) SELECT frame, 1 AS id, 0 AS pos_x, 0 AS pos_y
        FROM n;";
    assert!(problem(bytes(sql)).contains("no table trajectory_data"));
}

#[test]
fn broken_areas_are_warnings() {
    let sql = V2.replace("(3 3, 4 3, 4 4)", "(3 3, 4 three, 4 4)");
    let recording = read(bytes(&sql));
    let expected = "the walkable area was left out: a number expected, \"three\" found at byte 39 \
                    of the WKT";
    assert_eq!(warnings(&recording), [expected]);
    assert_eq!(recording.place.changes.len(), 1);
    let recording = read(bytes(&V2.replace("(2, 77)", "(2, 78)")));
    assert!(warnings(&recording)[0].contains("walkable area that the file does not have"));
}

#[test]
fn frames_and_areas_of_other_types_are_read_or_left_out() {
    let sql =
        V2.replace("geometry(hash INTEGER NOT NULL, wkt TEXT NOT NULL)", "geometry(hash, wkt)");
    let sql = sql
        .replace("frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL", "frame, geometry_hash");
    let sql = sql.replace("(2, 77)", "('10', '77'), (2, NULL), ('9', -5), (3, NULL)");
    let recording = read(bytes(&sql));
    let times: Vec<_> = recording.place.changes.iter().map(|change| change.from_secs).collect();
    assert_eq!(times, [0.0, 1.0]);
    assert_eq!(
        warnings(&recording),
        ["frames without the hash of a walkable area keep the one before (2 rows)"]
    );
    let recording = read(bytes(&format!("{sql} INSERT INTO geometry VALUES (NULL, 5);")));
    assert_eq!(recording.place.changes.len(), 2);
    assert!(warnings(&recording)[0].starts_with("the walkable area was left out"));
}

#[test]
fn times_that_run_backwards_and_twins_are_warnings() {
    let sql = format!(
        "{V2} DELETE FROM trajectory_data; INSERT INTO trajectory_data VALUES
         (2, 1, 3, 0, 0, 0), (0, 1, 1, 0, 0, 0), (1, 1, 2, 0, 0, 0), (1, 1, 9, 0, 0, 0);"
    );
    let recording = read(bytes(&sql));
    assert_eq!(rows_of(&recording, "1"), [(0.0, [1.0, 0.0]), (0.1, [2.0, 0.0]), (0.2, [3.0, 0.0])]);
    assert_eq!(recording.warnings.len(), 2);
}

#[test]
fn compressed_files_and_odd_paths_are_read() {
    assert_eq!(read(compressed(&small())).row_count(), 5);
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["with space #1?.sqlite", "100%20.sqlite", "packed.sqlite.gz"] {
        let path = folder.path().join(name);
        let bytes = if name.ends_with("gz") { compressed(&small()) } else { small() };
        std::fs::write(&path, bytes).expect("a file");
        assert_eq!(load(&path, &ReadSettings::default()).expect(name).row_count(), 5);
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("files").count(), 3, "nothing was added");
}

#[test]
fn logs_beside_a_file_are_named_and_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("running.sqlite");
    let writer = Connection::open(&path).expect("a file");
    writer.pragma_update(None, "journal_mode", "wal").expect("a log");
    writer.execute_batch(V2).expect("good SQL");
    writer.pragma_update(None, "wal_checkpoint", "truncate").expect("merged");
    writer.execute("INSERT INTO trajectory_data VALUES (3, 7, 1.3, 2, 1, 0)", []).expect("a row");
    // The writer is still at work, or was stopped: here is what it leaves.
    let copy = folder.path().join("copy.sqlite");
    std::fs::copy(&path, &copy).expect("a file");
    std::fs::copy(folder.path().join("running.sqlite-wal"), folder.path().join("copy.sqlite-wal"))
        .expect("a log");
    let recording = load(&copy, &ReadSettings::default()).expect("rows");
    assert_eq!(recording.row_count(), 5);
    assert!(warnings(&recording)[0].contains("copy.sqlite-wal"), "{:?}", warnings(&recording));
    assert!(!folder.path().join("copy.sqlite-shm").exists());
    // In memory the log is not there at all.
    let bytes = std::fs::read(&copy).expect("a file");
    assert_eq!(read(bytes).row_count(), 5);
}

#[test]
fn truncated_files_are_refused() {
    let mut sql = V2.to_owned();
    for frame in 3..500 {
        sql += &format!("INSERT INTO trajectory_data VALUES ({frame}, 7, 1, 2, 0, 0);");
    }
    let bytes = bytes(&sql);
    for part in [100, bytes.len() / 3, bytes.len() - 5000] {
        let text = problem(&bytes[..part]);
        assert!(text.contains("SQLite cannot read it"), "{text}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.sqlite");
    std::fs::write(&path, &bytes[..bytes.len() / 3]).expect("a file");
    load(&path, &ReadSettings::default()).expect_err("refused");
}

#[test]
fn a_unit_that_is_told_holds_for_the_area() {
    let settings = ReadSettings { unit: Some(Unit::Feet), ..ReadSettings::default() };
    let recording = parse(Path::new("file"), small(), &settings).expect("rows");
    assert_eq!(rows_of(&recording, "7")[0].1, [0.3048, 0.6096]);
    let area = &recording.place.walkable_at(0.2)[0];
    assert_eq!(area.outline[2], [9.0 * 0.3048; 2]);
    assert_eq!(area.holes[0][0], [3.0 * 0.3048; 2]);
}
