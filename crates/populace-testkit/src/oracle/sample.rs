//! Sampling: evaluates animation curves (glTF 2.0, appendix C).

use std::collections::HashMap;

use glam::{DQuat, DVec3, DVec4};
use populace_model::{ClipSource, Interpolation, Property, Track};

use super::local::Local;

/// Returns the value of a track at a time. The fourth component of translations and scales is 0;
/// rotations have length 1.
///
/// The first value holds before the first key, the last value after the last key.
#[must_use]
pub fn track_value(track: &Track, time_secs: f64) -> DVec4 {
    let last = track.times.len() - 1;
    let time_of = |key: usize| f64::from(track.times[key]);
    let value = if time_secs <= time_of(0) {
        part(track, 0, Part::Value)
    } else if time_secs >= time_of(last) {
        part(track, last, Part::Value)
    } else {
        let mut key = 0;
        while time_of(key + 1) <= time_secs {
            key += 1;
        }
        let span = time_of(key + 1) - time_of(key);
        let t = (time_secs - time_of(key)) / span;
        let (from, to) = (part(track, key, Part::Value), part(track, key + 1, Part::Value));
        match track.interpolation {
            Interpolation::Step => from,
            Interpolation::Linear if track.property == Property::Rotation => {
                let rotation = slerp(quat(from), quat(to), t);
                DVec4::from_array(rotation.to_array())
            }
            Interpolation::Linear => from * (1.0 - t) + to * t,
            Interpolation::CubicSpline => {
                let out_tangent = part(track, key, Part::OutTangent);
                let in_tangent = part(track, key + 1, Part::InTangent);
                let (t2, t3) = (t * t, t * t * t);
                from * (2.0 * t3 - 3.0 * t2 + 1.0)
                    + out_tangent * (span * (t3 - 2.0 * t2 + t))
                    + to * (-2.0 * t3 + 3.0 * t2)
                    + in_tangent * (span * (t3 - t2))
            }
        }
    };
    if track.property == Property::Rotation { value.normalize() } else { value }
}

/// Interpolates along the shorter great arc from `a` to `b` at constant speed.
#[must_use]
pub fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let cosine = a.dot(b);
    let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
    let angle = cosine.abs().min(1.0).acos();
    if angle < 1e-9 {
        return (a * (1.0 - t) + b * (sign * t)).normalize();
    }
    let (from, to) = (((1.0 - t) * angle).sin(), (t * angle).sin());
    ((a * from + b * (sign * to)) / angle.sin()).normalize()
}

#[derive(Clone, Copy)]
enum Part {
    InTangent = 0,
    Value = 1,
    OutTangent = 2,
}

/// Returns a key's value or tangent, padded to four components.
fn part(track: &Track, key: usize, part: Part) -> DVec4 {
    let width = if track.property == Property::Rotation { 4 } else { 3 };
    let first = if track.interpolation == Interpolation::CubicSpline {
        (key * 3 + part as usize) * width
    } else {
        key * width
    };
    let mut wide = [0.0; 4];
    for (to, from) in wide.iter_mut().zip(&track.values[first..first + width]) {
        *to = f64::from(*from);
    }
    let is_plain_rotation =
        track.property == Property::Rotation && track.interpolation != Interpolation::CubicSpline;
    if is_plain_rotation { DVec4::from_array(wide).normalize() } else { DVec4::from_array(wide) }
}

fn quat(v: DVec4) -> DQuat {
    DQuat::from_array(v.to_array())
}

/// A clip's tracks by joint name.
pub(super) struct TracksByJoint<'a> {
    tracks: HashMap<&'a str, Vec<&'a Track>>,
    /// The earliest key time.
    first_time: f64,
}

impl<'a> TracksByJoint<'a> {
    pub(super) fn new(clip: &'a ClipSource) -> Self {
        let mut tracks: HashMap<&str, Vec<&Track>> = HashMap::new();
        let mut first_time = f64::INFINITY;
        for track in &clip.tracks {
            tracks.entry(&track.joint).or_default().push(track);
            first_time = first_time.min(f64::from(track.times[0]));
        }
        Self { tracks, first_time }
    }

    /// The earliest key time.
    pub(super) fn first_time(&self) -> f64 {
        self.first_time
    }

    /// Returns a joint's local transform at a time; properties without a track keep the rest value.
    pub(super) fn local(&self, joint: &str, rest: &Local, time_secs: f64) -> Local {
        let mut local = *rest;
        for track in self.tracks.get(joint).into_iter().flatten() {
            let value = track_value(track, time_secs);
            match track.property {
                Property::Translation => local.translation = DVec3::new(value.x, value.y, value.z),
                Property::Rotation => local.rotation = quat(value),
                Property::Scale => local.scale = DVec3::new(value.x, value.y, value.z),
            }
        }
        local
    }

    /// Returns a joint's local transform at the clip's earliest key: the reference of additive
    /// slots.
    pub(super) fn reference(&self, joint: &str, rest: &Local) -> Local {
        self.local(joint, rest, self.first_time)
    }
}
