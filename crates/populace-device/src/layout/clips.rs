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
        /// 1 if a block of columns stores a property as floats, else 0.
        pub has_floats: u32,
    }
}

pub use populace_clip::RowBlock;

device_struct! {
    /// A clip bound to a body.
    pub struct BoundClip {
        /// Index into `clips`: the clip as it was added.
        pub clip: u32,
        /// Index into `clips`: the rows that the joints follow, each the column of its own number.
        /// They are those of the clip, or of the clip converted to the body.
        pub rows: u32,
        /// Offset into `poses`: the planes of [`RANGE_PLANES`].
        pub range_first: u32,
        /// Offset into `bound_blocks`: one for each block of 16 joints of the body.
        pub block_first: u32,
        /// The body it is bound to; [`NONE`] for an unused element, which slots must not name.
        pub body: u32,
        /// Scale of root motion: distance moved by the body per distance moved by the clip's
        /// skeleton.
        pub motion_scale: f32,
        /// Offset into `contacts`.
        pub contact_first: u32,
        /// Number of contacts; 0 if they are not known.
        pub contact_count: u32,
    }
}

device_struct! {
    /// A time in which a foot stands, in seconds after the clip's start. It may go on through the
    /// end of a cycle. A foot that never lifts has one contact as long as the clip
    /// ([`CONTACT_WHOLE`]).
    pub struct Contact {
        /// The ankle's joint.
        pub joint: u32,
        /// Touchdown: from 0 up to the clip's duration.
        pub from_secs: f32,
        /// Lift-off: at most one duration after touchdown.
        pub until_secs: f32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// Location of the columns of 16 neighbouring joints of a body within a row: the fields of a
    /// [`RowBlock`], and what is at rest.
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
        /// Bits of [`REST_TRANSLATION`], [`REST_SCALE`] and [`NEAR_REST`].
        pub flags: u32,
    }
}

impl BoundBlock {
    /// Creates a block with the given flags.
    #[must_use]
    pub const fn new(rows: &RowBlock, flags: u32) -> Self {
        Self {
            rotation_first: rows.rotation_first,
            rotation_lanes: rows.rotation_lanes,
            translation_first: rows.translation_first,
            translation_lanes: rows.translation_lanes,
            scale_first: rows.scale_first,
            scale_lanes: rows.scale_lanes,
            flags,
        }
    }

    /// Returns the location of the columns.
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
