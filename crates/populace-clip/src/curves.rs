//! Source curves, sampled in double precision.

use glam::{DAffine3, DQuat, DVec3, DVec4};
use populace_model::{
    ClipSource, Interpolation, JointIndex, Property, Skeleton, Track, Trs, f64math,
};

use crate::Error;

/// The value to take at a key where a STEP track jumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Side {
    Before,
    After,
}

/// A local transform in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// Rotation of length 1.
    pub rotation: DQuat,
    /// Translation in the units of the parent's space.
    pub translation: DVec3,
    /// Scale factors.
    pub scale: DVec3,
}

impl Local {
    /// Converts a transform of a joint, and normalizes its rotation.
    #[must_use]
    pub fn of(trs: &Trs) -> Self {
        Self {
            rotation: f64math::quat(trs.rotation).normalize(),
            translation: f64math::vec3(trs.translation),
            scale: f64math::vec3(trs.scale),
        }
    }

    /// Returns the transform in single precision.
    #[must_use]
    pub fn trs(&self) -> Trs {
        Trs {
            translation: f64math::to_f32(self.translation.to_array()),
            rotation: f64math::to_f32(self.rotation.to_array()),
            scale: f64math::to_f32(self.scale.to_array()),
        }
    }

    /// Interpolates between two rows as devices do. `u` is 0 at the first and 1 at the second.
    pub(crate) fn mix(&self, next: &Self, u: f64) -> Self {
        let near =
            if self.rotation.dot(next.rotation) < 0.0 { -next.rotation } else { next.rotation };
        Self {
            rotation: (self.rotation * (1.0 - u) + near * u).normalize(),
            translation: self.translation.lerp(next.translation, u),
            scale: self.scale.lerp(next.scale, u),
        }
    }

    /// Returns the transform as a matrix.
    #[must_use]
    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// The tracks of a clip, by joint of its own skeleton.
pub(crate) struct Curves<'a> {
    tracks: Vec<[Option<&'a Track>; 3]>,
    rest: Vec<Local>,
    pub(crate) source: &'a ClipSource,
}

impl<'a> Curves<'a> {
    pub(crate) fn new(source: &'a ClipSource, skeleton: &Skeleton) -> Result<Self, Error> {
        let mut tracks = vec![[None; 3]; skeleton.joint_count()];
        for track in &source.tracks {
            track.check()?;
            let Some(joint) = skeleton.find(&track.joint) else {
                continue;
            };
            let place = &mut tracks[joint.index()][track.property as usize];
            if place.replace(track).is_some() {
                let (joint, property) = (track.joint.clone(), track.property);
                return Err(Error::DuplicateTrack { joint, property });
            }
        }
        let rest = skeleton.joints().map(|j| Local::of(skeleton.rest(j))).collect();
        Ok(Self { tracks, rest, source })
    }

    /// Iterates over the joints of the clip's own skeleton.
    pub(crate) fn joints(&self) -> impl Iterator<Item = JointIndex> {
        (0..).map(JointIndex).take(self.rest.len())
    }

    pub(crate) fn track(&self, joint: JointIndex, property: Property) -> Option<&'a Track> {
        self.tracks[joint.index()][property as usize]
    }

    pub(crate) fn all_tracks(&self) -> impl Iterator<Item = &'a Track> {
        self.tracks.iter().flatten().flatten().copied()
    }

    /// Returns a joint's local transform at a time on the clip's axis. Before the first key the
    /// first value holds, after the last key the last.
    pub(crate) fn local(&self, joint: JointIndex, secs: f64, side: Side) -> Local {
        let mut local = self.rest[joint.index()];
        let sampled = |property| self.track(joint, property).map(|track| sample(track, secs, side));
        if let Some(v) = sampled(Property::Rotation) {
            local.rotation = DQuat::from_array(v).normalize();
        }
        if let Some([x, y, z, _]) = sampled(Property::Translation) {
            local.translation = DVec3::new(x, y, z);
        }
        if let Some([x, y, z, _]) = sampled(Property::Scale) {
            local.scale = DVec3::new(x, y, z);
        }
        local
    }
}

/// Samples a track (glTF 2.0, appendix C). The fourth component of vectors is 0.
fn sample(track: &Track, secs: f64, side: Side) -> [f64; 4] {
    let times = &track.times;
    // The number of keys at or before `secs` (only before it for `Side::Before`).
    let passed = match side {
        Side::After => times.partition_point(|t| f64::from(*t) <= secs),
        Side::Before => times.partition_point(|t| f64::from(*t) < secs),
    };
    let value = |key: usize| widen(track.value(key));
    if passed == 0 {
        return value(0);
    }
    if passed == times.len() {
        return value(times.len() - 1);
    }
    let (key, next) = (passed - 1, passed);
    let span = f64::from(times[next]) - f64::from(times[key]);
    let u = (secs - f64::from(times[key])) / span;
    match track.interpolation {
        Interpolation::Step => value(key),
        Interpolation::Linear if u == 0.0 => value(key),
        Interpolation::Linear if u == 1.0 => value(next),
        Interpolation::Linear if track.property == Property::Rotation => {
            slerp(value(key), value(next), u)
        }
        Interpolation::Linear => combine([(1.0 - u, value(key)), (u, value(next))]),
        Interpolation::CubicSpline => {
            let width = track.property.width();
            let tangent = |key: usize, place: usize| {
                let first = (key * 3 + place) * width;
                widen(&track.values[first..first + width])
            };
            let (u2, u3) = (u * u, u * u * u);
            let mixed = combine([
                (2.0 * u3 - 3.0 * u2 + 1.0, value(key)),
                (span * (u3 - 2.0 * u2 + u), tangent(key, 2)),
                (-2.0 * u3 + 3.0 * u2, value(next)),
                (span * (u3 - u2), tangent(next, 0)),
            ]);
            // Between a quaternion and its negative, a spline may pass through 0, which is none.
            let is_rotation = DVec4::from_array(mixed).try_normalize().is_some();
            if is_rotation || track.property != Property::Rotation {
                mixed
            } else {
                value(if u < 0.5 { key } else { next })
            }
        }
    }
}

fn widen(values: &[f32]) -> [f64; 4] {
    let mut wide = [0.0; 4];
    for (to, from) in wide.iter_mut().zip(values) {
        *to = f64::from(*from);
    }
    wide
}

fn combine<const N: usize>(terms: [(f64, [f64; 4]); N]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (weight, value) in terms {
        for (to, from) in sum.iter_mut().zip(value) {
            *to += weight * from;
        }
    }
    sum
}

fn slerp(a: [f64; 4], b: [f64; 4], u: f64) -> [f64; 4] {
    DQuat::from_array(a).normalize().slerp(DQuat::from_array(b).normalize(), u).to_array()
}
