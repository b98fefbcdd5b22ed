//! Reduced skeletons: the joints that small pictures of a character need.

use populace_model::Skeleton;
use populace_model::convert::single;

/// How far the joints that a level leaves out may reach, in errors of the level. A finger that stays
/// straight is off by much less than its length.
const REACH: f32 = 4.0;

/// Returns how many joints, counted from the first in level order, a picture needs in which
/// distances below `error_m` metres do not count: up to the last joint that moves vertices four
/// times as far away from it. At least 1. The skeleton must have its [reach](Skeleton::reach_m).
#[must_use]
pub fn joints_needed(skeleton: &Skeleton, error_m: f32) -> usize {
    let last = extents_m(skeleton).iter().rposition(|extent| *extent > REACH * error_m);
    last.map_or(1, |last| last + 1)
}

/// Distances in metres, at rest, from each joint to the farthest vertex that it or its descendants
/// move: upper bounds, along the chains of joints.
fn extents_m(skeleton: &Skeleton) -> Vec<f32> {
    let mut extents = skeleton.reach_m().to_vec();
    let models = skeleton.rest_models();
    let joints: Vec<_> = skeleton.joints().collect();
    for joint in joints.into_iter().rev() {
        let (own, parent) = (extents[joint.index()], skeleton.parent(joint));
        if let Some(parent) = parent.filter(|_| own > 0.0) {
            let [from, to] = [parent, joint].map(|j| models[j.index()].translation);
            let extent = &mut extents[parent.index()];
            *extent = extent.max(single(from.distance(to)) + own);
        }
    }
    extents
}
