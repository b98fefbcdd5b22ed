use populace_trajectory::{Error, ReadSettings, load};

use super::warnings;

const ROWS: &str =
    "# framerate: 25 fps\n# id frame x/m y/m z/m\n1 0 5001 2 1.7\n1 1 5001 2.05 1.7\n";

#[test]
fn an_area_beside_the_file_is_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rows.txt");
    std::fs::write(&path, ROWS).expect("a file");
    let read = |settings: &ReadSettings| load(&path, settings);
    let plain = ReadSettings::default();
    assert!(read(&plain).expect("rows").place.changes.is_empty());
    let wkt = folder.path().join("rows.wkt");
    std::fs::write(&wkt, "POLYGON ((5000 0, 5009 0, 5009 9))\n").expect("a file");
    let recording = read(&plain).expect("rows");
    assert_eq!(recording.origin_m, [5000.0, 0.0]);
    assert_eq!(recording.place.walkable_at(0.0)[0].outline, [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]);
    std::fs::write(&wkt, "POLYGON ((5000 0, 5009 x, 5009 9))\n").expect("a file");
    let recording = read(&plain).expect("rows");
    assert!(recording.place.changes.is_empty());
    assert!(warnings(&recording)[0].contains("rows.wkt, byte 23"), "{:?}", warnings(&recording));
    let strict = ReadSettings { strict: true, ..ReadSettings::default() };
    assert!(matches!(read(&strict), Err(Error::Strict { .. })));
}

#[test]
fn the_area_of_the_settings_counts_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rows.txt");
    std::fs::write(&path, ROWS).expect("a file");
    std::fs::write(folder.path().join("rows.wkt"), "broken").expect("a file");
    let geometry = folder.path().join("hall.txt");
    let settings = ReadSettings { geometry: Some(geometry.clone()), ..ReadSettings::default() };
    assert!(matches!(load(&path, &settings), Err(Error::Unreadable { .. })));
    std::fs::write(&geometry, "POINT (1 2)").expect("a file");
    let text = load(&path, &settings).expect_err("no area").to_string();
    assert!(text.contains("hall.txt, byte 0: POINT is no area"), "{text}");
    std::fs::write(&geometry, b"glTF\xff\0").expect("a file");
    let text = load(&path, &settings).expect_err("no text").to_string();
    assert!(text.contains("hall.txt: it is no text") && text.contains("WKT"), "{text}");
    std::fs::write(&geometry, "MULTIPOLYGON (((0 0, 1 0, 1 1)), ((2 2, 3 2, 3 3)))").expect("it");
    let recording = load(&path, &settings).expect("rows");
    assert_eq!(recording.place.walkable_at(0.0).len(), 2);
    assert!(recording.warnings.is_empty());
}
