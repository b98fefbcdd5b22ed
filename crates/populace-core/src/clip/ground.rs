//! The ground speed of a clip that walks in place.

use glam::DVec3;

use super::parents;
use super::rows::Rows;
use crate::{JointIndex, Skeleton, f64math};

/// A foot counts as planted while it is this part of the body's size above its lowest place, or less.
const PLANTED: f64 = 0.02;

/// The mean backward speed of the planted foot in metres per second: the speed at which the ground must pass for the
/// feet not to slide. `None` where no foot is known by its name or nothing is ever planted.
pub(super) fn ground_speed(rows: &Rows, skeleton: &Skeleton) -> Option<f32> {
    let feet = feet(skeleton);
    if feet.is_empty() || rows.times.len() < 2 {
        return None;
    }
    let parents = parents(skeleton);
    let positions: Vec<Vec<DVec3>> = (0..rows.times.len())
        .map(|row| {
            let locals = skeleton.joints().map(|j| rows.local(j, row, 0.0).affine());
            let models = f64math::model_from_joints(&parents, locals);
            feet.iter().map(|foot| models[foot.index()].translation).collect()
        })
        .collect();
    let lowest = |foot: usize| positions.iter().map(|p| p[foot].y).fold(f64::INFINITY, f64::min);
    let heights: Vec<f64> = (0..feet.len()).map(lowest).collect();
    let limit = PLANTED * f64::from(skeleton.size_m());
    let (mut distance, mut time) = (0.0, 0.0);
    for (times, pair) in rows.times.windows(2).zip(positions.windows(2)) {
        let secs = f64::from(times[1]) - f64::from(times[0]);
        let above = |foot: &usize| pair[0][*foot].y.max(pair[1][*foot].y) - heights[*foot];
        let planted = (0..feet.len()).min_by(|a, b| above(a).total_cmp(&above(b)));
        if let Some(foot) = planted.filter(|foot| above(foot) <= limit && secs > 0.0) {
            distance += pair[0][foot].z - pair[1][foot].z;
            time += secs;
        }
    }
    (time > 0.0).then(|| f64math::to_f32([distance / time])[0])
}

/// The joints that touch the ground, by name: toes, else feet, else ankles; helpers of a rig left out.
fn feet(skeleton: &Skeleton) -> Vec<JointIndex> {
    let named = |word: &str| -> Vec<JointIndex> {
        let is_foot = |name: &str| {
            let name = name.to_lowercase();
            let helper = ["control", "ik", "roll", "pole", "target", "end"].iter().any(|h| name.contains(h));
            name.contains(word) && !helper
        };
        skeleton.joints().filter(|&j| is_foot(skeleton.name(j))).collect()
    };
    ["toe", "foot", "ankle"].iter().map(|word| named(word)).find(|feet| !feet.is_empty()).unwrap_or_default()
}
