//! Random sequences of calls to the whole public API of a crowd and of its ragdolls.
//!
//! On each device and schedule, two crowds get the same calls. Neither may panic, and their
//! palettes and return values must be equal bit for bit. All palettes must be finite, whatever
//! numbers the calls were given.
//!
//! Fixed seeds run as tests. Other seeds run by `cargo test -p populace-cli --test sequences --
//! --seed 7 --calls 1000000`, on every device or, with `--setup native/fused`, on one. A failing
//! sequence is shortened and printed.
//!
//! `--soak-minutes 60` keeps two large crowds on different devices alive instead (`soak.rs`).

mod assets;
#[path = "../../../populace-assets/tests/gltf/builder.rs"]
#[allow(dead_code, reason = "only some of its files are needed here")]
mod builder;
mod builders;
mod calls;
mod controls;
mod draw;
mod fixture;
#[path = "../../../../fuzz/seeds.rs"]
mod fuzz_seeds;
mod imported;
mod long;
mod reads;
mod sequence;
mod soak;
mod watched;
mod world;

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

use fixture::{Setup, setups};
use sequence::Sequence;

/// Number of sequences in the test of each set-up.
const SEQUENCES: u64 = 48;
/// Number of calls in a sequence.
const CALLS: usize = 500;

fn main() -> ExitCode {
    if std::env::args().any(|argument| long::FLAGS.contains(&argument.as_str())) {
        return long::run();
    }
    if std::env::args().any(|argument| argument == soak::FLAG) {
        return soak::run();
    }
    let mut arguments = Arguments::from_args();
    // More threads would wait for each other on the same OpenCL device.
    arguments.test_threads.get_or_insert(2);
    let trials = setups().into_iter().map(|setup| {
        let is_skipped = setup.needs_opencl && cfg!(skip_opencl);
        let trial = Trial::test(format!("sequences: {}", setup.name), move || check(&setup));
        trial.with_ignored_flag(is_skipped)
    });
    let others = [
        Trial::test("soak: a small crowd", soak::check_small),
        Trial::test("builders: random bytes", builders::check_random),
        Trial::test("imported: changed bytes", imported::check_mutations),
        Trial::test("seeds: sequences from bytes", check_seeds),
    ];
    libtest_mimic::run(&arguments, trials.chain(others).collect()).exit_code()
}

/// Writes seeds of the fuzz targets that share code with this test. Sequences must be the same after
/// they are read again.
fn check_seeds() -> Result<(), libtest_mimic::Failed> {
    for seed in 0..8 {
        let sequence = Sequence::new(seed, CALLS / 10);
        let bytes = sequence.to_bytes();
        if Sequence::from_bytes(&bytes).to_bytes() != bytes {
            return Err(format!("sequence {seed} changes when it is read").into());
        }
        fuzz_seeds::write("calls", &seed.to_string(), &bytes);
        fuzz_seeds::write("builders", &seed.to_string(), &bytes);
    }
    for (nth, bytes) in imported::seeds().iter().enumerate() {
        fuzz_seeds::write("gltf_evaluate", &nth.to_string(), bytes);
    }
    Ok(())
}

fn check(setup: &Setup) -> Result<(), libtest_mimic::Failed> {
    for seed in 0..SEQUENCES {
        let sequence = Sequence::new(seed, CALLS);
        if let Err(fault) = sequence.run(setup) {
            return Err(sequence.report(setup, &fault).into());
        }
    }
    Ok(())
}
