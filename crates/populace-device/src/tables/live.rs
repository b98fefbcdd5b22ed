//! Rows of clips, and rows that arrive while a live clip plays.

use populace_clip::Clip;
use populace_model::Trs;

use super::Tables;
use super::runs::Runs;
use crate::Error;
use crate::layout::{ClipRows, JOINT_BLOCK};

/// The newest row of a live clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveNewest {
    /// Clock tick of the row.
    pub tick: u64,
    /// Index of the row in the ring.
    pub row: u32,
    /// Number of rows in the ring received so far, including this one.
    pub row_count: u32,
    /// Ticks since the previous row, 1 to
    /// [`LiveRing::row_ticks`](populace_clip::LiveRing::row_ticks).
    pub ticks: u32,
}

/// Ring fields of a clip that has received nothing: one row, at rest.
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
    /// Adds the rows of a clip, or empty rows for its ring, and returns the first word.
    pub(super) fn add_rows(&mut self, clip: &Clip, runs: &mut Runs) -> Result<u32, Error> {
        // The first row, which additive layers measure from, and the ring.
        let times = clip.ring().map_or(1, |ring| 1 + ring.rows as usize);
        let (rows, count) = (clip.rows(), clip.rows().len().saturating_mul(times));
        if self.all.rows.len().saturating_add(count) > u32::MAX as usize {
            return Err(Error::TooLarge { what: "rows", count, limit: u32::MAX as usize });
        }
        self.add_words(rows.iter().copied().cycle().take(count), runs)
    }

    /// Adds words with padding behind them, so that runs are whole blocks, and returns the first
    /// word.
    pub(super) fn add_words(
        &mut self,
        words: impl Iterator<Item = u32>,
        runs: &mut Runs,
    ) -> Result<u32, Error> {
        let mut words: Vec<u32> = words.collect();
        let past_the_end = words.len() + JOINT_BLOCK as usize;
        words.resize(past_the_end.next_multiple_of(JOINT_BLOCK as usize), 0);
        runs.add(&mut self.all.rows, words)
    }

    /// Writes a pose into a row of a live clip's ring. With `row` of `None` it writes the row that
    /// additive layers measure from. `clip` must be the clip that was added as `index`.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if `clip` is another clip or the row does not exist.
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
            return Err(Error::BadPlayback {
                what: "live clip with such rows and index",
                value: index,
            });
        }
        if let Some(row) = row.filter(|row| *row >= rows.ring_rows) {
            return Err(Error::BadPlayback { what: "ring row", value: row });
        }
        let nth = row.map_or(0, |row| row as usize + 1);
        self.all.rows.set_run(rows.row_first as usize + nth * words.len(), &words);
        Ok(())
    }

    /// Sets the newest row of a live clip.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the clip is not live, or if the row, row count or tick count is
    /// out of range.
    pub fn set_live_newest(&mut self, index: u32, newest: LiveNewest) -> Result<(), Error> {
        let rows = self.live_rows(index)?;
        for (what, value, fits) in [
            ("ring row", newest.row, newest.row < rows.ring_rows),
            ("row count", newest.row_count, (1..=rows.ring_rows).contains(&newest.row_count)),
            ("row length in ticks", newest.ticks, (1..=rows.row_ticks).contains(&newest.ticks)),
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
