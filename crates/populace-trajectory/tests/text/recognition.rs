//! Formats by their content.

use std::io::Write;

use populace_trajectory::{Format, parse};

use super::fixtures::{CSV, PETRACK, error, recording};

#[test]
fn compressed_files_are_recognised_inside() {
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(PETRACK.as_bytes()).expect("compressed");
    let recording = recording(gzip.finish().expect("compressed"));
    assert_eq!(recording.source.format, Format::PeTrack);
}

#[test]
fn a_compressed_file_that_ends_early_is_an_error() {
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(PETRACK.repeat(2000).as_bytes()).expect("compressed");
    let bytes = gzip.finish().expect("compressed");
    for length in [3, 20, bytes.len() / 2, bytes.len() - 4] {
        assert!(error(&bytes[..length]).starts_with("cannot read file"));
    }
}

#[test]
fn unsupported_families_are_refused_by_name_with_a_hint() {
    for (head, name, hint) in [
        ("<?xml version=\"1.0\"?>\n<!-- x --><trajectories>", "the former JuPedSim", "plain text"),
        ("<trajectoriesDataset>", "the former JuPedSim", "plain text"),
        ("<a:html>", "root \"a:html\"", "--format"),
        ("PAR1\0\0", "Parquet", "CSV"),
        ("PK\x03\x04", "ZIP", "unpack"),
        ("3 - the number of splines\n", "UCY", "obsmat.txt"),
        ("recordingId,trackId,frame,xCenter,yCenter\n0,0,0,1,2\n", "inD", "id,frame,x,y"),
        ("0 1 2 3 4 5 0 0 0 \"Biker\"\n", "Stanford Drone", "pixels"),
        ("{\"agents\": []}", "JSON", "--format"),
        ("id,t,lon,lat\n1,0,8.5,47.4\n", "longitudes", "project"),
        ("hello world\n", "hello world", "id,frame,x,y"),
        ("1.5 2.5 3.5\n", "1.5 2.5 3.5", "id,frame,x,y"),
        ("\0\x01\x02", "binary", "--format"),
    ] {
        let message = error(head);
        assert!(message.contains(name) && message.contains(hint), "{head:?}: {message}");
    }
}

#[test]
fn pictures_are_refused_by_name() {
    let png = error(*b"\x89PNG\r\n\x1a\n\0");
    assert!(png.contains("a PNG picture") && png.contains("positions of people"), "{png}");
    assert!(error(*b"\xff\xd8\xff\xe0\0").contains("a JPEG picture"));
}

#[test]
fn an_unknown_file_lists_the_formats() {
    let message = error("hello\n");
    for (_, name, _) in Format::ALL {
        assert!(message.contains(name), "{message}");
    }
}

#[test]
fn the_format_can_be_told() {
    let settings =
        |format| populace_trajectory::ReadSettings { format: Some(format), ..Default::default() };
    let rows = "1 0 1 2 0\n1 1 2 2 0\n";
    let told = |format| parse("file".as_ref(), rows.into(), &settings(format)).expect("rows");
    assert_eq!(told(Format::PeTrack).track(&told(Format::PeTrack).agents[0]).elevations, [0.0; 0]);
    assert_eq!(told(Format::Jpscore).source.fps.value, 16.0);
    let wrong = parse("file".as_ref(), CSV.into(), &settings(Format::Menge)).map(|_| ());
    assert!(wrong.expect_err("no Menge file").to_string().contains("version"));
}
