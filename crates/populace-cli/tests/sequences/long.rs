//! Runs of as many calls as are asked for.

use std::process::ExitCode;
use std::time::Instant;

use crate::fixture::{Setup, setups};
use crate::sequence::Sequence;

/// What is asked for by name; each takes a value.
pub(crate) const FLAGS: [&str; 4] = ["--seed", "--calls", "--length", "--setup"];

/// Calls of a sequence unless `--length` says otherwise.
const LENGTH: usize = 600;

fn value(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

fn number(name: &str, otherwise: u64) -> u64 {
    value(name).map_or(otherwise, |text| {
        text.parse()
            .unwrap_or_else(|_| panic!("{name} takes a whole number, and \"{text}\" is none"))
    })
}

/// Talks to whoever started the run.
#[expect(clippy::print_stderr, reason = "this is a program, and stderr is where it talks")]
fn talk(text: &str) {
    eprint!("{text}");
}

/// Runs sequences of seeds from `--seed` on, until `--calls` calls were made on each set-up whose
/// name begins with `--setup`.
pub(crate) fn run() -> ExitCode {
    let (seed, calls) = (number("--seed", 0), number("--calls", 1));
    let length = usize::try_from(number("--length", LENGTH as u64)).unwrap_or(LENGTH).max(1);
    let wanted = value("--setup").unwrap_or_default();
    let setups: Vec<Setup> =
        setups().into_iter().filter(|setup| setup.name.starts_with(&wanted)).collect();
    assert!(!setups.is_empty(), "there is no set-up \"{wanted}\"");
    for setup in &setups {
        let setup = &Setup { has_stages: true, ..setup.clone() };
        let count = calls.div_ceil(length as u64);
        let (start, mut early) = (Instant::now(), 0);
        for nth in 0..count {
            // Drivers, programs and pools are loaded by then.
            if nth == count / 10 {
                early = resident_mib();
            }
            // Told before it runs, for a driver that crashes leaves nothing else.
            talk(&format!("\r{}: seed {} ", setup.name, seed + nth));
            let sequence = Sequence::new(seed + nth, length);
            if let Err(fault) = sequence.run(setup) {
                talk(&format!("\n{}\n", sequence.report(setup, &fault)));
                return ExitCode::FAILURE;
            }
        }
        let secs = start.elapsed().as_secs();
        let made = count * length as u64;
        let now = resident_mib();
        talk(&format!(
            "\r{}: {made} calls on each of two crowds in {secs} s, {early} MiB resident after a \
             tenth, {now} MiB at the end\n",
            setup.name
        ));
    }
    ExitCode::SUCCESS
}

/// Memory of this process, where the system tells; 0 elsewhere.
fn resident_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0) / 1024
}
