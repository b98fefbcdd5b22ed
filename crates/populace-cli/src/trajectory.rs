//! Trajectory files among the inputs: how they are told apart and read, and words about them.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use populace_trajectory::{
    Error, Fact, Format, HeadingSource, Kind, Origin, ReadSettings, Recording, Source, Unit,
    Warning,
};

use crate::doubts::doubts;
use crate::failure::Failure;
use crate::report::counted;

/// Bytes by which a glTF file is told from others.
const HEAD_BYTES: u64 = 4096;
/// The other inputs of the program, for the refusal of unknown files.
const OTHER_INPUTS: &str = "characters are glTF files (.glb, .gltf, .vrm), and scenes end in .toml";
/// Words behind a fact that an option said.
const TOLD: &str = " (as told)";
/// Words behind headings whose angles have no unit.
const GUESSED_ANGLES: &str = " (radians or degrees by their size)";

/// Options for reading trajectory files.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub(crate) struct ReadArgs {
    /// Format of the trajectory file [default: recognised by its content]
    #[arg(long, value_name = "NAME", help_heading = "Trajectory files")]
    format: Option<Format>,
    /// Unit of its positions, or the metres in one, such as 0.02 for pixels of 2 cm [default: that
    /// of the file or format, or assumed]
    #[arg(long, value_name = "m|cm|mm|ft|N", help_heading = "Trajectory files")]
    unit: Option<Unit>,
    /// Frames per second by which it counts [default: those of the file, or assumed]
    #[arg(
        long,
        value_name = "N",
        value_parser = data_rate,
        help_heading = "Trajectory files"
    )]
    data_fps: Option<f64>,
    /// Headings of people: data takes those of the file, motion the way they go [default: data
    /// where the file has some]
    #[arg(long, value_name = "data|motion", help_heading = "Trajectory files")]
    heading: Option<HeadingSource>,
    /// File with the walkable area as WKT [default: in the trajectory file, or beside it]
    #[arg(long, value_name = "FILE", help_heading = "Trajectory files")]
    pub(crate) geometry: Option<PathBuf>,
    /// Refuse trajectory files with faults that have a sensible reading
    #[arg(long, help_heading = "Trajectory files")]
    strict: bool,
}

impl ReadArgs {
    /// Reads a trajectory file, and adds what looks wrong in it to its warnings.
    pub(crate) fn load(&self, file: &Path) -> Result<Recording, Failure> {
        let read = populace_trajectory::load(file, &self.settings());
        let mut recording = read.map_err(|error| match error {
            Error::Unknown { .. } => Failure::Input(anyhow::anyhow!("{error}; {OTHER_INPUTS}")),
            error => error.into(),
        })?;
        // All commands see the place that can be drawn.
        let (place, left_out) = populace_scene::PlaceModel::buildable(&recording.place);
        recording.place = place;
        let left_out = left_out.iter().map(ToString::to_string);
        let doubts =
            left_out.chain(doubts(&recording)).map(|text| Warning { text, rows: 0, first: None });
        recording.warnings.extend(doubts);
        match recording.warnings.first() {
            Some(warning) if self.strict => {
                Err(Error::Strict { path: file.to_owned(), warning: warning.clone() }.into())
            }
            _ => Ok(recording),
        }
    }

    /// Refuses these options if any was given. For commands without a trajectory file.
    pub(crate) fn refuse_unused(&self) -> Result<(), Failure> {
        if *self == Self::default() {
            return Ok(());
        }
        Err(Failure::usage(
            "--format, --unit, --data-fps, --heading, --geometry and --strict need a trajectory \
             file",
        ))
    }

    fn settings(&self) -> ReadSettings {
        ReadSettings {
            format: self.format,
            unit: self.unit,
            fps: self.data_fps,
            heading: self.heading,
            geometry: self.geometry.clone(),
            strict: self.strict,
        }
    }
}

/// Parses the frame rate of a file.
fn data_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if (0.001..=1000.0).contains(&rate) => Ok(rate),
        _ => Err("write a number from 0.001 to 1000".into()),
    }
}

/// Returns true for an input that is neither a built-in person, a folder, standard input nor a glTF
/// file: it must be a trajectory file. A path that does not exist would be one if it has another
/// extension than glTF files.
pub(crate) fn is_trajectory(input: &Path) -> bool {
    let extension = input.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let is_gltf = ["glb", "gltf", "vrm"].iter().any(|known| extension.eq_ignore_ascii_case(known));
    let is_named = input.to_str().is_some_and(|name| name.starts_with('@') || name == "-");
    if is_gltf || is_named {
        return false;
    }
    if !input.is_file() {
        return !input.exists() && !extension.is_empty();
    }
    let mut head = Vec::new();
    let read = File::open(input).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head));
    let holds = |word: &[u8]| head.windows(word.len()).any(|bytes| bytes == word);
    read.is_ok() && !head.starts_with(b"glTF") && !(head.starts_with(b"{") && holds(b"\"asset\""))
}

/// Returns one line about a recording: format, agents, length, and how it was read.
pub(crate) fn headline(recording: &Recording) -> String {
    let [from, until] = recording.secs();
    format!(
        "{}: {}, {:.1} s, {}",
        format_of(&recording.source),
        people(recording),
        until - from,
        reading(recording)
    )
}

/// Returns the format with its version.
pub(crate) fn format_of(source: &Source) -> String {
    match source.version.as_str() {
        "" => source.format.to_string(),
        version => format!("{}, {version}", source.format),
    }
}

/// Returns the number of people, and of vehicles if there are any.
pub(crate) fn people(recording: &Recording) -> String {
    let vehicles = vehicles(recording);
    let people = match recording.agents.len() - vehicles {
        1 => "1 person".to_owned(),
        people => format!("{people} people"),
    };
    match vehicles {
        0 => people,
        _ => format!("{people} and {}", counted(vehicles, "vehicle")),
    }
}

/// Returns the number of vehicles.
pub(crate) fn vehicles(recording: &Recording) -> usize {
    recording.agents.iter().filter(|agent| agent.kind == Kind::Vehicle).count()
}

/// Returns rate, unit and headings, with what was told or assumed. A file without headings needs no
/// assumption.
pub(crate) fn reading(recording: &Recording) -> String {
    let source = &recording.source;
    let [rows, frames] = [recording.rows_per_sec(), source.fps.value].map(rate);
    let plural = |rate: &str| if rate == "1" { "" } else { "s" };
    let frames = if rows == frames {
        String::new()
    } else {
        format!(", {frames} frame{} a second", plural(&frames))
    };
    format!(
        "{rows} row{} a second{frames}{}, positions in {}{}, headings from {}{}",
        plural(&rows),
        origin(source.fps),
        source.unit.value,
        origin(source.unit),
        source.heading.value,
        match source.heading {
            Fact { origin: Origin::Settings, .. } => TOLD,
            Fact { value: HeadingSource::Data, origin: Origin::Assumed } => GUESSED_ANGLES,
            _ => "",
        },
    )
}

/// Returns a rate with at most four decimals.
pub(crate) fn rate(per_sec: f64) -> String {
    let text = format!("{per_sec:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn origin<T>(fact: Fact<T>) -> &'static str {
    match fact.origin {
        Origin::File => "",
        Origin::Settings => TOLD,
        Origin::Assumed => " (assumed)",
    }
}
