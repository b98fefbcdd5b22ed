//! Conversion of source curves to rows within the error bound.

use populace_model::{Interpolation, JointIndex, Property, Skeleton, Trs, f64math};

use crate::curves::{Curves, Local, Side};
use crate::gap::Gap;
use crate::probes::{Judge, Reach, distance_at_probes, in_joint_units};
use crate::row::{Motion, Row};
use crate::storage::Storage;

/// The distance from a joint, in sizes of the body ([`Skeleton::size_m`]), up to which the error
/// bound of clips holds. One stray vertex would otherwise ask for thousands of rows.
pub const FARTHEST_SIZES: f32 = 32.0;

/// Error bound for a body of 1.8 m, in metres. It is half of what is promised at 3 cm from the
/// joints, so that vertices stay within 1e-4 of the body's height of the source curves.
const TOLERANCE_M: f64 = 0.000_16;
/// The part of the error bound that 16-bit storage may use.
const STORAGE_M: f64 = 0.000_06;
const TOLERANCE_BODY_M: f64 = 1.8;
/// Distance from each joint at which the error is measured, unless the vertices that the joint
/// moves are further away.
const PROBE_M: f64 = 0.03;
/// Error of single precision relative to the body's size: a few roundings of 2^-24 along a chain.
const COMPUTED: f64 = 4.8e-7;
/// Maximum number of times that a gap between keys is halved.
const MAX_HALVINGS: u32 = 12;
/// Limits on the rows of a clip: this many per key time, plus this many poses of one joint in
/// total. They keep a small file from using a disproportionate amount of memory. If the limits are
/// too low for a clip, its reported error exceeds the bound.
const ROWS_PER_KEY: usize = 8;
const FREE_POSES: usize = 200_000;
/// Rows count as evenly spaced if none is off by more than this part of the spacing.
const EVEN_SPACING: f64 = 1e-4;

/// The rows of a clip; see [`Clip`](crate::Clip) for their layout.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    pub(crate) times: Vec<f32>,
    pub(crate) storage: Storage,
    pub(crate) buckets: Vec<u32>,
    pub(crate) buckets_per_sec: f32,
    pub(crate) rows_per_sec: f32,
    /// For each column and [`Property`](populace_model::Property): whether a track drives it.
    pub(crate) driven: Vec<[bool; 3]>,
    pub(crate) error_bound_m: f32,
    pub(crate) tolerance_m: f32,
}

impl Rows {
    pub(crate) fn new(curves: &Curves, skeleton: &Skeleton, most_rows: usize) -> Self {
        let driven = skeleton
            .joints()
            .map(|j| Property::ALL.map(|p| curves.track(j, p).is_some()))
            .collect();
        Self::of(curves, key_times(curves), driven, skeleton, most_rows)
    }

    /// Converts a motion of `skeleton` that may have a corner at each of `times`, and jumps at
    /// those with `true`.
    pub(crate) fn of(
        motion: &dyn Motion,
        times: Vec<(f32, bool)>,
        driven: Vec<[bool; 3]>,
        skeleton: &Skeleton,
        most_rows: usize,
    ) -> Self {
        let scale = f64::from(skeleton.size_m()) / TOLERANCE_BODY_M;
        let tolerance = TOLERANCE_M * scale;
        let allowed = tolerance - STORAGE_M * scale - COMPUTED * f64::from(skeleton.size_m());
        let farthest = f64::from(FARTHEST_SIZES) * f64::from(skeleton.size_m());
        let probe = |&reach: &f32| f64::from(reach).clamp(PROBE_M * scale, farthest);
        let probes: Vec<f64> = skeleton.reach_m().iter().map(probe).collect();
        let reach = Reach::new(skeleton, &probes);
        let probes = &in_joint_units(skeleton, &probes);
        let mut rows = Vec::new();
        let mut worst: f64 = 0.0;
        let most =
            (ROWS_PER_KEY * times.len() + FREE_POSES / skeleton.joint_count()).min(most_rows);
        for (secs, jumps) in times {
            let row = Row::new(motion, secs, if jumps { Side::Before } else { Side::After });
            if let Some(last) = rows.pop() {
                let gap = Gap { motion, skeleton, probes, reach: &reach, allowed, most };
                worst = worst.max(gap.fill(last, &row, MAX_HALVINGS, &mut rows));
            }
            rows.push(row);
            if jumps {
                rows.push(Row::new(motion, secs, Side::After));
            }
        }
        let allowed = STORAGE_M * scale;
        let storage = Storage::new(
            &rows,
            &rounded(&rows),
            &Judge { skeleton, probes, reach: &reach.over(&[]), allowed },
        );
        let bound = worst + storage.error_m + COMPUTED * f64::from(skeleton.size_m());
        let [error_bound_m, tolerance_m] = f64math::to_f32([bound, tolerance]);
        debug_assert!(rows.windows(2).all(|w| w[0].secs < w[1].secs || w[0].side < w[1].side));
        let times: Vec<f32> = rows.iter().map(|row| row.secs).collect();
        let rows_per_sec = even_rate(&times);
        let (buckets, buckets_per_sec) =
            if rows_per_sec > 0.0 || times.len() < 2 { (Vec::new(), 0.0) } else { buckets(&times) };
        Self {
            times,
            storage,
            buckets,
            buckets_per_sec,
            rows_per_sec,
            driven,
            error_bound_m,
            tolerance_m,
        }
    }

    /// See [`Clip::measured_error_m`](crate::Clip::measured_error_m).
    pub(crate) fn measured_error_m(
        &self,
        curves: &Curves,
        skeleton: &Skeleton,
        points: usize,
    ) -> f32 {
        let probes =
            vec![PROBE_M * f64::from(skeleton.size_m()) / TOLERANCE_BODY_M; skeleton.joint_count()];
        let probes = in_joint_units(skeleton, &probes);
        let parents = skeleton.parents();
        let mut worst: f64 = 0.0;
        for at in 0..self.times.len() - 1 {
            let (from, to) = (f64::from(self.times[at]), f64::from(self.times[at + 1]));
            if from >= to {
                continue; // both sides of a STEP
            }
            for point in 0..=points {
                let u = point as f64 / (points + 1) as f64;
                let secs = from + (to - from) * u;
                let exact = skeleton.joints().map(|j| curves.local(j, secs, Side::After).affine());
                let exact = f64math::model_from_joints(parents, exact);
                let stored = skeleton.joints().map(|j| self.local(j, at, u).affine());
                let stored = f64math::model_from_joints(parents, stored);
                for ((a, b), &probe) in exact.iter().zip(&stored).zip(&probes) {
                    worst = worst.max(distance_at_probes(a, b, probe));
                }
            }
        }
        f64math::to_f32([worst])[0]
    }

    /// Returns a joint's local transform between two stored rows, as interpolated by devices.
    pub(crate) fn local(&self, joint: JointIndex, row: usize, u: f64) -> Local {
        self.storage.local(joint, [row, (row + 1).min(self.times.len() - 1)], u)
    }
}

/// Returns all key times, each with a flag that tells whether a STEP track jumps there. A clip
/// without keys has the single time 0.
fn key_times(curves: &Curves) -> Vec<(f32, bool)> {
    let mut times = Vec::new();
    for track in curves.all_tracks() {
        let step = track.interpolation == Interpolation::Step;
        for (key, &secs) in track.times.iter().enumerate() {
            times.push((secs, step && key > 0 && track.value(key) != track.value(key - 1)));
        }
    }
    if times.is_empty() {
        // Keys of joints that the skeleton lacks still determine the clip's length.
        let (start, end) = curves.source.time_range_secs();
        times = vec![(start, false), (end, false)];
    }
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    times.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        kept.1 |= same && next.1;
        same
    });
    times
}

/// Converts rows to single precision, with each rotation in the hemisphere of the previous row.
fn rounded(rows: &[Row]) -> Vec<Vec<Trs>> {
    let mut poses: Vec<Vec<Trs>> = Vec::with_capacity(rows.len());
    for row in rows {
        let mut pose = Vec::with_capacity(row.pose.len());
        for (column, local) in row.pose.iter().enumerate() {
            let mut rotation = f64math::to_f32(local.rotation.to_array());
            let before = poses.last().map(|last| last[column].rotation);
            if before.is_some_and(|b| populace_model::math::quat::dot(b, rotation) < 0.0) {
                rotation = rotation.map(|v| -v);
            }
            pose.push(Trs {
                translation: f64math::to_f32(local.translation.to_array()),
                rotation,
                scale: f64math::to_f32(local.scale.to_array()),
            });
        }
        poses.push(pose);
    }
    poses
}

/// Returns rows per second if rows are evenly spaced, else 0.
fn even_rate(times: &[f32]) -> f32 {
    let last = times.len() - 1;
    let start = f64::from(times[0]);
    let span = f64::from(times[last]) - start;
    if last == 0 || span <= 0.0 {
        return 0.0;
    }
    let spacing = span / last as f64;
    let even = times.iter().enumerate().all(|(row, &t)| {
        (f64::from(t) - start - spacing * row as f64).abs() <= EVEN_SPACING * spacing
    });
    if even { f64math::to_f32([1.0 / spacing])[0] } else { 0.0 }
}

/// Builds one bucket per row. A bucket holds the last row at or before the bucket's start, minus a
/// hundredth of a bucket, so that rounding on a device cannot skip a row.
fn buckets(times: &[f32]) -> (Vec<u32>, f32) {
    let start = f64::from(times[0]);
    let span = f64::from(times[times.len() - 1]) - start;
    let count = times.len();
    let per_sec = if span > 0.0 { count as f64 / span } else { 0.0 };
    let mut row = 0;
    let buckets = (0..count).map(|bucket| {
        let from = start + (bucket as f64 - 0.01) / per_sec.max(1e-30);
        while row + 1 < count && f64::from(times[row + 1]) <= from {
            row += 1;
        }
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rows are limited by the memory of their keys"
        )]
        let row = row as u32;
        row
    });
    (buckets.collect(), f64math::to_f32([per_sec])[0])
}
