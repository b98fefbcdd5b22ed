//! Surface of the arms: rings from the shoulder to the wrist.

use std::f64::consts::PI;

use glam::DVec3;

use super::covers::Covers;
use super::wrist::{self, AROUND, on_arm};
use super::{Region, Surface, Weights, chain, hand, mixed};
use crate::Reach;
use crate::anatomy::{Body, ELBOW, Limb, Side, WRIST};

/// Distance from the shoulder, half breadth from front to back, and half depth of each ring, as
/// fractions of the body's height.
const RINGS: [[f64; 3]; 10] = [
    [0.052, 0.0300, 0.0295],
    [0.078, 0.0283, 0.0278],
    [0.105, 0.0260, 0.0255],
    [0.159, 0.0232, 0.0230],
    [0.172, 0.0228, 0.0225],
    [0.185, 0.0232, 0.0228],
    [0.208, 0.0238, 0.0228],
    [0.250, 0.0208, 0.0195],
    [0.300, 0.0166, 0.0138],
    [0.316, 0.0166, 0.0124],
];

/// Returns the ring at which the sleeves end.
const fn hem(sleeves: Reach) -> usize {
    match sleeves {
        Reach::Short => 2,
        Reach::Long => 8,
    }
}

pub(super) fn build(
    surface: &mut Surface,
    body: &Body,
    covers: &Covers,
    side: Side,
    opening: &[usize],
) {
    let mirrored = side == Side::Left;
    let first = ring(surface, body, side, 0);
    let mut inner = opening.to_vec();
    for t in SHOULDER {
        let shoulder = shoulder_ring(surface, body, side, [opening, &first], t);
        surface.bridge(&inner, &shoulder, covers.sleeve, mirrored);
        inner = shoulder;
    }
    surface.bridge(&inner, &first, covers.sleeve, mirrored);
    let mut last = first;
    for row in 1..RINGS.len() {
        let next = ring(surface, body, side, row);
        let cover = if row <= hem(body.look.sleeves) { covers.sleeve } else { Region::Skin.into() };
        surface.bridge(&last, &next, cover, mirrored);
        last = next;
    }
    hand::build(surface, body, side, &last);
}

/// Returns the angle of point `k` of a ring in radians: 0 on the outside, a quarter turn behind.
fn angle(k: usize) -> f64 {
    PI / 6.0 * k as f64 - PI / 3.0
}

fn ring(surface: &mut Surface, body: &Body, side: Side, row: usize) -> Vec<usize> {
    let [at, breadth, depth] = RINGS[row];
    let ease = cloth(body.look.sleeves, row);
    let girth = body.look.limbs + (1.0 - body.look.limbs) * (at / WRIST).powi(2);
    (0..AROUND)
        .map(|k| {
            let (sin, cos) = angle(k).sin_cos();
            let position =
                on_arm(body, at, (breadth * girth + ease) * sin, (depth * girth + ease) * cos);
            surface.point(side.mirror_point(position), weights(side, at))
        })
        .collect()
}

/// Returns the distance of cloth from the skin at ring `row`, as a fraction of the body's height.
fn cloth(sleeves: Reach, row: usize) -> f64 {
    let last = hem(sleeves);
    if row > last || row == 0 {
        return 0.0;
    }
    match sleeves {
        Reach::Short => 0.0015 * row as f64,
        Reach::Long => 0.0024,
    }
}

/// Returns the weights of a ring at the distance `at` from the shoulder.
fn weights(side: Side, at: f64) -> Weights {
    let segments =
        [Limb::Clavicle, Limb::UpperArm, Limb::Forearm, Limb::Hand].map(|limb| limb.of(side));
    chain(at, &segments, &[(0.0, 0.075), (ELBOW, 0.032), (WRIST, wrist::BLEND)])
}

/// Positions of the shoulder's rings between the trunk's opening (0) and the arm's first ring (1).
const SHOULDER: [f64; 2] = [0.33, 0.70];

/// Adds the ring at `t` between the trunk's opening and the arm's first ring, with the bulge of the
/// deltoid.
fn shoulder_ring(
    surface: &mut Surface,
    body: &Body,
    side: Side,
    [opening, first]: [&[usize]; 2],
    t: f64,
) -> Vec<usize> {
    let up = side.mirror_point(DVec3::new(0.55, 0.83, 0.0));
    (0..AROUND)
        .map(|k| {
            let outside = angle(k).cos();
            let bulge = 4.0
                * t
                * (1.0 - t)
                * (0.0095 * outside.max(0.0) + 0.004 * angle(k).sin().powi(2))
                * body.height
                * body.look.limbs;
            let round = side.mirror_point(body.outward * outside - DVec3::Z * angle(k).sin());
            let dir = if outside > 0.0 { up.lerp(round, 0.4).normalize() } else { round };
            let position =
                surface.points[opening[k]].lerp(surface.points[first[k]], t) + dir * bulge;
            let inner = surface.weights[opening[k]].clone();
            let outer = surface.weights[first[k]].clone();
            surface.point(position, mixed(inner, &outer, t))
        })
        .collect()
}
