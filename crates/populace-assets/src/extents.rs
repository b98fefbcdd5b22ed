//! How large the transforms of a file can become where those of its nodes are multiplied down the
//! hierarchy.

use std::sync::Arc;

use populace_clip::Clip;
use populace_model::{Interpolation, Property, Track};

use crate::json::LARGEST;
use crate::log::{Checked, Log};
use crate::nodes::Node;
use crate::rig::Rig;

/// Largest product of scales, and largest distance, along a chain of joints. Single precision still
/// holds its product with a bind matrix and a vertex of [`LARGEST`].
const LARGEST_OF_CHAIN: f64 = LARGEST * LARGEST;
/// Largest overshoot that a tangent adds to a spline, as a fraction of the tangent's size.
const TANGENT: f64 = 4.0 / 27.0;

/// For each joint the most that its rest and the keys of all clips make of its scale and its
/// distance from its parent. However clips are mixed, a joint's own transform stays within.
pub(crate) struct Extents {
    joints: Vec<Extent>,
}

#[derive(Clone, Copy)]
struct Extent {
    scale: f64,
    distance: f64,
}

impl Extents {
    pub(crate) fn of(rig: &Rig, clips: &[Arc<Clip>]) -> Self {
        let skeleton = &rig.skeleton;
        let at_rest = skeleton.joints().map(|joint| {
            let rest = skeleton.rest(joint);
            Extent { scale: most(&rest.scale), distance: length(&rest.translation) }
        });
        let mut joints: Vec<_> = at_rest.collect();
        for track in clips.iter().flat_map(|clip| &clip.source().tracks) {
            let Some(joint) = skeleton.find(&track.joint) else { continue };
            let extent = &mut joints[joint.index()];
            match track.property {
                Property::Translation => {
                    extent.distance = extent.distance.max(largest(track, length))
                }
                Property::Scale => extent.scale = extent.scale.max(largest(track, most)),
                Property::Rotation => {}
            }
        }
        Self { joints }
    }

    /// That no chain of joints comes to more than may be; each chain is told once, by its first
    /// node that does.
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
                    "can be scaled by {:.1e} and be {:.1e} m away, by its own transform and keys \
                     and those of the nodes above it; at most {LARGEST_OF_CHAIN:e} is possible",
                    chain.scale, chain.distance
                );
                failed = Err(log.problem(&nodes[node].place, what));
            }
            chains.push(if large.is_some() { None } else { chain });
        }
        failed
    }
}

/// The most that `size` makes of a track's values; a spline's tangents count by what they add
/// between two keys.
fn largest(track: &Track, size: fn(&[f32]) -> f64) -> f64 {
    let most = |part: usize, parts: usize| {
        let vectors = track.values.chunks(track.property.width()).skip(part).step_by(parts);
        vectors.map(size).fold(0.0, f64::max)
    };
    if track.interpolation != Interpolation::CubicSpline {
        return most(0, 1);
    }
    let longest =
        track.times.windows(2).map(|w| f64::from(w[1]) - f64::from(w[0])).fold(0.0, f64::max);
    most(1, 3) + TANGENT * longest * (most(0, 3) + most(2, 3))
}

fn most(vector: &[f32]) -> f64 {
    vector.iter().map(|v| f64::from(v.abs())).fold(0.0, f64::max)
}

fn length(vector: &[f32]) -> f64 {
    vector.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt()
}
