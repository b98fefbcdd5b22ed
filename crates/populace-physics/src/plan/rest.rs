//! The skeleton at rest, measured.

use populace::model::{Affine, JointIndex, Skeleton};

use super::names;
use crate::math::{Rotation, Vector, origin};

/// Vertices that stray less than this part of the body's size make no body part.
const SLIGHT: f32 = 0.005;

/// A skeleton at rest in model space, and what of it has flesh.
pub(super) struct Rest<'a> {
    pub(super) skeleton: &'a Skeleton,
    pub(super) model_from_joint: Vec<Affine>,
    /// Rotations alone, without what scales do to them.
    pub(super) turns: Vec<Rotation>,
    pub(super) places: Vec<Vector>,
    pub(super) parents: Vec<Option<usize>>,
    pub(super) children: Vec<Vec<usize>>,
    /// How far each joint's vertices lie from it, but no further than flesh does.
    pub(super) reach: Vec<f32>,
    /// Whether the skeleton tells reaches at all.
    pub(super) knows_reach: bool,
    /// Joints of each subtree that move vertices and are neither props nor controls.
    pub(super) flesh: Vec<usize>,
    /// How far each subtree's flesh stretches from its first joint.
    pub(super) extent: Vec<f32>,
    /// The larger sides of the box around the flesh, on average, in metres.
    pub(super) size: f32,
}

impl<'a> Rest<'a> {
    pub(super) fn new(skeleton: &'a Skeleton) -> Self {
        let count = skeleton.joint_count();
        let mut rest = Self {
            skeleton,
            model_from_joint: Vec::with_capacity(count),
            turns: Vec::with_capacity(count),
            places: Vec::with_capacity(count),
            parents: skeleton.joints().map(|j| skeleton.parent(j).map(JointIndex::index)).collect(),
            children: vec![Vec::new(); count],
            reach: skeleton.reach_m().to_vec(),
            knows_reach: skeleton.reach_m().iter().any(|r| *r > 0.0),
            flesh: vec![0; count],
            extent: vec![0.0; count],
            size: skeleton.size_m(),
        };
        rest.pose();
        rest.find_flesh();
        rest.measure();
        rest
    }

    fn pose(&mut self) {
        for joint in self.skeleton.joints() {
            let local = self.skeleton.rest(joint);
            let turn = Rotation::from_array(local.rotation);
            let (model, turn) = match self.parents[joint.index()] {
                Some(p) => {
                    self.children[p].push(joint.index());
                    (self.model_from_joint[p].mul(&Affine::from_trs(local)), self.turns[p] * turn)
                }
                None => (Affine::from_trs(local), turn),
            };
            self.places.push(origin(&model));
            self.model_from_joint.push(model);
            self.turns.push(turn.normalize());
        }
    }

    fn find_flesh(&mut self) {
        let count = self.places.len();
        let mut is_prop = vec![false; count];
        for joint in self.skeleton.joints() {
            let above = self.parents[joint.index()].is_some_and(|p| is_prop[p]);
            is_prop[joint.index()] = above || names::is_prop(self.skeleton.name(joint));
        }
        let slight = SLIGHT * self.size;
        for joint in (0..count).rev() {
            let own = !is_prop[joint] && (!self.knows_reach || self.reach[joint] > slight);
            self.flesh[joint] += usize::from(own);
            if let Some(p) = self.parents[joint] {
                self.flesh[p] += self.flesh[joint];
            }
        }
    }

    fn measure(&mut self) {
        let count = self.places.len();
        let fleshy =
            (0..count).filter(|&j| self.flesh[j] > 0 && (!self.knows_reach || self.reach[j] > 0.0));
        let mut low = Vector::MAX;
        let mut high = Vector::MIN;
        for joint in fleshy {
            low = low.min(self.places[joint]);
            high = high.max(self.places[joint]);
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
            *reach = reach.min(0.2 * self.size); // capes and swords reach far, and are no flesh
        }
        self.stretch();
    }

    fn stretch(&mut self) {
        for joint in (0..self.places.len()).rev().filter(|&j| self.flesh[j] > 0) {
            let is_leaf = self.fleshy_children(joint).next().is_none();
            let own = match (self.parents[joint], self.knows_reach) {
                (_, true) => self.reach[joint],
                (Some(p), false) if is_leaf => 0.5 * self.places[joint].distance(self.places[p]),
                _ => 0.0,
            };
            self.extent[joint] = self.extent[joint].max(own);
            if let Some(p) = self.parents[joint] {
                let further = self.extent[joint] + self.places[joint].distance(self.places[p]);
                self.extent[p] = self.extent[p].max(further);
            }
        }
    }

    /// The children whose subtrees have flesh.
    pub(super) fn fleshy_children(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        self.children[joint].iter().copied().filter(|&c| self.flesh[c] > 0)
    }

    /// The length of a joint's own bone: as far as the child with the largest subtree, 0 for a
    /// leaf.
    pub(super) fn bone(&self, joint: usize) -> f32 {
        let main =
            self.fleshy_children(joint).max_by(|&a, &b| self.extent[a].total_cmp(&self.extent[b]));
        main.map_or(0.0, |child| self.places[child].distance(self.places[joint]))
    }
}
