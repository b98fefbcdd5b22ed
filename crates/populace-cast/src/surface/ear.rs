//! Surface of the ears: a rim around a hollow.

use std::f64::consts::TAU;

use glam::DVec3;

use super::skull::Skull;
use super::{Region, Surface};
use crate::anatomy::Side;

/// Points around an ear.
const AROUND: usize = 8;

/// Size of a ring as a fraction of the rim's, distance from the head, and paint: from inside the
/// head over the back and the rim to the hollow.
const RINGS: [(f64, f64, f64); 4] =
    [(0.62, -0.035, 0.9), (1.0, 0.026, 1.0), (0.90, 0.044, 1.0), (0.56, 0.024, 0.72)];

pub(super) fn build(surface: &mut Surface, skull: Skull<'_>, side: Side) {
    let size = skull.body.look.face.ears;
    let at = skull.at_height(0.44, 93_f64.to_radians());
    // The plane of the ear: leans back, and stands off behind.
    let up = DVec3::new(0.06, 1.0, -0.16).normalize();
    let out = DVec3::new(0.95, 0.0, 0.31).normalize();
    let forward = up.cross(out).normalize();
    let forward = if forward.z < 0.0 { -forward } else { forward };
    let place = |surface: &mut Surface, p: DVec3, paint: f64| {
        surface.brush = [paint, 0.92 * paint, 0.90 * paint];
        let p = DVec3::new(p.x * side.sign(), p.y, p.z);
        let point = surface.point(skull.in_model(p), skull.weights(p));
        surface.brush = super::PLAIN;
        point
    };
    let rings: Vec<Vec<usize>> = RINGS
        .iter()
        .map(|&(scale, off, paint)| {
            let ring = (0..AROUND).map(|k| {
                let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
                // Broad above, narrow at the lobe.
                let broad = 0.066 + 0.022 * cos;
                let [u, v] = [-sin * broad * scale, cos * 0.118 * scale].map(|l| l * size);
                place(surface, at + forward * u + up * v + out * off * size, paint)
            });
            ring.collect()
        })
        .collect();
    surface.tube(&rings, Region::Skin);
    // The hollow lies deeper towards the face.
    let tip = surface.points.len() - 1;
    surface.paints[tip] = [0.55, 0.46, 0.45];
    let sunk = at + (forward * 0.012 + out * 0.012) * size;
    surface.points[tip] = skull.in_model(DVec3::new(sunk.x * side.sign(), sunk.y, sunk.z));
}
