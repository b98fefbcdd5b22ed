//! Small mutations of the seeds of the fuzz targets. None of them may panic or hang.

use std::path::Path;

use populace_trajectory::{Format, ReadSettings, parse};
use proptest::prelude::*;

use super::fixtures;

#[path = "../../../../fuzz/seeds.rs"]
mod fuzz_seeds;

/// Reads bytes as what they seem to be, and as a format. What is refused must say why.
fn survives(bytes: &[u8], format: Format) {
    for format in [None, Some(format)] {
        let settings = ReadSettings { format, ..ReadSettings::default() };
        match parse(Path::new("seed"), bytes.to_vec(), &settings) {
            Ok(recording) => {
                assert!(recording.row_count() > 0);
                for agent in &recording.agents {
                    let track = recording.track(agent);
                    assert!(track.times.is_sorted() && !track.times.is_empty());
                    assert_eq!(track.times.len(), track.positions.len());
                }
                let rows = recording.row_count();
                for column in &recording.columns {
                    let length = match &column.values {
                        populace_trajectory::Values::Numbers(numbers) => numbers.len(),
                        populace_trajectory::Values::Words { indices, .. } => indices.len(),
                    };
                    assert_eq!(length, rows, "{}", column.name);
                }
            }
            Err(error) => assert!(error.to_string().contains(": "), "{error}"),
        }
    }
}

#[test]
fn seeds_load_and_can_be_written() {
    for (index, seed) in fixtures::all().into_iter().enumerate() {
        survives(&seed.bytes, seed.format);
        let own = if seed.format == Format::Menge { "trajectory_menge" } else { "trajectory_text" };
        for target in [own, "trajectory_recognised"] {
            fuzz_seeds::write(target, &format!("{index}-{}", seed.name), &seed.bytes);
        }
    }
}

#[test]
fn every_truncation_survives() {
    for fixture in fixtures::all() {
        for length in 0..fixture.bytes.len() {
            survives(&fixture.bytes[..length], fixture.format);
        }
    }
}

#[test]
fn changing_any_byte_survives() {
    for fixture in fixtures::all() {
        for at in 0..fixture.bytes.len() {
            let mut changed = fixture.bytes.clone();
            for new in [changed[at] ^ 1, changed[at] ^ 0x80, 0, 0xff, b'9', b'-', b'"', b'\n', b';']
            {
                changed[at] = new;
                survives(&changed, fixture.format);
            }
        }
    }
}

#[test]
fn replacing_any_number_survives() {
    for fixture in fixtures::all() {
        let Ok(text) = String::from_utf8(fixture.bytes) else { continue };
        let digits = text.match_indices(|c: char| c.is_ascii_digit());
        for (at, _) in digits {
            for new in ["-1", "1e300", "-1e-300", "18446744073709551616", "nan", "inf", "1e9", ""] {
                let changed = format!("{}{new}{}", &text[..at], &text[at + 1..]);
                survives(changed.as_bytes(), fixture.format);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn shuffled_pieces_survive(
        which in 0_usize..16,
        cuts in prop::collection::vec((0..=100_usize, 0..=100_usize), 1..6),
        noise in prop::collection::vec(any::<u8>(), 0..8),
    ) {
        let fixtures = fixtures::all();
        let fixture = &fixtures[which % fixtures.len()];
        let length = fixture.bytes.len();
        let mut bytes = Vec::new();
        for (from, until) in cuts {
            let [from, until] = [from, until].map(|percent| percent * length / 100);
            bytes.extend(&fixture.bytes[from.min(until)..from.max(until)]);
            bytes.extend(&noise);
        }
        survives(&bytes, fixture.format);
    }
}
