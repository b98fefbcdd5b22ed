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

pub use populace_clip::{ROW_FLOATS, RowBlock};

device_struct! {
    /// A clip bound to a body.
    pub struct BoundClip {
        /// Index into `clips`: the clip as it was added.
        pub clip: u32,
        /// Index into `clips`: the rows that the joints follow, each the column of its own number.
        /// They are those of the clip, or of the clip converted to the body.
        pub rows: u32,
        /// Offset into `poses`: the planes of [`BOUND_PLANES`].
        pub plane_first: u32,
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
        /// First word of the translations, or [`NONE`].
        pub translation_first: u32,
        /// First word of the scales, or [`NONE`].
        pub scale_first: u32,
        /// A byte each, the lowest first: columns per rotation plane, per translation plane and per
        /// scale plane; bits of [`REST_TRANSLATION`], [`REST_SCALE`], [`NEAR_REST`] and [`FLOATS`].
        pub lanes_and_flags: u32,
    }
}

/// Bits of [`BoundBlock::lanes_and_flags`] that count the columns of a plane.
const LANES_MOST: u32 = 0xff;
/// The bit of [`BoundBlock::lanes_and_flags`] at which flags begin.
const FLAGS_SHIFT: u32 = 24;

/// Returns [`FLOATS`] if the lanes of a property have [`ROW_FLOATS`], else 0.
const fn floats_of(lanes: u32) -> u32 {
    if lanes & ROW_FLOATS == 0 { 0 } else { FLOATS }
}

impl BoundBlock {
    /// Creates a block with the given flags of properties at rest.
    #[must_use]
    pub const fn new(rows: &RowBlock, rest: u32) -> Self {
        let (r, t, s) = (rows.rotation_lanes, rows.translation_lanes, rows.scale_lanes);
        let floats = floats_of(r) | floats_of(t) << 1 | floats_of(s) << 2;
        Self {
            rotation_first: rows.rotation_first,
            translation_first: rows.translation_first,
            scale_first: rows.scale_first,
            lanes_and_flags: r & LANES_MOST
                | (t & LANES_MOST) << 8
                | (s & LANES_MOST) << 16
                | (rest | floats) << FLAGS_SHIFT,
        }
    }

    /// Returns bits of [`REST_TRANSLATION`], [`REST_SCALE`], [`NEAR_REST`] and [`FLOATS`].
    #[inline]
    #[must_use]
    pub const fn flags(&self) -> u32 {
        self.lanes_and_flags >> FLAGS_SHIFT
    }

    /// Returns whether a property is stored as floats.
    #[inline]
    #[must_use]
    pub const fn has_floats(&self) -> bool {
        self.flags() & (FLOATS | FLOATS << 1 | FLOATS << 2) != 0
    }

    /// Returns the location of the columns.
    #[inline]
    #[must_use]
    pub const fn rows(&self) -> RowBlock {
        RowBlock {
            rotation_first: self.rotation_first,
            rotation_lanes: self.lanes(0),
            translation_first: self.translation_first,
            translation_lanes: self.lanes(1),
            scale_first: self.scale_first,
            scale_lanes: self.lanes(2),
        }
    }

    /// Returns the columns per plane of a property, and [`ROW_FLOATS`].
    #[inline]
    const fn lanes(&self, property: u32) -> u32 {
        let floats = if self.flags() & FLOATS << property == 0 { 0 } else { ROW_FLOATS };
        self.lanes_and_flags >> (8 * property) & LANES_MOST | floats
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bound_blocks_keep_the_location_of_columns() {
        for floats in 0..8_u32 {
            let lanes = |property: u32| {
                let flag = if floats >> property & 1 == 0 { 0 } else { ROW_FLOATS };
                flag | (7 + property)
            };
            let rows = RowBlock {
                rotation_first: 1,
                rotation_lanes: lanes(0),
                translation_first: 1 << 20,
                translation_lanes: lanes(1),
                scale_first: NONE,
                scale_lanes: lanes(2),
            };
            let bound = BoundBlock::new(&rows, REST_SCALE | NEAR_REST);
            assert_eq!(bound.rows(), rows);
            assert_eq!(bound.flags(), REST_SCALE | NEAR_REST | (FLOATS * floats));
            assert_eq!(bound.has_floats(), floats != 0);
        }
    }
}
