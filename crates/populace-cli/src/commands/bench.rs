//! `populace bench`

use std::path::Path;

use populace::{Devices, Schedule, Split};
use serde_json::Value;

use crate::bench::{
    DeviceSetup, Document, Load, Measurement, Method, Scene, SceneSettings, Subject, as_svg,
    as_table, measure,
};
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
    let wrong = |reason: String| Failure::Input(anyhow::anyhow!("{}: {reason}", file.display()));
    let text = crate::input::read_text(file).map_err(wrong)?;
    let json: Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    Document::from_json(&json).map_err(wrong)
}

fn measure_all(args: &BenchArgs) -> Result<Vec<Measurement>, Failure> {
    let settings =
        SceneSettings { joints: args.joints, slots: args.slots as usize, seed: args.seed };
    let scenes = loads(args).into_iter().map(|load| Scene::new(settings, load));
    let scenes = scenes.collect::<Result<Vec<_>, _>>()?;
    let setups = setups(args)?;
    let mut runs = Vec::new();
    for &members in &args.members {
        let scenes: Vec<_> =
            scenes.iter().map(|scene| scene.with_members(members as usize)).collect();
        let subjects = subjects(&scenes, &setups, args);
        if subjects.is_empty() {
            return Err(Failure::usage(
                "baked is measured on the native device only; add --device native",
            ));
        }
        report::message!("{members} members, {} subjects to measure", subjects.len());
        runs.extend(measure(subjects, args.frames)?);
    }
    if runs.is_empty() {
        return Err(Failure::Run(anyhow::anyhow!(
            "all subjects were skipped; measure smaller crowds"
        )));
    }
    Ok(runs)
}

fn check(run: &Measurement) -> Result<(), Failure> {
    match (run.error_m, run.allowed_m) {
        (Some(error), Some(allowed)) if error.is_nan() || error > allowed => {
            Err(Failure::Run(anyhow::anyhow!(
                "{} ({}, {}) is wrong: a joint is {error:.6} m away from the oracle's result, and \
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

/// Returns all subjects, with the loads of each schedule side by side.
fn subjects<'a>(
    scenes: &'a [Scene],
    setups: &'a [DeviceSetup],
    args: &BenchArgs,
) -> Vec<Subject<'a>> {
    let defaults = [Method::Crowd(Schedule::Staged), Method::Crowd(Schedule::Fused), Method::Baked];
    let methods = if args.schedule.is_empty() { &defaults[..] } else { &args.schedule };
    let mut subjects = Vec::new();
    for on in setups {
        for &method in methods {
            let measured = |scene: &&Scene| match method {
                Method::Crowd(_) => true,
                Method::Baked => scene.load == Load::Plain && on.is_native() && !on.is_shared(),
            };
            let scenes = scenes.iter().filter(measured);
            subjects.extend(scenes.map(|scene| Subject { scene, on, method }));
        }
    }
    subjects
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

/// Describes the processor by its name, if the system reports it, and its threads.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or("unknown processor", |(_, name)| name.trim());
    format!("{model}, {threads} threads, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}
