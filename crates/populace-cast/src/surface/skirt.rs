//! Surface of skirts: a shell from the waist to the knees that swings with the thighs.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Region, Surface, Weights, mixed_in, smooth, trunk};
use crate::Bottom;
use crate::anatomy::{Body, Limb, PELVIS, Side};

/// Points around a skirt: point 0 is in front, and the left follows.
const AROUND: usize = 16;
/// Rows of the trunk that the skirt follows, with its distance as a fraction of the height. The first
/// lies inside the body, so that the skirt comes out below the blouse.
const UPPER: [(usize, f64); 3] = [(3, -0.006), (2, 0.006), (0, 0.012)];
/// Upper end of the inner side: its height between hips (0) and hem (1), and its breadth as a fraction
/// of the outer side's. It is far from the outer side, so that coarse levels keep both apart.
const INSIDE: [f64; 2] = [0.55, 0.35];
/// Breadth and depth of the body under a skirt, as fractions of its own. Coarse levels of detail must
/// not show it.
const DRAWN_IN: f64 = 0.8;
/// Rows below the hips: position between hips (0) and hem (1).
const LOWER: [f64; 3] = [0.34, 0.68, 1.0];
/// Half breadth of the hem, and its depth behind and in front, as fractions of the height. In front
/// it is near the knees, so that it lies on the thighs of who sits.
const HEM: [f64; 3] = [0.117, 0.094, 0.084];

/// Adds the skirt of a person who wears one.
pub(super) fn build(surface: &mut Surface, body: &Body) {
    let region = match body.look.bottom {
        Bottom::Skirt => Region::Trousers,
        Bottom::Dress => Region::Top,
        Bottom::Trousers | Bottom::Shorts => return,
    };
    draw_in(surface, body);
    let mut rings: Vec<Vec<usize>> = UPPER
        .iter()
        .map(|&(row, off)| {
            let ring = (0..AROUND).map(|j| {
                let p = on_trunk(body, row, j);
                let out = DVec3::new(p.x, 0.0, p.z).normalize();
                surface.point(p + out * off * body.height, weights(body, p))
            });
            ring.collect()
        })
        .collect();
    rings.extend(LOWER.iter().map(|&t| lower(surface, body, t, 1.0, 0.0)));
    // The inner side, which is seen from below.
    surface.brush = [0.45; 3];
    rings.push(lower(surface, body, 1.0, 0.955, 0.004));
    rings.push(lower(surface, body, INSIDE[0], INSIDE[1], 0.0));
    surface.brush = super::PLAIN;
    surface.tube(&rings, region);
}

/// Narrows hips and thighs of a dressed body towards its middle, from below the blouse to above the
/// knees.
fn draw_in(surface: &mut Surface, body: &Body) {
    let (knee, hem) = (body.joint(Limb::Shin, Side::Left).y, trunk::position(body, 3, 0).y);
    let hidden = [PELVIS, Limb::Thigh.of(Side::Left), Limb::Thigh.of(Side::Right)];
    for (point, weights) in surface.points.iter_mut().zip(&surface.weights) {
        let of_hidden: f64 =
            weights.iter().filter(|(s, _)| hidden.contains(s)).map(|(_, weight)| weight).sum();
        let between = point.y > knee + 0.05 * body.height && point.y < hem - 0.02 * body.height;
        if of_hidden > 0.5 && between {
            point.x *= DRAWN_IN;
            point.z *= DRAWN_IN;
        }
    }
}

/// Returns the point of a row of the trunk at point `j` of a skirt's ring.
fn on_trunk(body: &Body, row: usize, j: usize) -> DVec3 {
    // Three points of the trunk are two of a skirt.
    let (low, odd) = (j / 2 * 3, j % 2 == 1);
    let at = |j: usize| trunk::position(body, row, j % trunk::AROUND);
    if odd { at(low + 1).lerp(at(low + 2), 0.5) } else { at(low) }
}

/// Adds a ring below the hips, at `t` between hips and hem.
fn lower(surface: &mut Surface, body: &Body, t: f64, scale: f64, up: f64) -> Vec<usize> {
    let h = body.height;
    let top_y = trunk::position(body, 0, 0).y;
    let hem_y = body.joint(Limb::Shin, Side::Left).y - 0.012 * h;
    let girth = 0.5 + 0.25 * (body.look.hips + body.look.limbs);
    let ring = (0..AROUND).map(|j| {
        let hip = on_trunk(body, 0, j);
        let angle = TAU * j as f64 / AROUND as f64;
        // Pleats deepen towards the hem.
        let pleat = 1.0 + 0.014 * t * if j % 2 == 0 { 1.0 } else { -1.0 };
        let depth = if angle.cos() < 0.0 { HEM[1] } else { HEM[2] };
        let [x, z] = [HEM[0] * angle.sin(), depth * angle.cos()].map(|v| v * girth * pleat * h);
        let hip_out = DVec3::new(hip.x, 0.0, hip.z).normalize() * 0.012 * h;
        let (hip_x, hip_z) = (hip.x + hip_out.x, hip.z + hip_out.z);
        let p = DVec3::new(
            (hip_x + (x - hip_x) * t) * scale,
            top_y + (hem_y - top_y) * t + up * h,
            (hip_z + (z - hip_z) * t) * scale,
        );
        surface.point(p, weights(body, p))
    });
    ring.collect()
}

/// Returns the weights at a point: the front and the back hang between both thighs.
fn weights(body: &Body, p: DVec3) -> Weights {
    let h = body.height;
    let knee = body.joint(Limb::Shin, Side::Left).y;
    let down = smooth(body.hip_y + 0.06 * h, 0.45 * body.hip_y + 0.55 * knee, p.y);
    let legs = 0.20 + 0.78 * down;
    let legs = legs * smooth(body.trunk_y(0.15), body.hip_y - 0.02 * h, p.y);
    let left = smooth(-0.065 * h, 0.065 * h, p.x);
    let weights = vec![(PELVIS, 1.0 - legs)];
    let thigh = |side| Limb::Thigh.of(side);
    mixed_in(weights, &[(thigh(Side::Left), left), (thigh(Side::Right), 1.0 - left)], legs)
}
