//! Trajectory files among the inputs, and the films that they fill.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use populace_film::FrameRate;
use populace_trajectory::{ReadSettings, Recording};

use crate::cli::{MOST_FRAMES, TrajectoryArgs};
use crate::failure::Failure;

/// Frames per second of a film, if none are given.
const DEFAULT_FPS: u32 = 25;
/// Bytes by which a glTF file is told from others.
const HEAD_BYTES: u64 = 4096;

/// Returns true for an input that is neither a built-in person, a folder, standard input nor a glTF
/// file: it must be a trajectory file.
pub(crate) fn is_trajectory(input: &Path) -> bool {
    let extension = input.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let is_gltf = ["glb", "gltf", "vrm"].iter().any(|known| extension.eq_ignore_ascii_case(known));
    let is_named = input.to_str().is_some_and(|name| name.starts_with('@') || name == "-");
    if is_gltf || is_named || !input.is_file() {
        return false;
    }
    let mut head = Vec::new();
    let read = File::open(input).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head));
    let holds = |word: &[u8]| head.windows(word.len()).any(|bytes| bytes == word);
    read.is_ok() && !head.starts_with(b"glTF") && !(head.starts_with(b"{") && holds(b"\"asset\""))
}

/// Reads a trajectory file.
pub(crate) fn load(file: &Path, args: &TrajectoryArgs) -> Result<Recording, Failure> {
    let settings = ReadSettings {
        format: args.format,
        unit: args.unit,
        fps: args.data_fps,
        heading: args.heading,
        geometry: args.geometry.clone(),
        strict: args.strict,
    };
    Ok(populace_trajectory::load(file, &settings)?)
}

/// Returns the rate of a film of people who follow trajectories: the one that was asked for, or 25.
pub(crate) fn film_rate(asked: Option<FrameRate>) -> Result<FrameRate, Failure> {
    Ok(asked.map_or_else(|| FrameRate::new(DEFAULT_FPS, 1), Ok)?)
}

/// Returns the number of frames from the beginning of a recording to its end, at least 1 and at
/// most [`MOST_FRAMES`].
pub(crate) fn frame_count(recording: &Recording, rate: FrameRate) -> u32 {
    let [from, until] = recording.secs();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let last = ((until - from) * rate.per_sec() + 1e-6).floor() as u32;
    last.saturating_add(1).min(MOST_FRAMES)
}
