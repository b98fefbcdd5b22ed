//! Where a foot of a member goes: with its clips and its stride, locked to the ground while it
//! stands. Twin of `kernels/foot.cl`; twins of its functions of the ground are in populace-device.
//!
//! Reads constraints, soles, the ground, the leg's transforms, and the foot's state as of the frame
//! before. Writes the foot's state.
//!
//! A standing foot is locked in world space: at the lowest point of its sole, over which it rolls,
//! and in its direction. Once lifted, it catches up with the clip.

use populace_device::layout::{
    Constraint, FOOT_EDGE, FOOT_MAX_TURN, FOOT_NEAR_SECS, FOOT_PIVOT_SLACK, FOOT_REACH,
    FOOT_RELEASE_SECS, FOOT_RELOCK, FOOT_STATE_BITS, FOOT_TURN_STATE, Float4,
};
use populace_model::Affine;
use populace_model::math::{Real, quat, vec3};

use super::targets::Solver;

/// Goal of a foot.
pub(super) struct FootGoal {
    /// The ankle's position in model space, and the tangent of half the angle about +Y by which the
    /// foot turns.
    pub(super) ankle: [f32; 4],
    /// The ground's unit normal in model space, and how much the foot follows the slope: 1 while
    /// planted, 0 when lifted.
    pub(super) follows: [f32; 4],
}

/// State of a foot as of the frame before, in world space.
#[derive(Clone, Copy)]
pub(super) struct FootState {
    /// Horizontal: the pivot's position if planted, else the offset from where the clip has the
    /// foot.
    vector: [f32; 3],
    /// If planted, the unit direction from heel to toes along X and Z; else the tangent of half the
    /// angle by which the foot is turned from the clip, then 0.
    direction: [f32; 2],
    /// Height of the ground that the foot is shown on.
    pub(super) height: f32,
    /// Height of the planted pivot above the true ground.
    pub(super) above: f32,
    /// Speed at which the foot rises to the height of the ground, in metres per second.
    pub(super) climb: f32,
    /// The point of the sole that stands, if planted.
    pivot: u32,
    pub(super) planted: bool,
    /// The lock was let go within a contact that has not ended.
    released: bool,
    /// False if the member had no such state in the frame before.
    pub(super) known: bool,
}

/// A leg before the constraint, in model space.
pub(super) struct Leg {
    pub(super) hip: [f32; 3],
    pub(super) knee: [f32; 3],
    /// Direction that the knee bends to.
    pub(super) bend: [f32; 3],
    /// Transforms of the ankle, and of the joint that carries the front of the sole.
    pub(super) ankle: Affine,
    pub(super) toes: Affine,
}

/// A rotation about +Y, by the tangent of half its angle.
#[derive(Clone, Copy)]
struct Turn {
    half_tan: f32,
    sin: f32,
    cos: f32,
}

impl Turn {
    #[inline(always)]
    fn turn_of(half_tan: f32) -> Self {
        let inverse = 1.0 / (1.0 + half_tan * half_tan);
        Self { half_tan, sin: (half_tan + half_tan) * inverse, cos: 2.0 * inverse - 1.0 }
    }

    /// Returns the turn by the sum of two angles, which is less than half a turn.
    #[inline(always)]
    fn turn_and(self, half_tan: f32) -> Self {
        Self::turn_of((self.half_tan + half_tan) / (1.0 - self.half_tan * half_tan))
    }

    #[inline(always)]
    fn turned(self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        [self.cos * x + self.sin * z, y, self.cos * z - self.sin * x]
    }
}

/// A foot as its clips and the member's stride pose it, in model space.
struct Stepped {
    ankle: [f32; 3],
    turn: Turn,
    /// From heel to ball, as the clips have it.
    along: [f32; 3],
    /// Index of the lowest point of the sole, and its height.
    lowest: u32,
    clearance: f32,
}

impl Stepped {
    /// Applies the member's stride: distances that the clip steps along +Z, from the ankle's
    /// position at rest, are scaled and turned, and the foot turns by them about the origin.
    #[inline(always)]
    fn step_foot(
        leg: &Leg,
        foot: &Constraint,
        soles: &[Float4],
        [along_x, along_z, turn, _]: [f32; 4],
    ) -> Self {
        let ([x, y, z], rest_z) = (leg.ankle.origin(), foot.limits.0[2]);
        let stride = z - rest_z;
        let turn = Turn::turn_of(turn * stride);
        let ankle = turn.turned([x + stride * along_x, y, rest_z + stride * along_z]);
        let of_ankle = &soles[foot.sole_first as usize..][..foot.sole_count as usize];
        let of_toes = &soles[foot.toe_first as usize..][..foot.toe_count as usize];
        let along = match of_ankle {
            [heel, .., ball] => leg.ankle.transform_vector(vec3::sub(ball.xyz(), heel.xyz())),
            _ => [0.0; 3],
        };
        let mut step = Self { ankle, turn, along, lowest: 0, clearance: f32::MAX };
        step.lower(&leg.ankle, of_ankle, 0);
        step.lower(&leg.toes, of_toes, foot.sole_count);
        if foot.sole_count + foot.toe_count == 0 {
            step.clearance = y - foot.limits.0[3];
        }
        step
    }

    /// Finds the lowest of the points that a joint carries, the first of which has the index
    /// `first`.
    #[inline(always)]
    fn lower(&mut self, joint: &Affine, points: &[Float4], first: u32) {
        let row = joint.rows[1];
        for (index, Float4([x, y, z, _])) in (first..).zip(points) {
            let height = row[0] * x + row[1] * y + row[2] * z + row[3];
            if height < self.clearance {
                (self.lowest, self.clearance) = (index, height);
            }
        }
    }
}

/// Returns a point of the sole as the clips pose it; beneath the ankle if none is known.
#[inline(always)]
fn sole_point(leg: &Leg, foot: &Constraint, soles: &[Float4], point: u32) -> [f32; 3] {
    if point < foot.sole_count {
        leg.ankle.transform_point(soles[(foot.sole_first + point) as usize].xyz())
    } else if point - foot.sole_count < foot.toe_count {
        let of_toes = foot.toe_first + (point - foot.sole_count);
        leg.toes.transform_point(soles[of_toes as usize].xyz())
    } else {
        let [x, y, z] = leg.ankle.origin();
        [x, y - foot.limits.0[3], z]
    }
}

/// Returns where a point of the sole of a turned foot is, relative to the ankle.
#[inline(always)]
fn sole_arm(leg: &Leg, foot: &Constraint, soles: &[Float4], point: u32, turn: Turn) -> [f32; 3] {
    turn.turned(vec3::sub(sole_point(leg, foot, soles, point), leg.ankle.origin()))
}

/// Returns the nearest number of a range.
#[inline(always)]
pub(super) fn within(value: f32, least: f32, most: f32) -> f32 {
    if value > most {
        most
    } else if value < least {
        least
    } else {
        value
    }
}

/// Returns a part of the way from 0 to 1 that begins and ends without speed.
fn eased(part: f32) -> f32 {
    let part = if part > 0.0 { if part < 1.0 { part } else { 1.0 } } else { 0.0 };
    part * part * (3.0 - 2.0 * part)
}

/// Returns whether a foot stands, and how near it is to that: 1 while it stands, 0 in the air.
#[inline(always)]
fn stance(foot: &Constraint, ankle_height: f32, within_secs: Option<f32>) -> (bool, f32) {
    let [rest, planted_below, lifted_above, _] = foot.up.0;
    match within_secs {
        Some(secs) => (secs >= 0.0, eased(1.0 + secs * (1.0 / FOOT_NEAR_SECS))),
        None => {
            let lift = ankle_height - rest;
            let above = (lift - planted_below) / (lifted_above - planted_below);
            (lift <= planted_below, eased(1.0 - above))
        }
    }
}

/// Returns the horizontal offset of a foot from its position in the clip, at most `most` metres,
/// and whether the member was moved elsewhere, which ends the offset. `pivot` is where the clip has
/// the point that stands.
#[inline(always)]
fn offset(state: &FootState, pivot: [f32; 3], decay: f32, most: f32) -> ([f32; 3], bool) {
    let mut vector = if state.planted {
        vec3::sub(state.vector, pivot)
    } else {
        vec3::scale(state.vector, decay)
    };
    vector[1] = 0.0;
    let far = vec3::dot(vector, vector);
    if far > 4.0 * most * most {
        return ([0.0; 3], true);
    }
    if far > most * most {
        vector = vec3::scale(vector, most * far.inverse_sqrt());
    }
    (vector, false)
}

impl Solver<'_> {
    fn foot_state(&self, foot: u32) -> FootState {
        let [x, height, z, bits] = self.state(foot).0;
        let [along_x, along_z, above, climb] = self.state(FOOT_TURN_STATE + foot).0;
        let bits = bits.to_bits();
        let known = bits >> FOOT_STATE_BITS == self.control.epoch;
        FootState {
            vector: if known { [x, 0.0, z] } else { [0.0; 3] },
            direction: if known { [along_x, along_z] } else { [0.0; 2] },
            height,
            above,
            climb,
            pivot: bits >> 1 & 15,
            planted: known && bits & 1 != 0,
            released: known && bits & 32 != 0,
            known,
        }
    }

    fn keep_foot_state(&mut self, foot: u32, state: &FootState) {
        let ([x, _, z], [along_x, along_z]) = (state.vector, state.direction);
        let flags = u32::from(state.released) << 5 | u32::from(state.planted);
        let bits = self.control.epoch << FOOT_STATE_BITS | flags | state.pivot << 1;
        self.keep_state(foot, Float4([x, state.height, z, f32::from_bits(bits)]));
        let turned = Float4([along_x, along_z, state.above, state.climb]);
        self.keep_state(FOOT_TURN_STATE + foot, turned);
    }

    /// Returns the tangent of half the angle by which a foot is turned from where the clip has it.
    /// `own` is the direction from heel to toes in the clip, in world space.
    fn turn_lag(&self, state: &FootState, own: [f32; 2], decay: f32) -> f32 {
        let [x, z] = state.direction;
        let lag = if state.planted {
            let (cross, dot) = (own[1] * x - own[0] * z, own[0] * x + own[1] * z);
            if dot > 0.0 { cross / (1.0 + dot) } else { 0.0 }
        } else {
            x * decay
        };
        within(lag, -FOOT_MAX_TURN, FOOT_MAX_TURN)
    }

    /// Returns the unit direction in world space of a vector of model space, along X and Z.
    fn level_direction(&self, [x, _, z]: [f32; 3]) -> [f32; 2] {
        let [sin, cos, ..] = self.control.facing.0;
        let along = vec3::unit_or([cos * x + sin * z, 0.0, cos * z - sin * x], [0.0, 0.0, 1.0]);
        [along[0], along[2]]
    }

    /// Returns the goal of a foot, and writes its state. `within_secs` is the time within its
    /// contact, if that is known.
    pub(super) fn foot_goal(
        &mut self,
        foot: u32,
        constraint: &Constraint,
        leg: &Leg,
        within_secs: Option<f32>,
    ) -> FootGoal {
        let soles = self.tables.soles().as_slice();
        let most = constraint.up.0[3] * self.control.place.0[3];
        let stepped = Stepped::step_foot(leg, constraint, soles, self.control.stride.0);
        let (stands, near) = stance(constraint, stepped.ankle[1], within_secs);
        let mut state = self.foot_state(foot);
        let elapsed_secs = self.inputs.frame.elapsed_secs();
        let decay = 1.0 / (1.0 + elapsed_secs * (1.0 / FOOT_RELEASE_SECS));
        let own = self.level_direction(stepped.turn.turned(stepped.along));
        let lag = if constraint.sole_count > 1 { self.turn_lag(&state, own, decay) } else { 0.0 };
        let turn = stepped.turn.turn_and(lag);
        let arm = |point: u32| sole_arm(leg, constraint, soles, point, turn);
        let in_world = |arm: [f32; 3]| self.to_world(vec3::add(stepped.ankle, arm));
        let kept_arm = if state.planted { arm(state.pivot) } else { [0.0; 3] };
        let (vector, moved_elsewhere) = offset(&state, in_world(kept_arm), decay, most);
        let relock = FOOT_RELOCK * most;
        let behind = state.released && vec3::dot(vector, vector) > relock * relock;
        let released = stands && (behind || self.overstretches(leg, &stepped, vector, most));
        let planted = stands && !released;
        let slack = FOOT_PIVOT_SLACK * constraint.up.0[3];
        let kept = state.planted && stepped.ankle[1] + kept_arm[1] <= stepped.clearance + slack;
        let pivot = if kept { state.pivot } else { stepped.lowest };
        let pivot_arm = if kept { kept_arm } else { arm(pivot) };
        let place = vec3::add(in_world(pivot_arm), vector);
        let points = (0..constraint.sole_count + constraint.toe_count)
            .map(|point| vec3::add(in_world(arm(point)), vector));
        let (ground, normal, on_edge) = self.ground_under(place, points, FOOT_EDGE * most);
        state.known &= !moved_elsewhere;
        let [height, climb] = if planted {
            self.height_planted(&state, ground, on_edge)
        } else {
            self.ground_beneath(&state, place, ground, [most, near])
        };
        let direction = Turn::turn_of(lag).turned([own[0], 0.0, own[1]]);
        self.keep_foot_state(
            foot,
            &FootState {
                vector: if planted { [place[0], 0.0, place[2]] } else { vector },
                direction: if planted { [direction[0], direction[2]] } else { [lag, 0.0] },
                height,
                above: if planted { height - ground } else { 0.0 },
                climb,
                pivot,
                planted,
                released,
                known: true,
            },
        );
        let ankle =
            self.ankle_over(&stepped, [place[0], height, place[2]], pivot_arm, normal, near);
        let [x, y, z] = ankle;
        let [nx, ny, nz] = self.direction_to_model(normal);
        FootGoal { ankle: [x, y, z, turn.half_tan], follows: [nx, ny, nz, near] }
    }

    /// Returns the ankle's position in model space above the place of its pivot. A lifted foot is
    /// as far above the ground as the clip has it.
    #[inline(always)]
    fn ankle_over(
        &self,
        stepped: &Stepped,
        [x, height, z]: [f32; 3],
        arm: [f32; 3],
        normal: [f32; 3],
        near: f32,
    ) -> [f32; 3] {
        let clearance =
            if stepped.clearance > 0.0 { stepped.clearance * (1.0 - near) } else { 0.0 };
        let above = clearance + (stepped.ankle[1] + arm[1] - stepped.clearance);
        let y = height + above * self.control.place.0[3];
        let [nx, ny, nz] = self.direction_to_model(normal);
        let arm = if nx == 0.0 && nz == 0.0 {
            arm
        } else {
            let tilt = quat::normalize_or([nz, 0.0, -nx, 1.0 + ny], quat::identity());
            vec3::rotated(vec3::part_of(tilt, near), arm)
        };
        vec3::sub(self.to_model([x, y, z]), arm)
    }

    /// Returns whether an offset takes an ankle too far from its hip, horizontally.
    fn overstretches(&self, leg: &Leg, stepped: &Stepped, offset: [f32; 3], most: f32) -> bool {
        let [x, _, z] = vec3::sub(self.to_world(stepped.ankle), self.to_world(leg.hip));
        let own = x * x + z * z;
        let (x, z) = (x + offset[0], z + offset[2]);
        let with_offset = x * x + z * z;
        with_offset > own && with_offset > FOOT_REACH * FOOT_REACH * most * most
    }
}
