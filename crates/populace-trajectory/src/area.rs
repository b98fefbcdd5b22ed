//! Walkable areas: in the file, beside it, or as the settings say.

use std::io::Read;
use std::path::Path;

use crate::input::Input;
use crate::scenario;
use crate::warnings::Warnings;
use crate::wkt;
use crate::{Error, Location, Place, PlaceChange, Polygon, ReadSettings, Recording, Warning};

/// Most points of all areas of a file together. Areas that keep changing would otherwise need far
/// more memory than their file.
const MOST_POINTS: usize = 4_000_000;

/// Areas by their hashes.
pub(crate) struct Areas(Vec<(i64, Vec<Polygon>)>);

impl Areas {
    /// Reads the texts of a file; a broken one is an empty area with a warning.
    pub(crate) fn parse(texts: Vec<(i64, String)>, warnings: &mut Warnings) -> Self {
        let parse = |(hash, text): (i64, String)| {
            let polygons = wkt::polygons(&text).unwrap_or_else(|error| {
                warnings.whole(format!("the walkable area was left out: {error}"));
                Vec::new()
            });
            (hash, polygons)
        };
        Self(texts.into_iter().map(parse).collect())
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns the place, whose area changes at times in seconds, in their order, to one with a hash.
    /// Without changes it is the first area.
    pub(crate) fn place(&self, changes: &[(f64, i64)], warnings: &mut Warnings) -> Place {
        let mut place = Place::default();
        let (mut last, mut points) = (None, 0);
        for &(from_secs, hash) in changes {
            if last == Some(hash) || !from_secs.is_finite() {
                continue;
            }
            last = Some(hash);
            let Some((_, walkable)) = self.0.iter().find(|(known, _)| *known == hash) else {
                warnings.row("frames name a walkable area that the file does not have", None);
                continue;
            };
            points += walkable.iter().map(Polygon::point_count).sum::<usize>();
            if points > MOST_POINTS {
                warnings.whole("the walkable area changes too often; later changes were left out");
                break;
            }
            place.changes.push(PlaceChange { from_secs, walkable: walkable.clone() });
        }
        if let (true, Some((_, walkable))) = (place.changes.is_empty(), self.0.first()) {
            place.changes.push(PlaceChange { from_secs: 0.0, walkable: walkable.clone() });
        }
        place.changes.retain(|change| !change.walkable.is_empty());
        place
    }
}

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
    let mut text = String::new();
    file.open()?.read_to_string(&mut text).map_err(file.unreadable())?;
    let text = text.trim_start_matches('\u{feff}');
    if text.trim_start().starts_with('{') {
        return scenario::place(text).map_err(|problem| file.malformed(None, problem));
    }
    let walkable = wkt::polygons(text)
        .map_err(|error| file.malformed(Some(Location::Byte(error.at as u64)), error.problem))?;
    Ok(Place { changes: vec![PlaceChange { from_secs: 0.0, walkable }], ..Place::default() })
}
