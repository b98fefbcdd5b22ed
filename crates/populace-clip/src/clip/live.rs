//! Live clips, which receive their rows while they play.

use populace_model::{Property, Skeleton, Trs};

use super::Clip;
use crate::clock::TICKS_PER_SEC;
use crate::rows::Rows;
use crate::storage::Storage;
use crate::{Error, LiveFault};

/// Allowed rows per second of a live clip.
const ROWS_PER_SEC: std::ops::RangeInclusive<f32> = 1.0..=1000.0;
/// Maximum number of rows kept: an hour at 1000 rows per second.
const MAX_ROWS: f32 = 3.6e6;

/// Selects joints of which a live clip receives translations or scales. Rotations of all joints are
/// received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Streamed {
    /// No joints: they keep their rest, and the poses' values are ignored.
    Nothing,
    /// The joints of these names.
    Joints(Vec<String>),
    /// All joints.
    All,
}

/// Settings of a live clip.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveSettings {
    /// Rows per second, 1 to 1000. Poses are stored at this rate, rounded to whole ticks, at
    /// whatever rate they arrive.
    pub rows_per_sec: f32,
    /// Time for which rows are kept, in seconds; at most 3.6 million rows. Older rows are
    /// overwritten. A member can play with a delay of up to this time.
    pub secs: f32,
    /// Joints of which translations are received. If the streamed body has other proportions than
    /// the members that play the clip, use the hips only.
    pub translations: Streamed,
    /// Joints of which scales are received.
    pub scales: Streamed,
}

impl Default for LiveSettings {
    /// 60 rows per second, kept for 10 seconds; all rotations and translations.
    fn default() -> Self {
        Self {
            rows_per_sec: 60.0,
            secs: 10.0,
            translations: Streamed::All,
            scales: Streamed::Nothing,
        }
    }
}

/// The ring buffer of a live clip's rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveRing {
    /// Capacity in rows.
    pub rows: u32,
    /// Ticks of the crowd's clock between rows.
    pub row_ticks: u32,
}

impl Clip {
    /// Creates a clip that receives its rows while it plays: a stream of poses of `skeleton`. It
    /// has no length of its own and is at rest until the first pose arrives.
    ///
    /// # Errors
    ///
    /// [`Error::BadLive`] for settings out of range,
    /// [`UnknownJoints`](populace_model::Error::UnknownJoints) with the nearest names.
    pub fn live(name: &str, skeleton: &Skeleton, settings: &LiveSettings) -> Result<Self, Error> {
        let ring = ring(name, settings)?;
        let mut moves = vec![[false, true, false]; skeleton.joint_count()];
        stream(&settings.translations, Property::Translation, skeleton, &mut moves)?;
        stream(&settings.scales, Property::Scale, skeleton, &mut moves)?;
        let rest = skeleton.joints().map(|joint| *skeleton.rest(joint)).collect();
        Ok(Self::with_ring(name, skeleton, ring, rest, moves))
    }

    /// Creates a live clip that shows `pose` until rows arrive. `moves` tells for each joint and
    /// [`Property`] whether rows drive it.
    pub(super) fn with_ring(
        name: &str,
        skeleton: &Skeleton,
        ring: LiveRing,
        pose: Vec<Trs>,
        moves: Vec<[bool; 3]>,
    ) -> Self {
        let rows = Rows {
            times: vec![0.0],
            storage: Storage::live(pose, &moves),
            buckets: Vec::new(),
            buckets_per_sec: 0.0,
            rows_per_sec: 0.0,
            driven: moves,
            error_bound_m: 0.0,
            tolerance_m: 0.0,
        };
        Self { ring: Some(ring), ..Self::of_rows(name, skeleton, rows) }
    }

    /// The ring of a live clip's rows; `None` for other clips.
    #[must_use]
    pub fn ring(&self) -> Option<LiveRing> {
        self.ring
    }

    /// Converts a pose to a row of a live clip.
    #[must_use]
    pub fn row_of(&self, pose: &[Trs]) -> Vec<u32> {
        self.rows.storage.row_of(pose)
    }

    /// Converts a row of a live clip to a pose.
    ///
    /// # Panics
    ///
    /// If `row` is shorter than a row.
    #[must_use]
    pub fn pose_of(&self, row: &[u32]) -> Vec<Trs> {
        self.rows.storage.pose_of(row)
    }
}

fn ring(name: &str, settings: &LiveSettings) -> Result<LiveRing, Error> {
    let bad = |fault| Err(Error::BadLive { clip: name.to_owned(), fault });
    let LiveSettings { rows_per_sec, secs, .. } = *settings;
    if !ROWS_PER_SEC.contains(&rows_per_sec) {
        return bad(LiveFault::RowRate { rows_per_sec });
    }
    let rows = (rows_per_sec * secs).ceil();
    if !(secs > 0.0 && rows <= MAX_ROWS) {
        return bad(LiveFault::RingLength { secs });
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked just before"
    )]
    let (rows, row_ticks) =
        (rows as u32, (TICKS_PER_SEC as f64 / f64::from(rows_per_sec)).round() as u32);
    // One row to begin with, and one more because the newest is rarely a full step ahead.
    Ok(LiveRing { rows: rows + 2, row_ticks })
}

/// Marks the streamed columns; `moves` is indexed by column and [`Property::ALL`].
fn stream(
    streamed: &Streamed,
    property: Property,
    skeleton: &Skeleton,
    moves: &mut [[bool; 3]],
) -> Result<(), Error> {
    debug_assert_eq!(Property::ALL[property as usize], property);
    match streamed {
        Streamed::Nothing => {}
        Streamed::All => moves.iter_mut().for_each(|moves| moves[property as usize] = true),
        Streamed::Joints(names) => {
            for joint in skeleton.find_all(names)? {
                moves[joint.index()][property as usize] = true;
            }
        }
    }
    Ok(())
}
