//! Any bytes: the importer gives a character or says what is wrong, and never panics, hangs or
//! fills the memory.
//!
//! `cargo +nightly fuzz run gltf`; the seeds run as ordinary tests in
//! `crates/populace-assets/tests/gltf/mutations.rs`, and `POPULACE_WRITE_SEEDS=fuzz/corpus/gltf
//! cargo test -p populace-assets seeds` writes them where this finds them.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = populace_assets::load_from_slice(bytes, None) {
        assert!(!error.to_string().is_empty());
    }
});
