//! Constraint program of a member, run on the way down its hierarchy: constraints, overrides, user
//! stages, watched joints, attachments and root motion. Twin of `kernels/constraints.cl`.
//!
//! Reads the member's control and its steps, and all that the steps name. Writes model transforms;
//! states and watched joints, deferred.
//!
//! Constraints rotate joints in model space, each joint about its own position, once the joint's
//! parent has its final transform. All joints below follow rigidly, so lengths stay as they are
//! however joints are scaled. A constraint is solved at the first joint of its chain, from the
//! chain's local transforms, and hands rotations down to the steps of the other joints.

mod chain;
mod contacts;
mod descent;
mod feet;
mod foot;
mod foot_state;
mod foothold;
mod gaze;
mod limb;
mod motion;
mod programs;
mod targets;

use populace_device::layout::{
    Float4, STEP_ATTACH, STEP_CARRY, STEP_MOTION, STEP_OVERRIDE, STEP_STAGE, STEP_WATCH, Step,
    WATCHED_ELEMENTS,
};
use populace_model::math::{quat, vec3};
use populace_model::{Affine, Trs};

pub(crate) use self::programs::{Alone, Company, Programs, step_rotations};
use self::targets::Solver;
use crate::hierarchy::Hierarchy;
use crate::stages::stage_model;

/// Returns a column of a transform: the direction of an axis.
fn column_of(m: &Affine, c: usize) -> [f32; 3] {
    [m.rows[0][c], m.rows[1][c], m.rows[2][c]]
}

/// Returns the directions of a transform's axes, orthonormalized.
fn axes(m: &Affine) -> [[f32; 3]; 3] {
    let x = vec3::unit_or(column_of(m, 0), [1.0, 0.0, 0.0]);
    let y = vec3::unit_or(vec3::across(column_of(m, 1), x), vec3::any_across(x));
    [x, y, vec3::cross(x, y)]
}

/// Returns the rotation from one set of axes to another: first from x to x, then about x from y to
/// y.
fn rotation_between(from: &[[f32; 3]; 3], to: &[[f32; 3]; 3]) -> [f32; 4] {
    let first = vec3::between(from[0], to[0], from[1]);
    let second = vec3::between(vec3::rotated(first, from[1]), to[1], to[0]);
    quat::mul(second, first)
}

/// Returns an affine transform between two: the position on the straight line, the axes by the
/// shortest rotation, and the axes' lengths in proportion.
fn part_of_the_way(from: &Affine, to: &Affine, k: f32) -> Affine {
    let rotated = from.rotated(vec3::part_of(rotation_between(&axes(from), &axes(to)), k));
    let mut rows = rotated.rows;
    for c in 0..3 {
        let (old, new) = (vec3::length(column_of(from, c)), vec3::length(column_of(to, c)));
        let factor = if old > 1e-10 { 1.0 + (new / old - 1.0) * k } else { 1.0 };
        for row in &mut rows {
            row[c] *= factor;
        }
    }
    for (row, (start, end)) in rows.iter_mut().zip(from.origin().into_iter().zip(to.origin())) {
        row[3] = start + (end - start) * k;
    }
    Affine { rows }
}

/// A transform given by the host, and its weight from 0 to 1.
struct Given {
    transform: Affine,
    weight: f32,
}

impl Solver<'_> {
    fn given_transform(&self, index: u32) -> Given {
        let given = &self.tables.overrides().as_slice()[index as usize];
        let [x, y, z, weight] = given.translation_and_weight.0;
        let trs =
            Trs { translation: [x, y, z], rotation: given.rotation.0, scale: given.scale.xyz() };
        Given { transform: Affine::from_trs(&trs), weight }
    }

    #[inline(never)]
    fn override_model(&self, joints: &mut impl Hierarchy, joint: usize, index: u32) {
        let Given { transform: to, weight } = self.given_transform(index);
        joints.keep_model(
            joint,
            if weight >= 1.0 { to } else { part_of_the_way(&joints.model_of(joint), &to, weight) },
        );
    }

    fn world_from_model(&self) -> Affine {
        let ([x, y, z, scale], sin, cos) =
            (self.control.place.0, self.control.sine, self.control.cosine);
        let (s, c) = (sin * scale, cos * scale);
        Affine { rows: [[c, 0.0, s, x], [0.0, scale, 0.0, y], [-s, 0.0, c, z]] }
    }

    /// Writes the transform of a watched joint, for other members and for the next frame.
    fn keep_watched(&mut self, watched: u32, joint: Affine) {
        self.writes.watched.add(watched * WATCHED_ELEMENTS, &joint.rows.map(Float4));
    }

    /// Moves a root to the joint that the member is attached to, as an earlier phase of this frame
    /// wrote it.
    #[inline(never)]
    fn attach(&self, joints: &mut impl Hierarchy, joint: usize, step: &Step) {
        if let Some(parent) = self.inputs.history.watched_now(step.index) {
            let offset = self.given_transform(step.operand).transform;
            joints.keep_model(joint, parent.mul(&offset).mul(&joints.model_of(joint)));
        }
    }

    /// Takes a step that concerns one member.
    #[inline(always)]
    pub(super) fn take_step(&mut self, step: &Step, joints: &mut impl Hierarchy) {
        let joint = step.joint as usize;
        match step.kind {
            STEP_OVERRIDE => self.override_model(joints, joint, step.index),
            STEP_STAGE => {
                let own = joints.model_of(joint);
                if let Some(model) = stage_model(self.inputs, step, self.control, own) {
                    joints.keep_model(joint, model);
                }
            }
            STEP_WATCH => {
                let world = self.world_from_model().mul(&joints.model_of(joint));
                self.keep_watched(step.index, world);
            }
            STEP_CARRY => self.keep_watched(step.index, joints.model_of(joint)),
            STEP_ATTACH => self.attach(joints, joint, step),
            STEP_MOTION => self.moves(joints, joint),
            _ => {}
        }
    }
}
