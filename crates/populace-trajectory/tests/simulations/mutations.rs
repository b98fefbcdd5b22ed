//! Small good files with bytes changed or cut off must be read or refused, never more.

use std::path::Path;

use populace_trajectory::{Format, ReadSettings, parse};
use proptest::prelude::*;
use proptest::sample::Index;

#[path = "../../../../fuzz/seeds.rs"]
mod fuzz_seeds;

/// Good files of all families that these tests write.
fn seeds() -> Vec<(Format, Vec<u8>)> {
    let seeds = vec![
        (Format::Vadere, super::vadere::small().into_bytes()),
        (Format::Sumo, super::sumo::small().into_bytes()),
        (Format::PathfinderJson, super::pathfinder_json::small().into_bytes()),
    ];
    #[cfg(feature = "sqlite")]
    let seeds = [seeds, vec![(Format::JuPedSim, super::jupedsim::small())]].concat();
    #[cfg(feature = "hdf5")]
    let seeds = {
        let files = [super::hdf5::jupedsim(), super::hdf5::petrack()];
        [seeds, files.map(|bytes| (Format::Hdf5, bytes)).to_vec()].concat()
    };
    seeds
}

/// Reads bytes as a format, and looks at all of what it gives.
fn survives(format: Format, bytes: Vec<u8>) {
    let settings = ReadSettings { format: Some(format), ..ReadSettings::default() };
    match parse(Path::new("file"), bytes, &settings) {
        Ok(recording) => {
            let summary = recording.summary();
            assert!(summary.agents > 0 && summary.frames > 0);
            assert!(recording.extent().as_flattened().iter().all(|v| v.is_finite()));
            for agent in &recording.agents {
                let track = recording.track(agent);
                assert!(track.times.windows(2).all(|pair| pair[0] < pair[1]));
                assert_eq!(track.times.len(), track.positions.len());
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

#[test]
fn simulation_seeds_can_be_read_and_written() {
    for (index, (format, bytes)) in seeds().into_iter().enumerate() {
        let own = format!("trajectory_{}", format.name().replace('-', "_"));
        for target in [&own, "trajectory_recognised"] {
            fuzz_seeds::write(target, &format!("{index}.{}", format.name()), &bytes);
        }
        let settings = ReadSettings::default();
        let recording = parse(Path::new("file"), bytes, &settings).expect("a good file");
        assert_eq!(recording.source.format, format);
    }
}

#[test]
fn every_beginning_of_a_file_is_read_or_refused() {
    for (format, bytes) in seeds() {
        let step = (bytes.len() / 300).max(1);
        for end in (0..bytes.len()).step_by(step) {
            survives(format, bytes[..end].to_vec());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 100,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn changed_bytes_are_read_or_refused(
        changes in proptest::collection::vec((any::<Index>(), any::<u8>()), 1..8),
    ) {
        for (format, mut bytes) in seeds() {
            for (place, byte) in &changes {
let index = place.index(bytes.len());
                bytes[index] = *byte;
            }
            survives(format, bytes);
        }
    }
}
