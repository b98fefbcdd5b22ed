//! `populace view`

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use etcetera::BaseStrategy as _;
use populace_film::Format;
use populace_viewer::{Closed, Layout, Script, WindowSettings};
use serde_json::json;

use crate::cli::ViewArgs;
use crate::failure::Failure;
use crate::output;
use crate::report::{self, message};
use crate::text_file;
use crate::view::CommandLine;

pub(crate) fn run(args: &ViewArgs) -> Result<(), Failure> {
    args.refuse_films()?;
    let script = args.script.as_deref().map(read_script).transpose()?;
    let usual = || layout_file().filter(|_| script.is_none());
    let file = args.layout.clone().or_else(usual);
    let layout = match &args.layout {
        Some(asked) => read_layout(asked)?,
        None => {
            let text = file.as_ref().and_then(|file| std::fs::read_to_string(file).ok());
            Layout::from_toml(&text.unwrap_or_default())
        }
    };
    if Format::of(&args.film).is_none() {
        return Err(populace_film::Error::UnknownFormat { path: args.film.clone() }.into());
    }
    let settings = WindowSettings {
        layout,
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
    let text = text_file::read(file)
        .map_err(|e| Failure::Input(anyhow::anyhow!("cannot read {}: {e}", file.display())))?;
    Ok(Script::parse(&text, file.parent().unwrap_or(Path::new("")))?)
}

/// Returns the file that holds the layout of windows; `None` if this person has no folder for it.
fn layout_file() -> Option<PathBuf> {
    let folder = etcetera::choose_base_strategy().ok()?.config_dir();
    Some(folder.join("populace").join("viewer.toml"))
}

/// Reads the layout that was asked for, if it exists. The window writes its layout into this file,
/// so that another one, named by mistake, would be lost.
fn read_layout(file: &Path) -> Result<Layout, Failure> {
    let name = file.display();
    let bytes = match std::fs::read(file) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Layout::default()),
        Err(error) => return Err(Failure::Input(anyhow::anyhow!("cannot read {name}: {error}"))),
    };
    let refusal = |fault: String| {
        Failure::Input(anyhow::anyhow!(
            "{name} is no layout of a window, and closing the window would write one over it \
             ({fault}); name another file after --layout, or remove this one"
        ))
    };
    let text = String::from_utf8(bytes).map_err(|_| refusal("it is no text".into()))?;
    Layout::parse(&text).map_err(|error| refusal(error.to_string()))
}

/// Writes the layout, whole or not at all.
fn remember(file: &Path, layout: &Layout) {
    let written = match file.parent().map_or(Ok(()), std::fs::create_dir_all) {
        Ok(()) => output::write(file, layout.to_toml().as_bytes()),
        Err(error) => {
            Err(Failure::Run(anyhow::anyhow!("cannot write {}: {error}", file.display())))
        }
    };
    if let Err(failure) = written {
        message!("warning: the window will not open as it was closed: {failure}");
    }
}

/// Says how fast the window was.
fn describe(args: &ViewArgs, closed: &Closed) -> Result<(), Failure> {
    let times = &closed.report;
    message!("{} frames, median: {:.1} ms", times.frame_ms.len(), times.median_ms());
    if !times.inputs.is_empty() {
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
