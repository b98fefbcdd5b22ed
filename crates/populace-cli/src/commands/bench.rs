//! `populace bench`

use std::path::Path;

use populace::{Devices, Schedule, Split};
use serde_json::Value;

use crate::bench::{Document, Load, Run, Scene, Setup, Subject, Way, as_svg, as_table, measure};
use crate::cli::BenchArgs;
use crate::failure::Failure;
use crate::output::{self, check_inputs, check_kind, check_writable};
use crate::report;

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    if let Some(chart) = &args.chart {
        check_kind(chart, "svg")?;
        check_inputs(std::iter::once(chart.clone()), args.from.as_slice())?;
        check_writable(chart)?;
    }
    let document = match &args.from {
        Some(file) => read(file)?,
        None => Document { machine: machine(), runs: measure_all(args)? },
    };
    if let Some(chart) = &args.chart {
        output::write(chart, as_svg(&document).as_bytes())?;
    }
    if args.json {
        report::json(&document.as_json())?;
    } else {
        report::text(&as_table(&document))?;
    }
    document.runs.iter().try_for_each(check)
}

fn read(file: &Path) -> Result<Document, Failure> {
    let wrong = |why: String| Failure::Input(anyhow::anyhow!("{}: {why}", file.display()));
    let text = crate::input::read_text(file).map_err(wrong)?;
    let json: Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    Document::from_json(&json).map_err(wrong)
}

fn measure_all(args: &BenchArgs) -> Result<Vec<Run>, Failure> {
    let scenes = loads(args).into_iter().map(|load| Scene::new(args, load));
    let scenes = scenes.collect::<Result<Vec<_>, _>>()?;
    let setups = setups(args)?;
    let mut runs = Vec::new();
    for &members in &args.members {
        let scenes: Vec<_> =
            scenes.iter().map(|scene| scene.with_members(members as usize)).collect();
        let subjects = subjects(&scenes, &setups, args);
        if subjects.is_empty() {
            return Err(Failure::usage("baked is measured on the native device alone"));
        }
        report::talk!("{members} members, {} ways to measure", subjects.len());
        runs.extend(measure(subjects, args.frames)?);
    }
    if runs.is_empty() {
        return Err(Failure::Run(anyhow::anyhow!("nothing was left to measure")));
    }
    Ok(runs)
}

fn check(run: &Run) -> Result<(), Failure> {
    match (run.error_m, run.allowed_m) {
        (Some(error), Some(allowed)) if error.is_nan() || error > allowed => {
            Err(Failure::Run(anyhow::anyhow!(
                "{} ({}, {}) is wrong: a joint is {error:.6} m from where the oracle puts it; \
                 {allowed:.6} m are allowed",
                run.device,
                run.schedule,
                run.load
            )))
        }
        _ => Ok(()),
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

/// Everything to measure; the loads of one schedule stand side by side.
fn subjects<'a>(scenes: &'a [Scene], setups: &'a [Setup], args: &BenchArgs) -> Vec<Subject<'a>> {
    let usual = [Way::Crowd(Schedule::Staged), Way::Crowd(Schedule::Fused), Way::Baked];
    let ways = if args.schedule.is_empty() { &usual[..] } else { &args.schedule };
    let mut subjects = Vec::new();
    for on in setups {
        for &way in ways {
            let measured = |scene: &&Scene| match way {
                Way::Crowd(_) => true,
                Way::Baked => scene.load == Load::Plain && on.is_native() && !on.is_shared(),
            };
            subjects.extend(scenes.iter().filter(measured).map(|scene| Subject { scene, on, way }));
        }
    }
    subjects
}

/// The devices to measure on, with how several share a crowd.
fn setups(args: &BenchArgs) -> Result<Vec<Setup>, Failure> {
    let devices = if args.device.is_empty() { all_devices() } else { args.device.clone() };
    let setup = |devices: Devices| {
        let split = if devices.as_slice().len() > 1 { args.split.clone() } else { Split::Measured };
        Setup { devices, split }
    };
    let setups: Vec<_> = devices.into_iter().map(setup).collect();
    if args.split != Split::Measured && !setups.iter().any(Setup::is_shared) {
        return Err(Failure::usage(
            "--split is for several devices; join them by +, as --device native+opencl:0",
        ));
    }
    Ok(setups)
}

fn all_devices() -> Vec<Devices> {
    populace::devices().into_iter().filter_map(|report| report.device.map(Devices::from)).collect()
}

/// The processor by name, where the system tells it, and its threads.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or("unknown processor", |(_, name)| name.trim());
    format!("{model}, {threads} threads, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}
