//! Bounds of the world transforms that nodes and clips can produce along the hierarchy.

use std::sync::Arc;

use populace_clip::Clip;
use populace_model::{Interpolation, Property, Track};

use crate::json::LARGEST;
use crate::log::{Checked, Log};
use crate::nodes::Node;
use crate::rig::Rig;

/// Largest product of scales, and largest distance in metres, along a chain of joints. The product
/// with a bind matrix and a vertex of magnitude [`LARGEST`] still fits single precision.
const LARGEST_OF_CHAIN: f64 = LARGEST * LARGEST;
/// Largest overshoot that a tangent adds to a cubic spline, as a fraction of the tangent's length:
/// the maximum of the Hermite basis function `t (1 - t)^2` on 0 to 1.
const TANGENT: f64 = 4.0 / 27.0;

/// Bounds of each joint's local transform over the rest pose and the keys of all clips. Any blend
/// of the clips stays within them.
pub(crate) struct Extents {
    joints: Vec<Extent>,
}

#[derive(Clone, Copy)]
struct Extent {
    /// Largest absolute scale along an axis.
    scale: f64,
    /// Largest distance from the parent in metres.
    distance: f64,
}

impl Extents {
    pub(crate) fn of(rig: &Rig, clips: &[Arc<Clip>]) -> Self {
        let skeleton = &rig.skeleton;
        let at_rest = skeleton.joints().map(|joint| {
            let rest = skeleton.rest(joint);
            Extent { scale: max_component(&rest.scale), distance: length(&rest.translation) }
        });
        let mut joints: Vec<_> = at_rest.collect();
        for track in clips.iter().flat_map(|clip| &clip.source().tracks) {
            let Some(joint) = skeleton.find(&track.joint) else { continue };
            let extent = &mut joints[joint.index()];
            match track.property {
                Property::Translation => {
                    extent.distance = extent.distance.max(largest(track, length))
                }
                Property::Scale => extent.scale = extent.scale.max(largest(track, max_component)),
                Property::Rotation => {}
            }
        }
        Self { joints }
    }

    /// Checks that no chain of joints exceeds [`LARGEST_OF_CHAIN`]. Each chain is reported once, at
    /// the first node that exceeds it.
    pub(crate) fn check(&self, rig: &Rig, nodes: &[Node], log: &Log) -> Checked<()> {
        let node_from_joint = rig.node_from_joint();
        let mut chains: Vec<Option<Extent>> = Vec::with_capacity(self.joints.len());
        let mut failed = Ok(());
        for (joint, own) in rig.skeleton.joints().zip(&self.joints) {
            let root = Some(Extent { scale: 1.0, distance: 0.0 });
            let above = rig.skeleton.parent(joint).map_or(root, |parent| chains[parent.index()]);
            let chain = above.map(|above| Extent {
                scale: above.scale * own.scale,
                distance: above.distance + above.scale * own.distance,
            });
            let large = chain.filter(|c| c.scale.max(c.distance) > LARGEST_OF_CHAIN);
            if let (Some(chain), Some(node)) = (large, node_from_joint[joint.index()]) {
                let what = format!(
                    "can be scaled by {:.1e} and be {:.1e} m away through its own transform and \
                     keys and those of its ancestors; both must be at most {LARGEST_OF_CHAIN:e}",
                    chain.scale, chain.distance
                );
                failed = Err(log.problem(&nodes[node].place, what));
            }
            chains.push(if large.is_some() { None } else { chain });
        }
        failed
    }
}

/// Returns the maximum of `size` over the values of a track. For cubic splines it includes an upper
/// bound of the overshoot between two keys.
fn largest(track: &Track, size: fn(&[f32]) -> f64) -> f64 {
    let max_of = |part: usize, parts: usize| {
        let vectors = track.values.chunks(track.property.width()).skip(part).step_by(parts);
        vectors.map(size).fold(0.0, f64::max)
    };
    if track.interpolation != Interpolation::CubicSpline {
        return max_of(0, 1);
    }
    let longest =
        track.times.windows(2).map(|w| f64::from(w[1]) - f64::from(w[0])).fold(0.0, f64::max);
    max_of(1, 3) + TANGENT * longest * (max_of(0, 3) + max_of(2, 3))
}

fn max_component(vector: &[f32]) -> f64 {
    vector.iter().map(|v| f64::from(v.abs())).fold(0.0, f64::max)
}

fn length(vector: &[f32]) -> f64 {
    vector.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt()
}
