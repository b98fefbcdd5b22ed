//! Feeds arbitrary bytes to the readers of trajectories in text, which must return a recording or
//! an error that says what is wrong. They must never panic, hang or exhaust memory.
//!
//! Seeds, which are also ordinary tests: `crates/populace-trajectory/tests/text/mutations.rs`.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use populace_trajectory::{Format, ReadSettings, parse};

const FORMATS: [Format; 9] = [
    Format::PeTrack,
    Format::Jpscore,
    Format::PathfinderCsv,
    Format::Viswalk,
    Format::CrowdIt,
    Format::Obsmat,
    Format::TrajNet,
    Format::TrajNetPlusPlus,
    Format::Csv,
];

fuzz_target!(|bytes: &[u8]| {
    for format in FORMATS {
        let settings = ReadSettings { format: Some(format), ..ReadSettings::default() };
        if let Err(error) = parse(Path::new("fuzz"), bytes.to_vec(), &settings) {
            assert!(!error.to_string().is_empty());
        }
    }
});
