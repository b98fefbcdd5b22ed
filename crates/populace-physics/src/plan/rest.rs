//! Measurements of a skeleton in its rest pose.

use populace::model::{Affine, JointIndex, Skeleton};

use super::names;
use crate::math::{Rotation, Vector, origin};

/// Least reach of a joint's vertices, relative to the body size, for the joint to count as
/// deforming.
const MIN_REACH: f32 = 0.005;

/// A skeleton in its rest pose in model space, with measurements of its deforming joints.
pub(super) struct Rest<'a> {
    pub(super) skeleton: &'a Skeleton,
    pub(super) model_from_joint: Vec<Affine>,
    /// Rotations down the hierarchy, without the effect of scales.
    pub(super) rotations: Vec<Rotation>,
    pub(super) positions: Vec<Vector>,
    pub(super) parents: Vec<Option<usize>>,
    pub(super) children: Vec<Vec<usize>>,
    /// Distance of each joint's farthest vertex in metres, limited to the plausible thickness of a
    /// body.
    pub(super) reach: Vec<f32>,
    /// Whether the skeleton has reaches at all.
    pub(super) knows_reach: bool,
    /// Number of deforming joints in each subtree: those that move vertices and are neither props
    /// nor controls.
    pub(super) deforming_count: Vec<usize>,
    /// Largest distance in metres from each joint to the deforming joints below it, including their
    /// reach.
    pub(super) extent: Vec<f32>,
    /// Mean of the two larger sides of the bounding box of all deforming joints, in metres.
    pub(super) size: f32,
}

impl<'a> Rest<'a> {
    pub(super) fn new(skeleton: &'a Skeleton) -> Self {
        let count = skeleton.joint_count();
        let mut rest = Self {
            skeleton,
            model_from_joint: Vec::with_capacity(count),
            rotations: Vec::with_capacity(count),
            positions: Vec::with_capacity(count),
            parents: skeleton.joints().map(|j| skeleton.parent(j).map(JointIndex::index)).collect(),
            children: vec![Vec::new(); count],
            reach: skeleton.reach_m().to_vec(),
            knows_reach: skeleton.reach_m().iter().any(|r| *r > 0.0),
            deforming_count: vec![0; count],
            extent: vec![0.0; count],
            size: skeleton.size_m(),
        };
        rest.pose();
        rest.count_deforming();
        rest.measure();
        rest
    }

    /// Computes the transforms in model space.
    fn pose(&mut self) {
        for joint in self.skeleton.joints() {
            let local = self.skeleton.rest(joint);
            let rotation = Rotation::from_array(local.rotation);
            let (model, rotation) = match self.parents[joint.index()] {
                Some(p) => {
                    self.children[p].push(joint.index());
                    (
                        self.model_from_joint[p].mul(&Affine::from_trs(local)),
                        self.rotations[p] * rotation,
                    )
                }
                None => (Affine::from_trs(local), rotation),
            };
            self.positions.push(origin(&model));
            self.model_from_joint.push(model);
            self.rotations.push(rotation.normalize());
        }
    }

    fn count_deforming(&mut self) {
        let count = self.positions.len();
        let mut is_prop = vec![false; count];
        for joint in self.skeleton.joints() {
            let above = self.parents[joint.index()].is_some_and(|p| is_prop[p]);
            is_prop[joint.index()] = above || names::is_prop(self.skeleton.name(joint));
        }
        let min_reach = MIN_REACH * self.size;
        for joint in (0..count).rev() {
            let own = !is_prop[joint] && (!self.knows_reach || self.reach[joint] > min_reach);
            self.deforming_count[joint] += usize::from(own);
            if let Some(p) = self.parents[joint] {
                self.deforming_count[p] += self.deforming_count[joint];
            }
        }
    }

    /// Computes the size, limits the reaches, and computes the extents.
    fn measure(&mut self) {
        let count = self.positions.len();
        let deforming = (0..count)
            .filter(|&j| self.deforming_count[j] > 0 && (!self.knows_reach || self.reach[j] > 0.0));
        let mut low = Vector::MAX;
        let mut high = Vector::MIN;
        for joint in deforming {
            low = low.min(self.positions[joint]);
            high = high.max(self.positions[joint]);
        }
        let mut sides = (high - low).max(Vector::ZERO).to_array();
        sides.sort_by(f32::total_cmp);
        let mean = (sides[1] + sides[2]) * 0.5;
        let longest = self.reach.iter().copied().fold(0.0, f32::max);
        self.size = match mean {
            m if m > 1e-6 && m.is_finite() => m,
            _ if longest > 0.0 => 2.0 * longest,
            _ => self.skeleton.size_m(),
        };
        for reach in &mut self.reach {
            *reach = reach.min(0.2 * self.size); // capes and swords reach too far
        }
        self.measure_extents();
    }

    fn measure_extents(&mut self) {
        for joint in (0..self.positions.len()).rev().filter(|&j| self.deforming_count[j] > 0) {
            let is_leaf = self.deforming_children(joint).next().is_none();
            let own = match (self.parents[joint], self.knows_reach) {
                (_, true) => self.reach[joint],
                (Some(p), false) if is_leaf => {
                    0.5 * self.positions[joint].distance(self.positions[p])
                }
                _ => 0.0,
            };
            self.extent[joint] = self.extent[joint].max(own);
            if let Some(p) = self.parents[joint] {
                let further =
                    self.extent[joint] + self.positions[joint].distance(self.positions[p]);
                self.extent[p] = self.extent[p].max(further);
            }
        }
    }

    /// Returns the children whose subtrees have deforming joints.
    pub(super) fn deforming_children(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        self.children[joint].iter().copied().filter(|&c| self.deforming_count[c] > 0)
    }

    /// Returns the distance to the child with the largest subtree, or 0 for a leaf.
    pub(super) fn bone_length(&self, joint: usize) -> f32 {
        let main = self
            .deforming_children(joint)
            .max_by(|&a, &b| self.extent[a].total_cmp(&self.extent[b]));
        main.map_or(0.0, |child| self.positions[child].distance(self.positions[joint]))
    }
}
