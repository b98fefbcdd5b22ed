//! Motions of a body's segments: from stances, keyed in time, to turns.

mod curve;
mod gait;
mod idle;
mod stance;
mod stride;

use glam::{DQuat, DVec3};

use crate::anatomy::{Body, SEGMENTS};

/// One instant: how each segment is turned from rest, in model space, and where the pelvis went.
#[derive(Clone, Debug)]
pub(crate) struct Pose {
    pub(crate) turns: [DQuat; SEGMENTS],
    pub(crate) pelvis_offset: DVec3,
}

/// Poses evenly spaced in time; the last is the first again.
pub(crate) struct Motion {
    pub(crate) name: &'static str,
    pub(crate) duration_secs: f64,
    pub(crate) poses: Vec<Pose>,
}

impl Motion {
    /// Samples a stance over one cycle, from phase 0 to 1.
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

/// The clips of a body.
pub(crate) fn all(body: &Body) -> [Motion; 4] {
    [idle::breathe(body), idle::shift(body), gait::walk(body), gait::run(body)]
}
