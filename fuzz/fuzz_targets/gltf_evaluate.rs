//! Loads arbitrary bytes as glTF, adds the character to a crowd and evaluates its clips. No step
//! may panic or hang, and what is refused must say why.
//!
//! Seeds and check, which are also ordinary tests: `crates/populace-cli/tests/sequences/imported.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| populace_fuzz::imported(bytes));
