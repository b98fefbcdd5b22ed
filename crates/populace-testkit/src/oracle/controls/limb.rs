//! Two-bone inverse kinematics by the law of cosines, with soft reach and a pole.

use glam::{DQuat, DVec3};
use populace_device::Limb;
use populace_device::layout::LIMB_OWN_BEND;

use super::{Descent, short_part_of};
use crate::oracle::noise::Noise;

/// Returns how far a chain reaches for a goal at a distance. It reaches from `least` to `length`.
/// Beyond the last part `soft` of the length, and before the first, it comes near the limit ever
/// more slowly: `s x / (s + x)` of the excess `x` over the slack `s`.
pub(super) fn soft_reach(distance: f64, length: f64, least: f64, soft: f64) -> f64 {
    let eased =
        |over: f64, slack: f64| if over > 0.0 { slack * over / (slack + over) } else { 0.0 };
    let (far, near) = (length * (1.0 - soft), least + (length - least) * soft);
    if distance > far {
        far + eased(distance - far, length - far)
    } else {
        distance.max(near) - eased(near - distance, near - least)
    }
}

/// Returns the shortest rotation between two vectors; half a turn about `about` if they are
/// opposite.
///
/// Its quaternion has the direction of `(from x to, 1 + from . to)`, of length `2 cos(angle / 2)`.
/// So rounding errors grow as vectors come near to opposite.
pub(super) fn shortest(from: DVec3, to: DVec3, about: DVec3, noise: &mut Noise) -> DQuat {
    let (from, to) = (from.normalize_or_zero(), to.normalize_or_zero());
    let (axis, cosine) = (from.cross(to), from.dot(to));
    if cosine < 0.0 && axis.length() < 1e-9 {
        return DQuat::from_axis_angle(about, std::f64::consts::PI);
    }
    let [x, y, z] = noise.sized(axis, 1.0).to_array();
    DQuat::from_xyzw(x, y, z, noise.near(1.0 + cosine, 1.0)).normalize()
}

/// Returns the part of a vector at right angles to a unit vector.
fn across(v: DVec3, axis: DVec3) -> DVec3 {
    v - axis * v.dot(axis)
}

/// Returns the axis about which a limb bends: at right angles to the plane of its bones, where the
/// preferred direction counts the more the straighter the limb is.
fn hinge(upper: DVec3, lower: DVec3, bend: DVec3, noise: &mut Noise) -> DVec3 {
    let size = upper.length();
    let out = upper / size + bend.normalize_or_zero() * f64::from(LIMB_OWN_BEND);
    let chain = (upper + lower) / size;
    noise.sized(out.cross(chain), out.length() * chain.length())
}

/// Returns the angle about `axis` that brings two bones to a distance from end to end, on the side
/// to which the axis bends them.
///
/// With the parts of both bones along the axis fixed, `upper . rotated(lower)` is
/// `still + most * cos(angle - straight)`, where `straight` is the angle that straightens them. All
/// are differences of squares of lengths, and round as those do.
fn bend_angle(upper: DVec3, lower: DVec3, axis: DVec3, reach: f64, noise: &mut Noise) -> f64 {
    let both = upper.length() * lower.length();
    let still = noise.near(upper.dot(axis) * lower.dot(axis), both);
    let (level_upper, level_lower) = (across(upper, axis), across(lower, axis));
    let sine = noise.near(level_lower.cross(level_upper).dot(axis), both);
    let cosine = noise.near(level_lower.dot(level_upper), both);
    let squares = upper.length_squared() + lower.length_squared();
    let wanted = 0.5 * noise.near(reach * reach - squares, reach * reach + squares);
    let bent = noise.near((wanted - still) / cosine.hypot(sine), 1.0);
    sine.atan2(cosine) + bent.clamp(-1.0, 1.0).acos()
}

/// Returns the rotations in model space of the first and the middle joint of a limb, the second
/// after the first, which bring its end to `to`, relative to the first joint. `bend` is the
/// direction to which it bends if it is straight. `None` for a limb or a way without length.
pub(super) fn two_bones(
    [upper, lower]: [DVec3; 2],
    to: DVec3,
    bend: DVec3,
    (soft, pole): (f64, Option<DVec3>),
    noise: &mut Noise,
) -> Option<[DQuat; 2]> {
    let (a, b) = (upper.length(), lower.length());
    if a.min(b).min(to.length()) < 1e-6 {
        return None;
    }
    let reach = soft_reach(to.length(), a + b, (a - b).abs(), soft);
    let axis = hinge(upper, lower, bend, noise).normalize();
    let reach = noise.number(reach);
    let angle = bend_angle(upper, lower, axis, reach, noise);
    let bent = noise.rotation(DQuat::from_axis_angle(axis, angle)) * lower;
    // The length of the bent limb is a root of a difference of squares, so its error grows as the
    // limb folds, and with it that of the swing.
    let folded = (a * a + b * b) / (reach * reach);
    let bent_limb = noise.sized(upper + bent, a + b);
    let swing = shortest(bent_limb, to, axis, noise);
    let opposite = (0.5 * (1.0 + bent_limb.normalize().dot(to.normalize()))).sqrt();
    let mut swing = noise.rotation_by(swing, folded.max(1.0) / opposite.max(1e-6));
    if let Some(pole) = pole {
        let ahead = to.normalize();
        let knee = across(noise.vector(swing * upper), ahead).normalize();
        let drawn = across(noise.vector(pole), ahead).normalize_or(knee);
        let drawn = shortest(knee, drawn, ahead, noise);
        swing = noise.rotation(drawn * swing);
    }
    // The middle joint bends about the axis as the first joint has turned it.
    let second = DQuat::from_axis_angle((swing * axis).normalize(), angle);
    Some([swing, second].map(|whole| noise.rotation(whole)))
}

impl Descent<'_, '_> {
    /// Returns the rotations of a limb's first and middle joint in model space, each after that of
    /// the joint above, and that of the end if it keeps its own.
    pub(super) fn limb(&mut self, limb: &Limb) -> Vec<(usize, DQuat)> {
        let of = self.of;
        let now = self.walk(of.path(limb.first, limb.end));
        let [first, middle, end] = [limb.first, limb.middle, limb.end].map(|j| of.source(j));
        let at = |joint: usize| {
            let place = now.joints.iter().position(|of_chain| *of_chain == joint);
            now.positions[place.expect("the joint is in the chain")]
        };
        let Some(goal) = self.goal(&limb.targets, at(first)) else { return Vec::new() };
        let upper = self.noise.vector(at(middle) - at(first));
        let lower = self.noise.vector(at(end) - at(middle));
        let to = self.noise.vector(goal.position - at(first));
        let bend = self.model(first).matrix3 * of.in_joint(Some(first), limb.bend);
        let pole = limb.pole.map(|pole| DVec3::from_array(pole.map(f64::from)));
        let (soft, noise) = (f64::from(limb.soft), &mut *self.noise);
        let Some(whole) = two_bones([upper, lower], to, bend, (soft, pole), noise) else {
            return Vec::new();
        };
        let [swing, second] = whole
            .map(|whole| if goal.weight < 1.0 { short_part_of(whole, goal.weight) } else { whole });
        let mut rotations = vec![(first, swing), (middle, second)];
        if limb.keeps_end {
            rotations.push((end, (second * swing).inverse()));
        }
        rotations
    }
}
