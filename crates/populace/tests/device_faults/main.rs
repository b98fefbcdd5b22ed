//! Faults of OpenCL devices: chosen calls fail, and the crowd goes on.
//!
//! Each run draws a crowd, a schedule and a fault. Two crowds get the same calls, one on the device
//! that fails and one on the native device. An update that fails leaves its crowd as it was; it then
//! runs again, there or on another device, and both crowds must be equal bit for bit.
#![cfg(all(feature = "opencl", not(skip_opencl)))]
#![expect(clippy::expect_used, dead_code, reason = "a failed call fails the test")]
#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]
#![expect(clippy::print_stdout, reason = "counts are shown with --nocapture")]

#[path = "../controls/fixture.rs"]
mod fixture;

mod driver;
mod pair;

use std::sync::{Mutex, PoisonError};

use pair::{Pair, Tally};

/// Only one crowd's calls may be counted at a time.
static ONE: Mutex<()> = Mutex::new(());

fn run(seeds: std::ops::Range<u64>) {
    let _alone = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    driver::install();
    let mut tally = Tally::default();
    for seed in seeds.clone() {
        Pair::run(seed, &mut tally);
    }
    println!("{} runs: {tally:?}", seeds.end - seeds.start);
    assert!(3 * tally.failed_updates > seeds.end - seeds.start, "{tally:?}");
}

#[test]
fn crowds_go_on_after_faults() {
    run(1000..1030);
}

#[ignore = "minutes; make test-long runs it"]
#[test]
fn crowds_go_on_after_a_thousand_faults() {
    run(1030..2030);
}
