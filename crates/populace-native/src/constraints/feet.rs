//! Foot IK: feet keep to the ground and lock while planted, and the pelvis sinks for them. Twin of
//! `kernels/feet.cl`.
//!
//! Reads constraints, links, the ground, the legs' transforms, and the feet's state as of the frame
//! before. Writes the feet's state, the model transforms of pelvis or hip, and rotations for hips,
//! knees and ankles.
//!
//! A foot is lifted above the ground beneath it by as much as the clip lifts it above its rest
//! height. While that is little, the foot is planted: it stays where it came down, in world space,
//! however the member moves. Once lifted, it catches up with the clip.

use populace_device::Tables;
use populace_device::layout::{
    Constraint, FOOT_RELEASE_SECS, Float4, Link, MAX_FEET, MAX_PELVIS_SINK, Step,
};
use populace_model::Affine;
use populace_model::math::{Real, quat, vec3};

use super::limb::Limb;
use super::targets::Solver;
use crate::hierarchy::Hierarchy;
use crate::lanes::Simd;

/// Returns the last sample at or before a position on a grid, except the very last one, and the
/// part of the way to the next sample. Positions are in samples, and clamped to the grid.
fn grid_sample(at: f32, count: u32) -> (u32, f32) {
    let last = (count - 1) as f32;
    let at = if at > 0.0 { if at < last { at } else { last } } else { 0.0 };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and a count"
    )]
    let whole = (at as u32).min(count - 2);
    (whole, at - whole as f32)
}

/// Returns the ground's height and upward unit normal at a position, in world space.
fn ground_at(tables: &Tables, x: f32, z: f32) -> (f32, [f32; 3]) {
    let ground = &tables.ground().as_slice()[0];
    let (mut height, mut slope) =
        (ground.offset + ground.slope_x * x + ground.slope_z * z, [ground.slope_x, ground.slope_z]);
    if ground.per_metre > 0.0 {
        let (column, across) = grid_sample((x - ground.grid_x) * ground.per_metre, ground.count_x);
        let (row, along) = grid_sample((z - ground.grid_z) * ground.per_metre, ground.count_z);
        let heights = tables.heights().as_slice();
        let at = |row: u32, column: u32| heights[(row * ground.count_x + column) as usize];
        let (h00, h10) = (at(row, column), at(row, column + 1));
        let (h01, h11) = (at(row + 1, column), at(row + 1, column + 1));
        let (near, far) = (h00 + (h10 - h00) * across, h01 + (h11 - h01) * across);
        height += near + (far - near) * along;
        slope[0] += ((h10 - h00) + ((h11 - h01) - (h10 - h00)) * along) * ground.per_metre;
        slope[1] += (far - near) * ground.per_metre;
    }
    (height, vec3::unit_or([-slope[0], 1.0, -slope[1]], [0.0, 1.0, 0.0]))
}

/// Goal of a foot.
struct FootGoal {
    /// The ankle's position in model space.
    ankle: [f32; 3],
    /// The ground's unit normal in model space, and how much the foot follows the slope: 1 while
    /// planted, 0 when lifted.
    follows: [f32; 4],
}

/// State of a foot as of the frame before, in world space.
struct FootState {
    /// If planted, the position; else the horizontal offset from where the clip has the foot.
    vector: [f32; 3],
    planted: bool,
}

/// Offset of a foot.
struct Offset {
    /// From where the clip has the foot, in world space, horizontal.
    vector: [f32; 3],
    /// True if a planted foot may stay where it is.
    stays: bool,
}

/// A leg before the constraint, in model space.
#[derive(Default)]
struct Leg {
    hip: [f32; 3],
    knee: [f32; 3],
    ankle: [f32; 3],
    /// Direction that the knee bends to.
    bend: [f32; 3],
}

/// A leg and its goal: one lane of [`Legs`].
#[derive(Clone, Copy, Default)]
struct Stride {
    upper: [f32; 3],
    lower: [f32; 3],
    bend: [f32; 3],
    to: [f32; 3],
    follows: [f32; 4],
}

impl Stride {
    #[inline(always)]
    fn new(leg: &Leg, ankle: [f32; 3], follows: [f32; 4]) -> Self {
        let (upper, lower) = (vec3::sub(leg.knee, leg.hip), vec3::sub(leg.ankle, leg.knee));
        Self { upper, lower, bend: leg.bend, to: vec3::sub(ankle, leg.hip), follows }
    }
}

const FEET: usize = MAX_FEET as usize;

/// One lane for each leg of a member.
type Feet = Simd<FEET>;

/// Legs of a member.
struct Legs {
    limb: Limb<Feet>,
    /// As [`FootGoal::follows`].
    follows: [Feet; 4],
}

impl Legs {
    #[inline(always)]
    fn new(strides: &[Stride; FEET]) -> Self {
        let each = |of: fn(&Stride) -> &[f32; 3]| -> [Feet; 3] {
            [0, 1, 2].map(|c: usize| Simd::from_fn(|lane| of(&strides[lane])[c]))
        };
        let limb = Limb {
            upper: each(|s| &s.upper),
            lower: each(|s| &s.lower),
            bend: each(|s| &s.bend),
            to: each(|s| &s.to),
        };
        let follows = [0, 1, 2, 3].map(|c: usize| Simd::from_fn(|lane| strides[lane].follows[c]));
        Self { limb, follows }
    }

    /// Returns the drop of the pelvis, in metres, that each leg needs to reach its goal.
    #[inline(always)]
    fn sinks(&self, soft: f32) -> Feet {
        let length = vec3::length(self.limb.upper) + vec3::length(self.limb.lower);
        let (reach, most) =
            (length * Feet::splat(1.0 - soft), length * Feet::splat(MAX_PELVIS_SINK));
        let [x, y, z] = self.limb.to;
        let needed = -y - vec3::root(reach * reach - x * x - z * z);
        Feet::choose(most.less(needed), most, needed)
    }
}

impl Solver<'_> {
    fn foot_state(&self, foot: u32) -> FootState {
        let [x, y, z, bits] = self.state(foot).0;
        let bits = bits.to_bits();
        let ours = bits >> 1 == self.control.epoch;
        let vector = if ours { [x, y, z] } else { [0.0; 3] };
        FootState { vector, planted: ours && bits & 1 != 0 }
    }

    fn keep_foot_state(&mut self, foot: u32, state: &FootState) {
        let [x, y, z] = state.vector;
        let bits = self.control.epoch << 1 | u32::from(state.planted);
        self.keep_state(foot, Float4([x, y, z, f32::from_bits(bits)]));
    }

    /// Returns the offset of a foot from its position `clip` in the clip. A planted foot that is
    /// held back by more than `held_most` metres slips. By more than twice that, the member was
    /// moved elsewhere, and the offset is 0.
    fn offset(&self, state: &FootState, clip: [f32; 3], held_most: f32) -> Offset {
        let mut vector = if state.planted {
            vec3::sub(state.vector, clip)
        } else {
            let elapsed_secs = self.inputs.frame.elapsed_secs();
            vec3::scale(state.vector, 1.0 / (1.0 + elapsed_secs * (1.0 / FOOT_RELEASE_SECS)))
        };
        vector[1] = 0.0;
        let (far, held) = (vec3::dot(vector, vector), held_most * held_most);
        if far > 4.0 * held {
            Offset { vector: [0.0; 3], stays: false }
        } else if far > held {
            let vector = vec3::scale(vector, held_most * far.inverse_sqrt());
            Offset { vector, stays: false }
        } else {
            Offset { vector, stays: state.planted }
        }
    }

    /// Returns the goal of a foot, and writes its state. `ankle` is its position before the
    /// constraint, in model space.
    fn foot_goal(&mut self, foot: u32, constraint: &Constraint, ankle: [f32; 3]) -> FootGoal {
        let [rest, planted_below, lifted_above, held_most] = constraint.up.0;
        let size = self.control.place.0[3];
        let clip = self.to_world(ankle);
        let state = self.foot_state(foot);
        let offset = self.offset(&state, clip, held_most * size);
        let lift = ankle[1] - rest;
        let planted = lift <= planted_below;
        let position =
            if planted && offset.stays { state.vector } else { vec3::add(clip, offset.vector) };
        let vector = if planted { position } else { offset.vector };
        self.keep_foot_state(foot, &FootState { vector, planted });
        let (height, normal) = ground_at(self.tables, position[0], position[2]);
        let between = (lift - planted_below) / (lifted_above - planted_below);
        let (lift, follows) = if planted {
            (0.0, 1.0)
        } else if lift < lifted_above {
            (between * lifted_above, 1.0 - between)
        } else {
            (lift, 0.0)
        };
        let height = height + (rest / normal[1] + lift) * size;
        let ankle = self.to_model([position[0], height, position[2]]);
        let [x, y, z] = self.direction_to_model(normal);
        FootGoal { ankle, follows: [x, y, z, follows] }
    }

    /// Walks down a leg's chain from link `start`. `from` is the model transform of its joint.
    #[inline(never)]
    fn walk_leg(
        joints: &impl Hierarchy,
        links: &[Link],
        foot: &Constraint,
        start: usize,
        from: Affine,
    ) -> Leg {
        let (mut leg, mut model) = (Leg::default(), from);
        for (at, link) in links.iter().enumerate().skip(start) {
            if at > start {
                model = model.mul(&joints.local_of(link.joint as usize));
            }
            if at == foot.upper as usize {
                leg.hip = model.origin();
                leg.bend = model.transform_vector(foot.axis.xyz());
            }
            if at == foot.middle as usize {
                leg.knee = model.origin();
            }
        }
        leg.ankle = model.origin();
        leg
    }

    /// Solves legs. Writes three rotations for each of the first `count`: hip, knee and ankle.
    #[inline(never)]
    fn leg_rotations(&mut self, legs: &Legs, constraint: &Constraint, first: u32, count: usize) {
        let [soft, weight, ..] = constraint.limits.0;
        let [mut hip, mut knee] = legs.limb.rotations(None, soft);
        if weight < 1.0 {
            [hip, knee] = [hip, knee].map(|rotation| vec3::part_of(rotation, Feet::splat(weight)));
        }
        // The ankle keeps its rotation from before the constraint, and follows the slope: by the
        // rotation from up to the normal.
        let [nx, ny, nz, follows] = legs.follows;
        let tilt = [nz, Feet::splat(0.0), -nx, Feet::splat(1.0) + ny];
        let slope = quat::normalize_or(tilt, quat::identity());
        let slope = vec3::part_as_told(slope, follows * Feet::splat(weight));
        let ankle = quat::mul(slope, quat::conjugate(quat::mul(knee, hip)));
        let rotations = self.step_rotations[first as usize..].as_chunks_mut::<3>().0;
        for (lane, of_leg) in rotations.iter_mut().take(count).enumerate() {
            *of_leg =
                [hip, knee, ankle].map(|rotation| rotation.map(|component| component.0[lane]));
        }
    }

    /// Finds the goals of all feet, and lowers the pelvis until the legs can reach them. Solves the
    /// legs too, unless something else moves them after the pelvis.
    #[inline(never)]
    pub(super) fn pelvis(&mut self, joints: &mut impl Hierarchy, joint: usize, step: &Step) {
        let own = joints.model_of(joint);
        let first = self.constraint(step);
        let count = first.target_count as usize;
        let mut strides = [Stride::default(); FEET];
        for (foot, stride) in (0..first.target_count).zip(&mut strides) {
            let constraint = &self.tables.constraints().as_slice()[(step.index + foot) as usize];
            let leg = Self::walk_leg(joints, self.links(constraint), constraint, 0, own);
            let foot_goal = self.foot_goal(foot, constraint, leg.ankle);
            *stride = Stride::new(&leg, foot_goal.ankle, foot_goal.follows);
            let ([x, y, z], first) = (foot_goal.ankle, (step.operand + 3 * foot) as usize);
            self.step_rotations[first] = [x, y, z, 0.0];
            self.step_rotations[first + 1] = foot_goal.follows;
        }
        let mut legs = Legs::new(&strides);
        let mut drop = 0.0;
        for needed in &legs.sinks(first.limits.0[0]).0[..count] {
            drop = if *needed > drop { *needed } else { drop };
        }
        drop *= first.limits.0[1];
        let mut rows = own.rows;
        rows[1][3] -= drop;
        joints.keep_model(joint, Affine { rows });
        if first.at_once != 0 {
            legs.limb.to[1] = legs.limb.to[1] + Feet::splat(drop);
            self.leg_rotations(&legs, first, step.operand, count);
        }
    }

    /// Solves a leg that something else has moved after the pelvis, for the goal that
    /// [`pelvis`](Self::pelvis) found.
    #[inline(never)]
    pub(super) fn foot(&mut self, joints: &mut impl Hierarchy, joint: usize, step: &Step) {
        let constraint = self.constraint(step);
        let own = joints.model_of(joint);
        let links = self.links(constraint);
        let leg = Self::walk_leg(joints, links, constraint, constraint.upper as usize, own);
        let first = step.operand as usize;
        let [x, y, z, _] = self.step_rotations[first];
        let mut strides = [Stride::default(); FEET];
        strides[0] = Stride::new(&leg, [x, y, z], self.step_rotations[first + 1]);
        self.leg_rotations(&Legs::new(&strides), constraint, step.operand, 1);
        joints.keep_model(joint, own.rotated(self.step_rotations[first]));
    }
}
