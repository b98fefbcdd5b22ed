//! `populace view`

use std::path::{Path, PathBuf};

use etcetera::BaseStrategy as _;
use populace_viewer::{Closed, Layout, Script, WindowSettings};
use serde_json::json;

use crate::cli::ViewArgs;
use crate::failure::Failure;
use crate::report::{self, message};
use crate::view::CommandLine;

pub(crate) fn run(args: &ViewArgs) -> Result<(), Failure> {
    args.refuse_films()?;
    let script = args.script.as_deref().map(read_script).transpose()?;
    let usual = || layout_file().filter(|_| script.is_none());
    let file = args.layout.clone().or_else(usual);
    let text = file.as_ref().and_then(|file| std::fs::read_to_string(file).ok());
    let settings = WindowSettings {
        layout: Layout::from_toml(&text.unwrap_or_default()),
        size: args.picture.size.map(|size| size.0),
        at_secs: args.picture.film.at.unwrap_or_default(),
        script,
        film: args.film.clone(),
    };
    let closed = populace_viewer::run(Box::new(CommandLine::new(args)), settings)?;
    if let Some(file) = &file {
        remember(file, &closed.layout);
    }
    describe(args, &closed)
}

fn read_script(file: &Path) -> Result<Script, Failure> {
    let text = std::fs::read_to_string(file)
        .map_err(|e| Failure::Input(anyhow::anyhow!("cannot read {}: {e}", file.display())))?;
    Ok(Script::parse(&text, file.parent().unwrap_or(Path::new("")))?)
}

/// Returns the file that holds the layout of windows; `None` if this person has no folder for it.
fn layout_file() -> Option<PathBuf> {
    let folder = etcetera::choose_base_strategy().ok()?.config_dir();
    Some(folder.join("populace").join("viewer.toml"))
}

/// Writes the layout. A folder that cannot be written is no reason to complain.
fn remember(file: &Path, layout: &Layout) {
    if let Some(folder) = file.parent() {
        let _ = std::fs::create_dir_all(folder);
        let _ = std::fs::write(file, layout.to_toml());
    }
}

/// Says how fast the window was.
fn describe(args: &ViewArgs, closed: &Closed) -> Result<(), Failure> {
    let times = &closed.report;
    message!("{} frames, median: {:.1} ms", times.frame_ms.len(), times.median_ms());
    if args.script.is_some() {
        message!("input was shown after at most {} frames", times.most_frames());
    }
    if !args.picture.json {
        return Ok(());
    }
    let inputs: Vec<_> = times
        .inputs
        .iter()
        .map(|input| {
            json!({
                "line": input.line,
                "input": input.words,
                "at": input.at_secs,
                "ms": input.ms,
                "frames": input.frames,
            })
        })
        .collect();
    report::json(&json!({
        "schema": 1,
        "frames": times.frame_ms.len(),
        "ms_median": {"total": times.median_ms()},
        "inputs": inputs,
    }))
}
