//! Walkable areas in a file, which may change with time.

use crate::warnings::Warnings;
use crate::wkt;
use crate::{Place, PlaceChange, Polygon};

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

    /// Returns the place. Its area changes to the one with a hash at times in seconds, which are in
    /// order. Without changes it is the first area.
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
            points += walkable.iter().map(point_count).sum::<usize>();
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

/// The number of points of all rings.
fn point_count(polygon: &Polygon) -> usize {
    polygon.outline.len() + polygon.holes.iter().map(Vec::len).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_that_keep_changing_need_bounded_memory() {
        let ring = vec!["1 0, 2 1, 3 0"; 20_000].join(", ");
        let texts = [1, 2].map(|hash| (hash, format!("POLYGON (({ring}))")));
        let mut warnings = Warnings::default();
        let areas = Areas::parse(texts.to_vec(), &mut warnings);
        let changes: Vec<_> = (0..1000).map(|i| (f64::from(i), i64::from(i % 2 + 1))).collect();
        let place = areas.place(&changes, &mut warnings);
        assert_eq!(place.changes.len(), MOST_POINTS / 60_000);
        assert!(warnings.into_vec()[0].text.contains("changes too often"));
    }
}
