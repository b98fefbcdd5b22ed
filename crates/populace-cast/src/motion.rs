//! Motions of a body: stances sampled over a cycle, or key poses on the ground, solved to segment
//! rotations.

mod act;
mod curve;
mod figure;
mod gait;
mod get_up;
mod idle;
mod limb;
mod reach;
mod stance;
mod stride;

use glam::{DQuat, DVec3};

use crate::anatomy::{Body, SEGMENTS};
use crate::rig::Joints;
use crate::surface::Surface;
use figure::Figure;

/// Pose of all segments, relative to rest, in model space.
#[derive(Clone, Debug)]
pub(crate) struct Pose {
    pub(crate) rotations: [DQuat; SEGMENTS],
    /// Translation of the pelvis in metres.
    pub(crate) pelvis_offset: DVec3,
}

/// A motion: poses at equal time steps. In a looping motion the last equals the first.
pub(crate) struct Motion {
    pub(crate) name: &'static str,
    pub(crate) duration_secs: f64,
    pub(crate) poses: Vec<Pose>,
}

impl Motion {
    /// Samples a looping motion: `stance` at `keys` equal steps of the phase, from 0 to below 1.
    fn sampled(
        name: &'static str,
        duration_secs: f64,
        keys: usize,
        body: &Body,
        stance: impl Fn(f64) -> stance::Stance,
    ) -> Self {
        let mut poses: Vec<Pose> =
            (0..keys).map(|key| stance(key as f64 / keys as f64).solve(body)).collect();
        poses.push(poses[0].clone());
        Self { name, duration_secs, poses }
    }
}

/// Returns all motions of a body.
pub(crate) fn all(body: &Body, joints: &Joints, surface: &Surface) -> Vec<Motion> {
    let figure = Figure::new(body, joints, surface);
    let mut motions =
        vec![idle::breathe(body), idle::shift(body), gait::walk(body), gait::run(body)];
    motions.extend(get_up::all(&figure));
    motions.extend(act::loops(&figure));
    motions.extend(act::once(&figure));
    motions
}
