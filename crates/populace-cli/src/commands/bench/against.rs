//! `populace bench --against`: another program evaluates the same crowd, in turn.

use std::io::{self, BufRead, BufReader, BufWriter, Lines, Write};
use std::num::NonZero;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, anyhow};
use populace::model::Affine;
use populace_bench::{Load, Measurement, Method, Scene};
use serde_json::{Value, json};

use crate::failure::Failure;

const HEAD: &str = "
| members | device | schedule | load | against, ms, median | ms, least | worst error, mm \
| ratio of medians | least |
|--:|---|---|---|--:|--:|--:|--:|--:|
";

/// The other program while it runs: it evaluates a frame for each empty line, and answers the index
/// of a member with its palette.
pub(super) struct Against {
    child: Child,
    input: ChildStdin,
    output: Lines<BufReader<ChildStdout>>,
    scene: Scene,
    /// Frames since the start.
    frames: u32,
    /// Milliseconds of the measured frames.
    times: anyhow::Result<Vec<f64>>,
}

/// What the other program took for a crowd.
pub(super) struct Rival {
    members: usize,
    slots: usize,
    ms_median: f64,
    ms_min: f64,
    error_m: f64,
}

impl Against {
    /// Starts the program for the crowd of a scene, which it reads from its input.
    pub(super) fn start(program: &Path, scene: &Scene) -> Result<Self, Failure> {
        let wrong = |e: anyhow::Error| Failure::Input(e.context(program.display().to_string()));
        let path = program.canonicalize().map_err(|e| wrong(e.into()))?;
        let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
        let mut child = Command::new(path)
            .arg(threads.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| wrong(e.into()))?;
        let pipes = child.stdin.take().zip(child.stdout.take());
        let (input, output) = pipes.ok_or_else(|| wrong(anyhow!("it has no pipes")))?;
        let mut started = Self {
            child,
            input,
            output: BufReader::new(output).lines(),
            scene: scene.clone(),
            frames: 0,
            times: Ok(Vec::new()),
        };
        let said = started.send(|input| scene.write_text(input)).map_err(wrong)?;
        if said == "ready" {
            Ok(started)
        } else {
            Err(wrong(anyhow!("it answered the scene with {said:?} and not with \"ready\"")))
        }
    }

    /// Writes to the program, and returns the line that it answers.
    fn send(
        &mut self,
        write: impl FnOnce(&mut BufWriter<&mut ChildStdin>) -> io::Result<()>,
    ) -> anyhow::Result<String> {
        let mut input = BufWriter::new(&mut self.input);
        write(&mut input).and_then(|()| input.flush()).map_err(|error| match error.kind() {
            io::ErrorKind::BrokenPipe => anyhow!("it ended early"),
            _ => error.into(),
        })?;
        Ok(self.output.next().context("it ended early")??)
    }

    /// Lets the program evaluate a frame.
    pub(super) fn frame(&mut self, is_measured: bool) {
        let took = self.timed();
        self.frames += 1;
        match (took, &mut self.times) {
            (Ok(ms), Ok(times)) if is_measured => times.push(ms),
            (Err(error), times @ Ok(_)) => *times = Err(error),
            _ => {}
        }
    }

    fn timed(&mut self) -> anyhow::Result<f64> {
        let said = self.send(|input| writeln!(input))?;
        let ms = said.parse::<f64>().ok().filter(|ms| ms.is_finite() && *ms > 0.0);
        ms.with_context(|| format!("it said {said:?} and not the milliseconds of a frame"))
    }

    /// Ends the program, and returns what it took and how far its last frame is wrong; `None` if no
    /// crowd was measured beside it.
    pub(super) fn finish(mut self) -> Result<Option<Rival>, Failure> {
        let failed = |e: anyhow::Error| Failure::Run(e.context("the program of --against"));
        let mut times = std::mem::replace(&mut self.times, Ok(Vec::new())).map_err(failed)?;
        times.sort_by(f64::total_cmp);
        let at = |nth: usize| times.get(nth).copied();
        let Some((ms_median, ms_min)) = at(times.len() / 2).zip(at(0)) else {
            return Ok(None);
        };
        let (scene, frames) = (self.scene.clone(), self.frames);
        let error_m = scene.error_of(frames, |member| self.palette(member)).map_err(failed)?;
        if !error_m.is_finite() {
            let wrong = "its palettes have another size than those of the crowd, or numbers that \
                         are not finite";
            return Err(failed(anyhow!(wrong)));
        }
        let [members, slots] = [scene.member_count(), scene.slot_count()];
        Ok(Some(Rival { members, slots, ms_median, ms_min, error_m }))
    }

    fn palette(&mut self, member: usize) -> anyhow::Result<Vec<Affine>> {
        let said = self.send(|input| writeln!(input, "{member}"))?;
        let numbers: Result<Vec<f32>, _> = said.split_whitespace().map(str::parse).collect();
        let numbers = numbers.with_context(|| format!("its palette of member {member}"))?;
        let (rows, rest) = numbers.as_chunks::<4>();
        let (matrices, more) = rows.as_chunks::<3>();
        anyhow::ensure!(
            rest.is_empty() && more.is_empty(),
            "its palette of member {member} has {} numbers, which are no 3x4 matrices",
            numbers.len()
        );
        Ok(matrices.iter().map(|&rows| Affine { rows }).collect())
    }
}

impl Drop for Against {
    fn drop(&mut self) {
        // It may wait for its output to be read, and has nothing more to say.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns whole frames of plain crowds, each with what the other program took for as many members.
fn pairs<'a>(
    runs: &'a [Measurement],
    rivals: &'a [Rival],
) -> impl Iterator<Item = (&'a Measurement, &'a Rival)> {
    let is_plain = |run: &&Measurement| run.load == Load::Plain.to_string();
    let whole = |run: &&Measurement| {
        run.stage == "all" && !["floor", Method::Baked.name()].contains(&run.schedule.as_str())
    };
    let with_rival = |run: &'a Measurement| {
        Some((run, rivals.iter().find(|rival| rival.members == run.members)?))
    };
    runs.iter().filter(is_plain).filter(whole).filter_map(with_rival)
}

/// Formats a Markdown table of the ratios.
pub(super) fn table(runs: &[Measurement], rivals: &[Rival]) -> String {
    pairs(runs, rivals).fold(HEAD.to_owned(), |text, (run, rival)| {
        let Rival { members, ms_median, ms_min, error_m, .. } = rival;
        let (device, schedule, load) = (&run.device, &run.schedule, &run.load);
        let [median, least] = [run.ms_median / ms_median, run.ms_min / ms_min];
        text + &format!(
            "| {members} | {device} | {schedule} | {load} | {ms_median:.2} | {ms_min:.2} \
             | {:.3} | {median:.3} | {least:.3} |\n",
            error_m * 1e3
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
            "error_m": rival.error_m,
            "ratio_median": run.ms_median / rival.ms_median,
            "ratio_min": run.ms_min / rival.ms_min,
        })
    });
    Value::Array(all.collect())
}
