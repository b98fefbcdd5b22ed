//! Rows of clips, and their binding to bodies.

use super::*;

device_struct! {
    /// The rows of a clip, and how to find the row for a time.
    ///
    /// A live clip receives rows while it plays. Its rows form a ring behind a fixed first row,
    /// which additive layers measure from. Rows of the ring are [`row_ticks`](Self::row_ticks)
    /// apart on the crowd's clock; only the newest may follow sooner. Devices count back from the
    /// newest row in whole ticks, so precision does not degrade however long the stream runs.
    pub struct ClipRows {
        /// Live clips: clock tick of the newest row.
        pub newest_tick: u64,
        /// Word offset into `rows`: the first row.
        pub row_first: u32,
        /// Words from one row to the next.
        pub row_stride: u32,
        /// Number of rows, at least one. Live clips: rows of the ring received so far.
        pub row_count: u32,
        /// Offset into `row_blocks`: one for each block of 16 columns.
        pub block_first: u32,
        /// Offset into `row_times`.
        pub time_first: u32,
        /// Offset into `buckets`. Each bucket holds a row at or before the bucket's start.
        pub bucket_first: u32,
        /// Number of buckets; 0 if rows are evenly spaced.
        pub bucket_count: u32,
        /// Buckets per second.
        pub buckets_per_sec: f32,
        /// Time of the first row on the clip's own axis.
        pub start_secs: f32,
        /// Seconds from the first row to the last.
        pub duration_secs: f32,
        /// Rows per second if they are evenly spaced, else 0.
        pub rows_per_sec: f32,
        /// Capacity of a live clip's ring in rows; 0 for other clips.
        pub ring_rows: u32,
        /// Live clips: ticks between rows.
        pub row_ticks: u32,
        /// Live clips: index of the newest row in the ring.
        pub newest_row: u32,
        /// Live clips: ticks from the second newest row to the newest, 1 to
        /// [`row_ticks`](Self::row_ticks).
        pub newest_ticks: u32,
        /// Live clips: 1 divided by [`row_ticks`](Self::row_ticks).
        pub per_row_tick: f32,
        /// Live clips: 1 divided by [`newest_ticks`](Self::newest_ticks).
        pub per_newest_tick: f32,
        /// Offset into `motions`: the first row of root motion.
        pub motion_first: u32,
        /// Number of root-motion rows; 0 if the clip has none.
        pub motion_count: u32,
        /// Root-motion rows per second.
        pub motion_rows_per_sec: f32,
    }
}

device_struct! {
    /// Location of a block of 16 columns within a row.
    ///
    /// A row is a run of 32-bit words. For each property that moves in the block, planes of words
    /// follow each other from the property's first word:
    ///
    /// | Format | Property | Plane | Words | Lane `i` |
    /// |---|---|---|---|---|
    /// | 16-bit | rotation | 0 | `lanes` | word `i`: `x` in bits 0 to 15, `y` in 16 to 31 |
    /// | 16-bit | rotation | 1 | `lanes` | word `i`: `z` in bits 0 to 15, `w` in 16 to 31 |
    /// | 16-bit | others | 0 | `lanes` | word `i`: `x` in bits 0 to 15, `y` in 16 to 31 |
    /// | 16-bit | others | 1 | `lanes / 2` | word `i / 2`: `z`, low half for even `i`, else high |
    /// | float | rotation | 0 to 3 | 16 each | word `i`: `x`, `y`, `z`, `w` as `f32` |
    /// | float | others | 0 to 2 | 16 each | word `i`: `x`, `y`, `z` as `f32` |
    ///
    /// *Others* are translation and scale; `lanes / 2` is rounded up.
    ///
    /// The fields of each property:
    ///
    /// | Field | Bits | Content |
    /// |---|---|---|
    /// | `*_first` | 0 to 31 | first word within the row, or [`NONE`] if nothing moves |
    /// | `*_lanes` | 31 | [`ROW_FLOATS`]: the planes hold floats |
    /// | `*_lanes` | 0 to 30 | columns per plane, up to the last column that moves |
    ///
    /// A 16-bit number `n` stands for `offset + step * n`, see [`RANGE_PLANES`].
    pub struct RowBlock {
        /// First word of the rotations, or [`NONE`].
        pub rotation_first: u32,
        /// Columns per rotation plane, and [`ROW_FLOATS`].
        pub rotation_lanes: u32,
        /// First word of the translations, or [`NONE`].
        pub translation_first: u32,
        /// Columns per translation plane, and [`ROW_FLOATS`].
        pub translation_lanes: u32,
        /// First word of the scales, or [`NONE`].
        pub scale_first: u32,
        /// Columns per scale plane, and [`ROW_FLOATS`].
        pub scale_lanes: u32,
    }
}

impl RowBlock {
    /// A block without any moving property.
    pub const STILL: Self = Self {
        rotation_first: NONE,
        rotation_lanes: 0,
        translation_first: NONE,
        translation_lanes: 0,
        scale_first: NONE,
        scale_lanes: 0,
    };

    /// Merges two blocks into one that only tells what moves in either, and whether either stores
    /// it as floats ([`ROW_FLOATS`]). First words are those of one of the two.
    #[must_use]
    pub const fn or_moving(mut self, other: &Self) -> Self {
        if other.rotation_first != NONE {
            (self.rotation_first, self.rotation_lanes) =
                (other.rotation_first, self.rotation_lanes | other.rotation_lanes);
        }
        if other.translation_first != NONE {
            (self.translation_first, self.translation_lanes) =
                (other.translation_first, self.translation_lanes | other.translation_lanes);
        }
        if other.scale_first != NONE {
            (self.scale_first, self.scale_lanes) =
                (other.scale_first, self.scale_lanes | other.scale_lanes);
        }
        self
    }
}

impl From<&populace_clip::RowBlock> for RowBlock {
    fn from(block: &populace_clip::RowBlock) -> Self {
        Self {
            rotation_first: block.rotation_first,
            rotation_lanes: block.rotation_lanes,
            translation_first: block.translation_first,
            translation_lanes: block.translation_lanes,
            scale_first: block.scale_first,
            scale_lanes: block.scale_lanes,
        }
    }
}

device_struct! {
    /// A clip bound to a body.
    pub struct BoundClip {
        /// Index into `clips`.
        pub clip: u32,
        /// Offset into `joint_maps`: for each joint the clip's column, and `MAP_` flags for the
        /// properties that the clip's rows drive.
        pub map_first: u32,
        /// Offset into `poses`: the planes of [`RANGE_PLANES`].
        pub range_first: u32,
        /// Offset into `bound_blocks`: one for each block of 16 joints of the body.
        pub block_first: u32,
        /// The body it is bound to; [`NONE`] for a retarget correction, which slots must not name.
        pub body: u32,
        /// Index into `bound_clips`: the correction that the sampled pose goes through next, or
        /// [`NONE`]. A correction is a bound clip whose ranges are those of [`CORRECTION_PLANES`].
        /// Blocks without [`BLOCK_CORRECTED`] skip it.
        pub next: u32,
        /// Scale of root motion: distance moved by the body per distance moved by the clip's
        /// skeleton.
        pub motion_scale: f32,
        /// Offset into `row_blocks`: where the first 16 columns lie within a row.
        pub row_block_first: u32,
        /// Word offset into `rows`: rows of a correction that has its own, one for each row of the
        /// clip.
        pub row_first: u32,
        /// Words between rows of the correction; 0 if it uses the clip's rows.
        pub row_stride: u32,
    }
}

device_struct! {
    /// Location of the columns of 16 neighbouring joints of a body within a clip's rows.
    ///
    /// The first six fields are those of a [`RowBlock`]. With [`BLOCK_STRAIGHT`] they are those of
    /// the single block that the joints follow. Otherwise a first word only tells whether anything
    /// moves, and the lanes only whether any source holds floats.
    pub struct BoundBlock {
        /// First word of the rotations, or [`NONE`].
        pub rotation_first: u32,
        /// Columns per rotation plane, and [`ROW_FLOATS`].
        pub rotation_lanes: u32,
        /// First word of the translations, or [`NONE`].
        pub translation_first: u32,
        /// Columns per translation plane, and [`ROW_FLOATS`].
        pub translation_lanes: u32,
        /// First word of the scales, or [`NONE`].
        pub scale_first: u32,
        /// Columns per scale plane, and [`ROW_FLOATS`].
        pub scale_lanes: u32,
        /// Bits of [`BLOCK_STRAIGHT`], [`BLOCK_CORRECTED`], [`REST_TRANSLATION`] and
        /// [`REST_SCALE`].
        pub flags: u32,
        /// Offset into `sources`.
        pub source_first: u32,
        /// Number of the clip's blocks that the joints follow; 0 if nothing moves.
        pub source_count: u32,
    }
}

impl BoundBlock {
    /// Returns the location of the columns; valid with [`BLOCK_STRAIGHT`].
    #[inline]
    #[must_use]
    pub const fn rows(&self) -> RowBlock {
        RowBlock {
            rotation_first: self.rotation_first,
            rotation_lanes: self.rotation_lanes,
            translation_first: self.translation_first,
            translation_lanes: self.translation_lanes,
            scale_first: self.scale_first,
            scale_lanes: self.scale_lanes,
        }
    }
}

device_struct! {
    /// A block of columns that some of 16 neighbouring joints follow.
    pub struct Source {
        /// Index into `row_blocks`.
        pub block: u32,
        /// Offset into `source_lanes`: for each of the 16 joints its lane in the block, or [`NONE`]
        /// if it follows another block.
        pub lanes_first: u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merged_blocks_keep_float_flags_in_either_order() {
        let block = |lanes| RowBlock {
            rotation_first: 0,
            rotation_lanes: lanes,
            translation_first: 8,
            translation_lanes: lanes,
            scale_first: 16,
            scale_lanes: lanes,
        };
        let (floats, halves) = (block(ROW_FLOATS | 16), block(3));
        for merged in [floats.or_moving(&halves), halves.or_moving(&floats)] {
            let lanes = [merged.rotation_lanes, merged.translation_lanes, merged.scale_lanes];
            assert!(lanes.iter().all(|lanes| lanes & ROW_FLOATS != 0), "{merged:?}");
        }
    }
}
