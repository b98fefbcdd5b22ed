//! Feeds arbitrary bytes to the reader of SUMO's floating car data, which must return a recording
//! or an error that says what is wrong. It must never panic, hang or exhaust memory.
//!
//! Seeds, which are also ordinary tests: `crates/populace-trajectory/tests/simulations/mutations.rs`.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use populace_trajectory::{Format, ReadSettings, parse};

fuzz_target!(|bytes: &[u8]| {
    let settings = ReadSettings { format: Some(Format::Sumo), ..ReadSettings::default() };
    if let Err(error) = parse(Path::new("fuzz"), bytes.to_vec(), &settings) {
        assert!(!error.to_string().is_empty());
    }
});
