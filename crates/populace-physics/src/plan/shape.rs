//! Lengths, radii and masses of bodies.

use super::rest::Rest;
use super::select::SelectedBody;
use crate::math::Vector;

/// Mass in kg of a person of [`PERSON_M`]. Other masses are proportional to the cube of the size.
const PERSON_KG: f32 = 75.0;
const PERSON_M: f32 = 1.8;
/// Ratio of the height of a person to [`Rest::size`], the mean of height and width between joints.
const HEIGHT_FROM_SIZE: f32 = 1.2;

/// A capsule at rest in model space.
pub(super) struct Capsule {
    pub(super) from: Vector,
    pub(super) to: Vector,
    pub(super) radius: f32,
}

impl Capsule {
    fn volume(&self) -> f32 {
        let area = std::f32::consts::PI * self.radius * self.radius;
        area * (self.from.distance(self.to) + self.radius * (4.0 / 3.0))
    }
}

/// Returns which bodies form the trunk: the first one, those with several children, and those
/// between. A body with a mirrored sibling is part of a limb even if it has several children.
pub(super) fn trunk(rest: &Rest, bodies: &[SelectedBody]) -> Vec<bool> {
    let mut forks = vec![false; bodies.len()];
    let mut child_count = vec![0; bodies.len()];
    let mut descendant_count = vec![0; bodies.len()];
    for index in (0..bodies.len()).rev() {
        forks[index] |= child_count[index] >= 2;
        if let Some(parent) = bodies[index].parent {
            child_count[parent] += 1;
            descendant_count[parent] += descendant_count[index] + 1;
            forks[parent] |= forks[index];
        }
    }
    let extent = |index: usize| rest.extent[bodies[index].head];
    let is_twin = |a: usize, b: usize| {
        let same_extent = (extent(a) - extent(b)).abs() < 0.2 * extent(a).max(extent(b));
        a != b
            && bodies[a].parent == bodies[b].parent
            && descendant_count[a] == descendant_count[b]
            && same_extent
    };
    let mut is_trunk = vec![true; bodies.len()];
    for index in 1..bodies.len() {
        let parent_is = bodies[index].parent.is_some_and(|p| is_trunk[p]);
        is_trunk[index] =
            parent_is && forks[index] && !(1..bodies.len()).any(|other| is_twin(index, other));
    }
    is_trunk
}

pub(super) fn capsules(
    rest: &Rest,
    bodies: &[SelectedBody],
    body_of: &[Option<usize>],
    is_trunk: &[bool],
) -> Vec<Capsule> {
    let one = |(index, body): (usize, &SelectedBody)| {
        let from = rest.positions[body.head];
        let child_heads: Vec<Vector> = bodies
            .iter()
            .filter(|b| b.parent == Some(index))
            .map(|b| rest.positions[b.head])
            .collect();
        let reach = if rest.knows_reach { rest.reach[body.head] } else { 0.1 * rest.size };
        let radius = if is_trunk[index] {
            (0.6 * reach).clamp(0.045 * rest.size, 0.075 * rest.size)
        } else {
            let length = child_heads.first().map_or(0.0, |to| to.distance(from));
            let is_first = body.parent.is_some_and(|p| is_trunk[p]);
            let thickness = if is_first { 0.15 } else { 0.12 }; // limbs taper
            (thickness * length).clamp(0.018 * rest.size, 0.045 * rest.size)
        };
        if child_heads.is_empty() {
            return leaf(rest, index, bodies, body_of);
        }
        let to = child_heads.iter().sum::<Vector>() / child_heads.len() as f32;
        Capsule { from, to, radius }
    };
    bodies.iter().enumerate().map(one).collect()
}

/// Returns the capsule of the last body of a limb. It reaches to the body's farthest joint and
/// beyond; without further joints, it continues straight.
fn leaf(rest: &Rest, index: usize, bodies: &[SelectedBody], body_of: &[Option<usize>]) -> Capsule {
    let body = &bodies[index];
    let from = rest.positions[body.head];
    let own =
        (0..body_of.len()).filter(|&j| body_of[j] == Some(index) && rest.deforming_count[j] > 0);
    let far = own.max_by(|&a, &b| {
        rest.positions[a].distance(from).total_cmp(&rest.positions[b].distance(from))
    });
    let far = far.unwrap_or(body.head);
    let reach = if rest.knows_reach { rest.reach[far] } else { 0.1 * rest.size };
    let span = rest.positions[far] - from;
    let radius = (0.4 * reach).clamp(0.018 * rest.size, 0.05 * rest.size);
    let above = body.parent.map_or(Vector::Y * -1.0, |p| from - rest.positions[bodies[p].head]);
    let onward = if span.length() > 0.02 * rest.size { span } else { above };
    let to = from + span + onward.normalize_or(Vector::Y) * (reach - radius).max(0.0) * 0.7;
    Capsule { from, to, radius }
}

/// Returns the masses in kg, distributed by volume. Light bodies between heavy ones would make the
/// simulation jitter, so short bodies of the trunk have a minimum mass, and no body is lighter than
/// one of its children.
pub(super) fn masses(
    rest: &Rest,
    bodies: &[SelectedBody],
    capsules: &[Capsule],
    is_trunk: &[bool],
) -> Vec<f32> {
    let tall = HEIGHT_FROM_SIZE * rest.size / PERSON_M;
    let total = PERSON_KG * tall * tall * tall;
    let volume: f32 = capsules.iter().map(Capsule::volume).sum();
    let least = |is_trunk: bool| if is_trunk { 0.06 } else { 0.008 };
    let parts = capsules.iter().zip(is_trunk);
    let mut shares: Vec<f32> =
        parts.map(|(c, &trunk)| (c.volume() / volume).max(least(trunk))).collect();
    for index in (1..bodies.len()).rev() {
        if let Some(parent) = bodies[index].parent {
            shares[parent] = shares[parent].max(shares[index]);
        }
    }
    let sum: f32 = shares.iter().sum();
    shares.iter().map(|share| total * share / sum).collect()
}
