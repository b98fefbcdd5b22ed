//! Surface of the trunk: rings from the crotch to the neck, with openings for arms and legs.

use std::f64::consts::PI;

use glam::DVec3;

use super::covers::Covers;
use super::{Surface, Weights, chain, mixed, smooth};
use crate::anatomy::{Body, Limb, NECK, PELVIS, SPINE, SPINE_AT, Side};

/// Points around the trunk: point 0 is in front, 6 on the left, 12 behind, 18 on the
/// right.
pub(super) const AROUND: usize = 24;
/// Lowest, middle and highest row of the arms' openings.
const ARM_ROWS: [usize; 3] = [8, 9, 10];
/// First point of the arms' openings in a half ring.
const ARM_FROM: usize = 4;
/// Last point of the arms' openings in a half ring.
const ARM_TO: usize = 8;
/// Row of the base of the neck.
pub(super) const COLLAR: usize = 12;

/// Border rings of the trunk's openings.
pub(super) struct Ends {
    /// Twelve points: five above from front to back, one behind, five below, one in front.
    pub(super) arms: [Vec<usize>; 2],
    /// Sixteen points: thirteen on the outside from front to back, three on the inside.
    pub(super) legs: [Vec<usize>; 2],
}

/// Height between the hip joints (0) and the base of the neck (1); half breadth, depth in front and
/// behind, and half of the front's drop below the back, as fractions of the body's height.
pub(super) const ROWS: [[f64; 5]; 13] = [
    [-0.150, 0.094, 0.054, 0.064, 0.0],
    [-0.060, 0.098, 0.059, 0.073, 0.0],
    [-0.010, 0.101, 0.064, 0.076, 0.0],
    [0.120, 0.094, 0.063, 0.064, 0.0],
    [0.260, 0.085, 0.061, 0.055, 0.0],
    [0.400, 0.086, 0.062, 0.058, 0.0],
    [0.530, 0.091, 0.065, 0.064, 0.0],
    [0.630, 0.096, 0.068, 0.069, 0.0],
    [0.700, 0.098, 0.067, 0.071, 0.0],
    [0.800, 0.103, 0.058, 0.068, 0.0],
    [0.890, 0.096, 0.045, 0.058, 0.004],
    [0.950, 0.062, 0.039, 0.044, 0.012],
    [1.000, 0.0345, 0.036, 0.033, 0.020],
];

pub(super) fn build(surface: &mut Surface, body: &Body, covers: &Covers) -> Ends {
    let rings: Vec<Vec<usize>> = (0..ROWS.len())
        .map(|row| {
            (0..AROUND).map(|j| surface.point(position(body, row, j), weights(row, j))).collect()
        })
        .collect();
    for (row, pair) in rings.windows(2).enumerate() {
        for j in 0..AROUND {
            let side = if j < AROUND / 2 { j } else { AROUND - 1 - j };
            let open =
                (ARM_ROWS[0]..ARM_ROWS[2]).contains(&row) && (ARM_FROM..ARM_TO).contains(&side);
            if !open {
                let next = (j + 1) % AROUND;
                let corners = [pair[0][j], pair[0][next], pair[1][next], pair[1][j]];
                surface.quad(corners, covers.trunk(row, side), j >= AROUND / 2);
            }
        }
    }
    let arms = Side::BOTH.map(|side| arm_ring(&rings, side));
    let legs = leg_rings(surface, body, &rings[0]);
    close_neck(surface, body, covers, &rings[COLLAR]);
    Ends { arms, legs }
}

/// Folds the neckline inwards and closes it inside the neck.
fn close_neck(surface: &mut Surface, body: &Body, covers: &Covers, ring: &[usize]) {
    let inner: Vec<usize> = (0..AROUND)
        .map(|j| {
            let p = position(body, COLLAR, j);
            let inside = DVec3::new(0.72 * p.x, p.y - 0.016 * body.height, 0.62 * p.z);
            surface.point(inside, weights(COLLAR, j))
        })
        .collect();
    let cover = covers.trunk(COLLAR - 1, 0);
    surface.bridge(ring, &inner, cover, false);
    surface.close(&inner, cover, false);
}

/// Returns the border of an arm's opening.
fn arm_ring(rings: &[Vec<usize>], side: Side) -> Vec<usize> {
    let column = |j: usize| if side == Side::Left { j } else { AROUND - j };
    let [low, middle, high] = ARM_ROWS;
    let mut ring: Vec<usize> = (ARM_FROM..=ARM_TO).map(|j| rings[high][column(j)]).collect();
    ring.push(rings[middle][column(ARM_TO)]);
    ring.extend((ARM_FROM..=ARM_TO).rev().map(|j| rings[low][column(j)]));
    ring.push(rings[middle][column(ARM_FROM)]);
    ring
}

/// Splits the lowest ring into the two rings of the legs, by a strip of three points between them.
fn leg_rings(surface: &mut Surface, body: &Body, ring: &[usize]) -> [Vec<usize>; 2] {
    let half = AROUND / 2;
    let (front, back) = (surface.points[ring[0]], surface.points[ring[half]]);
    let strip: Vec<usize> = [0.25, 0.5, 0.75]
        .into_iter()
        .map(|t: f64| {
            let drop = DVec3::NEG_Y * 0.012 * body.height * (PI * t).sin();
            surface.point(back.lerp(front, t) + drop, between_legs(0.45))
        })
        .collect();
    Side::BOTH.map(|side| {
        let column = |j: usize| if side == Side::Left { j } else { (AROUND - j) % AROUND };
        (0..=half).map(|j| ring[column(j)]).chain(strip.iter().copied()).collect()
    })
}

/// Returns the weights between the legs: `pull` is the sum of both thighs' equal weights.
fn between_legs(pull: f64) -> Weights {
    let mut weights = vec![(PELVIS, 1.0 - pull)];
    weights.extend(Side::BOTH.map(|side| (Limb::Thigh.of(side), 0.5 * pull)));
    weights
}

/// Returns the position of point `j` of a ring.
pub(super) fn position(body: &Body, row: usize, j: usize) -> DVec3 {
    let [u, breadth, front, back, tilt] = ROWS[row];
    let look = &body.look;
    let angle = 2.0 * PI * j as f64 / AROUND as f64;
    let (sin, cos) = angle.sin_cos();
    let bump = |at: f64, width: f64| (-((u - at) / width).powi(2)).exp();
    let hips = look.hips * (1.0 - smooth(0.0, 0.3, u));
    let shoulders = look.shoulders * smooth(0.45, 0.75, u);
    let waist = look.waist * (smooth(0.0, 0.3, u) - smooth(0.45, 0.75, u));
    let mut breadth = breadth * (hips + waist + shoulders);
    let (mut front, mut back) = (front, back);
    if row < 11 {
        let stout = 0.5 * (look.waist + look.limbs) - 1.0;
        front *= 1.0 + 0.5 * stout;
        back *= 1.0 + 0.7 * stout;
    } else {
        breadth = ROWS[row][1] * (0.5 + 0.5 * look.shoulders);
    }
    front += 0.042 * look.belly * bump(0.26, 0.25);
    let across = smooth(0.1, 0.5, sin.abs()) * (1.0 - smooth(0.65, 0.95, sin.abs()));
    front += 0.020 * look.bust * bump(0.62, 0.11) * (0.55 + 0.45 * across);
    back += 0.010 * (look.hips - 1.0 + look.bust * 0.4) * bump(-0.05, 0.12);
    // Superellipses resemble a trunk more closely than ellipses.
    let depth = if cos > 0.0 { front } else { back };
    let x = breadth * sin.signum() * sin.abs().powf(0.88);
    let z = depth * cos.signum() * cos.abs().powf(0.80);
    DVec3::new(
        x * body.height,
        body.trunk_y(u) - tilt * cos * body.height,
        (z - 0.004 - 0.006 * smooth(0.7, 1.0, u)) * body.height,
    )
}

/// Returns the weights of point `j` of a ring.
pub(super) fn weights(row: usize, j: usize) -> Weights {
    let u = ROWS[row][0];
    let column = j.min(AROUND - j);
    let side = if j <= AROUND / 2 { Side::Left } else { Side::Right };
    let [a, b, c, d] = SPINE_AT;
    let segments = [PELVIS, SPINE[0], SPINE[1], SPINE[2], SPINE[3], NECK[0]];
    let spine = chain(u, &segments, &[(a, 0.09), (b, 0.09), (c, 0.09), (d, 0.09), (1.0, 0.06)]);
    let sin = (2.0 * PI * j as f64 / AROUND as f64).sin().abs();
    if row < 4 {
        let pull = [0.5, 0.26, 0.14, 0.0][row];
        let own = smooth(0.0, 0.6, sin);
        return mixed(
            mixed(spine, &between_legs(1.0)[1..], pull * (1.0 - own)),
            &[(Limb::Thigh.of(side), 1.0)],
            pull * own,
        );
    }
    let clavicle =
        0.7 * smooth(0.25, 0.8, sin) * smooth(0.66, 0.85, u) * (1.0 - smooth(0.95, 1.0, u));
    let arm = match (row, column) {
        (9 | 10, 4..=8) => 0.4,
        (8, 4..=8) => 0.44,
        (7, 4..=8) => 0.16,
        (7..=11, 3..=9) => 0.1,
        _ => 0.0,
    };
    mixed(
        mixed(spine, &[(Limb::Clavicle.of(side), 1.0)], clavicle),
        &[(Limb::UpperArm.of(side), 1.0)],
        arm,
    )
}
