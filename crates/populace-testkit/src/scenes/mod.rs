//! Synthetic scenes: skeletons, palette entries and clips that cover the features of files. They
//! are the same on every machine.

mod bodies;
mod clips;
mod humanoids;
mod motion;
mod walkers;

use std::collections::HashMap;
use std::sync::LazyLock;

use populace_character::PaletteEntry;
use populace_clip::Clip;
use populace_model::{ClipSource, JointSource, Role, Skeleton};

use crate::oracle::{OracleBody, OracleRetarget};
use crate::tolerance::SampleBound;

pub(crate) use walkers::ScenePace;

/// A skeleton with its palette entries.
#[derive(Clone, Debug)]
pub struct SceneBody {
    /// Joints in source order: shuffled, so that some children precede their parents.
    pub joints: Vec<JointSource>,
    /// The same joints in level order.
    pub skeleton: Skeleton,
    /// Palette entries: several or none per joint, with arbitrary bind matrices.
    pub palette: Vec<PaletteEntry>,
    /// The same body for the oracle.
    pub oracle: OracleBody,
    /// Humanoid roles and their joints in source order; empty for most bodies.
    pub roles: Vec<(Role, usize)>,
}

/// A clip and its own body.
#[derive(Clone, Debug)]
pub struct SceneClip {
    /// The clip.
    pub clip: Clip,
    /// Index of its own body in [`Scene::bodies`].
    pub body: usize,
    /// The bound of samples at [`SceneClip::exact_times`] and outside of all keys.
    pub at_keys: SampleBound,
    /// Times at which rows are exact, ascending and unique: all keys, and for [`clip::LEAVES`] also
    /// the middles between them.
    pub exact_times: Vec<f32>,
    /// The bound of samples at any time; `None` if only the clip's bound in model space holds.
    pub between_keys: Option<SampleBound>,
}

impl SceneClip {
    pub(crate) fn new(source: ClipSource, body: &SceneBody, index: usize) -> Self {
        let clip = Clip::new(source, &body.skeleton).expect("generated clips are valid");
        Self {
            exact_times: key_times(clip.source()),
            at_keys: SampleBound::at_keys(&clip),
            between_keys: SampleBound::between_keys(&clip),
            body: index,
            clip,
        }
    }

    /// Adds the middles between keys to the exact times: there the chord meets the arc, so rows are
    /// exact however often a gap is halved.
    fn with_halves(mut self) -> Self {
        let halves: Vec<f32> = self.exact_times.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
        self.exact_times.extend(halves);
        self.exact_times.sort_by(f32::total_cmp);
        self
    }
}

fn key_times(source: &ClipSource) -> Vec<f32> {
    let mut times: Vec<f32> = source.tracks.iter().flat_map(|t| t.times.clone()).collect();
    times.sort_by(f32::total_cmp);
    times.dedup();
    times
}

/// Bodies, clips and retargets.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Skeletons with palette entries.
    pub bodies: Vec<SceneBody>,
    /// Clips.
    pub clips: Vec<SceneClip>,
    /// Retargets by clip and body. All other pairs are bound by joint names.
    pub retargets: HashMap<(usize, usize), OracleRetarget>,
}

impl Scene {
    /// Returns six bodies and fifteen clips; see [`body`] and [`clip`]. They are made once in a
    /// process and copied, because making them takes longer than most checks.
    #[must_use]
    pub fn new() -> Self {
        static MADE: LazyLock<Scene> = LazyLock::new(|| {
            let bodies = bodies::all();
            let clips = clips::all(&bodies);
            Scene { bodies, clips, retargets: HashMap::new() }
        });
        MADE.clone()
    }

    /// Returns the clips that have a tight bound at every time, not only at keys.
    #[must_use]
    pub fn tight_clips(&self) -> Vec<usize> {
        (0..self.clips.len()).filter(|&clip| self.clips[clip].between_keys.is_some()).collect()
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

/// Indices into [`Scene::bodies`].
pub mod body {
    /// Two joints.
    pub const PAIR: usize = 0;
    /// 24 joints.
    pub const SMALL: usize = 1;
    /// 54 joints under two roots.
    pub const TWO_ROOTS: usize = 2;
    /// 54 joints with non-uniform scales, at rest and moving.
    pub const SCALED: usize = 3;
    /// 300 joints.
    pub const LARGE: usize = 4;
    /// 17 joints (one more than a block) and no palette entry.
    pub const BARE: usize = 5;
}

/// Indices into [`Scene::clips`].
pub mod clip {
    /// Evenly spaced LINEAR keys from 0 s, on [`body::SMALL`](super::body::SMALL).
    pub const EVEN: usize = 0;
    /// Unevenly spaced LINEAR keys from 0.033 s, on [`body::TWO_ROOTS`](super::body::TWO_ROOTS).
    pub const UNEVEN: usize = 1;
    /// LINEAR keys, also of scales, on [`body::SCALED`](super::body::SCALED).
    pub const SCALED: usize = 2;
    /// STEP keys only, on [`body::TWO_ROOTS`](super::body::TWO_ROOTS).
    pub const STEPS: usize = 3;
    /// LINEAR and STEP tracks from 0.5 s, with different key times, on
    /// [`body::SMALL`](super::body::SMALL).
    pub const LINEAR_AND_STEPS: usize = 4;
    /// One key per track, so that the duration is 0, on [`body::SMALL`](super::body::SMALL).
    pub const STILL: usize = 5;
    /// Moves a few joints, and some that no skeleton has, on [`body::SMALL`](super::body::SMALL).
    pub const STRANGERS: usize = 6;
    /// Rotations of up to 170 degrees between evenly spaced keys whose signs flip, on
    /// [`body::SMALL`](super::body::SMALL).
    pub const WIDE: usize = 7;
    /// Like [`WIDE`] with uneven spacing and scales, on [`body::SCALED`](super::body::SCALED).
    pub const WIDE_UNEVEN: usize = 8;
    /// CUBICSPLINE tracks, on [`body::TWO_ROOTS`](super::body::TWO_ROOTS).
    pub const SPLINE: usize = 9;
    /// Tracks of all three kinds, on [`body::SMALL`](super::body::SMALL).
    pub const ALL_KINDS: usize = 10;
    /// Evenly spaced LINEAR keys, on [`body::LARGE`](super::body::LARGE).
    pub const LARGE: usize = 11;
    /// Unevenly spaced LINEAR keys, on [`body::PAIR`](super::body::PAIR).
    pub const PAIR: usize = 12;
    /// Evenly spaced LINEAR keys, on [`body::BARE`](super::body::BARE).
    pub const BARE: usize = 14;
    /// Joints without children rotate by 40 to 48 degrees between LINEAR keys, on
    /// [`body::SMALL`](super::body::SMALL): rows so far apart that the length of a rotation between
    /// them matters.
    pub const LEAVES: usize = 13;
}

#[cfg(test)]
mod tests {
    use populace_model::Interpolation;

    use super::*;

    #[test]
    fn bodies_match_their_descriptions() {
        let scene = Scene::new();
        let counts: Vec<_> = scene.bodies.iter().map(|b| b.skeleton.joint_count()).collect();
        assert_eq!(counts, [2, 24, 54, 54, 300, 17]);
        let roots = |b: usize| scene.bodies[b].joints.iter().filter(|j| j.parent.is_none()).count();
        assert_eq!(roots(body::TWO_ROOTS), 2);
        assert!(scene.bodies[body::BARE].palette.is_empty());
        let small = &scene.bodies[body::SMALL];
        let first_child = |(at, joint): (usize, &JointSource)| joint.parent.is_some_and(|p| p > at);
        assert!(small.joints.iter().enumerate().any(first_child), "some child precedes its parent");
        let entries = |joint| small.palette.iter().filter(|e| e.joint == joint).count();
        let counts: Vec<_> = small.skeleton.joints().map(entries).collect();
        assert!(counts.contains(&0) && counts.iter().any(|&c| c > 1), "{counts:?}");
    }

    #[test]
    fn clips_match_their_descriptions() {
        let scene = Scene::new();
        let of = |clip: usize| scene.clips[clip].clip.stats();
        assert!(of(clip::EVEN).evenly_spaced && !of(clip::UNEVEN).evenly_spaced);
        assert_eq!(scene.clips[clip::STILL].clip.duration_secs(), 0.0);
        assert_eq!(scene.clips[clip::UNEVEN].clip.start_secs(), 0.033);
        let tight: Vec<_> = scene.tight_clips();
        assert_eq!(tight, [0, 1, 2, 3, 4, 5, 6, 11, 12, 14]);
        let kinds = |kind| {
            let tracks = &scene.clips[clip::ALL_KINDS].clip.source().tracks;
            tracks.iter().filter(|t| t.interpolation == kind).count()
        };
        for kind in [Interpolation::Linear, Interpolation::Step, Interpolation::CubicSpline] {
            assert!(kinds(kind) > 2, "{kind:?}");
        }
    }
}
