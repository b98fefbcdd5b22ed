//! Files of any format.

use std::path::Path;

#[cfg(feature = "hdf5")]
use crate::hdf5;
use crate::input::Input;
#[cfg(feature = "sqlite")]
use crate::jupedsim;
use crate::recognise::recognise;
use crate::{
    Error, Format, ReadSettings, Recording, area, jpscore, menge, named, obsmat, pathfinder_json,
    petrack, sumo, trajnet, trajnet_plus_plus, vadere,
};

/// Reads a file. Its format is recognised by its content.
///
/// # Errors
///
/// A file that cannot be read, that no format fits, that breaks the rules of its format, or that
/// holds no positions. With [`ReadSettings::strict`], the first warning too.
pub fn load(path: &Path, settings: &ReadSettings) -> Result<Recording, Error> {
    read(&Input::of_file(path), settings)
}

/// Reads the bytes of a file. `name` stands for it in messages. Files that would lie beside it are
/// not looked for.
///
/// # Errors
///
/// As [`load`].
pub fn parse(name: &Path, bytes: Vec<u8>, settings: &ReadSettings) -> Result<Recording, Error> {
    read(&Input::of_bytes(name, bytes), settings)
}

fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let format = settings.format.map_or_else(|| recognise(input), Ok)?;
    let recording = match format {
        Format::PeTrack => petrack::read(input, settings),
        Format::Jpscore => jpscore::read(input, settings),
        #[cfg(feature = "sqlite")]
        Format::JuPedSim => jupedsim::read(input, settings),
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => hdf5::read(input, settings),
        Format::Vadere => vadere::read(input, settings),
        Format::Sumo => sumo::read(input, settings),
        Format::PathfinderCsv | Format::Viswalk | Format::CrowdIt | Format::Csv => {
            named::read(input, format, settings)
        }
        Format::PathfinderJson => pathfinder_json::read(input, settings),
        Format::Obsmat => obsmat::read(input, settings),
        Format::TrajNet => trajnet::read(input, settings),
        Format::TrajNetPlusPlus => trajnet_plus_plus::read(input, settings),
        Format::Menge => menge::read(input, settings),
        #[cfg(not(feature = "sqlite"))]
        Format::JuPedSim => Err(input
            .malformed(None, "this build has no reader of SQLite; build with the feature sqlite")),
        #[cfg(not(feature = "hdf5"))]
        Format::Hdf5 => {
            Err(input
                .malformed(None, "this build has no reader of HDF5; build with the feature hdf5"))
        }
    };
    area::with_area(recording?, input, settings)
}
