//! Probes: points near joints, by which the error of rows is measured.

use glam::DAffine3;
use populace_model::{Skeleton, f64math};

/// What storage is judged by.
pub(crate) struct Judge<'a> {
    pub(crate) skeleton: &'a Skeleton,
    /// Distances of the probes in each joint's own units.
    pub(crate) probes: &'a [f64],
    /// For each joint how far the farthest probe that it moves can be, in metres.
    pub(crate) reach: &'a [f64],
    /// How far storage may move a probe, in metres.
    pub(crate) allowed: f64,
}

/// For each joint how far from it, at rest, a probe of the joint or of one that hangs on it can be.
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

/// Distances in model space at rest as each joint's own units count them.
pub(crate) fn in_joint_units(skeleton: &Skeleton, distances: &[f64]) -> Vec<f64> {
    let locals = skeleton.joints().map(|j| f64math::affine(skeleton.rest(j)));
    let models = f64math::model_from_joints(skeleton.parents(), locals);
    let unit = |m: &DAffine3| {
        m.matrix3.x_axis.length().max(m.matrix3.y_axis.length()).max(m.matrix3.z_axis.length())
    };
    models.iter().zip(distances).map(|(model, distance)| distance / unit(model).max(1e-6)).collect()
}

/// At most how far apart two transforms take any point at the probe's distance, in the joint's own
/// units: of three axes at right angles one shows at least sqrt(2/3) of the worst that a turn can
/// do.
pub(crate) fn distance_at_probes(a: &DAffine3, b: &DAffine3, probe: f64) -> f64 {
    let (m, n) = (&a.matrix3, &b.matrix3);
    let turn = m
        .x_axis
        .distance(n.x_axis)
        .max(m.y_axis.distance(n.y_axis))
        .max(m.z_axis.distance(n.z_axis));
    (a.translation - b.translation).length() + turn * probe * 1.225
}
