//! Feeds arbitrary bytes to the glTF importer, which must return a character or an error that says
//! what is wrong. It must never panic, hang or exhaust memory.
//!
//! Run with `cargo +nightly fuzz run gltf`. The seeds are also ordinary tests, in
//! `crates/populace-assets/tests/gltf/mutations.rs`. To write them to the corpus, run
//! `POPULACE_WRITE_SEEDS=fuzz/corpus/gltf cargo test -p populace-assets seeds`.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = populace_assets::load_from_slice(bytes, None) {
        assert!(!error.to_string().is_empty());
    }
});
