//! `populace bench`

use populace::{Devices, Schedule, Split};
use serde_json::json;

use crate::bench::{Run, Scene, measure};
use crate::cli::BenchArgs;
use crate::failure::Failure;
use crate::report;

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let devices = if args.device.is_empty() { all_devices() } else { args.device.clone() };
    if args.split != Split::Measured && devices.iter().all(|d| d.as_slice().len() == 1) {
        return Err(Failure::usage(
            "--split is for several devices; join them by +, as --device native+opencl:0",
        ));
    }
    let scene = Scene::new(args.members, args.joints, args.slots, args.seed)?;
    crate::report::talk!(
        "{} members, {} joints, on {} devices",
        args.members,
        scene.joint_count(),
        devices.len()
    );
    let both = [Schedule::Staged, Schedule::Fused];
    let schedules = if args.schedule.is_empty() { &both[..] } else { &args.schedule };
    let runs = measure(&scene, &devices, &args.split, schedules, args.frames)?;
    let machine = machine();
    if args.json {
        let runs: Vec<_> = runs.iter().map(|r| as_json(r, &scene)).collect();
        report::json(&json!({"schema": 1, "machine": machine, "runs": runs}))?;
    } else {
        report::text(&as_table(&runs, &scene, &machine))?;
    }
    let wrong = runs
        .iter()
        .find_map(|r| r.error_m.filter(|(error, allowed)| error > allowed).map(|e| (&r.device, e)));
    match wrong {
        None => Ok(()),
        Some((device, (error, allowed))) => Err(Failure::Run(anyhow::anyhow!(
            "{device} is wrong: a joint is {error:.6} m from where the oracle puts it; {allowed:.6} m are allowed"
        ))),
    }
}

fn all_devices() -> Vec<Devices> {
    populace::devices().into_iter().filter_map(|report| report.device.map(Devices::from)).collect()
}

fn ns_per_joint(run: &Run, scene: &Scene) -> f64 {
    run.ms_median * 1e6 / scene.joint_count() as f64
}

fn as_json(run: &Run, scene: &Scene) -> serde_json::Value {
    json!({
        "device": run.device.to_string(),
        "schedule": run.schedule,
        "stage": run.stage,
        "load": "plain",
        "members": scene.member_count(),
        "joints": scene.joint_count(),
        "slots": scene.slot_count(),
        "ms_median": run.ms_median,
        "ms_min": run.ms_min,
        "ns_per_joint": ns_per_joint(run, scene),
        "bytes_per_joint": run.bytes_per_joint,
        "memory_bytes": run.memory_bytes,
        "max_error": run.error_m.map(|(error, _)| error),
    })
}

fn as_table(runs: &[Run], scene: &Scene, machine: &str) -> String {
    let mut text = format!(
        "{machine}\n{} members, {} joints, {} clips blended\n\n",
        scene.member_count(),
        scene.joint_count(),
        scene.slot_count()
    );
    text += "| device | schedule | stage | ms, median | ms, least | ns per joint | MiB on the device | worst error, mm |\n";
    text += "|---|---|---|---|---|---|---|---|\n";
    for run in runs {
        let error = run.error_m.map_or(String::new(), |(error, _)| format!("{:.3}", error * 1e3));
        text += &format!(
            "| {} | {} | {} | {:.2} | {:.2} | {:.1} | {} | {error} |\n",
            run.device,
            run.schedule,
            run.stage,
            run.ms_median,
            run.ms_min,
            ns_per_joint(run, scene),
            run.memory_bytes >> 20,
        );
    }
    text
}

/// The processor by name, where the system tells it, and its threads.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or("unknown processor", |(_, name)| name.trim());
    format!("{model}, {threads} threads, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}
