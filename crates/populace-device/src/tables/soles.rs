//! Points of the soles of bodies, on which planted feet stand.

use populace_model::convert::u32_from;
use populace_model::{JointIndex, Skeleton, f64math};

use super::runs::Runs;
use super::set::TableSet;
use crate::Error;
use crate::layout::{Float4, MAX_SOLE_POINTS};

/// Directions in which the farthest points of a sole are taken: from straight down up to this angle
/// to the back and to the front.
const MOST_RAD: f64 = std::f64::consts::FRAC_PI_2 * 0.9;

/// The points of a sole that one joint carries: offset and number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SoleRun {
    pub(super) first: u32,
    pub(super) count: u32,
}

/// The soles of one body, by joint.
#[derive(Clone, Debug, Default)]
pub(super) struct Soles(Vec<(JointIndex, SoleRun)>);

impl Soles {
    /// Adds the outline of each joint's sole, from heel to toes.
    pub(super) fn add(
        skeleton: &Skeleton,
        all: &mut TableSet,
        runs: &mut Runs,
    ) -> Result<Self, Error> {
        let mut soles = Vec::new();
        for joint in skeleton.joints().filter(|joint| !skeleton.soles(*joint).is_empty()) {
            let points = outline(skeleton, joint);
            let count = u32_from(points.len());
            let first = runs.add(&mut all.soles, points)?;
            soles.push((joint, SoleRun { first, count }));
        }
        Ok(Self(soles))
    }

    /// Returns the points that a joint carries.
    pub(super) fn of(&self, joint: JointIndex) -> Option<SoleRun> {
        self.0.iter().find(|(own, _)| *own == joint).map(|(_, run)| *run)
    }
}

/// Returns the lowest points of a joint's sole as it rolls from heel to toes, in the space of the
/// joint. They lie in the middle of the foot.
fn outline(skeleton: &Skeleton, joint: JointIndex) -> Vec<Float4> {
    let points = skeleton.soles(joint);
    let bounds = points.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), point| {
        (low.min(point[0]), high.max(point[0]))
    });
    let middle = f32::midpoint(bounds.0, bounds.1);
    let joint_from_model = skeleton.in_bind_pose().rest_models()[joint.index()].inverse();
    let mut found: Vec<[f32; 3]> = Vec::new();
    for nth in 0..MAX_SOLE_POINTS {
        let part = f64::from(nth) / f64::from(MAX_SOLE_POINTS - 1);
        let (forward, down) = ((2.0 * part - 1.0) * MOST_RAD).sin_cos();
        let far = |point: &[f32; 3]| forward * f64::from(point[2]) - down * f64::from(point[1]);
        let farthest = points.iter().max_by(|a, b| far(a).total_cmp(&far(b)));
        let Some([_, y, z]) = farthest.copied() else { continue };
        if !found.contains(&[middle, y, z]) {
            found.push([middle, y, z]);
        }
    }
    let in_joint = |point: [f32; 3]| {
        let at = joint_from_model.transform_point3(f64math::vec3(point)).to_array();
        Float4::from_xyz(f64math::to_f32(at))
    };
    found.into_iter().map(in_joint).collect()
}
