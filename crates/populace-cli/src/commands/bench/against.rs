//! `populace bench --against`: another program evaluates a crowd of the same size, in turn.

use std::io::{BufRead, BufReader, Lines, Write};
use std::num::NonZero;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, anyhow};
use populace_bench::Measurement;
use serde_json::{Value, json};

use crate::failure::Failure;

const HEAD: &str = "
| members | device | schedule | load | against, ms, median | ms, least | ratio of medians | least |
|--:|---|---|---|--:|--:|--:|--:|
";

/// The other program while it runs: it evaluates a frame for each line that it is sent.
pub(super) struct Against {
    child: Child,
    /// `None` once it is told to end.
    input: Option<ChildStdin>,
    output: Lines<BufReader<ChildStdout>>,
    members: usize,
    slots: usize,
    /// Milliseconds of the measured frames.
    times: anyhow::Result<Vec<f64>>,
}

/// What the other program took for a crowd.
pub(super) struct Rival {
    members: usize,
    slots: usize,
    ms_median: f64,
    ms_min: f64,
}

impl Against {
    /// Starts the program for a crowd whose members have a number of joints.
    pub(super) fn start(
        program: &Path,
        [members, slots]: [u32; 2],
        joints: u32,
    ) -> Result<Self, Failure> {
        let wrong = |e: anyhow::Error| Failure::Input(e.context(program.display().to_string()));
        let path = program.canonicalize().map_err(|e| wrong(e.into()))?;
        let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
        let mut child = Command::new(path)
            .args([members.to_string(), slots.to_string(), threads.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| wrong(e.into()))?;
        let (input, output) = (child.stdin.take(), child.stdout.take());
        let output = output.ok_or_else(|| wrong(anyhow!("it has no output")))?;
        let mut started = Self {
            child,
            input,
            output: BufReader::new(output).lines(),
            members: members as usize,
            slots: slots as usize,
            times: Ok(Vec::new()),
        };
        let said = started.line().map_err(wrong)?;
        let own = said.strip_prefix("joints ").and_then(|count| count.parse::<u32>().ok());
        match own {
            None => Err(wrong(anyhow!("it began with {said:?} and not with \"joints N\""))),
            Some(own) if own != joints => Err(Failure::usage(format!(
                "{} evaluates members of {own} joints; add --joints {own}",
                program.display()
            ))),
            Some(_) => Ok(started),
        }
    }

    fn line(&mut self) -> anyhow::Result<String> {
        Ok(self.output.next().context("it ended early")??)
    }

    /// Lets the program evaluate a frame.
    pub(super) fn frame(&mut self, is_measured: bool) {
        let took = self.timed();
        match (took, &mut self.times) {
            (Ok(ms), Ok(times)) if is_measured => times.push(ms),
            (Err(error), times @ Ok(_)) => *times = Err(error),
            _ => {}
        }
    }

    fn timed(&mut self) -> anyhow::Result<f64> {
        let input = self.input.as_mut().context("it was told to end")?;
        input.write_all(b"\n").and_then(|()| input.flush()).context("it ended early")?;
        let said = self.line()?;
        let ms = said.parse::<f64>().ok().filter(|ms| ms.is_finite() && *ms > 0.0);
        ms.with_context(|| format!("it said {said:?} and not the milliseconds of a frame"))
    }

    /// Ends the program, and returns what it took.
    pub(super) fn finish(mut self) -> Result<Rival, Failure> {
        let times = std::mem::replace(&mut self.times, Ok(Vec::new()));
        let mut times = times.map_err(|e| Failure::Run(e.context("the program of --against")))?;
        times.sort_by(f64::total_cmp);
        let at = |nth: usize| times.get(nth).copied();
        let both = at(times.len() / 2).zip(at(0));
        let (ms_median, ms_min) =
            both.ok_or_else(|| Failure::Run(anyhow!("--against measured no frame")))?;
        Ok(Rival { members: self.members, slots: self.slots, ms_median, ms_min })
    }
}

impl Drop for Against {
    fn drop(&mut self) {
        // It ends when its input does.
        drop(self.input.take());
        let _ = self.child.wait();
    }
}

/// Returns whole frames of the same number of members, each with what the other program took.
fn pairs<'a>(
    runs: &'a [Measurement],
    rivals: &'a [Rival],
) -> impl Iterator<Item = (&'a Measurement, &'a Rival)> {
    let whole = |run: &&Measurement| run.stage == "all" && run.schedule != "floor";
    let with_rival = |run: &'a Measurement| {
        Some((run, rivals.iter().find(|rival| rival.members == run.members)?))
    };
    runs.iter().filter(whole).filter_map(with_rival)
}

/// Formats a Markdown table of the ratios.
pub(super) fn table(runs: &[Measurement], rivals: &[Rival]) -> String {
    pairs(runs, rivals).fold(HEAD.to_owned(), |text, (run, rival)| {
        let Rival { members, ms_median, ms_min, .. } = rival;
        let (device, schedule, load) = (&run.device, &run.schedule, &run.load);
        let [median, least] = [run.ms_median / ms_median, run.ms_min / ms_min];
        text + &format!(
            "| {members} | {device} | {schedule} | {load} | {ms_median:.2} | {ms_min:.2} \
             | {median:.3} | {least:.3} |\n"
        )
    })
}

/// Returns what the other program took, and the ratios, as JSON.
pub(super) fn as_json(runs: &[Measurement], rivals: &[Rival]) -> Value {
    let all = pairs(runs, rivals).map(|(run, rival)| {
        json!({
            "members": rival.members,
            "slots": rival.slots,
            "device": run.device.to_string(),
            "schedule": run.schedule,
            "load": run.load,
            "ms_median": rival.ms_median,
            "ms_min": rival.ms_min,
            "ratio_median": run.ms_median / rival.ms_median,
            "ratio_min": run.ms_min / rival.ms_min,
        })
    });
    Value::Array(all.collect())
}
