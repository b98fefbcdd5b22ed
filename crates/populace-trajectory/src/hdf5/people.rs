//! Directions of view, body heights and markers, which PeTrack adds to trajectories.

use std::collections::HashMap;

use super::table::Table;
use crate::extra::Extra;
use crate::rows::Rows;

/// The directions of view in `/petrack_data`. Its `view_angle` is an angle at the camera, and not
/// used.
pub(super) struct Views {
    table: Table,
    x: usize,
    y: usize,
    /// Ids, frames and rows in their order.
    by_frame: Vec<(i64, i64, usize)>,
}

impl Views {
    /// Returns nothing if the table holds no directions.
    pub(super) fn new(table: Table) -> Option<Self> {
        let (x, y) = (table.member("view_dir_x")?, table.member("view_dir_y")?);
        let (id, frame) = (table.member("id")?, table.member("frame")?);
        let key = |row| Some((table.integer(row, id)?, table.integer(row, frame)?, row));
        let mut by_frame: Vec<_> = (0..table.len()).filter_map(key).collect();
        by_frame.sort_unstable();
        Some(Self { table, x, y, by_frame })
    }

    /// Returns the direction in radians in which somebody looks at a frame.
    pub(super) fn of(&self, id: i64, frame: i64) -> Option<f64> {
        let index = self.by_frame.partition_point(|known| (known.0, known.1) < (id, frame));
        let (.., row) =
            self.by_frame.get(index).filter(|known| (known.0, known.1) == (id, frame))?;
        let (x, y) = (self.table.number(*row, self.x), self.table.number(*row, self.y));
        (x != 0.0 || y != 0.0).then(|| y.atan2(x))
    }
}

/// Body heights and markers in `/personal_details`.
pub(super) struct Details {
    of_person: HashMap<i64, (f64, f64)>,
    marker: Extra,
}

impl Details {
    pub(super) fn new(table: Table) -> Option<Self> {
        let id = table.member("id")?;
        let (height, marker) = (table.member("height"), table.member("marker_id"));
        let number = |row, member: Option<usize>| {
            member.map_or(f64::NAN, |member| table.number(row, member))
        };
        let person =
            |row| Some((table.integer(row, id)?, (number(row, height), number(row, marker))));
        let of_person = (0..table.len()).filter_map(person).collect();
        Some(Self { of_person, marker: Extra::new("marker_id") })
    }

    /// Sets the marker of the person of the last row, and returns the height in metres.
    pub(super) fn set(&mut self, rows: &mut Rows, id: i64) -> Option<f64> {
        let (height_m, marker) = *self.of_person.get(&id)?;
        if marker.is_finite() {
            self.marker.set_number(rows, marker);
        }
        (height_m > 0.0).then_some(height_m)
    }
}
