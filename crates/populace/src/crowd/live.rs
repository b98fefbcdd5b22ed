//! Live clips: poses that arrive while members play them.

use std::collections::HashMap;
use std::sync::Arc;

use populace_clip::{Clip, LiveFault, LiveRing, TICKS_PER_SEC, ticks_from_secs};
use populace_device::{LiveNewest, Tables};
use populace_model::Trs;
use populace_model::convert::single;
use populace_settings::parts::{Mode, Parts};

use super::ClipId;
use super::base::{Base, ClipIndex};
use crate::Error;

/// The largest distance of a stream's time from its first pose, in seconds.
const MAX_STREAM_SECS: f64 = 1e10;

/// The state of a live clip's stream. Its time is counted in ticks from the first pose. Rows are at
/// multiples of the ring's spacing, except for the newest, which is the newest pose itself.
#[derive(Clone)]
struct Stream {
    ring: LiveRing,
    /// The stream's time at the first pose.
    first_secs: f64,
    /// The crowd's tick at the first pose.
    first_tick: u64,
    /// The time of the newest pose in ticks, and that pose.
    newest: u64,
    pose: Vec<Trs>,
    /// The next multiple of the spacing at or after the newest pose, and its row in the ring.
    next: u64,
    row: u32,
    row_count: u32,
}

impl Stream {
    /// Returns the ticks from the first pose to a time of the stream.
    fn ticks_at(&self, time_secs: f64) -> u64 {
        ticks_from_secs(time_secs - self.first_secs)
    }

    fn step(&mut self) {
        self.next += u64::from(self.ring.row_ticks);
        self.row = if self.row + 1 == self.ring.rows { 0 } else { self.row + 1 };
        self.row_count = self.ring.rows.min(self.row_count + 1);
    }

    /// Writes the rows between the previous pose and `pose`, and `pose` itself.
    fn take(
        &mut self,
        tables: &mut Tables,
        index: u32,
        at: u64,
        pose: Vec<Trs>,
    ) -> Result<(), Error> {
        let row_ticks = u64::from(self.ring.row_ticks);
        // After a long pause, only as many rows as the ring holds.
        let passed = at.saturating_sub(self.next).div_ceil(row_ticks);
        let skipped = passed.saturating_sub(u64::from(self.ring.rows));
        if skipped > 0 {
            self.next += skipped * row_ticks;
            self.row_count = self.ring.rows;
        }
        while self.next < at {
            let between = (self.next - self.newest) as f64 / (at - self.newest) as f64;
            let row: Vec<_> =
                self.pose.iter().zip(&pose).map(|(a, b)| mix(a, b, between)).collect();
            tables.set_live_row(index, Some(self.row), &row)?;
            self.step();
        }
        tables.set_live_row(index, Some(self.row), &pose)?;
        (self.newest, self.pose) = (at, pose);
        self.tell(tables, index)
    }

    /// Uploads the position of the newest row.
    fn tell(&self, tables: &mut Tables, index: u32) -> Result<(), Error> {
        let early = self.next - self.newest;
        let ticks = u64::from(self.ring.row_ticks) - early;
        let newest = LiveNewest {
            tick: self.first_tick.saturating_add(self.newest),
            row: self.row,
            row_count: self.row_count,
            ticks: u32::try_from(ticks).unwrap_or(self.ring.row_ticks),
        };
        Ok(tables.set_live_newest(index, newest)?)
    }
}

/// Streams of the live clips that have received poses.
#[derive(Clone, Default)]
pub(super) struct LiveClips {
    streams: HashMap<ClipIndex, Stream>,
}

impl LiveClips {
    pub(super) fn append(
        &mut self,
        base: &mut Base,
        clip: ClipId,
        time_secs: f64,
        pose: &[Trs],
    ) -> Result<(), Error> {
        let known = base.live_clip(clip)?;
        let pose = checked(&known, pose)?;
        self.append_checked(base, ClipIndex::of(clip), &known, time_secs, pose)
    }

    pub(super) fn append_joints(
        &mut self,
        base: &mut Base,
        clip: ClipId,
        time_secs: f64,
        joints: &[(&str, Trs)],
    ) -> Result<(), Error> {
        let known = base.live_clip(clip)?;
        let skeleton = known.skeleton();
        let found = skeleton.find_all(joints.iter().map(|(name, _)| name))?;
        let mut pose = match self.streams.get(&ClipIndex::of(clip)) {
            Some(stream) => stream.pose.clone(),
            None => skeleton.joints().map(|joint| *skeleton.rest(joint)).collect(),
        };
        for (joint, (_, transform)) in found.into_iter().zip(joints) {
            pose[joint.index()] = *transform;
        }
        let pose = checked(&known, &pose)?;
        self.append_checked(base, ClipIndex::of(clip), &known, time_secs, pose)
    }

    pub(super) fn resync(
        &mut self,
        base: &mut Base,
        clip: ClipId,
        time_secs: f64,
    ) -> Result<(), Error> {
        let known = base.live_clip(clip)?;
        let tick = base.clock.tick;
        let Some(stream) = self.streams.get_mut(&ClipIndex::of(clip)) else {
            return refused(&known, LiveFault::NoPose);
        };
        check_time(&known, time_secs, stream.first_secs)?;
        let (after, before) =
            (stream.ticks_at(time_secs), ticks_from_secs(stream.first_secs - time_secs));
        stream.first_tick = tick.saturating_add(before).saturating_sub(after);
        stream.tell(&mut base.tables, clip.parts().index)
    }

    /// Forgets the stream of a clip that is removed.
    pub(super) fn forget(&mut self, clip: ClipIndex) {
        self.streams.remove(&clip);
    }

    fn append_checked(
        &mut self,
        base: &mut Base,
        index: ClipIndex,
        clip: &Arc<Clip>,
        time_secs: f64,
        mut pose: Vec<Trs>,
    ) -> Result<(), Error> {
        let Some(stream) = self.streams.get_mut(&index) else {
            check_time(clip, time_secs, time_secs)?;
            let Some(ring) = clip.ring() else { return refused(clip, LiveFault::NotLive) };
            let mut stream = Stream {
                ring,
                first_secs: time_secs,
                first_tick: base.clock.tick,
                newest: 0,
                pose: Vec::new(),
                next: 0,
                row: 0,
                row_count: 1,
            };
            base.tables.set_live_row(index.0, None, &pose)?;
            stream.take(&mut base.tables, index.0, 0, pose)?;
            self.streams.insert(index, stream);
            return Ok(());
        };
        check_time(clip, time_secs, stream.first_secs)?;
        let at = stream.ticks_at(time_secs);
        if at <= stream.newest {
            let last_secs = stream.first_secs + stream.newest as f64 / TICKS_PER_SEC as f64;
            return refused(clip, LiveFault::TimeOrder { time_secs, last_secs });
        }
        for (now, before) in pose.iter_mut().zip(&stream.pose) {
            let dot: f32 = now.rotation.iter().zip(before.rotation).map(|(a, b)| a * b).sum();
            if dot < 0.0 {
                now.rotation = now.rotation.map(|c| -c);
            }
        }
        stream.take(&mut base.tables, index.0, at, pose)
    }

    /// Returns the stream time that is shown with a delay of `delay_ticks`.
    pub(super) fn live_secs(&self, base: &Base, clip: u32, delay_ticks: u64) -> f32 {
        let Some(stream) = self.streams.get(&ClipIndex(clip)) else { return 0.0 };
        let shown = base.clock.tick.saturating_sub(delay_ticks).saturating_sub(stream.first_tick);
        let row_ticks = u64::from(stream.ring.row_ticks);
        let oldest =
            (stream.next + row_ticks).saturating_sub(u64::from(stream.row_count) * row_ticks);
        let shown = shown.max(oldest).min(stream.newest);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to the nearest f32 is what is wanted"
        )]
        let secs = (stream.first_secs + shown as f64 / TICKS_PER_SEC as f64) as f32;
        secs
    }
}

impl Base {
    /// Refuses other modes for live clips, and the live mode for other clips.
    pub(super) fn check_mode(&self, clip: ClipId, mode: Mode) -> Result<(), Error> {
        let known = self.known_clip(clip)?;
        match (known.ring(), mode) {
            (None, Mode::Live { .. }) => refused(known, LiveFault::NotLive),
            (Some(_), Mode::Looping | Mode::Once | Mode::Held { .. }) => {
                refused(known, LiveFault::NoEnd)
            }
            _ => Ok(()),
        }
    }

    fn live_clip(&self, clip: ClipId) -> Result<Arc<Clip>, Error> {
        let known = self.known_clip(clip)?;
        if known.ring().is_some() {
            Ok(Arc::clone(known))
        } else {
            refused(known, LiveFault::NotLive)
        }
    }
}

fn refused<T>(clip: &Clip, fault: LiveFault) -> Result<T, Error> {
    Err(populace_clip::Error::BadLive { clip: clip.name().to_owned(), fault }.into())
}

fn check_time(clip: &Clip, time_secs: f64, first_secs: f64) -> Result<(), Error> {
    if time_secs.is_finite() && (time_secs - first_secs).abs() <= MAX_STREAM_SECS {
        return Ok(());
    }
    refused(clip, LiveFault::Time { time_secs })
}

/// Checks a pose for the clip's skeleton and returns it with rotations of length 1.
fn checked(clip: &Clip, pose: &[Trs]) -> Result<Vec<Trs>, Error> {
    let skeleton = clip.skeleton();
    if pose.len() != skeleton.joint_count() {
        let (count, joints) = (pose.len(), skeleton.joint_count());
        return refused(clip, LiveFault::PoseLength { count, joints });
    }
    let one = |(joint, trs): (_, &Trs)| {
        let length = trs.rotation.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
        if !(trs.is_bounded() && length.is_finite() && length > 1e-6) {
            let joint = skeleton.name(joint).to_owned();
            return refused(clip, LiveFault::Transform { joint, transform: *trs });
        }
        Ok(Trs { rotation: trs.rotation.map(|c| single(f64::from(c) / length)), ..*trs })
    };
    skeleton.joints().zip(pose).map(one).collect()
}

/// Interpolates a joint from `a` to `b`, whose rotations lie in the same hemisphere.
fn mix(a: &Trs, b: &Trs, between: f64) -> Trs {
    let one = |(a, b): (f32, f32)| f64::from(a) * (1.0 - between) + f64::from(b) * between;
    let three = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|i| single(one((a[i], b[i]))));
    let turned: [f64; 4] = std::array::from_fn(|i| one((a.rotation[i], b.rotation[i])));
    let length = turned.iter().map(|c| c * c).sum::<f64>().sqrt();
    Trs {
        translation: three(a.translation, b.translation),
        rotation: turned.map(|c| single(c / length)),
        scale: three(a.scale, b.scale),
    }
}
