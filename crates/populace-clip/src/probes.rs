//! Probes: points near joints at which the error of rows is measured.

use glam::DAffine3;
use populace_model::{Skeleton, f64math};

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

/// Returns for each joint the largest distance at rest to a probe of the joint or of its
/// descendants.
pub(crate) fn reaches(skeleton: &Skeleton, probes: &[f64]) -> Vec<f64> {
    let parents = skeleton.parents();
    let locals = skeleton.joints().map(|j| f64math::affine(skeleton.rest(j)));
    let models = f64math::model_from_joints(parents, locals);
    let mut reach = probes.to_vec();
    for joint in (0..parents.len()).rev() {
        if let Some(parent) = parents[joint] {
            let bone = models[joint].translation.distance(models[parent.index()].translation);
            reach[parent.index()] = reach[parent.index()].max(reach[joint] + bone);
        }
    }
    reach
}

/// Converts distances in model space at rest to each joint's own units.
pub(crate) fn in_joint_units(skeleton: &Skeleton, distances: &[f64]) -> Vec<f64> {
    let locals = skeleton.joints().map(|j| f64math::affine(skeleton.rest(j)));
    let models = f64math::model_from_joints(skeleton.parents(), locals);
    let unit = |m: &DAffine3| {
        m.matrix3.x_axis.length().max(m.matrix3.y_axis.length()).max(m.matrix3.z_axis.length())
    };
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
