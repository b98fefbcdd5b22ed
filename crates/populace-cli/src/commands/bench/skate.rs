//! `populace bench --skate`

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::anyhow;
use populace::character::Character;
use populace::clip::Clip;
use populace_bench::SkateDocument;
use populace_locomotion::GaitClips;

use crate::built_in;
use crate::cli::BenchArgs;
use crate::failure::Failure;
use crate::legs::on_legs;
use crate::progress::Progress;
use crate::report::{self, message};
use crate::roles;

/// A character and the name under which it is reported.
struct Walker {
    name: String,
    character: Arc<Character>,
    /// True for a person made by code, who is measured with clips of their own alone.
    built_in: bool,
}

pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let (walkers, shared) = load(args)?;
    let mut document = SkateDocument::default();
    let mut progress = Progress::new("characters", walkers.len());
    for walker in &walkers {
        measure(&mut document, walker, &shared)?;
        progress.step();
    }
    drop(progress);
    if args.json { report::json(&document.as_json()) } else { report::text(&document.as_table()) }
}

/// Returns the characters, and the clips of files without meshes.
fn load(args: &BenchArgs) -> Result<(Vec<Walker>, Vec<Arc<Clip>>), Failure> {
    let people = [PathBuf::from("@people")];
    let files = if args.files.is_empty() { &people[..] } else { &args.files };
    let (mut walkers, mut shared) = (Vec::new(), Vec::new());
    let mut loader = roles::Loader::new(&args.input);
    for file in files {
        if let Some(name) = built_in::name_of(file) {
            for look in built_in::people(name)? {
                walkers.push(Walker { name: look.name.clone(), character: look, built_in: true });
            }
            continue;
        }
        let character = loader.load(file)?;
        if character.parts.is_empty() {
            shared.extend(character.clips.iter().cloned());
            continue;
        }
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        let character = Arc::new(on_legs(character, file)?);
        walkers.push(Walker { name, character, built_in: false });
    }
    if walkers.is_empty() {
        return Err(Failure::usage("no file has a mesh to walk with; add one of a character"));
    }
    Ok((walkers, shared))
}

/// Measures a character with clips of its own and of files without meshes, and with those of the
/// built-in people.
fn measure(
    document: &mut SkateDocument,
    walker: &Walker,
    shared: &[Arc<Clip>],
) -> Result<(), Failure> {
    let Walker { name, character, built_in } = walker;
    let failed = |e: populace_locomotion::Error| Failure::Run(anyhow!("{name}: {e}"));
    let own: Vec<_> = character.clips.iter().chain(shared).cloned().collect();
    match GaitClips::among(character, &own) {
        Some(clips) => document.add(name, character, &clips, false).map_err(failed)?,
        None => message!("{name} has no clips that stand and walk; it walks with retargeted ones"),
    }
    if *built_in {
        return Ok(());
    }
    let clips = GaitClips::among(character, &built_in::clips("people")?);
    let clips = clips.ok_or_else(|| {
        Failure::Run(anyhow!("{name} does not walk with the clips of the built-in people"))
    })?;
    document.add(name, character, &clips, true).map_err(failed)
}
