//! A row of a clip before storage.

use populace_model::JointIndex;

use crate::curves::{Local, Side};

/// A row before storage: the pose of all joints at one time, on one side of a STEP.
pub(crate) struct Row {
    pub(crate) secs: f32,
    pub(crate) side: Side,
    pub(crate) pose: Vec<Local>,
}

impl Row {
    pub(crate) fn new(motion: &dyn Motion, secs: f32, side: Side) -> Self {
        Self { secs, side, pose: motion.pose(f64::from(secs), side) }
    }
}

/// Motion of all joints, from which rows are made.
pub(crate) trait Motion {
    /// Returns the pose at a time.
    fn pose(&self, secs: f64, side: Side) -> Vec<Local>;

    /// Returns an upper bound of the distance in metres by which interpolation of a joint between
    /// two rows moves a probe within `reach` metres. Infinite if it has to be measured.
    fn deviation(&self, joint: JointIndex, rows: [&Row; 2], reach: f64) -> f64;
}
