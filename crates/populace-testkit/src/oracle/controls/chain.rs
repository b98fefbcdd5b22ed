//! FABRIK (Aristidou and Lasenby, "FABRIK: A fast, iterative solver for the Inverse Kinematics
//! problem", Graphical Models 73(5), 2011): forward and backward reaching along a chain.

use glam::{DQuat, DVec3};
use populace_device::Chain;
use populace_device::layout::CHAIN_PASSES;

use super::limb::{shortest, soft_reach};
use super::{Descent, short_part_of};

/// Moves each point to its bone's length from the point before it, along the line between them
/// (algorithm 1 of the paper, lines 16 to 20 and 23 to 27).
fn reach(points: &mut [DVec3], lengths: &[f64], mut moved: impl FnMut(DVec3) -> DVec3) {
    for at in 1..points.len() {
        let away = (points[at] - points[at - 1]).normalize_or(DVec3::Y);
        points[at] = moved(points[at - 1] + away * lengths[at - 1]);
    }
}

impl Descent<'_, '_> {
    /// Returns the rotation of each joint of a chain but the last, in model space, after that of
    /// the joint above.
    pub(super) fn chain(&mut self, chain: &Chain) -> Vec<(usize, DQuat)> {
        let now = self.walk(self.of.path(chain.first, chain.end));
        let bones: Vec<DVec3> = now.positions.windows(2).map(|w| w[1] - w[0]).collect();
        let mut lengths: Vec<f64> = bones.iter().map(|bone| bone.length()).collect();
        let total: f64 = lengths.iter().sum();
        let root = now.positions[0];
        let Some(goal) = self.goal(&chain.targets, root) else { return Vec::new() };
        let to = goal.position - root;
        let distance = to.length();
        let mut points = now.positions.clone();
        if total > 1e-6 && distance > 1e-6 {
            // The paper stretches the chain towards a goal out of reach; here it nears its length.
            let soft = soft_reach(distance, total, 0.0, f64::from(chain.soft));
            let end = root + to * (self.noise.number(soft) / distance);
            for _ in 0..CHAIN_PASSES {
                for first in [end, root] {
                    points.reverse();
                    lengths.reverse();
                    points[0] = first;
                    let noise = &mut *self.noise;
                    reach(&mut points, &lengths, |at| noise.vector(at));
                }
            }
        }
        let (mut rotations, mut turned) = (Vec::new(), DQuat::IDENTITY);
        for (at, bone) in bones.iter().enumerate() {
            let was = turned * *bone;
            let is = points[at + 1] - points[at];
            let whole = shortest(was, is, any_across(was), self.noise);
            let part = short_part_of(whole, goal.weight);
            rotations.push((now.joints[at], part));
            turned = part * turned;
        }
        rotations
    }
}

/// Returns a unit vector at right angles to another.
fn any_across(v: DVec3) -> DVec3 {
    v.normalize_or(DVec3::Y).any_orthonormal_vector()
}
