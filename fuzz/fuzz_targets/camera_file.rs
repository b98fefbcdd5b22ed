//! Reads arbitrary text as a file of camera positions. A refusal must name the line.
//!
//! Seeds, which are also ordinary tests: `crates/populace-cli/src/camera/keys.rs`.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Err(error) = populace_cli::check_camera_file(text) {
        assert!(error.starts_with("line "), "{error}");
    }
});
