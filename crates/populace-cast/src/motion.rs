//! Motions of a body: stances sampled over a cycle and solved to segment rotations.

mod curve;
mod gait;
mod idle;
mod stance;
mod stride;

use glam::{DQuat, DVec3};

use crate::anatomy::{Body, SEGMENTS};

/// Pose of all segments, relative to rest, in model space.
#[derive(Clone, Debug)]
pub(crate) struct Pose {
    pub(crate) rotations: [DQuat; SEGMENTS],
    /// Translation of the pelvis in metres.
    pub(crate) pelvis_offset: DVec3,
}

/// A looping motion: poses at equal time steps, of which the last equals the first.
pub(crate) struct Motion {
    pub(crate) name: &'static str,
    pub(crate) duration_secs: f64,
    pub(crate) poses: Vec<Pose>,
}

impl Motion {
    /// Samples `stance` at `keys` equal steps of the phase, from 0 to below 1.
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
pub(crate) fn all(body: &Body) -> [Motion; 4] {
    [idle::breathe(body), idle::shift(body), gait::walk(body), gait::run(body)]
}
