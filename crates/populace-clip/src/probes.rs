//! Probes: points near joints at which the error of rows is measured.

use glam::DAffine3;
use populace_model::{JointIndex, Skeleton, f64math};

use crate::curves::Local;

/// Error metric and bound of storage.
pub(crate) struct Judge<'a> {
    pub(crate) skeleton: &'a Skeleton,
    /// Distances of the probes in each joint's own units.
    pub(crate) probes: &'a [f64],
    /// The distance of the farthest probe that each joint moves, in metres.
    pub(crate) reach: &'a [f64],
    /// The largest distance that storage may move a probe, in metres.
    pub(crate) allowed: f64,
}

/// Distances to the probes that each joint moves.
pub(crate) struct Reach<'a> {
    parents: &'a [Option<JointIndex>],
    /// Distances of the probes from their joints, in metres at rest.
    probes: &'a [f64],
    /// Distance of each joint from its parent, in metres at rest.
    bones: Vec<f64>,
    /// Metres, at rest, of a unit of each joint's translation.
    units: Vec<f64>,
}

impl<'a> Reach<'a> {
    pub(crate) fn new(skeleton: &'a Skeleton, probes: &'a [f64]) -> Self {
        let parents = skeleton.parents();
        let models = rest_models(skeleton);
        let parent = |joint: usize| Some(&models[parents[joint]?.index()]);
        let bone = |joint: usize| {
            parent(joint).map_or(0.0, |p| models[joint].translation.distance(p.translation))
        };
        let units = (0..parents.len()).map(|joint| parent(joint).map_or(1.0, unit)).collect();
        Self { parents, probes, bones: (0..parents.len()).map(bone).collect(), units }
    }

    /// Returns for each joint the largest distance in metres to a probe of the joint or of its
    /// descendants, with each translation as at rest or as in one of `poses`, the farther one.
    pub(crate) fn over(&self, poses: &[&[Local]]) -> Vec<f64> {
        let mut reach = self.probes.to_vec();
        for joint in (0..self.parents.len()).rev() {
            if let Some(parent) = self.parents[joint] {
                let length = |pose: &&[Local]| pose[joint].translation.length() * self.units[joint];
                let bone = poses.iter().map(length).fold(self.bones[joint], f64::max);
                reach[parent.index()] = reach[parent.index()].max(reach[joint] + bone);
            }
        }
        reach
    }
}

fn rest_models(skeleton: &Skeleton) -> Vec<DAffine3> {
    let locals = skeleton.joints().map(|j| f64math::affine(skeleton.rest(j)));
    f64math::model_from_joints(skeleton.parents(), locals)
}

/// Returns the length of the longest axis of a transform.
fn unit(model: &DAffine3) -> f64 {
    let axes = &model.matrix3;
    axes.x_axis.length().max(axes.y_axis.length()).max(axes.z_axis.length())
}

/// Converts distances in model space at rest to each joint's own units.
pub(crate) fn in_joint_units(skeleton: &Skeleton, distances: &[f64]) -> Vec<f64> {
    let models = rest_models(skeleton);
    models.iter().zip(distances).map(|(model, distance)| distance / unit(model).max(1e-6)).collect()
}

/// Returns an upper bound of the distance between the images of a point at the probe's distance
/// under two transforms, in the joint's own units. Of three perpendicular axes at least one shows
/// sqrt(2/3) of the largest distance that a rotation can cause.
pub(crate) fn distance_at_probes(a: &DAffine3, b: &DAffine3, probe: f64) -> f64 {
    let (m, n) = (&a.matrix3, &b.matrix3);
    let turn = m
        .x_axis
        .distance(n.x_axis)
        .max(m.y_axis.distance(n.y_axis))
        .max(m.z_axis.distance(n.z_axis));
    (a.translation - b.translation).length() + turn * probe * 1.225
}
