//! The allowed error of devices against the oracle, each bound with its derivation.
//!
//! `u` is half a unit in the last place of a single-precision 1: 2^-24. Each `+`, `-` and `*`
//! rounds by at most `u` of its result, and so do `sqrt` and `/` on a CPU. OpenCL allows 3 and 2.5
//! units in the last place for `sqrt` and `/` (OpenCL 1.2, section 7.4), which are 6 `u` and 5 `u`.
//! Errors are summed to first order, and constants are rounded up.

mod matrices;

use populace_clip::Clip;
use populace_device::layout::ROW_PARTS;
use populace_model::{ClipSource, Interpolation, Property, Track};

use crate::oracle::{Gain, Local};

pub use matrices::{AffineBound, model_bounds, palette_bounds};

/// Half a unit in the last place of 1, in single precision.
pub const UNIT: f64 = 1.0 / 16_777_216.0;

/// The largest bound for local transforms (quaternion components, factors, metres). A joint with a
/// wider bound is skipped, for instance where two rotations nearly cancel. A check that skips many
/// joints fails.
pub const LOCAL_CAP: f64 = 4e-5;

/// The largest bound for model matrices and palettes, in metres and for columns. It does not apply
/// where a clip's own bound decides.
pub const MODEL_CAP: f64 = 2e-3;

/// The largest bound for matrices if Transform or Write-back runs alone, so that the only error is
/// rounding.
pub const ROUNDING_CAP: f64 = 1e-4;

/// The factor by which both caps are wider for clips with large rotations between keys, which
/// layers above magnify.
pub const COARSE: f64 = 25.0;

/// Returns the rounding error of rotations in Pose, as four-component vectors.
///
/// In `u`: stored rows and rest (1 each: 2), interpolation between two rows (3), the length of a
/// sample (dot 4, halved; three sums, three products and a sign: 9), weight and share (3), one product
/// and one sum for each slot (2), normalising the mix (dot 4, halved by the root; root 6; quotient 5;
/// product 1: 14), and a margin of 9.
#[must_use]
pub fn rotation_rounding(slots: usize) -> f64 {
    (2 * slots + 40) as f64 * UNIT
}

/// Returns the rounding error of translations and scales in Pose, relative to the largest value.
///
/// In `u`: stored (2), interpolated (3) in parts of a step (4), a product and a sum for each slot (2), the total weight's
/// sum for each slot (1), the division by it or a ratio (5), blending over the layers below (4),
/// and a margin of 4.
#[must_use]
pub fn value_rounding(slots: usize) -> f64 {
    (3 * slots + 22) as f64 * UNIT
}

/// Returns the largest error of a slot's time.
///
/// In `u`: the phase is truncated to 24 bits, one part in 2^24 of the duration (2); three roundings
/// of times up to the clip's end (3); the fraction between two rows subtracts two rounded times
/// (2). The duration is taken as the clip states it. The fraction is then rounded to a whole number
/// of [`ROW_PARTS`].
#[must_use]
pub fn time_error_secs(clip: &Clip) -> f64 {
    rounding_secs(clip) + row_weight_secs(clip)
}

fn rounding_secs(clip: &Clip) -> f64 {
    8.0 * UNIT * (f64::from(clip.start_secs()).abs() + f64::from(clip.duration_secs()))
}

/// Returns half of one of [`ROW_PARTS`] of the time from a row to the next.
fn row_weight_secs(clip: &Clip) -> f64 {
    let apart = clip.row_times().windows(2).map(|pair| f64::from(pair[1]) - f64::from(pair[0]));
    let even = if clip.rows_per_sec() > 0.0 { 1.0 / f64::from(clip.rows_per_sec()) } else { 0.0 };
    0.5 / f64::from(ROW_PARTS) * apart.fold(even, f64::max)
}

/// Returns the largest error of a held time.
///
/// The time itself is exact, and so are the times of rows. In `u`: the time since the first row,
/// the rate of evenly spaced rows and their product round once each (3), and such rows may be one
/// rounding away from an even grid (1). The fraction between two rows is rounded to a whole number of
/// [`ROW_PARTS`].
#[must_use]
pub fn held_time_error_secs(clip: &Clip) -> f64 {
    0.5 * rounding_secs(clip) + row_weight_secs(clip)
}

/// The largest error of a weight that ramps between 0 and 1.
///
/// In `u`: the elapsed time rounds three times (3), the rate once (1), product and sum (2), and a
/// margin of 2.
pub const WEIGHT_ERROR: f64 = 8.0 * UNIT;

/// The largest distance of a slot's sampled value from the source curves, without the rounding in
/// Pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleBound {
    /// Metres.
    pub translation: f64,
    /// Quaternion components.
    pub rotation: f64,
    /// Factors.
    pub scale: f64,
    /// The largest translation component, in metres.
    pub translation_size: f64,
    /// The largest factor.
    pub scale_size: f64,
}

impl SampleBound {
    /// Returns the bound of a clip held at its key times, where rows are exact.
    #[must_use]
    pub fn at_keys(clip: &Clip) -> Self {
        Self::of_time(clip, held_time_error_secs(clip))
    }

    /// Returns the bound for an error in time, which changes the value by at most the steepest
    /// slope times that error.
    fn of_time(clip: &Clip, time: f64) -> Self {
        let mut bound = Self::default();
        for track in &clip.source().tracks {
            let shift = steepest_per_sec(track) * time;
            match track.property {
                Property::Translation => bound.translation = bound.translation.max(shift),
                Property::Rotation => bound.rotation = bound.rotation.max(shift),
                Property::Scale => bound.scale = bound.scale.max(shift),
            }
            let largest = track.values.iter().fold(0.0, |a: f32, v| a.max(v.abs()));
            match track.property {
                Property::Translation => {
                    bound.translation_size = bound.translation_size.max(f64::from(largest));
                }
                Property::Rotation => {}
                Property::Scale => bound.scale_size = bound.scale_size.max(f64::from(largest)),
            }
        }
        bound
    }

    /// Returns the bound of a clip at any time. `None` if only the clip's bound in model space
    /// holds, because a track is a spline or rotates far between two keys.
    ///
    /// Rows are stored at all key times, so the only error is that of a chord in place of an arc:
    /// normalised linear interpolation over an arc `a` (between the quaternions) differs from slerp
    /// by at most `a^3 t (1 - t) (1 - 2 t) / 6 <= 0.0161 a^3` (series of the tangent formula);
    /// 0.017 covers the next terms.
    #[must_use]
    pub fn between_keys(clip: &Clip) -> Option<Self> {
        const FAR: f64 = 0.15;
        let mut bound = Self::of_time(clip, time_error_secs(clip));
        let arc = widest_arc(clip.source())?;
        if arc > FAR {
            return None;
        }
        bound.rotation += 0.017 * arc.powi(3);
        Some(bound)
    }

    /// Widens the bound for a joint by the quantisation of its stored values: at most half a step
    /// of the joint's own range, which the tests of clips hold.
    #[must_use]
    pub fn with_storage<'a>(mut self, joint: &str, clips: impl Iterator<Item = &'a Clip>) -> Self {
        let mut worst = [0.0; 3];
        for clip in clips {
            let properties = [Property::Translation, Property::Rotation, Property::Scale];
            let stored = properties.map(|property| f64::from(clip.storage_error(joint, property)));
            worst = std::array::from_fn(|i| f64::max(worst[i], stored[i]));
        }
        self.translation += worst[0];
        self.rotation += worst[1];
        self.scale += worst[2];
        self
    }

    /// Returns the wider of two bounds.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            translation: self.translation.max(other.translation),
            rotation: self.rotation.max(other.rotation),
            scale: self.scale.max(other.scale),
            translation_size: self.translation_size.max(other.translation_size),
            scale_size: self.scale_size.max(other.scale_size),
        }
    }

    /// Widens the bound for weights with an error of `error` each, where `slots` of them sum to
    /// `total`. Shares change by at most `slots * error / total`, and the mix by that times the
    /// distance of two values: at most 2 between unit quaternions, twice the largest value
    /// elsewhere.
    #[must_use]
    pub fn with_weight_error(mut self, error: f64, slots: usize, total: f64) -> Self {
        let share = slots as f64 * error / total;
        self.translation += 2.0 * self.translation_size * share;
        self.rotation += 2.0 * share;
        self.scale += 2.0 * self.scale_size * share;
        self
    }
}

/// Returns the widest arc between two neighbouring LINEAR rotation keys, as the angle between the
/// quaternions. `None` if there are splines.
fn widest_arc(source: &ClipSource) -> Option<f64> {
    let mut widest: f64 = 0.0;
    for track in &source.tracks {
        match (track.interpolation, track.property) {
            (Interpolation::CubicSpline, _) if track.times.len() > 1 => return None,
            (Interpolation::Linear, Property::Rotation) => {
                for key in 1..track.times.len() {
                    widest = widest.max(arc(track, key));
                }
            }
            _ => {}
        }
    }
    Some(widest)
}

/// Returns the arc between a rotation key and the one before it.
fn arc(track: &Track, key: usize) -> f64 {
    let quat = |key| {
        glam::DVec4::from_array(std::array::from_fn(|c| f64::from(track.value(key)[c]))).normalize()
    };
    quat(key - 1).dot(quat(key)).abs().min(1.0).acos()
}

/// Returns the steepest slope of a track, per second.
///
/// For splines, the slopes of the four Hermite polynomials are at most 1.5, 1.5, 1 and 1, per value
/// and tangent. Normalising a rotation whose length is below 1 steepens its slope, by a factor of
/// at most 2 in the generated clips.
fn steepest_per_sec(track: &Track) -> f64 {
    let width = track.property.width();
    let mut steepest: f64 = 0.0;
    for key in 1..track.times.len() {
        let secs = f64::from(track.times[key]) - f64::from(track.times[key - 1]);
        let difference = distance(track.value(key - 1), track.value(key));
        let slope = match (track.interpolation, track.property) {
            (Interpolation::Step, _) => 0.0,
            (Interpolation::Linear, Property::Rotation) => arc(track, key) / secs,
            (Interpolation::Linear, _) => difference / secs,
            (Interpolation::CubicSpline, _) => {
                let stride = 3 * width;
                let out = &track.values[(key - 1) * stride + 2 * width..][..width];
                let into = &track.values[key * stride..][..width];
                let zero = [0.0; 4];
                2.0 * (1.5 * difference / secs
                    + distance(out, &zero[..width])
                    + distance(into, &zero[..width]))
            }
        };
        steepest = steepest.max(slope);
    }
    steepest
}

fn distance(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    squares.sum::<f64>().sqrt()
}

/// The largest error of one joint's local transform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalBound {
    /// Metres.
    pub translation: f64,
    /// Quaternion components.
    pub rotation: f64,
    /// Factors.
    pub scale: f64,
}

impl LocalBound {
    /// Returns a joint's bound after Pose has mixed `slots` slots that are each within `sample`.
    ///
    /// The error of a sample, and the rounding on the way, grow by the oracle's gain for the joint.
    #[must_use]
    pub fn after_pose(sample: &SampleBound, rest: &Local, gain: &Gain, slots: usize) -> Self {
        let translation_size = sample.translation_size.max(rest.translation.abs().max_element());
        let scale_size = sample.scale_size.max(rest.scale.abs().max_element());
        let rounding = value_rounding(slots);
        Self {
            translation: gain.translation * (sample.translation + rounding * translation_size),
            rotation: gain.rotation * (sample.rotation + rotation_rounding(slots)),
            scale: gain.scale * (sample.scale + rounding * scale_size),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use crate::oracle::slerp;

    #[test]
    fn chord_stays_within_its_stated_distance_of_the_arc() {
        let mut worst: f64 = 0.0;
        let to = DQuat::from_rotation_x(2.0 * 0.15);
        for step in 0..=1000 {
            let t = f64::from(step) / 1000.0;
            let chord = (DQuat::IDENTITY * (1.0 - t) + to * t).normalize();
            worst = worst.max((chord - slerp(DQuat::IDENTITY, to, t)).length());
        }
        let stated = 0.017 * 0.15f64.powi(3);
        assert!(worst <= stated && worst > 0.9 * stated, "{worst} {stated}");
    }
}
