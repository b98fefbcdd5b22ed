//! Surface of bags and their straps.

use std::f64::consts::TAU;

use glam::DVec3;

use super::trunk::{self, AROUND};
use super::{Region, Surface, Weights};
use crate::Bag;
use crate::anatomy::{Body, PELVIS, SPINE, Side};

/// Row and point of the trunk's half ring along a strap of a backpack, from the chest over the
/// shoulder to the back.
const STRAP: [(usize, usize); 8] =
    [(5, 6), (6, 5), (8, 3), (9, 3), (10, 4), (11, 6), (10, 8), (8, 9)];
/// The same of a bag's strap: from the left hip over the chest to the right shoulder, and back.
const SLING: [(usize, usize); 13] = [
    (2, 6),
    (4, 4),
    (6, 2),
    (8, 0),
    (9, 22),
    (10, 20),
    (11, 18),
    (10, 15),
    (9, 14),
    (7, 12),
    (5, 10),
    (3, 8),
    (2, 7),
];
/// Distance of a strap from the body as a fraction of its height.
const OFF: f64 = 0.0125;

/// Returns a bag with its straps.
pub(super) fn bag(body: &Body, bag: Bag) -> Surface {
    let mut surface = Surface::default();
    match bag {
        Bag::Backpack => {
            backpack(&mut surface, body);
            for side in Side::BOTH {
                let path =
                    STRAP.map(|(row, j)| (row, if side == Side::Left { j } else { AROUND - j }));
                strap(&mut surface, body, &path, 0.0105);
            }
        }
        Bag::Shoulder => {
            pouch(&mut surface, body);
            strap(&mut surface, body, &SLING, 0.008);
        }
    }
    surface
}

/// Adds the sack on the back.
fn backpack(surface: &mut Surface, body: &Body) {
    let h = body.height;
    let behind = |row: usize| trunk::position(body, row, AROUND / 2);
    let wide = 0.072 * h * (0.5 + 0.5 * body.look.shoulders);
    let weights = |y: f64| -> Weights {
        let up = super::smooth(body.trunk_y(0.2), body.trunk_y(0.7), y);
        vec![(SPINE[3], up), (SPINE[1], 1.0 - up)]
    };
    // Height along the trunk, breadth and depth of each ring.
    let rows = [
        (0.10, 0.75, 0.75),
        (0.14, 1.0, 1.0),
        (0.42, 1.04, 1.0),
        (0.68, 0.98, 0.85),
        (0.84, 0.80, 0.62),
        (0.89, 0.45, 0.4),
    ];
    let rear = behind(9).z.min(behind(7).z) - OFF * 0.4 * h;
    box_of(
        surface,
        &rows.map(|(u, b, d)| {
            let deep = 0.080 * h * d;
            (DVec3::new(0.0, body.trunk_y(u), rear - 0.5 * deep), wide * b, 0.5 * deep)
        }),
        weights,
        1.0,
    );
}

/// Adds a bag at the left hip.
fn pouch(surface: &mut Surface, body: &Body) {
    let h = body.height;
    let at = trunk::position(body, 1, 6);
    let weights = |_: f64| -> Weights { vec![(PELVIS, 1.0)] };
    let rows = [(-0.065, 0.7, 0.7), (-0.058, 1.0, 1.0), (0.010, 1.0, 1.0), (0.022, 0.8, 0.7)];
    box_of(
        surface,
        &rows.map(|(up, b, d)| {
            let center = DVec3::new(at.x + 0.016 * h, at.y + up * h, at.z);
            (center, 0.022 * h * d, 0.068 * h * b)
        }),
        weights,
        1.0,
    );
}

/// Adds a rounded box through level rings, each with its centre, half breadth and half depth.
fn box_of<const N: usize>(
    surface: &mut Surface,
    rows: &[(DVec3, f64, f64); N],
    weights: impl Fn(f64) -> Weights,
    paint: f64,
) {
    surface.brush = [paint; 3];
    let rings: Vec<Vec<usize>> = rows
        .iter()
        .map(|&(center, breadth, depth)| {
            let ring = (0..10).map(|k| {
                let (sin, cos) = (TAU * (f64::from(k) + 0.5) / 10.0).sin_cos();
                let [x, z] = [sin, cos].map(|v| v.signum() * v.abs().powf(0.45));
                let p = center + DVec3::new(x * breadth, 0.0, z * depth);
                surface.point(p, weights(p.y))
            });
            ring.collect()
        })
        .collect();
    surface.brush = super::PLAIN;
    surface.tube(&rings, Region::Accessory);
}

/// Adds a flat strap along points of the trunk.
fn strap(surface: &mut Surface, body: &Body, path: &[(usize, usize)], half: f64) {
    let h = body.height;
    let place = |(row, j): (usize, usize)| trunk::position(body, row, j);
    surface.brush = [0.7; 3];
    let rings: Vec<Vec<usize>> = path
        .iter()
        .enumerate()
        .map(|(at, &(row, j))| {
            let p = place((row, j));
            let along = (place(path[(at + 1).min(path.len() - 1)])
                - place(path[at.saturating_sub(1)]))
            .normalize();
            // Away from the trunk's axis; upwards at the shoulder.
            let rise = 1.6 * super::smooth(7.5, 11.0, row as f64);
            let flat = DVec3::new(p.x, 0.0, p.z + 0.006 * h).normalize();
            let out = flat + DVec3::Y * rise;
            let out = (out - along * out.dot(along)).normalize();
            let across = along.cross(out);
            let corners = [(-half, OFF), (half, OFF), (half, OFF - 0.008), (-half, OFF - 0.008)];
            corners
                .into_iter()
                .map(|(side, up)| {
                    let p = p + (across * side + out * up) * h;
                    surface.point(p, trunk::weights(row, j))
                })
                .collect()
        })
        .collect();
    surface.brush = super::PLAIN;
    surface.tube(&rings, Region::Accessory);
}
