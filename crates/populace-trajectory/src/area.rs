//! Walkable areas beside a file, or as the settings say.

use std::io::Read;
use std::path::Path;

use crate::input::Input;
use crate::scenario;
use crate::wkt;
use crate::{Error, Location, Place, PlaceChange, ReadSettings, Recording, Warning};

/// Returns the recording with the area that the settings name, or one beside its file if the file
/// itself has none.
pub(crate) fn with_area(
    mut recording: Recording,
    input: &Input,
    settings: &ReadSettings,
) -> Result<Recording, Error> {
    if let Some(path) = &settings.geometry {
        recording.place = load(path)?.relative_to(recording.origin_m);
    } else if recording.place == Place::default()
        && let Some(path) = input.beside("wkt")
    {
        match load(&path) {
            Ok(place) => recording.place = place.relative_to(recording.origin_m),
            Err(error) => {
                let text = format!("the area beside the file was left out: {error}");
                let warning = Warning { text, rows: 0, first: None };
                if settings.strict {
                    return Err(Error::Strict { path: input.path().to_owned(), warning });
                }
                recording.warnings.push(warning);
            }
        }
    }
    Ok(recording)
}

/// Reads a file with an area: WKT, or a scenario of Vadere.
pub(crate) fn load(path: &Path) -> Result<Place, Error> {
    let file = Input::of_file(path);
    let mut bytes = Vec::new();
    file.open()?.read_to_end(&mut bytes).map_err(file.unreadable())?;
    let Ok(text) = String::from_utf8(bytes) else {
        let problem = "it is no text in UTF-8; name a file of WKT or a scenario of Vadere";
        return Err(file.malformed(None, problem));
    };
    let text = text.trim_start_matches('\u{feff}');
    if text.trim_start().starts_with('{') {
        return scenario::place(text).map_err(|problem| file.malformed(None, problem));
    }
    let walkable = wkt::polygons(text)
        .map_err(|error| file.malformed(Some(Location::Byte(error.at as u64)), error.problem))?;
    Ok(Place { changes: vec![PlaceChange { from_secs: 0.0, walkable }], ..Place::default() })
}
