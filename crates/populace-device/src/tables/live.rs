//! Rows of clips, and those that come in while a clip plays.

use populace_clip::Clip;
use populace_model::Trs;

use super::Tables;
use crate::Error;
use crate::layout::{ClipRows, JOINT_BLOCK};

/// The newest row of a live clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveNewest {
    /// The clock when it stands.
    pub tick: u64,
    /// Its place in the ring.
    pub row: u32,
    /// Rows of the ring that have come in, itself included.
    pub row_count: u32,
    /// Ticks since the row before it, 1 to
    /// [`LiveRing::row_ticks`](populace_clip::LiveRing::row_ticks).
    pub ticks: u32,
}

/// What a clip's ring is before anything has come in: one row, at rest.
pub(super) fn new_ring(clip: &Clip) -> ClipRows {
    clip.ring().map_or_else(ClipRows::default, |ring| ClipRows {
        ring_rows: ring.rows,
        row_ticks: ring.row_ticks,
        newest_ticks: ring.row_ticks,
        per_row_tick: 1.0 / ring.row_ticks as f32,
        per_newest_tick: 1.0 / ring.row_ticks as f32,
        ..ClipRows::default()
    })
}

impl Tables {
    /// Adds the rows of a clip, or the room for them, and returns where they begin.
    pub(super) fn add_rows(&mut self, clip: &Clip) -> Result<u32, Error> {
        // The first row, from which additive layers measure, and the ring.
        let times = clip.ring().map_or(1, |ring| 1 + ring.rows as usize);
        let (rows, count) = (clip.rows(), clip.rows().len().saturating_mul(times));
        if self.all.rows.len().saturating_add(count) > u32::MAX as usize {
            return Err(Error::TooLarge { what: "rows", count, limit: u32::MAX as usize });
        }
        self.add_words(rows.iter().copied().cycle().take(count))
    }

    /// Adds rows and returns where they begin.
    pub(super) fn add_words(&mut self, words: impl Iterator<Item = u32>) -> Result<u32, Error> {
        let past_the_end = [0; JOINT_BLOCK as usize];
        self.all.rows.extend(words.chain(past_the_end))
    }

    /// Writes a pose into a row of a live clip's ring, or where `row` is `None` into the one that
    /// additive layers measure from. `clip` is what was added as `index`.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] for another clip, or a row that is not there.
    pub fn set_live_row(
        &mut self,
        index: u32,
        clip: &Clip,
        row: Option<u32>,
        pose: &[Trs],
    ) -> Result<(), Error> {
        let rows = self.live_rows(index)?;
        let words = clip.row_of(pose);
        if clip.ring().is_none() || words.len() != rows.row_stride as usize {
            return Err(Error::BadPlayback { what: "live clip of such rows", value: index });
        }
        if let Some(row) = row.filter(|row| *row >= rows.ring_rows) {
            return Err(Error::BadPlayback { what: "row", value: row });
        }
        let nth = row.map_or(0, |row| row as usize + 1);
        self.all.rows.set_run(rows.row_first as usize + nth * words.len(), &words);
        Ok(())
    }

    /// Says which row of a live clip is the newest.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] for a clip that is not live, or a row or number of ticks that it
    /// cannot have.
    pub fn set_live_newest(&mut self, index: u32, newest: LiveNewest) -> Result<(), Error> {
        let rows = self.live_rows(index)?;
        for (what, value, fits) in [
            ("row", newest.row, newest.row < rows.ring_rows),
            ("count of rows", newest.row_count, (1..=rows.ring_rows).contains(&newest.row_count)),
            (
                "length of a row in ticks",
                newest.ticks,
                (1..=rows.row_ticks).contains(&newest.ticks),
            ),
        ] {
            if !fits {
                return Err(Error::BadPlayback { what, value });
            }
        }
        let rows = ClipRows {
            newest_tick: newest.tick,
            newest_row: newest.row,
            row_count: newest.row_count,
            newest_ticks: newest.ticks,
            per_newest_tick: 1.0 / newest.ticks as f32,
            ..rows
        };
        self.all.clips.set(index as usize, rows);
        Ok(())
    }

    fn live_rows(&self, index: u32) -> Result<ClipRows, Error> {
        let rows = self.all.clips.as_slice().get(index as usize).filter(|rows| rows.ring_rows > 0);
        rows.copied().ok_or(Error::BadPlayback { what: "live clip", value: index })
    }
}
