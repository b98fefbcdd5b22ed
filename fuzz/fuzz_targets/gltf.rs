//! Feeds arbitrary bytes to the glTF importer, which must return a character or an error that says
//! what is wrong. It must never panic, hang or exhaust memory.
//!
//! Seeds, which are also ordinary tests: `crates/populace-assets/tests/gltf/mutations.rs`.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = populace_assets::load_from_slice(bytes, None) {
        assert!(!error.to_string().is_empty());
    }
});
