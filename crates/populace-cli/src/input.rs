//! Files that are read: what they may refer to, and how much memory they may take.

use std::cell::Cell;
use std::io::Read;
use std::path::Path;

use clap::Args;
use populace_assets::{Imported, LoadOptions};

use crate::failure::Failure;

/// Bytes of a text file that are read at most.
const TEXT_BYTES: u64 = 64 << 20;

/// What files may refer to, and how much memory they may take.
#[derive(Args, Clone, Debug)]
pub(crate) struct InputArgs {
    /// Also read buffers and images that lie outside the folder of the file that names them
    #[arg(long)]
    allow_outside: bool,
    /// Memory that loading one file may take, in MiB; a file that would take more is refused
    #[arg(long, value_name = "MIB", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
    memory_limit: u32,
    #[arg(skip)]
    stdin_is_read: Cell<bool>,
}

impl InputArgs {
    /// Loads a glTF file; `-` is standard input.
    pub(crate) fn load(&self, file: &Path) -> Result<Imported, Failure> {
        let options = LoadOptions {
            allow_outside: self.allow_outside,
            memory_limit_bytes: u64::from(self.memory_limit) << 20,
        };
        if file != Path::new("-") {
            return Ok(populace_assets::load_with(file, &options)?);
        }
        if self.stdin_is_read.replace(true) {
            return Err(Failure::usage("- can be named once; standard input holds one file"));
        }
        Ok(populace_assets::load_from_reader(std::io::stdin().lock(), "standard input", &options)?)
    }
}

/// Reads a text file that is a regular file and not too long.
pub(crate) fn read_text(file: &Path) -> Result<String, String> {
    let failed = |e: std::io::Error| e.to_string();
    // Opening a pipe would already wait.
    if !std::fs::metadata(file).map_err(failed)?.is_file() {
        return Err("it is not a regular file".into());
    }
    let mut text = String::new();
    let opened = std::fs::File::open(file).map_err(failed)?;
    opened.take(TEXT_BYTES + 1).read_to_string(&mut text).map_err(failed)?;
    if text.len() as u64 > TEXT_BYTES {
        return Err(format!("it is longer than {} MiB", TEXT_BYTES >> 20));
    }
    Ok(text)
}
