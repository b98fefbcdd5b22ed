//! A row of a clip before storage.

use populace_model::{Property, Skeleton};

use crate::curves::{Curves, Local, Side};

/// All properties; each one's index is its value as `usize`.
pub(crate) const PROPERTIES: [Property; 3] =
    [Property::Translation, Property::Rotation, Property::Scale];

/// A row before storage: the pose of all joints at one time, on one side of a STEP.
pub(crate) struct Row {
    pub(crate) secs: f32,
    pub(crate) side: Side,
    pub(crate) pose: Vec<Local>,
}

impl Row {
    pub(crate) fn new(curves: &Curves, skeleton: &Skeleton, secs: f32, side: Side) -> Self {
        let pose = skeleton.joints().map(|j| curves.local(j, f64::from(secs), side)).collect();
        Self { secs, side, pose }
    }
}
