//! Files of any format.

use std::path::Path;

use crate::input::Input;
use crate::recognise::recognise;
use crate::{
    Error, Format, ReadSettings, Recording, jpscore, menge, named, obsmat, petrack, trajnet,
    trajnet_plus_plus,
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
    match format {
        Format::PeTrack => petrack::read(input, settings),
        Format::Jpscore => jpscore::read(input, settings),
        Format::PathfinderCsv | Format::Viswalk | Format::CrowdIt | Format::Csv => {
            named::read(input, format, settings)
        }
        Format::Obsmat => obsmat::read(input, settings),
        Format::TrajNet => trajnet::read(input, settings),
        Format::TrajNetPlusPlus => trajnet_plus_plus::read(input, settings),
        Format::Menge => menge::read(input, settings),
        _ => Err(input.malformed(None, "the format is not supported")),
    }
}
