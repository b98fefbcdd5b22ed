//! Feet that keep to the ground, and the pelvis that sinks for them; the twin of `kernels/feet.cl`.
//!
//! What a clip lifts a foot above its rest height, the foot is lifted above the ground beneath it. While that is little the
//! foot is planted: it stays where it came down, in the world, however the member is moved. Lifted again, it makes up for
//! what it was held back.

use populace_core::layout::{Constraint, Float4, Step};
use populace_core::math::{quat, vec3};

use super::limb::Limb;
use super::{Models, Steering};

/// How fast a lifted foot makes up for what it was held back, in seconds for half of it at first.
const RELEASE_SECS: f32 = 0.06;
/// How far a pelvis sinks at most, in parts of a leg's length.
const SINKS_MOST: f32 = 0.5;

/// Where a foot goes.
struct Footing {
    /// Its ankle, in model space.
    place: [f32; 3],
    /// The ground's upward normal, in model space.
    normal: [f32; 3],
    /// How much the foot follows the ground's slope: 1 while planted, 0 when lifted.
    follows: f32,
}

/// What a foot left behind.
struct Kept {
    /// In the world: where it is planted, or how far it is behind where the clip has it.
    vector: [f32; 3],
    planted: bool,
}

impl Steering<'_> {
    fn to_world(&self, p: [f32; 3]) -> [f32; 3] {
        let ([x, y, z, scale], [sin, cos, ..]) = (self.control.place.0, self.control.facing.0);
        [(cos * p[0] + sin * p[2]) * scale + x, p[1] * scale + y, (cos * p[2] - sin * p[0]) * scale + z]
    }

    /// The ground's height and upward normal at a place in the world.
    fn ground_at(&self, x: f32, z: f32) -> (f32, [f32; 3]) {
        let ground = &self.tables.ground().as_slice()[0];
        let (mut height, mut slope) =
            (ground.offset + ground.slope_x * x + ground.slope_z * z, [ground.slope_x, ground.slope_z]);
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

    /// How far behind where the clip has it a foot is, in the world, and whether it stays where it was planted.
    fn behind(&self, kept: &Kept, clip: [f32; 3], held_most: f32) -> ([f32; 3], bool) {
        let mut behind = if kept.planted {
            vec3::sub(kept.vector, clip)
        } else {
            vec3::scale(kept.vector, 1.0 / (1.0 + self.elapsed_secs * (1.0 / RELEASE_SECS)))
        };
        behind[1] = 0.0;
        let far = vec3::length(behind);
        if far > 2.0 * held_most {
            ([0.0; 3], false) // the member was put elsewhere
        } else if far > held_most {
            (vec3::scale(behind, held_most / far), false)
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
        Footing { place, normal: [cos * x - sin * z, y, sin * x + cos * z], follows }
    }

    pub(super) fn pelvis(&mut self, models: &mut impl Models, joint: usize, step: &Step) {
        let own = models.model(joint);
        let first = self.constraint(step);
        let mut drop = 0.0;
        for foot in 0..first.target_count {
            let constraint = &self.tables.constraints().as_slice()[(step.index + foot) as usize];
            let links = self.links(constraint);
            let (places, _) = Self::walk(models, links, 0, own);
            let (upper, middle) = (constraint.upper as usize, constraint.middle as usize);
            let (hip, knee, ankle) = (places[upper], places[middle], places[links.len() - 1]);
            let footing = self.footing(foot, constraint, ankle);
            let length = vec3::length(vec3::sub(knee, hip)) + vec3::length(vec3::sub(ankle, knee));
            let reach = length * (1.0 - constraint.limits.0[0]);
            let [x, y, z] = vec3::sub(hip, footing.place);
            let needed = y - vec3::root(reach * reach - x * x - z * z);
            let needed = if needed > SINKS_MOST * length { SINKS_MOST * length } else { needed };
            drop = if needed > drop { needed } else { drop };
            let ([px, py, pz], [nx, ny, nz]) = (footing.place, footing.normal);
            let turn = (step.turn + 2 * foot) as usize;
            self.turns[turn] = [px, py, pz, 0.0];
            self.turns[turn + 1] = [nx, ny, nz, footing.follows];
        }
        let mut rows = own.rows;
        rows[1][3] -= drop * first.limits.0[1];
        models.set(joint, populace_core::Affine { rows });
    }

    pub(super) fn foot(&mut self, models: &mut impl Models, joint: usize, step: &Step) {
        let constraint = self.constraint(step);
        let links = self.links(constraint);
        let own = models.model(joint);
        let (upper, turn) = (constraint.upper as usize, step.turn as usize);
        let (places, _) = Self::walk(models, links, upper, own);
        let limb = Limb {
            places: [places[upper], places[constraint.middle as usize], places[links.len() - 1]],
            bend: own.transform_vector(constraint.axis.xyz()),
            pole: None,
            soft: constraint.limits.0[0],
        };
        let ([x, y, z, _], [nx, ny, nz, follows]) = (self.turns[turn], self.turns[turn + 1]);
        let weight = constraint.limits.0[1];
        let turns = limb.solve([x, y, z]).unwrap_or([quat::identity(); 2]).map(|t| vec3::part_of(t, weight));
        let undone = quat::conjugate(quat::mul(turns[1], turns[0]));
        let slope = vec3::between([0.0, 1.0, 0.0], [nx, ny, nz], [1.0, 0.0, 0.0]);
        models.set(joint, own.turned(turns[0]));
        self.turns[turn] = turns[1];
        self.turns[turn + 1] = quat::mul(vec3::part_of(slope, follows * weight), undone);
    }
}

/// The last sample at or before a place on a grid that has one after it, and how far it is to that; the first and the last
/// hold outside.
fn sample(at: f32, count: u32) -> (u32, f32) {
    let last = (count - 1) as f32;
    let at = if at > 0.0 { if at < last { at } else { last } } else { 0.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and a count")]
    let whole = (at as u32).min(count - 2);
    (whole, at - whole as f32)
}
