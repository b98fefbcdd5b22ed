//! Builds state machines and blend spaces of arbitrary bytes and plays them. What is refused must
//! say why, and what is accepted must give finite palettes.
//!
//! Check, which is also an ordinary test: `crates/populace-cli/tests/sequences/builders.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| populace_fuzz::builders(bytes));
