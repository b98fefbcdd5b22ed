//! Animation data as stored in a file: keyframes per joint and property.

use crate::{Error, Property, TrackFault};

/// Interpolation between two keyframes (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear; for rotations along the shorter great arc at constant speed (slerp).
    Linear,
    /// The value of the previous key.
    Step,
    /// Cubic Hermite splines. A key is three values: in-tangent, value, out-tangent. Tangents are
    /// per second.
    CubicSpline,
}

/// Keyframes of one property of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Name of the joint that the track drives.
    pub joint: String,
    /// The property that is driven.
    pub property: Property,
    /// Interpolation between keys.
    pub interpolation: Interpolation,
    /// Key times in seconds on the clip's own axis, strictly increasing, at least one.
    pub times: Vec<f32>,
    /// `keys x width` values, or `keys x 3 x width` (in-tangent, value, out-tangent) for cubic
    /// splines.
    pub values: Vec<f32>,
}

impl Track {
    /// Number of values per key: the property's width, three times that for cubic splines.
    #[must_use]
    pub fn values_per_key(&self) -> usize {
        let triple = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        self.property.width() * triple
    }

    /// Checks the track.
    ///
    /// # Errors
    ///
    /// [`Error::BadTrack`] names the joint and the defect: no keys, times that do not increase, a
    /// wrong number of values, a value that is not finite, or a rotation of length zero.
    pub fn check(&self) -> Result<(), Error> {
        let bad = |fault| {
            Err(Error::BadTrack { joint: self.joint.clone(), property: self.property, fault })
        };
        if self.times.is_empty() {
            return bad(TrackFault::NoKeys);
        }
        let needed = self.times.len() * self.values_per_key();
        if self.values.len() != needed {
            let (values, keys) = (self.values.len(), self.times.len());
            return bad(TrackFault::ValueCount { values, keys, needed });
        }
        if let Some(key) = self.times.iter().position(|t| !t.is_finite()) {
            return bad(TrackFault::TimeNotFinite { key });
        }
        if let Some(at) = self.times.windows(2).position(|w| w[0] >= w[1]) {
            let (before_secs, time_secs) = (self.times[at], self.times[at + 1]);
            return bad(TrackFault::TimeOrder { key: at + 1, time_secs, before_secs });
        }
        if let Some(at) = self.values.iter().position(|v| !v.is_finite()) {
            return bad(TrackFault::ValueNotFinite { key: at / self.values_per_key() });
        }
        if self.property == Property::Rotation {
            let zero = |key: &usize| self.value(*key).iter().all(|v| v.abs() < 1e-10);
            if let Some(key) = (0..self.times.len()).find(zero) {
                return bad(TrackFault::ZeroRotation { key });
            }
        }
        Ok(())
    }

    /// The value of a key, without tangents.
    #[must_use]
    pub fn value(&self, key: usize) -> &[f32] {
        let width = self.property.width();
        let first = key * self.values_per_key()
            + if self.interpolation == Interpolation::CubicSpline { width } else { 0 };
        &self.values[first..first + width]
    }

    /// Returns whether every key has the same value and, for splines, all tangents are zero.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        let first = self.value(0);
        let values = (1..self.times.len()).all(|key| self.value(key) == first);
        values
            && (self.interpolation != Interpolation::CubicSpline
                || self.times.len() < 2
                || self.tangents_zero())
    }

    fn tangents_zero(&self) -> bool {
        let width = self.property.width();
        self.values
            .chunks(3 * width)
            .all(|key| key[..width].iter().chain(&key[2 * width..]).all(|tangent| *tangent == 0.0))
    }
}

/// An animation as stored in a file: a name and its tracks, at most one for each joint and
/// property.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipSource {
    /// The clip's name; may be empty.
    pub name: String,
    /// The tracks, in any order.
    pub tracks: Vec<Track>,
}

impl ClipSource {
    /// First and last key time over all tracks in seconds, `(0, 0)` without tracks.
    #[must_use]
    pub fn time_range_secs(&self) -> (f32, f32) {
        let ends = self.tracks.iter().filter_map(|t| Some((*t.times.first()?, *t.times.last()?)));
        ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((0.0, 0.0))
    }
}
