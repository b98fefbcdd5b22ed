//! Two-bone inverse kinematics; the twin of `kernels/limb.cl`.

use populace_core::layout::Step;
use populace_core::math::{quat, vec3};

use super::{Models, Steering};

/// How far a limb's own bend has to stand out before it, and not the limb's preference, says where the middle joint goes:
/// a part of the first bone.
const OWN_BEND: f32 = 0.05;

/// A limb as the clips have it, in model space, and what is asked of it.
pub(super) struct Limb {
    /// First, middle and last joint.
    pub(super) places: [[f32; 3]; 3],
    /// Where the middle joint bends to when the limb is straight.
    pub(super) bend: [f32; 3],
    /// Where the middle joint is drawn to.
    pub(super) pole: Option<[f32; 3]>,
    /// Part of the length in which the limb straightens.
    pub(super) soft: f32,
}

/// How far away the end of a chain that is `length` long, and cannot come nearer than `least`, goes for a target at
/// `distance`: as far, but within the last `soft` of its length, and of what it can come nearer, ever more slowly.
pub(super) fn soft_distance(distance: f32, length: f32, least: f32, soft: f32) -> f32 {
    let (far, near) = (length - soft * length, least + soft * (length - least));
    if distance > far {
        let x = (distance - far) / (soft * length);
        far + soft * length * (x / (1.0 + x))
    } else if distance < near {
        let x = (near - distance) / (near - least);
        near - (near - least) * (x / (1.0 + x))
    } else {
        distance
    }
}

impl Limb {
    /// The turns of the first and of the middle joint, the second as of after the first, that bring the end to a target;
    /// `None` for a limb of no length.
    pub(super) fn solve(&self, target: [f32; 3]) -> Option<[[f32; 4]; 2]> {
        let [first, middle, end] = self.places;
        let (upper, lower) = (vec3::sub(middle, first), vec3::sub(end, middle));
        let (a, b) = (vec3::length(upper), vec3::length(lower));
        let to = vec3::sub(target, first);
        let distance = vec3::length(to);
        if a < 1e-6 || b < 1e-6 || distance < 1e-6 {
            return None;
        }
        let least = if a < b { b - a } else { a - b };
        let reach = soft_distance(distance, a + b, least, self.soft);
        let ahead = vec3::scale(to, 1.0 / distance);
        // The limb as a whole swings to where the target is.
        let along = vec3::unit_or(vec3::sub(end, first), vec3::scale(upper, 1.0 / a));
        let bend = vec3::unit_or(self.bend, vec3::any_across(along));
        let swing = vec3::between(along, ahead, bend);
        // Where the middle joint stands out then.
        let own = vec3::across(vec3::turned(swing, upper), ahead);
        let wish = vec3::unit_or(vec3::across(vec3::turned(swing, bend), ahead), vec3::any_across(ahead));
        let mut out = vec3::unit_or(vec3::add_scaled(own, wish, OWN_BEND * a), wish);
        let mut first_turn = swing;
        if let Some(pole) = self.pole {
            let drawn = vec3::unit_or(vec3::across(pole, ahead), out);
            first_turn = quat::mul(vec3::between(out, drawn, ahead), swing);
            out = drawn;
        }
        // The triangle of both bones and the reach.
        let x = (reach * reach + a * a - b * b) * (0.5 / reach);
        let y = vec3::root(a * a - x * x);
        let bent = vec3::add_scaled(vec3::scale(ahead, x), out, y);
        let upper_now = vec3::scale(vec3::turned(first_turn, upper), 1.0 / a);
        let first_turn = quat::mul(vec3::between(upper_now, vec3::scale(bent, 1.0 / a), out), first_turn);
        let lower_now = vec3::scale(vec3::turned(first_turn, lower), 1.0 / b);
        let lower_then = vec3::unit_or(vec3::sub(vec3::scale(ahead, reach), bent), lower_now);
        let second_turn = vec3::between(lower_now, lower_then, vec3::cross(ahead, out));
        Some([first_turn, second_turn])
    }
}

impl Steering<'_> {
    pub(super) fn reach(&mut self, models: &mut impl Models, joint: usize, step: &Step) {
        let constraint = self.constraint(step);
        let links = self.links(constraint);
        let own = models.model(joint);
        let (places, _) = Self::walk(models, links, 0, own);
        let (target, weight) = self.goal(constraint, places[0]);
        let [x, y, z, has_pole] = constraint.front.0;
        let limb = Limb {
            places: [places[0], places[constraint.middle as usize], places[links.len() - 1]],
            bend: own.transform_vector(constraint.axis.xyz()),
            pole: (has_pole > 0.0).then_some([x, y, z]),
            soft: constraint.limits.0[0],
        };
        let solved = if weight > 0.0 { limb.solve(target) } else { None };
        let turns = solved.unwrap_or([quat::identity(); 2]).map(|turn| vec3::part_of(turn, weight));
        let undone = quat::conjugate(quat::mul(turns[1], turns[0]));
        models.set(joint, own.turned(turns[0]));
        self.turns[step.turn as usize] = turns[1];
        self.turns[step.turn as usize + 1] =
            if constraint.keeps_end != 0 { undone } else { quat::identity() };
    }
}
