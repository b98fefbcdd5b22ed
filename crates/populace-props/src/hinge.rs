//! Clips of hinges and wheels.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use populace_model::convert::single;
use populace_model::{ClipSource, Interpolation, Property, Track};

/// Seconds in which a door opens or closes.
const DOOR_SECS: f64 = 0.8;
/// Keys of a door's clip.
const DOOR_KEYS: u32 = 12;

/// Returns the clips `Door_Open` and `Door_Close` of a door that turns about +Y by `turn_rad`.
pub(crate) fn clips(joint: &str, turn_rad: f64) -> Vec<ClipSource> {
    let clip = |name: &str, opens: bool| {
        let mut track = rotations(joint);
        for key in 0..=DOOR_KEYS {
            let t = f64::from(key) / f64::from(DOOR_KEYS);
            // Starts and stops softly.
            let eased = t * t * t * (t * (6.0 * t - 15.0) + 10.0);
            let share = if opens { eased } else { 1.0 - eased };
            push(&mut track, DOOR_SECS * t, DQuat::from_rotation_y(turn_rad * share));
        }
        ClipSource { name: name.into(), tracks: vec![track] }
    };
    vec![clip("Door_Open", true), clip("Door_Close", false)]
}

/// Returns the clip `Roll`: one turn of wheels to +Z in a second.
pub(crate) fn roll(joints: &[&str]) -> ClipSource {
    let turn = |joint: &&str| {
        let mut track = rotations(joint);
        for key in 0..=8 {
            let t = f64::from(key) / 8.0;
            push(&mut track, t, DQuat::from_axis_angle(DVec3::X, TAU * t));
        }
        track
    };
    ClipSource { name: "Roll".into(), tracks: joints.iter().map(turn).collect() }
}

fn rotations(joint: &str) -> Track {
    Track {
        joint: joint.into(),
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: Vec::new(),
        values: Vec::new(),
    }
}

fn push(track: &mut Track, secs: f64, rotation: DQuat) {
    track.times.push(single(secs));
    track.values.extend(rotation.to_array().map(single));
}
