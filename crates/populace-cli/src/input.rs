//! Input files, and the limits on what they refer to and how much memory they take.

use std::io::BufRead;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use populace::character::{Character, CharacterSource};
use populace_assets::{Imported, LoadOptions, WriteOptions};

use crate::built_in;
use crate::failure::Failure;

/// Added to the refusal of anything else than glTF on standard input.
const OTHERS_BY_PATH: &str = "; trajectory files and scenes are read by their path";

/// Limits for input files.
#[derive(Args, Clone, Debug)]
pub(crate) struct InputArgs {
    /// Allow files to refer to buffers and images outside their own folder
    #[arg(long)]
    allow_outside: bool,
    /// Refuse files that would take more than this much memory to load, in MiB
    #[arg(
        long,
        value_name = "MIB",
        default_value_t = 1024,
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    memory_limit: u32,
    #[arg(skip)]
    stdin_is_read: Arc<AtomicBool>,
}

impl InputArgs {
    /// Loads a glTF file or a built-in person, such as `@man`; `-` is standard input.
    pub(crate) fn load(&self, file: &Path) -> Result<Imported, Failure> {
        let options = LoadOptions {
            allow_outside: self.allow_outside,
            memory_limit_bytes: u64::from(self.memory_limit) << 20,
        };
        if let Some(name) = built_in::name_of(file) {
            return built_in_person(name, &options);
        }
        if file != Path::new("-") {
            return Ok(populace_assets::load_with(file, &options)?);
        }
        if self.stdin_is_read.swap(true, Ordering::Relaxed) {
            return Err(Failure::usage("- is given twice; standard input can be read only once"));
        }
        let mut stdin = std::io::stdin().lock();
        let head = stdin.fill_buf().unwrap_or_default().trim_ascii_start();
        let is_other = !(head.is_empty() || head.starts_with(b"glTF") || head.starts_with(b"{"));
        let loaded = populace_assets::load_from_reader(stdin, "standard input", &options);
        loaded.map_err(|error| {
            let hint = if is_other { OTHERS_BY_PATH } else { "" };
            Failure::Input(anyhow::anyhow!("{error}{hint}"))
        })
    }
}

/// Returns a built-in person as it would be loaded from a file, with its clips.
fn built_in_person(name: &str, options: &LoadOptions) -> Result<Imported, Failure> {
    let person = built_in::person_of(name)?;
    let file = populace_assets::to_glb(&person, &WriteOptions::default())?;
    let imported = populace_assets::load_from_reader(&file[..], &format!("@{name}"), options)?;
    let clips = person.clips.clone();
    let source = CharacterSource { clips, ..CharacterSource::clone(&imported.character) };
    let character = Character::new(source).map_err(|e| Failure::Run(e.into()))?;
    Ok(Imported { character, ..imported })
}
