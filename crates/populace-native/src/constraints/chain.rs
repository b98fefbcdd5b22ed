//! Chains of any length, by FABRIK (Aristidou & Lasenby 2011, "FABRIK: a fast, iterative solver for
//! the inverse kinematics problem"). Twin of `kernels/chain.cl`.
//!
//! Reads constraints, links and targets, and the chain's transforms. Writes the first joint's model
//! transform, and returns the rotations of all.

use populace_device::layout::{CHAIN_PASSES, Link, MAX_LINKS, Step};
use populace_model::Affine;
use populace_model::math::{quat, vec3};

use super::limb::soft_distance;
use super::targets::{Solver, WeightedPoint};
use crate::hierarchy::Hierarchy;

/// Returns the point at `length` from `to` in the direction of `from`.
fn drawn(to: [f32; 3], from: [f32; 3], length: f32) -> [f32; 3] {
    let away = vec3::unit_or(vec3::sub(from, to), [0.0, 1.0, 0.0]);
    vec3::add_scaled(to, away, length)
}

/// Returns the positions of a chain's joints in model space, from their local transforms. `from` is
/// the first joint's model transform.
fn positions(
    joints: &impl Hierarchy,
    links: &[Link],
    from: Affine,
) -> [[f32; 3]; MAX_LINKS as usize] {
    let mut positions = [[0.0; 3]; MAX_LINKS as usize];
    let mut end = from;
    positions[0] = end.origin();
    for (position, link) in positions.iter_mut().zip(links).skip(1) {
        end = end.mul(&joints.local_of(link.joint as usize));
        *position = end.origin();
    }
    positions
}

impl Solver<'_> {
    /// Brings the end of a chain to its target. Returns the rotation of each joint.
    #[inline(never)]
    pub(super) fn chain(
        &self,
        joints: &mut impl Hierarchy,
        step: &Step,
    ) -> [[f32; 4]; MAX_LINKS as usize] {
        let joint = step.joint as usize;
        let constraint = self.constraint(step);
        let links = self.links(constraint);
        let own = joints.model_of(joint);
        let positions = positions(joints, links, own);
        let last = links.len() - 1;
        let mut lengths = [0.0; MAX_LINKS as usize];
        let mut total = 0.0;
        for at in 0..last {
            lengths[at] = vec3::length(vec3::sub(positions[at + 1], positions[at]));
            total += lengths[at];
        }
        let WeightedPoint { position: target, weight } = self.goal(constraint, positions[0]);
        let to = vec3::sub(target, positions[0]);
        let distance = vec3::length(to);
        let mut points = positions;
        if weight > 0.0 && total > 1e-6 && distance > 1e-6 {
            let reach = soft_distance(distance, total, 0.0, constraint.limits.0[0]);
            let goal = vec3::add_scaled(positions[0], to, reach / distance);
            for _ in 0..CHAIN_PASSES {
                points[last] = goal;
                for at in (0..last).rev() {
                    points[at] = drawn(points[at + 1], points[at], lengths[at]);
                }
                points[0] = positions[0];
                for at in 0..last {
                    points[at + 1] = drawn(points[at], points[at + 1], lengths[at]);
                }
            }
        }
        let mut rotations = [quat::identity(); MAX_LINKS as usize];
        let mut rotated_by = quat::identity();
        for at in 0..last {
            let was = vec3::unit_or(
                vec3::rotated(rotated_by, vec3::sub(positions[at + 1], positions[at])),
                [0.0; 3],
            );
            let is = vec3::unit_or(vec3::sub(points[at + 1], points[at]), was);
            let rotation = vec3::part_of(vec3::between(was, is, vec3::any_across(is)), weight);
            rotations[at] = rotation;
            rotated_by = quat::mul(rotation, rotated_by);
        }
        joints.keep_model(joint, own.rotated(rotations[0]));
        rotations
    }
}
