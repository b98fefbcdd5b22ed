//! Makes arbitrary calls of the public API on two crowds. Neither may panic, and both must return
//! the same, and the same finite palettes, bit for bit.
//!
//! Seeds and check, which are also ordinary tests: `crates/populace-cli/tests/sequences`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| populace_fuzz::calls(bytes));
