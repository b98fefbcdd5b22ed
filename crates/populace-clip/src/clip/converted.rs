//! Clips whose poses are converted to another skeleton.

use populace_model::{ClipSource, JointIndex, Skeleton, Trs};

use super::Clip;
use crate::contacts::Contacts;
use crate::curves::{Local, Side};
use crate::row::{Motion, Row};
use crate::rows::Rows;

/// A place within the rows of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowPlace {
    /// The row at or before the place.
    pub row: usize,
    /// Part of the way from there to the next row, from 0 to below 1.
    pub between: f64,
}

/// A clip's rows, interpolated and converted.
struct Converted<'a, F> {
    times: &'a [f32],
    rows: Vec<Vec<Local>>,
    convert: F,
}

impl<F> Motion for Converted<'_, F>
where
    F: Fn(RowPlace, &[Local]) -> Vec<Local>,
{
    fn pose(&self, secs: f64, side: Side) -> Vec<Local> {
        let Self { times, rows, convert } = self;
        let at = |row: usize| f64::from(times[row]);
        // Of two rows at one time, the first is before the jump.
        let row = match side {
            Side::After => times.partition_point(|t| f64::from(*t) <= secs).max(1) - 1,
            Side::Before => times.partition_point(|t| f64::from(*t) < secs).min(times.len() - 1),
        };
        if secs <= at(row) || row + 1 == times.len() {
            return convert(RowPlace { row, between: 0.0 }, &rows[row]);
        }
        let between = (secs - at(row)) / (at(row + 1) - at(row));
        let joints = rows[row].iter().zip(&rows[row + 1]);
        let pose: Vec<Local> = joints.map(|(a, b)| a.mix(b, between)).collect();
        convert(RowPlace { row, between }, &pose)
    }

    fn deviation(&self, _: JointIndex, _: [&Row; 2], _: f64) -> f64 {
        f64::INFINITY
    }
}

impl Clip {
    /// Converts the clip to poses of another skeleton. `convert` converts the pose of all joints
    /// of the clip's own skeleton at a place within its rows. The result has a row at the time of
    /// each of these rows, and further rows wherever interpolation would deviate from converted
    /// poses by more than the error bound of a [`Clip`]. `moves` tells for each joint of `skeleton`
    /// and [`Property`](populace_model::Property) whether it follows the rows.
    ///
    /// The result has no source, no footsteps and no root motion. Its error bound counts from the
    /// rows of the clip, not from the source curves.
    ///
    /// # Panics
    ///
    /// If `moves` or a converted pose has too few joints.
    #[must_use]
    pub fn converted(
        &self,
        skeleton: &Skeleton,
        moves: Vec<[bool; 3]>,
        convert: impl Fn(RowPlace, &[Local]) -> Vec<Local>,
    ) -> Self {
        if let Some(ring) = self.ring {
            let first = RowPlace { row: 0, between: 0.0 };
            let pose = convert(first, &self.pose_at(0)).iter().map(Local::trs).collect();
            return Self::with_ring(self.name(), skeleton, ring, pose, moves);
        }
        let mut times: Vec<(f32, bool)> = Vec::with_capacity(self.row_count());
        for &secs in &self.rows.times {
            match times.last_mut().filter(|last| last.0 == secs) {
                Some(last) => last.1 = true,
                None => times.push((secs, false)),
            }
        }
        let rows = (0..self.row_count()).map(|row| self.pose_at(row)).collect();
        let motion = Converted { times: &self.rows.times, rows, convert };
        let rows = Rows::of(&motion, times, moves, skeleton, usize::MAX);
        Self::of_rows(self.name(), skeleton, rows)
    }

    /// Copies the clip with its columns in the order of another skeleton's joints. `columns` names
    /// the clip's joint that each joint of `skeleton` follows; joints and properties that the clip
    /// does not drive keep the rest of `skeleton`. Values are those of the clip: rows and their
    /// times are the same.
    ///
    /// The result has no source, no footsteps and no root motion. Its error bound is that of the
    /// clip on its own skeleton.
    ///
    /// # Panics
    ///
    /// If `columns` has fewer joints than `skeleton`, or names one that the clip lacks.
    #[must_use]
    pub fn arranged(&self, skeleton: &Skeleton, columns: &[Option<JointIndex>]) -> Self {
        let driven = |joint: JointIndex| self.rows.driven[joint.index()];
        let copied: Vec<_> =
            columns.iter().map(|from| from.map(|from| (from.index(), driven(from)))).collect();
        let rest: Vec<Trs> = skeleton.joints().map(|joint| *skeleton.rest(joint)).collect();
        let Rows { times, buckets, buckets_per_sec, rows_per_sec, .. } = &self.rows;
        let rows = Rows {
            times: times.clone(),
            storage: self.rows.storage.arranged(&copied, &rest),
            buckets: buckets.clone(),
            buckets_per_sec: *buckets_per_sec,
            rows_per_sec: *rows_per_sec,
            driven: copied.iter().map(|from| from.map_or([false; 3], |(_, d)| d)).collect(),
            error_bound_m: self.rows.error_bound_m,
            tolerance_m: self.rows.tolerance_m,
        };
        Self { ring: self.ring, ..Self::of_rows(self.name(), skeleton, rows) }
    }

    /// Creates a clip of nothing but rows.
    pub(super) fn of_rows(name: &str, skeleton: &Skeleton, rows: Rows) -> Self {
        let source = ClipSource { name: name.to_owned(), tracks: Vec::new() };
        let (skeleton, contacts) = (skeleton.clone(), Contacts::default());
        Self { source, skeleton, rows, contacts, ring: None, motion: None }
    }

    pub(super) fn pose_at(&self, row: usize) -> Vec<Local> {
        self.skeleton.joints().map(|joint| self.rows.local(joint, row, 0.0)).collect()
    }
}

#[cfg(test)]
mod tests;
