//! Getting up from the ground: key poses, solved for the body so that it rests on the ground.

mod key;
mod keys;
mod solve;

use glam::DQuat;

use super::figure::Figure;
use super::{Motion, Pose, idle};
use crate::surface::smooth;
use key::{Key, between};

/// Keys of a clip per second.
const KEYS_PER_SEC: f64 = 20.0;
/// Time in seconds over which a motion ends in the first pose of the idle.
const END_SECS: f64 = 0.6;

/// Returns the motions of getting up from the back, the front, and the left and the right side.
/// They end in the first pose of the idle.
pub(super) fn all(figure: &Figure) -> [Motion; 4] {
    let end = idle::first(figure.body);
    let left = keys::from_left();
    let right = left.iter().map(|key| key.mirrored()).collect();
    [
        ("GetUp_Back", keys::from_back()),
        ("GetUp_Front", keys::from_front()),
        ("GetUp_Left", left),
        ("GetUp_Right", right),
    ]
    .map(|(name, keys)| motion(name, figure, &keys, &end))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few dozen keys")]
fn motion(name: &'static str, figure: &Figure, keys: &[Key], end: &Pose) -> Motion {
    let duration_secs = keys.last().map_or(0.0, |key| key.secs);
    let count = (duration_secs * KEYS_PER_SEC).round() as usize;
    let pose = |at: usize| {
        let secs = duration_secs * at as f64 / count as f64;
        let pose = figure.solve(&between(keys, secs), end);
        mixed(pose, end, smooth(duration_secs - END_SECS, duration_secs, secs))
    };
    Motion { name, duration_secs, poses: (0..=count).map(pose).collect() }
}

/// Mixes a pose with the one at the end.
fn mixed(mut pose: Pose, end: &Pose, weight: f64) -> Pose {
    if weight >= 1.0 {
        return end.clone();
    }
    for (own, end) in pose.rotations.iter_mut().zip(&end.rotations) {
        *own = DQuat::slerp(*own, *end, weight);
    }
    pose.pelvis_offset = pose.pelvis_offset.lerp(end.pelvis_offset, weight);
    pose
}
