//! Clips: their rows, and how they are bound to bodies.

use super::*;

device_struct! {
    /// A clip's rows and where to find the row of a time.
    ///
    /// Of a live clip, which rows come into while it plays, they are a ring after the first row,
    /// which stays: additive layers measure from it. Rows stand [`row_ticks`](Self::row_ticks)
    /// apart on the crowd's clock, the newest less than that after the one before it. Devices count
    /// back from it in whole ticks, so nothing is lost however long the stream goes on.
    pub struct ClipRows {
        /// Live clips: the clock at the newest row.
        pub newest_tick: u64,
        /// Into `rows`, in words: the first row.
        pub row_first: u32,
        /// Words from one row to the next.
        pub row_stride: u32,
        /// Rows, at least one; of a live clip those of the ring that have come in.
        pub row_count: u32,
        /// Into `row_blocks`: one for each block of 16 columns.
        pub block_first: u32,
        /// Into `row_times`.
        pub time_first: u32,
        /// Into `buckets`: for each, a row at or before the bucket's start.
        pub bucket_first: u32,
        /// Buckets; 0 where rows are evenly spaced.
        pub bucket_count: u32,
        /// Buckets per second.
        pub buckets_per_sec: f32,
        /// Time of the first row on the clip's own axis.
        pub start_secs: f32,
        /// From the first row to the last.
        pub duration_secs: f32,
        /// Rows per second where they are evenly spaced, else 0.
        pub rows_per_sec: f32,
        /// Rows of a live clip's ring; 0 for others.
        pub ring_rows: u32,
        /// Live clips: ticks from one row to the next.
        pub row_ticks: u32,
        /// Live clips: the newest row's place in the ring.
        pub newest_row: u32,
        /// Live clips: ticks from the row before the newest to that, 1 to
        /// [`row_ticks`](Self::row_ticks).
        pub newest_ticks: u32,
        /// Live clips: 1 divided by [`row_ticks`](Self::row_ticks).
        pub per_row_tick: f32,
        /// Live clips: 1 divided by [`newest_ticks`](Self::newest_ticks).
        pub per_newest_tick: f32,
        /// Into `motions`: the first row of its root motion.
        pub motion_first: u32,
        /// Rows of its root motion; 0 where it has none.
        pub motion_count: u32,
        /// Such rows per second.
        pub motion_rows_per_sec: f32,
    }
}

device_struct! {
    /// Where in a row a block of 16 columns stands: for each property the first word, or [`NONE`]
    /// where nothing moves, and the lanes: columns in each plane, with [`ROW_FLOATS`] where planes
    /// hold floats instead of 16-bit steps.
    pub struct RowBlock {
        /// First word of the rotations.
        pub rotation_first: u32,
        /// Columns in each of their planes.
        pub rotation_lanes: u32,
        /// First word of the translations.
        pub translation_first: u32,
        /// Columns in each of their planes.
        pub translation_lanes: u32,
        /// First word of the scales.
        pub scale_first: u32,
        /// Columns in each of their planes.
        pub scale_lanes: u32,
    }
}

impl RowBlock {
    /// A block in which nothing moves.
    pub const STILL: Self = Self {
        rotation_first: NONE,
        rotation_lanes: 0,
        translation_first: NONE,
        translation_lanes: 0,
        scale_first: NONE,
        scale_lanes: 0,
    };

    /// What moves in either block, and whether either holds floats; where it stands is that of one.
    #[must_use]
    pub const fn or_moving(mut self, other: &Self) -> Self {
        if other.rotation_first != NONE {
            (self.rotation_first, self.rotation_lanes) =
                (other.rotation_first, self.rotation_lanes | other.rotation_lanes);
        }
        if other.translation_first != NONE {
            (self.translation_first, self.translation_lanes) =
                (other.translation_first, other.translation_lanes);
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
        /// Into `clips`.
        pub clip: u32,
        /// Into `joint_maps`: for each joint the clip's column and `MAP_` flags of what its rows
        /// drive.
        pub map_first: u32,
        /// Into `poses`: thirteen planes of what the joints' stored components mean (see
        /// [`RANGE_PLANES`]).
        pub range_first: u32,
        /// Into `bound_blocks`: one for each block of 16 joints of the body.
        pub block_first: u32,
        /// The body it is bound to; [`NONE`] for a turn, which no slot may name.
        pub body: u32,
        /// Into `bound_clips`: the turn that what was sampled goes through next, or [`NONE`]. A
        /// turn is a bound clip whose ranges are those of [`TURN_PLANES`]; blocks that have no
        /// [`BLOCK_TURNED`] do not look at it.
        pub next: u32,
        /// How far root motion takes the body, in parts of how far it takes that of the clip.
        pub motion_scale: f32,
        /// Into `row_blocks`: where in a row the first 16 columns stand.
        pub row_block_first: u32,
        /// Into `rows`, in words: where the rows of a turn begin that has its own, one for each of
        /// the clip's.
        pub row_first: u32,
        /// Words from one of these to the next; 0 where the clip's rows are taken.
        pub row_stride: u32,
    }
}

device_struct! {
    /// Where 16 neighbouring joints of a body find their columns in a clip's rows. The first six
    /// are those of a
    /// [`RowBlock`]: where [`BLOCK_STRAIGHT`] is set, of the one that the joints follow; else a first word only tells
    /// whether anything moves, and lanes whether any of it is held as floats.
    pub struct BoundBlock {
        /// First word of the rotations.
        pub rotation_first: u32,
        /// Columns in each of their planes.
        pub rotation_lanes: u32,
        /// First word of the translations.
        pub translation_first: u32,
        /// Columns in each of their planes.
        pub translation_lanes: u32,
        /// First word of the scales.
        pub scale_first: u32,
        /// Columns in each of their planes.
        pub scale_lanes: u32,
        /// [`BLOCK_STRAIGHT`], [`BLOCK_TURNED`], [`REST_TRANSLATION`] and [`REST_SCALE`].
        pub flags: u32,
        /// Into `sources`.
        pub source_first: u32,
        /// Blocks of the clip that the joints follow; 0 where nothing moves.
        pub source_count: u32,
    }
}

impl BoundBlock {
    /// Where the columns stand if they stand in one block.
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
        /// Into `row_blocks`.
        pub block: u32,
        /// Into `source_lanes`: for each of the 16 joints its lane in the block, or [`NONE`] where
        /// it follows another.
        pub lanes_first: u32,
    }
}
