//! Tracks of generated clips.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use populace_model::convert::single;
use populace_model::{Interpolation, JointSource, Property, Track};

use crate::Rng;

fn track(joint: &str, property: Property, interpolation: Interpolation, times: &[f32]) -> Track {
    Track {
        joint: joint.to_owned(),
        property,
        interpolation,
        times: times.to_vec(),
        values: Vec::new(),
    }
}

fn rest_rotation(joint: &JointSource) -> DQuat {
    DQuat::from_array(joint.rest.rotation.map(f64::from)).normalize()
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Returns `count` times, `rate` per second.
pub(super) fn even_times(start_secs: f64, count: usize, rate: f64) -> Vec<f32> {
    (0..count).map(|k| single(start_secs + k as f64 / rate)).collect()
}

/// Returns `count` times with gaps of `low` to `high` seconds.
pub(super) fn uneven_times(
    rng: &mut Rng,
    start_secs: f64,
    count: usize,
    low: f64,
    high: f64,
) -> Vec<f32> {
    let mut time = start_secs;
    (0..count)
        .map(|_| {
            let now = time;
            time += rng.between(low, high);
            single(now)
        })
        .collect()
}

/// Creates a slow swing around rest, at most 35 degrees to each side and 1.6 rad/s.
pub(super) fn swing(
    rng: &mut Rng,
    joint: &JointSource,
    kind: Interpolation,
    times: &[f32],
) -> Track {
    let (axis, amplitude) = (rng.direction(), rng.between(0.1, 0.6));
    let (cycles_per_sec, phase) = (rng.between(0.1, 0.4), rng.between(0.0, 1.0));
    let mut track = track(&joint.name, Property::Rotation, kind, times);
    for time in times {
        let angle = amplitude * (TAU * (phase + cycles_per_sec * f64::from(*time))).sin();
        let value = rest_rotation(joint) * DQuat::from_axis_angle(axis, angle);
        let sign = if rng.chance(0.3) { -1.0 } else { 1.0 };
        track.values.extend((value * sign).to_array().map(single));
    }
    track
}

/// Creates a slow wave of a translation (metres) or scale around rest.
pub(super) fn wave(
    rng: &mut Rng,
    joint: &JointSource,
    property: Property,
    kind: Interpolation,
    times: &[f32],
) -> Track {
    let (cycles_per_sec, phase) = (rng.between(0.1, 0.5), rng.vector(0.0, 1.0));
    let mut track = track(&joint.name, property, kind, times);
    for time in times {
        let cycles = phase + DVec3::splat(cycles_per_sec * f64::from(*time));
        let wave = cycles.map(|t| (TAU * t).sin());
        let value = if property == Property::Scale {
            wide(joint.rest.scale) * (DVec3::ONE + wave * 0.15)
        } else {
            wide(joint.rest.translation) + wave * 0.05
        };
        track.values.extend(value.to_array().map(single));
    }
    track
}

/// Creates rotations of up to 170 degrees from key to key, with random signs.
pub(super) fn wide_rotations(rng: &mut Rng, joint: &JointSource, times: &[f32]) -> Track {
    let mut track = track(&joint.name, Property::Rotation, Interpolation::Linear, times);
    let mut value = rest_rotation(joint);
    for _ in times {
        let angle = if rng.chance(0.3) { 170f64.to_radians() } else { rng.between(0.3, 2.9) };
        value = (value * rng.turn(angle)).normalize();
        let sign = if rng.chance(0.5) { -1.0 } else { 1.0 };
        track.values.extend((value * sign).to_array().map(single));
    }
    track
}

/// Creates rotations to and fro by 42 to 48 degrees, at most 48 from rest.
pub(super) fn zigzag(rng: &mut Rng, joint: &JointSource, times: &[f32]) -> Track {
    let mut track = track(&joint.name, Property::Rotation, Interpolation::Linear, times);
    let axis = rng.direction();
    for (_, side) in times.iter().zip([-1.0, 0.0, 1.0, 0.0].into_iter().cycle()) {
        let degrees: f64 = side * 45.0 + rng.between(-1.5, 1.5);
        let value = rest_rotation(joint) * DQuat::from_axis_angle(axis, degrees.to_radians());
        track.values.extend(value.to_array().map(single));
    }
    track
}

/// Creates random values of a translation or scale.
pub(super) fn jumps(
    rng: &mut Rng,
    joint: &JointSource,
    property: Property,
    times: &[f32],
) -> Track {
    let mut track = track(&joint.name, property, Interpolation::Linear, times);
    for _ in times {
        let value = if property == Property::Scale {
            wide(joint.rest.scale) * rng.vector(0.8, 1.2)
        } else {
            wide(joint.rest.translation) + rng.vector(-0.15, 0.15)
        };
        track.values.extend(value.to_array().map(single));
    }
    track
}

/// Creates a spline with different tangents on both sides of each key.
pub(super) fn spline(
    rng: &mut Rng,
    joint: &JointSource,
    property: Property,
    times: &[f32],
) -> Track {
    let mut track = track(&joint.name, property, Interpolation::CubicSpline, times);
    for _ in times {
        let (reach, value) = match property {
            Property::Translation => {
                let value = wide(joint.rest.translation) + rng.vector(-0.08, 0.08);
                (0.3, value.to_array().to_vec())
            }
            Property::Scale => {
                let value = wide(joint.rest.scale) * rng.vector(0.85, 1.15);
                (0.4, value.to_array().to_vec())
            }
            Property::Rotation => {
                let angle = rng.between(0.0, 0.8);
                (0.8, (rest_rotation(joint) * rng.turn(angle)).to_array().to_vec())
            }
        };
        let tangent = |rng: &mut Rng| -> Vec<f64> {
            value.iter().map(|_| rng.between(-reach, reach)).collect()
        };
        let (into, out) = (tangent(rng), tangent(rng));
        track.values.extend([into, value, out].concat().into_iter().map(single));
    }
    track
}
