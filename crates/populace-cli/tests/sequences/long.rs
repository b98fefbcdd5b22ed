//! Long runs from the command line.

use std::process::ExitCode;
use std::time::Instant;

use crate::fixture::{Setup, setups};
use crate::sequence::Sequence;

/// The flags of long runs; each takes a value.
pub(crate) const FLAGS: [&str; 4] = ["--seed", "--calls", "--length", "--setup"];

/// Default number of calls in a sequence.
const DEFAULT_LENGTH: usize = 600;

pub(crate) fn value(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

pub(crate) fn number(name: &str, default: u64) -> u64 {
    value(name).map_or(default, |text| {
        text.parse().unwrap_or_else(|_| panic!("{name} takes a whole number, not \"{text}\""))
    })
}

/// Prints progress on stderr.
#[expect(clippy::print_stderr, reason = "a long run reports its progress")]
pub(crate) fn report(text: &str) {
    eprint!("{text}");
}

/// Runs sequences with seeds from `--seed` on, until `--calls` calls were made on each set-up whose
/// name begins with `--setup`.
pub(crate) fn run() -> ExitCode {
    let (seed, calls) = (number("--seed", 0), number("--calls", 1));
    let length =
        usize::try_from(number("--length", DEFAULT_LENGTH as u64)).unwrap_or(DEFAULT_LENGTH).max(1);
    let wanted = value("--setup").unwrap_or_default();
    let setups: Vec<Setup> =
        setups().into_iter().filter(|setup| setup.name.starts_with(&wanted)).collect();
    assert!(!setups.is_empty(), "no set-up begins with \"{wanted}\"");
    for setup in &setups {
        let setup = &Setup { has_stages: true, ..setup.clone() };
        let count = calls.div_ceil(length as u64);
        let (start, mut early) = (Instant::now(), 0);
        for nth in 0..count {
            // Drivers, programs and pools are loaded by then.
            if nth == count / 10 {
                early = resident_mib();
            }
            // Printed first, in case a driver crashes.
            report(&format!("\r{}: seed {} ", setup.name, seed + nth));
            let sequence = Sequence::new(seed + nth, length);
            if let Err(fault) = sequence.run(setup) {
                report(&format!("\n{}\n", sequence.report(setup, &fault)));
                return ExitCode::FAILURE;
            }
        }
        let secs = start.elapsed().as_secs();
        let made = count * length as u64;
        let now = resident_mib();
        report(&format!(
            "\r{}: {made} calls on each of two crowds in {secs} s, {early} MiB resident after a \
             tenth, {now} MiB at the end\n",
            setup.name
        ));
    }
    ExitCode::SUCCESS
}

fn resident_mib() -> u64 {
    resident_kib() / 1024
}

/// Returns the memory of this process; 0 if the system does not report it.
pub(crate) fn resident_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0)
}
