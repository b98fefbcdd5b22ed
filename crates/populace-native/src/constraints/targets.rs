//! Solver of a member's constraints, and the points that constraints aim at. Twin of
//! `kernels/targets.cl`.
//!
//! Reads the member's control, constraints, links and targets, and the state and watched joints of
//! the frame before. Writes states and watched joints, deferred.

use populace_device::Tables;
use populace_device::layout::{
    Constraint, Control, Float4, Link, STATES_PER_CONTROL, Step, TARGET_DIRECTION, TARGET_FAR_M,
    TARGET_WATCHED, TARGET_WORLD, Target,
};
use populace_model::math::{Real, vec3};

use crate::frame::FrameInputs;
use crate::history::DeferredWrites;
use crate::members::control_of;

/// Solver of one member's constraints.
pub(crate) struct Solver<'a> {
    pub(super) inputs: &'a FrameInputs<'a>,
    pub(super) tables: &'a Tables,
    pub(super) control: &'a Control,
    /// Index of the control.
    index: u32,
    pub(super) writes: &'a mut DeferredWrites,
}

/// Places of members: of one, or of several in SIMD lanes.
#[derive(Clone, Copy)]
pub(super) struct Standing<R> {
    /// Position in the world in metres, and scale.
    pub(super) place: [R; 4],
    /// Sine and cosine of the heading.
    pub(super) facing: [R; 2],
}

impl<R: Real> Standing<R> {
    /// Takes a direction from world to model space. Its length stays.
    #[inline(always)]
    pub(super) fn direction_to_model(self, [x, y, z]: [R; 3]) -> [R; 3] {
        let [sin, cos] = self.facing;
        [cos * x - sin * z, y, sin * x + cos * z]
    }

    /// Takes a point from world to model space.
    #[inline(always)]
    pub(super) fn to_model(self, point: [R; 3]) -> [R; 3] {
        let [x, y, z, scale] = self.place;
        let shrinks = R::splat(1.0) / scale;
        vec3::scale(self.direction_to_model(vec3::sub(point, [x, y, z])), shrinks)
    }

    /// Takes a point from model to world space.
    #[inline(always)]
    pub(super) fn to_world(self, p: [R; 3]) -> [R; 3] {
        let ([x, y, z, scale], [sin, cos]) = (self.place, self.facing);
        [
            (cos * p[0] + sin * p[2]) * scale + x,
            p[1] * scale + y,
            (cos * p[2] - sin * p[0]) * scale + z,
        ]
    }
}

/// A point in model space, and its weight from 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct WeightedPoint {
    pub(super) position: [f32; 3],
    pub(super) weight: f32,
}

impl<'a> Solver<'a> {
    /// Makes the solver of a member; `None` if only clips move the member.
    pub(crate) fn new(
        inputs: &'a FrameInputs<'a>,
        member: u32,
        writes: &'a mut DeferredWrites,
    ) -> Option<Self> {
        let tables = inputs.tables;
        let control = control_of(tables, member)?;
        let index = tables.members().as_slice()[member as usize].control;
        Some(Self { inputs, tables, control, index, writes })
    }

    #[inline(always)]
    pub(super) fn constraint(&self, step: &Step) -> &'a Constraint {
        &self.tables.constraints().as_slice()[step.index as usize]
    }

    #[inline(always)]
    pub(super) fn links(&self, constraint: &Constraint) -> &'a [Link] {
        let first = constraint.link_first as usize;
        &self.tables.links().as_slice()[first..first + constraint.link_count as usize]
    }

    pub(super) fn targets(&self, constraint: &Constraint) -> &[Target] {
        let first = self.control.target_first as usize + constraint.target_first as usize;
        &self.tables.targets().as_slice()[first..first + constraint.target_count as usize]
    }

    /// Returns an element of the member's state as of the frame before.
    pub(super) fn state(&self, element: u32) -> Float4 {
        self.inputs.history.state_before(self.index * STATES_PER_CONTROL + element)
    }

    /// Writes elements of the member's state for the next frame, from `first` on.
    pub(super) fn keep_states(&mut self, first: u32, values: &[Float4]) {
        self.writes.states.add(self.index * STATES_PER_CONTROL + first, values);
    }

    /// Returns where the member stands.
    #[inline(always)]
    pub(super) fn standing(&self) -> Standing<f32> {
        let facing = [self.control.sine, self.control.cosine];
        Standing { place: self.control.place.0, facing }
    }

    /// Returns a target's position as seen from a point, both in model space, and its present
    /// weight. A watched joint that no frame has written has weight 0.
    pub(super) fn sight(&self, target: &Target, from: [f32; 3]) -> WeightedPoint {
        let weight = target.weight_at(self.inputs.frame.tick);
        let point = target.point.xyz();
        let position = match target.kind {
            TARGET_WORLD => self.standing().to_model(point),
            TARGET_DIRECTION => {
                let direction = self.standing().direction_to_model(point);
                vec3::add_scaled(from, direction, TARGET_FAR_M)
            }
            TARGET_WATCHED => {
                let rows = self.inputs.history.watched_before(target.watched);
                let [a, b, c] = rows.map_or([[0.0; 4]; 3], |joint| joint.rows);
                let position = vec3::add([a[3], b[3], c[3]], point);
                // Both comparisons are false for NaN.
                let seen = a[0] * a[0] + a[1] * a[1] + a[2] * a[2] > 0.0
                    && vec3::dot(position, position) < 1e30;
                if !seen {
                    return WeightedPoint { position: from, weight: 0.0 };
                }
                self.standing().to_model(position)
            }
            _ => point,
        };
        WeightedPoint { position, weight }
    }

    /// Returns the weighted mean of all targets, and the sum of their weights, at most 1.
    pub(super) fn goal(&self, constraint: &Constraint, from: [f32; 3]) -> WeightedPoint {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for target in self.targets(constraint) {
            let WeightedPoint { position, weight } = self.sight(target, from);
            if weight > 0.0 {
                sum = vec3::add_scaled(sum, position, weight);
                total += weight;
            }
        }
        if total > 0.0 {
            let weight = if total < 1.0 { total } else { 1.0 };
            WeightedPoint { position: vec3::scale(sum, 1.0 / total), weight }
        } else {
            WeightedPoint { position: from, weight: 0.0 }
        }
    }
}
