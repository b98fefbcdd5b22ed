//! Clips that go on from their last pose to their first.

use glam::{DAffine3, DVec3};
use populace::clip::Clip;
use populace::model::Skeleton;

/// The part of the body's length by which no joint of a loop jumps. Feet of runners jump by less
/// where a clip ends a frame before its first pose comes again.
const MOST: f64 = 0.2;

/// Returns true for a clip whose last pose is near its first, wherever on the ground it leads.
pub(super) fn loops(clip: &Clip) -> bool {
    let last = clip.row_count().saturating_sub(1);
    let mut ends = clip.row_poses(last).map(|pose| joints(clip.skeleton(), &pose));
    let (Some(first), Some(last)) = (ends.next(), ends.next()) else { return true };
    let rest: Vec<DVec3> =
        clip.skeleton().rest_models().iter().map(|joint| joint.translation).collect();
    let way = middle(&last) - middle(&first);
    let way = DVec3::new(way.x, 0.0, way.z);
    let jumps = first.iter().zip(&last).map(|(first, last)| (*last - way).distance(*first));
    jumps.fold(0.0, f64::max) <= MOST * length(&rest)
}

/// Returns the places of all joints of a pose in model space.
fn joints(skeleton: &Skeleton, pose: &[DAffine3]) -> Vec<DVec3> {
    let mut models: Vec<DAffine3> = Vec::with_capacity(pose.len());
    for (joint, local) in skeleton.joints().zip(pose) {
        let parent = skeleton.parent(joint).and_then(|parent| models.get(parent.index()));
        models.push(parent.map_or(*local, |parent| *parent * *local));
    }
    models.iter().map(|joint| joint.translation).collect()
}

fn middle(joints: &[DVec3]) -> DVec3 {
    joints.iter().sum::<DVec3>() / joints.len().max(1) as f64
}

/// Returns the longest side of the box around joints.
fn length(joints: &[DVec3]) -> f64 {
    let corner = |pick: fn(DVec3, DVec3) -> DVec3| joints.iter().copied().reduce(pick);
    let (low, high) = (corner(DVec3::min), corner(DVec3::max));
    low.zip(high).map_or(0.0, |(low, high)| (high - low).max_element())
}
