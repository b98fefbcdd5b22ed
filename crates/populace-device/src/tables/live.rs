//! Live clips, whose rows arrive while they play.

use populace_clip::Clip;
use populace_model::Trs;
use populace_model::convert::u32_from;
use populace_model::math::quat;
use populace_retarget::Converted;

use super::Tables;
use super::binding::set_first_pose;
use super::set::TableSet;
use crate::Error;
use crate::layout::{ClipRows, NONE};

/// A live clip, and the bound clips that show it on other bodies.
#[derive(Clone, Debug)]
pub(super) struct LiveClip {
    clip: Clip,
    followers: Vec<LiveFollower>,
}

/// A bound clip that shows a live clip's poses converted to its body.
#[derive(Clone, Debug)]
struct LiveFollower {
    bound: u32,
    /// The index of the converted clip.
    rows: u32,
    converted: Converted,
    /// The pose converted last; empty before the first.
    last: Vec<Trs>,
}

impl LiveFollower {
    /// Converts a pose to a row. Its rotations are in the hemispheres of those of the pose before:
    /// a product of rotations may leave them, though each of its factors does not.
    fn row_of(&mut self, pose: &[Trs]) -> Vec<u32> {
        let mut pose = self.converted.retarget.pose(pose);
        for (now, before) in pose.iter_mut().zip(&self.last) {
            if quat::dot(now.rotation, before.rotation) < 0.0 {
                now.rotation = now.rotation.map(|c| -c);
            }
        }
        self.last = pose;
        self.converted.clip.row_of(&self.last)
    }
}

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
    /// Keeps a clip if it is live.
    pub(super) fn add_live(&mut self, index: u32, clip: &Clip) {
        if clip.ring().is_some() {
            self.had_live_clips = true;
            self.live_clips.insert(index, LiveClip { clip: clip.clone(), followers: Vec::new() });
        }
    }

    /// Makes the bound clip `bound` follow the live clip `index`. Converts all rows of the live
    /// clip's ring into the clip `rows`. [`set_live_row`](Self::set_live_row) converts later rows.
    /// Does nothing if the clip `index` is not live.
    pub(super) fn follow_live(&mut self, index: u32, bound: u32, rows: u32, converted: &Converted) {
        let Some(live) = self.live_clips.get_mut(&index) else {
            return;
        };
        let mut follower =
            LiveFollower { bound, rows, converted: converted.clone(), last: Vec::new() };
        let all = &mut self.all;
        let (from, to) =
            (all.clips.as_slice()[index as usize], all.clips.as_slice()[rows as usize]);
        // The first row, then those of the ring, oldest first.
        let oldest = from.newest_row + from.ring_rows + 1 - from.row_count;
        let ring = (0..from.row_count).map(|nth| 1 + (oldest + nth) % from.ring_rows);
        for nth in std::iter::once(0).chain(ring) {
            let words = from.row_first as usize + nth as usize * from.row_stride as usize;
            let words = &all.rows.as_slice()[words..][..from.row_stride as usize];
            let row = follower.row_of(&live.clip.pose_of(words));
            write_row(all, &to, nth as usize, &row);
        }
        let ClipRows { row_first, row_stride, has_floats, .. } = to;
        all.clips.set(rows as usize, ClipRows { row_first, row_stride, has_floats, ..from });
        live.followers.push(follower);
    }

    /// Returns whether a converted clip can follow a clip: neither is live, or both have the same
    /// ring and number of joints to convert.
    pub(super) fn can_follow(&self, index: u32, converted: &Converted) -> bool {
        match self.live_clips.get(&index) {
            None => converted.clip.ring().is_none(),
            Some(live) => {
                live.clip.ring() == converted.clip.ring()
                    && live.clip.skeleton().joint_count() == converted.retarget.joint_count()
            }
        }
    }

    /// Ends what [`follow_live`](Self::follow_live) began for a bound clip of the clip `index`.
    pub(super) fn forget_follower(&mut self, index: u32, bound: u32) {
        if let Some(live) = self.live_clips.get_mut(&index) {
            live.followers.retain(|follower| follower.bound != bound);
        }
    }

    /// Writes a pose into a row of a live clip's ring, and into those of the bound clips that it is
    /// converted for. With `row` of `None` it writes the first row, and stores it as the first pose
    /// of the bound clips, from which additive layers take differences.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the clip is not live, the row does not exist or the pose has
    /// another number of joints than the clip's own skeleton.
    pub fn set_live_row(
        &mut self,
        index: u32,
        row: Option<u32>,
        pose: &[Trs],
    ) -> Result<(), Error> {
        let live = self.live_clips.get_mut(&index);
        let live = live.ok_or(Error::BadPlayback { what: "live clip", value: index })?;
        if pose.len() != live.clip.skeleton().joint_count() {
            let (what, value) = ("number of joints of a live pose", u32_from(pose.len()));
            return Err(Error::BadPlayback { what, value });
        }
        let rows = self.all.clips.as_slice()[index as usize];
        if let Some(row) = row.filter(|row| *row >= rows.ring_rows) {
            return Err(Error::BadPlayback { what: "ring row", value: row });
        }
        let nth = row.map_or(0, |row| row as usize + 1);
        let row = live.clip.row_of(pose);
        write_row(&mut self.all, &rows, nth, &row);
        // The clip may not receive all that the pose holds.
        let received = live.clip.pose_of(&row);
        for follower in &mut live.followers {
            let rows = self.all.clips.as_slice()[follower.rows as usize];
            write_row(&mut self.all, &rows, nth, &follower.row_of(&received));
        }
        if nth == 0 {
            let bound_clips = (0..).zip(self.all.bound_clips.as_slice());
            let bound = bound_clips.filter(|(_, bound)| bound.body != NONE && bound.clip == index);
            let numbers: Vec<u32> = bound.map(|(number, _)| number).collect();
            for number in numbers {
                self.store_first_pose(number);
            }
        }
        Ok(())
    }

    /// Stores the first row of a live clip as the first pose of a clip bound to it. Does nothing if
    /// the clip is not live.
    pub(super) fn store_first_pose(&mut self, number: u32) {
        let TableSet { bodies, bound_clips, clips, rows, poses, .. } = &mut self.all;
        let bound = bound_clips.as_slice()[number as usize];
        let Some(live) = self.live_clips.get(&bound.clip) else {
            return;
        };
        let follower = live.followers.iter().find(|follower| follower.bound == number);
        let clip = follower.map_or(&live.clip, |follower| &follower.converted.clip);
        let ClipRows { row_first, row_stride, .. } = clips.as_slice()[bound.rows as usize];
        let words = &rows.as_slice()[row_first as usize..][..row_stride as usize];
        let mut pose = clip.pose_of(words);
        // The clip may have more joints than the body.
        pose.truncate(bodies.as_slice()[bound.body as usize].joint_count as usize);
        set_first_pose(poses, bound.plane_first, &pose);
    }

    /// Sets the newest row of a live clip.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the clip is not live, or if the row, row count or tick count is
    /// out of range.
    pub fn set_live_newest(&mut self, index: u32, newest: LiveNewest) -> Result<(), Error> {
        let live = self.live_clips.get(&index);
        let live = live.ok_or(Error::BadPlayback { what: "live clip", value: index })?;
        let rows = self.all.clips.as_slice()[index as usize];
        for (what, value, fits) in [
            ("ring row", newest.row, newest.row < rows.ring_rows),
            ("row count", newest.row_count, (1..=rows.ring_rows).contains(&newest.row_count)),
            ("row length in ticks", newest.ticks, (1..=rows.row_ticks).contains(&newest.ticks)),
        ] {
            if !fits {
                return Err(Error::BadPlayback { what, value });
            }
        }
        let followers = live.followers.iter().map(|follower| follower.rows);
        for index in std::iter::once(index).chain(followers) {
            let rows = ClipRows {
                newest_tick: newest.tick,
                newest_row: newest.row,
                row_count: newest.row_count,
                newest_ticks: newest.ticks,
                per_newest_tick: 1.0 / newest.ticks as f32,
                ..self.all.clips.as_slice()[index as usize]
            };
            self.all.clips.set(index as usize, rows);
        }
        Ok(())
    }
}

/// Writes the `nth` row behind the first of a live clip.
fn write_row(all: &mut TableSet, rows: &ClipRows, nth: usize, words: &[u32]) {
    all.rows.set_run(rows.row_first as usize + nth * rows.row_stride as usize, words);
}
