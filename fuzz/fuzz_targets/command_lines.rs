//! Parses arbitrary command lines, one argument in a line. A refusal must say why; nothing runs.
//!
//! Seeds, which are also ordinary tests: `crates/populace-cli/src/cli/tests.rs`.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Err(error) = populace_cli::check_command_line(text.lines()) {
        assert!(!error.is_empty());
    }
});
