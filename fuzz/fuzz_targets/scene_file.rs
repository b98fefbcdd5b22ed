//! Reads arbitrary text as a scene file. A refusal must say why, and a plan that is accepted must
//! be the same after it is written and read again.
//!
//! Seeds and check, which are also ordinary tests: `crates/populace-scene/tests/scene_file.rs`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use populace_scene::plan::ScenePlan;

fuzz_target!(|text: &str| match ScenePlan::parse(text) {
    Err(error) => assert!(!error.to_string().is_empty()),
    Ok(plan) => {
        let written = plan.to_toml().expect("an accepted plan can be written");
        assert_eq!(ScenePlan::parse(&written).as_ref(), Ok(&plan));
    }
});
