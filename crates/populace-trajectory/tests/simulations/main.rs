//! Files of simulators, written by the tests.

mod area;
#[cfg(feature = "hdf5")]
mod hdf5;
#[cfg(feature = "sqlite")]
mod jupedsim;
mod mutations;
mod pathfinder_json;
mod sumo;
mod vadere;

use std::path::Path;

use populace_trajectory::{Error, ReadSettings, Recording, Values, parse};

fn read(bytes: impl Into<Vec<u8>>) -> Recording {
    parse(Path::new("file"), bytes.into(), &ReadSettings::default()).expect("it can be read")
}

fn problem(bytes: impl Into<Vec<u8>>) -> String {
    problem_with(bytes, &ReadSettings::default()).to_string()
}

fn problem_with(bytes: impl Into<Vec<u8>>, settings: &ReadSettings) -> Error {
    parse(Path::new("file"), bytes.into(), settings).expect_err("it is refused")
}

fn warnings(recording: &Recording) -> Vec<String> {
    recording.warnings.iter().map(ToString::to_string).collect()
}

/// The times and positions of the agent with an id.
fn rows_of(recording: &Recording, id: &str) -> Vec<(f64, [f32; 2])> {
    let agent = recording.agents.iter().find(|agent| agent.id == id).expect("an agent");
    let track = recording.track(agent);
    track.times.iter().copied().zip(track.positions.iter().copied()).collect()
}

/// The values of a column, as text.
fn column(recording: &Recording, name: &str) -> Vec<String> {
    match &recording.column(name).expect("a column").values {
        Values::Numbers(numbers) => numbers.iter().map(ToString::to_string).collect(),
        Values::Words { words, indices } => {
            let word = |index: &u32| words.get(*index as usize).map_or("", String::as_str);
            indices.iter().map(|index| word(index).to_owned()).collect()
        }
    }
}

/// Bytes compressed by gzip.
fn compressed(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;

    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}
