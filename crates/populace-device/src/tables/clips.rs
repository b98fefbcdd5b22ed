//! Clips and their rows.

use populace_clip::{Clip, RootMotion, RowBlock};
use populace_model::convert::u32_from;

use super::runs::{Asset, Runs};
use super::{Tables, live};
use crate::Error;
use crate::layout::{ClipRows, Float4, JOINT_BLOCK, MOTION_ELEMENTS};

impl Tables {
    /// Adds a clip's rows and returns its index. A live clip gets a ring of the size that it asks
    /// for, filled with the rest pose until rows are written.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if offsets exceed 32 bits.
    pub fn add_clip(&mut self, clip: &Clip) -> Result<u32, Error> {
        self.add_asset(Asset::Clip, |tables, runs| {
            let motion = clip.root_motion();
            let motions = motion.into_iter().flat_map(RootMotion::device_rows).map(Float4);
            let motion_element = runs.add(&mut tables.all.motions, motions)?;
            let rows = ClipRows {
                motion_first: motion_element / MOTION_ELEMENTS,
                motion_count: u32_from(motion.map_or(0, RootMotion::row_count)),
                motion_rows_per_sec: motion.map_or(0.0, RootMotion::rows_per_sec),
                ..tables.rows_of(clip, runs)?
            };
            let index = runs.add(&mut tables.all.clips, [rows])?;
            tables.add_live(index, clip);
            Ok(index)
        })
    }

    /// Adds a clip that was converted to a body, with the root motion of the clip `of`, and
    /// returns its index.
    pub(super) fn add_converted(
        &mut self,
        of: u32,
        clip: &Clip,
        runs: &mut Runs,
    ) -> Result<u32, Error> {
        let ClipRows { motion_first, motion_count, motion_rows_per_sec, .. } =
            self.all.clips.as_slice()[of as usize];
        let rows = self.rows_of(clip, runs)?;
        let rows = ClipRows { motion_first, motion_count, motion_rows_per_sec, ..rows };
        runs.add(&mut self.all.clips, [rows])
    }

    /// Adds the rows of a clip and returns where they are; without root motion.
    fn rows_of(&mut self, clip: &Clip, runs: &mut Runs) -> Result<ClipRows, Error> {
        let row_first = self.add_rows(clip, runs)?;
        let all = &mut self.all;
        let (buckets, buckets_per_sec) = clip.buckets();
        let times = if buckets.is_empty() { &[] } else { clip.row_times() };
        Ok(ClipRows {
            row_first,
            row_stride: u32_from(clip.row_stride()),
            row_count: u32_from(clip.row_count()),
            time_first: runs.add(&mut all.row_times, times.iter().copied())?,
            bucket_first: runs.add(&mut all.buckets, buckets.iter().copied())?,
            bucket_count: u32_from(buckets.len()),
            buckets_per_sec,
            start_secs: clip.start_secs(),
            duration_secs: clip.duration_secs(),
            rows_per_sec: clip.rows_per_sec(),
            has_floats: u32::from(clip.row_blocks().iter().any(RowBlock::has_floats)),
            ..live::new_ring(clip)
        })
    }

    /// Adds the rows of a clip, or empty rows for its ring, and returns the first word.
    fn add_rows(&mut self, clip: &Clip, runs: &mut Runs) -> Result<u32, Error> {
        // The first row, which is the first pose of bound clips, and the ring.
        let times = clip.ring().map_or(1, |ring| 1 + ring.rows as usize);
        let (rows, count) = (clip.rows(), clip.rows().len().saturating_mul(times));
        if self.all.rows.len().saturating_add(count) > u32::MAX as usize {
            return Err(Error::TooLarge { what: "rows", count, limit: u32::MAX as usize });
        }
        let mut words: Vec<u32> = rows.iter().copied().cycle().take(count).collect();
        // Padding, because sixteen lanes may read past the end. Runs are whole blocks.
        let past_the_end = words.len() + JOINT_BLOCK as usize;
        words.resize(past_the_end.next_multiple_of(JOINT_BLOCK as usize), 0);
        runs.add(&mut self.all.rows, words)
    }
}
