//! Feeds arbitrary bytes to the reader of trajectories of any format, which must recognise them and
//! return a recording or an error that says what is wrong. It must never panic, hang or exhaust
//! memory.
//!
//! Seeds are those of the other targets of trajectories.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use populace_trajectory::{ReadSettings, parse};

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = parse(Path::new("fuzz"), bytes.to_vec(), &ReadSettings::default()) {
        assert!(!error.to_string().is_empty());
    }
});
