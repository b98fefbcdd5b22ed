//! `populace bench`

mod against;
mod skate;

use std::path::Path;
use std::sync::Arc;

use populace::{Crowd, Devices, Schedule, Split};
use populace_bench::{
    DeviceSetup, Document, Load, Measurement, Method, Observer, Scene, SceneSettings, Subject,
    machine, measure,
};
use serde_json::{Value, json};

use crate::built_in;
use crate::cli::BenchArgs;
use crate::crowd_renderer::devices_and_shares;
use crate::failure::Failure;
use crate::output::{self, check_inputs, check_kind, check_writable};
use crate::progress::Progress;
use crate::report;
use crate::roles;
use crate::text_file;
use against::{Against, Rival};

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    if args.skate {
        return skate::run(args);
    }
    if let Some(chart) = &args.chart {
        check_kind(chart, "svg")?;
        let inputs: Vec<_> = args.from.iter().chain(&args.files).cloned().collect();
        check_inputs(std::iter::once(chart.clone()), &inputs)?;
        check_writable(chart)?;
    }
    let (document, rivals) = match &args.from {
        Some(file) => (read(file)?, Vec::new()),
        None => {
            let (runs, rivals) = measure_all(args)?;
            (Document { machine: machine(), runs }, rivals)
        }
    };
    if let Some(chart) = &args.chart {
        output::write(chart, document.as_svg().as_bytes())?;
    }
    if args.json {
        let more = json!({"against": against::as_json(&document.runs, &rivals)});
        let more = if rivals.is_empty() { json!({}) } else { more };
        report::json(&report::with_fields(document.as_json(), more))?;
    } else {
        report::text(&document.as_table())?;
        if !rivals.is_empty() {
            report::text(&against::table(&document.runs, &rivals))?;
        }
    }
    document.runs.iter().try_for_each(check)
}

fn read(file: &Path) -> Result<Document, Failure> {
    let wrong = |reason: String| Failure::Input(anyhow::anyhow!("{}: {reason}", file.display()));
    let text = text_file::read(file).map_err(wrong)?;
    let json: Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    Document::from_json(&json).map_err(wrong)
}

/// Returns a scene without members for each load: of given characters, or of random ones.
fn scenes(args: &BenchArgs) -> Result<Vec<Scene>, Failure> {
    let (slots, seed) = (args.slots as usize, args.seed);
    let loads = loads(args).into_iter();
    if args.files.is_empty() {
        let settings = SceneSettings { joints: args.joints, slots, seed };
        return Ok(loads.map(|load| Scene::new(settings, load)).collect::<Result<_, _>>()?);
    }
    let (mut characters, mut loader) = (Vec::new(), roles::Loader::new(&args.input));
    for file in &args.files {
        match built_in::name_of(file) {
            Some(name) => characters.extend(built_in::people(name)?),
            None => characters.push(Arc::new(loader.load(file)?)),
        }
    }
    loads
        .map(|load| Scene::of_characters(characters.clone(), slots, seed, load))
        .collect::<Result<_, _>>()
        .map_err(|reason| Failure::Input(anyhow::anyhow!(reason)))
}

/// Measures crowds, and what the program of `--against` takes for them.
fn measure_all(args: &BenchArgs) -> Result<(Vec<Measurement>, Vec<Rival>), Failure> {
    let scenes = scenes(args)?;
    let setups = setups(args)?;
    let defaults = [Method::Crowd(Schedule::Staged), Method::Crowd(Schedule::Fused), Method::Baked];
    let methods = if args.schedule.is_empty() { &defaults[..] } else { &args.schedule };
    let (mut runs, mut rivals, mut report) = (Vec::new(), Vec::new(), Report::default());
    for &members in &args.members {
        let scenes: Vec<_> =
            scenes.iter().map(|scene| scene.with_members(members as usize)).collect();
        let subjects = Subject::all(&scenes, &setups, methods);
        if subjects.is_empty() {
            return Err(Failure::usage(
                "baked is measured on the native device only; add --device native",
            ));
        }
        let crowd = scenes.first().map_or(String::new(), Scene::crowd);
        report::message!("{crowd}; subjects to measure: {}", subjects.len());
        let rival = args.against.as_deref().zip(scenes.first());
        let rival = rival.map(|(program, plain)| Against::start(program, plain));
        report.against = rival.transpose()?;
        runs.extend(measure(subjects, args.frames, &mut report)?);
        rivals.extend(report.against.take().map(Against::finish).transpose()?.flatten());
    }
    if runs.is_empty() {
        return Err(Failure::Run(anyhow::anyhow!(
            "all subjects were skipped; measure smaller crowds"
        )));
    }
    Ok((runs, rivals))
}

fn check(run: &Measurement) -> Result<(), Failure> {
    run.fault().map_or(Ok(()), |fault| Err(Failure::Run(anyhow::anyhow!(fault))))
}

/// Shows a benchmark's progress and messages on the terminal, and lets another program take its
/// turns.
#[derive(Default)]
struct Report {
    progress: Option<Progress>,
    against: Option<Against>,
}

impl Observer for Report {
    fn drivers_started(&mut self) {
        #[cfg(unix)]
        crate::aborts::exit_on_abort();
    }

    fn work_started(&mut self, label: &'static str, steps: usize) {
        self.progress = Some(Progress::new(label, steps));
    }

    fn step_done(&mut self) {
        self.progress.iter_mut().for_each(Progress::step);
    }

    fn frame_done(&mut self, is_measured: bool) {
        self.against.iter_mut().for_each(|against| against.frame(is_measured));
    }

    fn work_done(&mut self) {
        self.progress = None;
    }

    fn skipped(&mut self, subject: &str, reason: &str) {
        report::message!("skipped: {subject}: {reason}");
    }

    fn crowd_measured(&mut self, crowd: &Crowd) {
        if crowd.device_info().devices.as_slice().len() > 1 {
            let (shares, schedule) = (devices_and_shares(crowd), crowd.device_info().schedule);
            report::message!("final shares: {shares} ({schedule})");
        }
    }
}

fn loads(args: &BenchArgs) -> Vec<Load> {
    let retargeted = args.retarget.then_some(Load::Retargeted);
    let changing = args.changing.map(|percent| Load::Changing { percent });
    let mut loads: Vec<Load> =
        [Some(Load::Plain), retargeted, changing].into_iter().flatten().collect();
    loads.extend(args.load.iter().copied().filter(|load| *load != Load::Plain));
    loads.dedup();
    loads
}

/// Returns the devices to measure on, and how several share a crowd.
fn setups(args: &BenchArgs) -> Result<Vec<DeviceSetup>, Failure> {
    let devices = if args.device.is_empty() { all_devices() } else { args.device.clone() };
    let setup = |devices: Devices| {
        let split = if devices.as_slice().len() > 1 { args.split.clone() } else { Split::Measured };
        DeviceSetup { devices, split }
    };
    let setups: Vec<_> = devices.into_iter().map(setup).collect();
    if args.split != Split::Measured && !setups.iter().any(DeviceSetup::is_shared) {
        return Err(Failure::usage(
            "--split needs several devices; join them by +, for example --device native+opencl:0",
        ));
    }
    Ok(setups)
}

fn all_devices() -> Vec<Devices> {
    populace::devices().into_iter().filter_map(|report| report.device.map(Devices::from)).collect()
}
