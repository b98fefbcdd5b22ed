//! Clips: animations as rows of poses, and their binding to skeletons.

mod converted;
mod live;
mod motion;

use glam::DAffine3;
use populace_model::{ClipSource, JointIndex, Property, Skeleton, Trs, f64math};

use crate::Error;
use crate::contacts::{Contacts, Footstep};
use crate::curves::{self, Curves};
use crate::row_block::RowBlock;
use crate::rows::Rows;
use crate::storage::Range;

pub use converted::RowPlace;
pub use live::{LiveRing, LiveSettings, Streamed};
pub use motion::{MotionOrigin, MotionSettings, MotionSource, RootMotion};

/// Tolerances within which the rests of two joints of the same name count as equal: rotation in
/// radians, and distance as a fraction of the bodies' size.
const SAME_TURN_RAD: f64 = 0.01;
const SAME_PLACE: f64 = 0.002;

/// An animation, stored as rows. A row is the pose of all joints of the clip's own skeleton at one
/// time. There is a row at every key time of any track, and further rows wherever interpolation
/// between rows would deviate from the source curves by more than the error bound.
///
/// The error bound is 0.16 mm in model space for a body of 1.8 m, and proportional for others. It
/// holds at points 3 cm from each joint, and as far from it as the vertices that it moves
/// ([`Skeleton::with_reach`]), up to [`FARTHEST_SIZES`](crate::FARTHEST_SIZES) times the size of
/// the body: what is farther away is off in proportion to its distance. Between rows, devices
/// interpolate translations and scales linearly, and rotations by normalised linear interpolation.
/// A STEP key is stored as two rows at one time.
///
/// A row holds blocks of 16 joints ("columns", in the level order of the clip's own skeleton),
/// joints fastest, with 16 bits per component over the joint's own range (see [`RowBlock`]). Blocks
/// in which nothing moves are omitted. Storage uses up part of the error bound; animations that 16
/// bits cannot represent within it are stored as floats.
///
/// Clips that were converted to another skeleton ([`converted`](Self::converted),
/// [`arranged`](Self::arranged)) have no source: nothing can be measured against it.
#[derive(Clone, Debug)]
pub struct Clip {
    source: ClipSource,
    skeleton: Skeleton,
    rows: Rows,
    contacts: Contacts,
    /// Set for live clips.
    ring: Option<LiveRing>,
    /// Root motion that was taken out of the pose.
    motion: Option<RootMotion>,
}

/// Statistics of a clip from loading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipStats {
    /// Number of rows stored.
    pub row_count: usize,
    /// True if rows are evenly spaced, so that the row of a time is found by multiplication.
    pub evenly_spaced: bool,
    /// Bytes of rows, row times, buckets and ranges.
    pub row_bytes: usize,
    /// Bytes of the source's key times and values.
    pub key_bytes: usize,
    /// Upper bound of the deviation from the source curves, in metres, for all points 3 cm from a
    /// joint (in proportion for bodies that are not 1.8 m) or as far from it as its vertices. At
    /// most [`tolerance_m`](Self::tolerance_m), unless the curves need more rows than a clip with
    /// so few keys may have.
    pub error_bound_m: f32,
    /// The bound asked for, in metres.
    pub tolerance_m: f32,
    /// Mean backward speed of the planted foot in metres per second; `None` if no joint has a known
    /// foot name or no foot is ever planted.
    pub ground_speed_m_per_sec: Option<f32>,
}

impl Clip {
    /// Converts an animation to rows. `skeleton` is the clip's own: that of the file it comes from.
    /// Tracks of joints that the skeleton lacks are kept in the source and have no effect.
    ///
    /// # Errors
    ///
    /// [`BadTrack`](populace_model::Error::BadTrack) or [`Error::DuplicateTrack`].
    pub fn new(source: ClipSource, skeleton: &Skeleton) -> Result<Self, Error> {
        Self::with_at_most(usize::MAX, source, skeleton)
    }

    /// Maximum number of bytes that a joint needs per row while a clip is created.
    pub const POSE_BYTES: usize =
        size_of::<curves::Local>() + size_of::<populace_model::Trs>() + ROW_POSE_BYTES;

    /// Like [`new`](Self::new), but gaps between keys are subdivided only while there are fewer
    /// than `most_rows` rows. Every key still gets its row. If these rows are not enough,
    /// [`ClipStats::error_bound_m`] exceeds the tolerance.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn with_at_most(
        most_rows: usize,
        source: ClipSource,
        skeleton: &Skeleton,
    ) -> Result<Self, Error> {
        let curves = Curves::new(&source, skeleton)?;
        let rows = Rows::new(&curves, skeleton, most_rows);
        let contacts = Contacts::new(&rows, skeleton);
        Ok(Self { source, skeleton: skeleton.clone(), rows, contacts, ring: None, motion: None })
    }

    /// The clip's name; may be empty.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.source.name
    }

    /// The animation as stored in the file.
    #[must_use]
    pub fn source(&self) -> &ClipSource {
        &self.source
    }

    /// The clip's own skeleton: that of the file it comes from.
    #[must_use]
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// Time of the first key on the clip's own axis, in seconds.
    #[must_use]
    pub fn start_secs(&self) -> f32 {
        self.rows.times[0]
    }

    /// Time from the first key to the last, in seconds; may be 0.
    #[must_use]
    pub fn duration_secs(&self) -> f32 {
        self.rows.times[self.rows.times.len() - 1] - self.rows.times[0]
    }

    /// Times at which feet touch down, in ascending order. Empty if no joint has a known foot name.
    /// Detected on load.
    #[must_use]
    pub fn footsteps(&self) -> &[Footstep] {
        &self.contacts.footsteps
    }

    /// Statistics of the clip.
    #[must_use]
    pub fn stats(&self) -> ClipStats {
        let rows = &self.rows;
        let keys = self.source.tracks.iter().map(|t| t.times.len() + t.values.len()).sum::<usize>();
        ClipStats {
            row_count: rows.times.len(),
            evenly_spaced: rows.buckets.is_empty(),
            row_bytes: 4 * (rows.storage.words.len() + rows.buckets.len() + self.row_times().len())
                + rows.storage.range_bytes(),
            key_bytes: 4 * keys,
            error_bound_m: rows.error_bound_m,
            tolerance_m: rows.tolerance_m,
            ground_speed_m_per_sec: self.contacts.speed,
        }
    }

    /// Measures the error: the largest distance between a point 3 cm from a joint (in proportion
    /// for bodies that are not 1.8 m) as the source curves move it and as the rows do. It is
    /// evaluated at `points` times between each two rows, in metres.
    ///
    /// # Panics
    ///
    /// If `skeleton` has another number of joints than the clip's own.
    #[must_use]
    pub fn measured_error_m(&self, skeleton: &Skeleton, points: usize) -> f32 {
        assert_eq!(
            self.skeleton.joint_count(),
            skeleton.joint_count(),
            "not the clip's own skeleton"
        );
        let curves = Curves::new(&self.source, skeleton).expect("checked by `new`");
        self.rows.measured_error_m(&curves, skeleton, points)
    }

    /// Maximum storage error of a joint at the times of the rows: of its rotation components, of
    /// its translation in metres, or of its scale factors. 0 if the clip does not have the joint.
    /// Part of [`ClipStats::error_bound_m`].
    #[must_use]
    pub fn storage_error(&self, joint: &str, property: Property) -> f32 {
        let column = self.skeleton.find(joint);
        column.map_or(0.0, |column| self.rows.storage.worst[column.index()][property as usize])
    }

    /// Returns whether the skeleton can be that of the clip: it has at least half of the joint
    /// names that the clip drives, with the same rests.
    #[must_use]
    pub fn is_made_for(&self, skeleton: &Skeleton) -> bool {
        let (size, own_size) = (f64::from(skeleton.size_m()), f64::from(self.skeleton.size_m()));
        let (mut driven, mut found) = (0, 0);
        for own in self.skeleton.joints().filter(|own| self.drives(*own)) {
            driven += 1;
            let Some(joint) = skeleton.find(self.skeleton.name(own)) else {
                continue;
            };
            found += 1;
            let (a, b) = (skeleton.rest(joint), self.skeleton.rest(own));
            let apart = f64math::vec3(a.translation).distance(f64math::vec3(b.translation));
            let turned = f64math::quat(a.rotation).angle_between(f64math::quat(b.rotation));
            if turned > SAME_TURN_RAD || apart > SAME_PLACE * size.max(own_size) {
                return false;
            }
        }
        found > 0 && 2 * found >= driven
    }

    /// Returns whether any track drives a joint of the clip's own skeleton.
    #[must_use]
    pub fn drives(&self, joint: JointIndex) -> bool {
        self.rows.driven[joint.index()].iter().any(|driven| *driven)
    }

    /// Returns whether a track drives a property of a joint of the clip's own skeleton.
    #[must_use]
    pub fn drives_property(&self, joint: JointIndex, property: Property) -> bool {
        self.rows.driven[joint.index()][property as usize]
    }

    /// The range of stored components for each joint of the clip's own skeleton and [`Property`].
    #[must_use]
    pub fn ranges(&self) -> &[[Range; 3]] {
        &self.rows.storage.ranges
    }

    /// Returns the local transforms of all joints in the first row.
    #[must_use]
    pub fn first_pose(&self) -> Vec<Trs> {
        self.pose_at(0).iter().map(curves::Local::trs).collect()
    }

    /// Iterates over the poses of every `every`th row, as local transforms of all joints. 0 counts
    /// as 1: all rows.
    pub fn row_poses(&self, every: usize) -> impl Iterator<Item = Vec<DAffine3>> + '_ {
        let pose = move |row| {
            let local = |joint| self.rows.local(joint, row, 0.0).affine();
            self.skeleton.joints().map(local).collect()
        };
        (0..self.row_count()).step_by(every.max(1)).map(pose)
    }

    /// All rows, one after the other.
    #[must_use]
    pub fn rows(&self) -> &[u32] {
        &self.rows.storage.words
    }

    /// Words from one row to the next.
    #[must_use]
    pub fn row_stride(&self) -> usize {
        self.rows.storage.stride
    }

    /// The number of rows; at least one.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.rows.times.len()
    }

    /// Rows per second if they are evenly spaced, else 0.
    #[must_use]
    pub fn rows_per_sec(&self) -> f32 {
        self.rows.rows_per_sec
    }

    /// Times of the rows on the clip's own axis; empty if rows are evenly spaced.
    #[must_use]
    pub fn row_times(&self) -> &[f32] {
        if self.rows.buckets.is_empty() { &[] } else { &self.rows.times }
    }

    /// A row at or before the start of each bucket, and buckets per second. Empty if rows are
    /// evenly spaced.
    #[must_use]
    pub fn buckets(&self) -> (&[u32], f32) {
        (&self.rows.buckets, self.rows.buckets_per_sec)
    }

    /// Location within a row of each block of 16 columns.
    #[must_use]
    pub fn row_blocks(&self) -> &[RowBlock] {
        &self.rows.storage.blocks
    }
}

/// Maximum size of a joint in a stored row: all its components as floats.
const ROW_POSE_BYTES: usize = 4 * (4 + 3 + 3);

#[cfg(test)]
mod tests {
    use super::*;
    use populace_model::{Interpolation, JointSource, Track, Trs};

    #[test]
    fn wild_splines_get_bounded_rows_and_report_their_error() {
        let joints: Vec<_> = (0..100)
            .map(|i| JointSource { name: format!("joint {i}"), parent: None, rest: Trs::IDENTITY })
            .collect();
        let skeleton = Skeleton::new(&joints).unwrap();
        let track = |joint: &JointSource| Track {
            joint: joint.name.clone(),
            property: Property::Translation,
            interpolation: Interpolation::CubicSpline,
            times: (0..20).map(|key| key as f32).collect(),
            values: [[1e6; 3], [0.0; 3], [-1e6; 3]].concat().repeat(20),
        };
        let source = ClipSource { name: "wild".into(), tracks: joints.iter().map(track).collect() };
        let stats = Clip::new(source, &skeleton).unwrap().stats();
        // 8 rows per key, 200,000 poses of one joint in addition, and the rows that were pending
        // when the limit was reached.
        assert!(stats.row_count < 20 * 8 + 2000 + 50, "{} rows", stats.row_count);
        assert!(stats.error_bound_m > stats.tolerance_m);
    }

    #[test]
    fn a_vertex_far_away_makes_no_more_rows_than_the_farthest_that_count() {
        let below = Trs { translation: [0.0, 1.0, 0.0], ..Trs::IDENTITY };
        let joint = |name: &str, parent, rest| JointSource { name: name.into(), parent, rest };
        let joints = [joint("upper", None, Trs::IDENTITY), joint("lower", Some(0), below)];
        let rows = |reach: f32| {
            let skeleton = Skeleton::new(&joints).unwrap().with_reach(&[reach, 0.5]);
            let half = std::f32::consts::FRAC_1_SQRT_2;
            let track = Track {
                joint: "upper".into(),
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                times: vec![0.0, 1.0],
                values: vec![0.0, 0.0, 0.0, 1.0, half, 0.0, 0.0, half],
            };
            let source = ClipSource { name: "turns".into(), tracks: vec![track] };
            Clip::new(source, &skeleton).unwrap().row_count()
        };
        let (near, farthest) = (rows(1.0), rows(crate::FARTHEST_SIZES));
        assert!(near < farthest && farthest < 20 * near, "{near} and {farthest} rows");
        assert_eq!([rows(1e6), rows(1e18)], [farthest; 2]);
    }

    /// Two joints, one below the other at 1 m. The upper one has a rotation track, the lower one a
    /// translation track.
    fn arm(rotation: Track, translations: &[[f32; 3]]) -> Clip {
        let below = Trs { translation: [0.0, 1.0, 0.0], ..Trs::IDENTITY };
        let joint = |name: &str, parent, rest| JointSource { name: name.into(), parent, rest };
        let skeleton =
            Skeleton::new(&[joint("up", None, Trs::IDENTITY), joint("low", Some(0), below)]);
        let translation = Track {
            joint: "low".into(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: (0..translations.len()).map(|key| key as f32).collect(),
            values: translations.concat(),
        };
        let tracks = vec![Track { joint: "up".into(), ..rotation }, translation];
        Clip::new(ClipSource { name: "arm".into(), tracks }, &skeleton.unwrap()).unwrap()
    }

    fn turns(interpolation: Interpolation, values: &[[f32; 4]]) -> Track {
        let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        Track {
            joint: String::new(),
            property: Property::Rotation,
            interpolation,
            times: (0..values.len() / per_key).map(|key| key as f32).collect(),
            values: values.concat(),
        }
    }

    #[test]
    fn error_bound_holds_for_joints_that_go_far() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let (one, quarter, none) = ([0.0, 0.0, 0.0, 1.0], [0.0, half, 0.0, half], [0.0; 4]);
        for rotation in [
            turns(Interpolation::Linear, &[one, quarter]),
            turns(Interpolation::CubicSpline, &[none, one, none, none, quarter, none]),
        ] {
            let clip = arm(rotation, &[[0.0, 1.0, 0.0], [1000.0, 1.0, 0.0]]);
            let worst_m = clip.measured_error_m(&clip.skeleton, 20);
            let bound_m = clip.stats().error_bound_m;
            assert!(worst_m <= bound_m, "{worst_m} m of {bound_m} m");
        }
    }

    #[test]
    fn splines_through_no_rotation_give_rotations() {
        let (one, none) = ([0.0, 0.0, 0.0, 1.0], [0.0; 4]);
        let spline = [none, one, none, none, one.map(|c| -c), none];
        let slow = turns(Interpolation::CubicSpline, &spline);
        let clip = arm(Track { times: vec![0.0, 2.0], ..slow }, &[[0.0, 1.0, 0.0]; 3]);
        for pose in clip.row_poses(1) {
            assert!(pose.iter().all(glam::DAffine3::is_finite), "{pose:?}");
        }
    }

    #[test]
    fn every_row_is_the_least_step() {
        let clip = arm(turns(Interpolation::Linear, &[[0.0, 0.0, 0.0, 1.0]]), &[[0.0; 3]]);
        assert_eq!(clip.row_poses(0).count(), clip.row_count());
    }

    #[test]
    fn blocks_that_need_floats_are_found_in_few_rounds() {
        // 4000 blocks of joints that all need floats: this takes minutes if they are found one by
        // one.
        let joints: Vec<_> = (0..64_000)
            .map(|i| JointSource { name: i.to_string(), parent: None, rest: Trs::IDENTITY })
            .collect();
        let skeleton = Skeleton::new(&joints).unwrap();
        let track = |joint: &JointSource| Track {
            joint: joint.name.clone(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0, 2.0],
            values: [[-100.0; 3], [0.0; 3], [100.0; 3]].concat(),
        };
        let source = ClipSource { name: "far".into(), tracks: joints.iter().map(track).collect() };
        let stats = Clip::new(source, &skeleton).unwrap().stats();
        assert!(stats.error_bound_m <= stats.tolerance_m, "{} m", stats.error_bound_m);
    }
}
