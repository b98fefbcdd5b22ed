//! Feet that keep to the ground, and the pelvis that sinks for them; the twin of `kernels/feet.cl`.
//!
//! What a clip lifts a foot above its rest height, the foot is lifted above the ground beneath it.
//! While that is little the foot is planted: it stays where it came down, in the world, however the
//! member is moved. Lifted again, it makes up for what it was held back.

use populace_device::layout::{Constraint, FEET_MOST, Float4, Link, Step};
use populace_model::Affine;
use populace_model::math::{Real, quat, vec3};

use super::limb::Limb;
use super::{Models, Steering};
use crate::lanes::Several;

/// How fast a lifted foot makes up for what it was held back, in seconds for half of it at first.
const RELEASE_SECS: f32 = 0.06;
/// How far a pelvis sinks at most, in parts of a leg's length.
const SINKS_MOST: f32 = 0.5;

/// Where a foot goes.
struct Footing {
    /// Its ankle, in model space.
    place: [f32; 3],
    /// The ground's upward normal, in model space, and how much the foot follows its slope: 1 while
    /// planted, 0 when lifted.
    follows: [f32; 4],
}

/// What a foot left behind.
struct Kept {
    /// In the world: where it is planted, or how far it is behind where the clip has it.
    vector: [f32; 3],
    planted: bool,
}

/// A leg as the clips have it, in model space.
#[derive(Default)]
struct Leg {
    hip: [f32; 3],
    knee: [f32; 3],
    ankle: [f32; 3],
    /// Where the knee bends to.
    bend: [f32; 3],
}

/// A leg and where it goes: what a [`Limb`] is made of, and what its foot follows.
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
    fn new(leg: &Leg, goes_to: [f32; 3], follows: [f32; 4]) -> Self {
        let (upper, lower) = (vec3::sub(leg.knee, leg.hip), vec3::sub(leg.ankle, leg.knee));
        Self { upper, lower, bend: leg.bend, to: vec3::sub(goes_to, leg.hip), follows }
    }
}

/// A member's legs side by side.
const FEET: usize = FEET_MOST as usize;
type Feet = Several<FEET>;

struct Legs {
    limb: Limb<Feet>,
    /// As [`Footing::follows`].
    follows: [Feet; 4],
}

impl Legs {
    #[inline(always)]
    fn new(strides: &[Stride; FEET]) -> Self {
        let each = |of: fn(&Stride) -> &[f32; 3]| -> [Feet; 3] {
            [0, 1, 2].map(|c: usize| Several::from_fn(|lane| of(&strides[lane])[c]))
        };
        let limb = Limb {
            upper: each(|s| &s.upper),
            lower: each(|s| &s.lower),
            bend: each(|s| &s.bend),
            to: each(|s| &s.to),
        };
        let follows =
            [0, 1, 2, 3].map(|c: usize| Several::from_fn(|lane| strides[lane].follows[c]));
        Self { limb, follows }
    }

    /// How far the pelvis has to sink so that each leg gets where it goes.
    #[inline(always)]
    fn sinks(&self, soft: f32) -> Feet {
        let length = vec3::length(self.limb.upper) + vec3::length(self.limb.lower);
        let (reach, most) = (length * Feet::splat(1.0 - soft), length * Feet::splat(SINKS_MOST));
        let [x, y, z] = self.limb.to;
        let needed = -y - vec3::root(reach * reach - x * x - z * z);
        Feet::choose(most.less(needed), most, needed)
    }
}

impl Steering<'_> {
    fn to_world(&self, p: [f32; 3]) -> [f32; 3] {
        let ([x, y, z, scale], [sin, cos, ..]) = (self.control.place.0, self.control.facing.0);
        [
            (cos * p[0] + sin * p[2]) * scale + x,
            p[1] * scale + y,
            (cos * p[2] - sin * p[0]) * scale + z,
        ]
    }

    /// The ground's height and upward normal at a place in the world.
    fn ground_at(&self, x: f32, z: f32) -> (f32, [f32; 3]) {
        let ground = &self.tables.ground().as_slice()[0];
        let (mut height, mut slope) = (
            ground.offset + ground.slope_x * x + ground.slope_z * z,
            [ground.slope_x, ground.slope_z],
        );
        if ground.per_metre > 0.0 {
            let (column, across) = sample((x - ground.grid_x) * ground.per_metre, ground.count_x);
            let (row, along) = sample((z - ground.grid_z) * ground.per_metre, ground.count_z);
            let heights = self.tables.heights().as_slice();
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

    fn kept(&self, foot: u32) -> Kept {
        let [x, y, z, bits] = self.state(foot).0;
        let bits = bits.to_bits();
        let ours = bits >> 1 == self.control.epoch;
        Kept { vector: if ours { [x, y, z] } else { [0.0; 3] }, planted: ours && bits & 1 != 0 }
    }

    fn keep(&mut self, foot: u32, kept: &Kept) {
        let [x, y, z] = kept.vector;
        let bits = self.control.epoch << 1 | u32::from(kept.planted);
        self.keep_state(foot, Float4([x, y, z, f32::from_bits(bits)]));
    }

    /// How far behind where the clip has it a foot is, in the world, and whether it stays where it
    /// was planted.
    fn behind(&self, kept: &Kept, clip: [f32; 3], held_most: f32) -> ([f32; 3], bool) {
        let mut behind = if kept.planted {
            vec3::sub(kept.vector, clip)
        } else {
            vec3::scale(kept.vector, 1.0 / (1.0 + self.elapsed_secs * (1.0 / RELEASE_SECS)))
        };
        behind[1] = 0.0;
        let (far, held) = (vec3::dot(behind, behind), held_most * held_most);
        if far > 4.0 * held {
            ([0.0; 3], false) // the member was put elsewhere
        } else if far > held {
            (vec3::scale(behind, held_most * far.inverse_sqrt()), false)
        } else {
            (behind, kept.planted)
        }
    }

    fn footing(&mut self, foot: u32, constraint: &Constraint, ankle: [f32; 3]) -> Footing {
        let [rest, planted_below, lifted_above, held_most] = constraint.up.0;
        let size = self.control.place.0[3];
        let clip = self.to_world(ankle);
        let kept = self.kept(foot);
        let (behind, stays) = self.behind(&kept, clip, held_most * size);
        let lift = ankle[1] - rest;
        let planted = lift <= planted_below;
        let place = if planted && stays { kept.vector } else { vec3::add(clip, behind) };
        self.keep(foot, &Kept { vector: if planted { place } else { behind }, planted });
        let (height, normal) = self.ground_at(place[0], place[2]);
        let between = (lift - planted_below) / (lifted_above - planted_below);
        let (lift, follows) = if planted {
            (0.0, 1.0)
        } else if lift < lifted_above {
            (between * lifted_above, 1.0 - between)
        } else {
            (lift, 0.0)
        };
        let place = self.to_model([place[0], height + (rest / normal[1] + lift) * size, place[2]]);
        let [sin, cos, ..] = self.control.facing.0;
        let [x, y, z] = normal;
        Footing { place, follows: [cos * x - sin * z, y, sin * x + cos * z, follows] }
    }

    /// Down a leg's chain from link `start`, whose joint's model transform is `from`.
    #[inline(never)]
    fn walk_leg(
        models: &impl Models,
        links: &[Link],
        foot: &Constraint,
        start: usize,
        from: Affine,
    ) -> Leg {
        let (mut leg, mut model) = (Leg::default(), from);
        for (at, link) in links.iter().enumerate().skip(start) {
            if at > start {
                model = model.mul(&models.local(link.joint as usize));
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

    /// Solves legs, and writes the turns of hips, knees and ankles, three for each leg, of the
    /// first `count`.
    #[inline(never)]
    fn step_with(&mut self, legs: &Legs, constraint: &Constraint, turn: u32, count: usize) {
        let [soft, weight, ..] = constraint.limits.0;
        let [mut hip, mut knee] = legs.limb.turns(None, soft);
        if weight < 1.0 {
            [hip, knee] = [hip, knee].map(|turn| vec3::part_of(turn, Feet::splat(weight)));
        }
        // The ankle keeps the rotation that the clips give it, and follows the slope: the turn from
        // upwards to the normal.
        let [nx, ny, nz, follows] = legs.follows;
        let tilt = [nz, Feet::splat(0.0), -nx, Feet::splat(1.0) + ny];
        let slope = quat::normalize_or(tilt, quat::identity());
        let slope = vec3::part_as_told(slope, follows * Feet::splat(weight));
        let ankle = quat::mul(slope, quat::conjugate(quat::mul(knee, hip)));
        let turns = self.turns[turn as usize..].as_chunks_mut::<3>().0;
        for (lane, of_leg) in turns.iter_mut().take(count).enumerate() {
            *of_leg = [hip, knee, ankle].map(|turn| turn.map(|component| component.0[lane]));
        }
    }

    #[inline(never)]
    pub(super) fn pelvis(&mut self, models: &mut impl Models, joint: usize, step: &Step) {
        let own = models.model(joint);
        let first = self.constraint(step);
        let count = first.target_count as usize;
        let mut strides = [Stride::default(); FEET];
        for (foot, stride) in (0..first.target_count).zip(&mut strides) {
            let constraint = &self.tables.constraints().as_slice()[(step.index + foot) as usize];
            let leg = Self::walk_leg(models, self.links(constraint), constraint, 0, own);
            let footing = self.footing(foot, constraint, leg.ankle);
            *stride = Stride::new(&leg, footing.place, footing.follows);
            let ([x, y, z], turn) = (footing.place, (step.turn + 3 * foot) as usize);
            self.turns[turn] = [x, y, z, 0.0];
            self.turns[turn + 1] = footing.follows;
        }
        let mut legs = Legs::new(&strides);
        let mut drop = 0.0;
        for needed in &legs.sinks(first.limits.0[0]).0[..count] {
            drop = if *needed > drop { *needed } else { drop };
        }
        drop *= first.limits.0[1];
        let mut rows = own.rows;
        rows[1][3] -= drop;
        models.set(joint, Affine { rows });
        if first.at_once != 0 {
            legs.limb.to[1] = legs.limb.to[1] + Feet::splat(drop);
            self.step_with(&legs, first, step.turn, count);
        }
    }

    /// A leg that something else moves after the pelvis: it goes where the pelvis found.
    #[inline(never)]
    pub(super) fn foot(&mut self, models: &mut impl Models, joint: usize, step: &Step) {
        let constraint = self.constraint(step);
        let own = models.model(joint);
        let links = self.links(constraint);
        let leg = Self::walk_leg(models, links, constraint, constraint.upper as usize, own);
        let turn = step.turn as usize;
        let [x, y, z, _] = self.turns[turn];
        let mut strides = [Stride::default(); FEET];
        strides[0] = Stride::new(&leg, [x, y, z], self.turns[turn + 1]);
        self.step_with(&Legs::new(&strides), constraint, step.turn, 1);
        models.set(joint, own.turned(self.turns[turn]));
    }
}

/// The last sample at or before a place on a grid that has one after it, and how far it is to that;
/// the first and the last hold outside.
fn sample(at: f32, count: u32) -> (u32, f32) {
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
