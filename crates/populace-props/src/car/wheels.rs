//! Wheels.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};

use super::Finishes;
use super::shape::Shape;
use crate::build::{Builder, extrude, spun};

/// The joints of the wheels.
pub(super) const NAMES: [&str; 4] =
    ["WheelFrontLeft", "WheelFrontRight", "WheelBackLeft", "WheelBackRight"];

/// Width of a tyre in metres.
const TYRE_M: f64 = 0.2;

/// Adds the wheels, each moved by a joint at its hub.
pub(super) fn build(b: &mut Builder, shape: &Shape, finishes: &Finishes, rims: usize) {
    for (nth, name) in NAMES.iter().enumerate() {
        let side = if nth % 2 == 0 { 1.0 } else { -1.0 };
        let x = side * (shape.half - 0.02 - 0.5 * TYRE_M);
        let hub = DVec3::new(x, shape.wheel, shape.axles[nth / 2]);
        let joint = b.joint(name, hub, None);
        b.moved_by(Some(joint));
        b.at = DAffine3::from_translation(hub);
        wheel(b, shape.wheel, finishes, side, rims);
    }
    b.moved_by(None);
    b.home();
}

fn wheel(b: &mut Builder, radius: f64, finishes: &Finishes, side: f64, rims: usize) {
    let (half, rim) = (0.5 * TYRE_M, 0.7 * radius);
    b.on(finishes.tyre);
    let tread = [[rim, -half], [radius, -0.72 * half], [radius, 0.72 * half], [rim, half]];
    let mut tyre = spun(&tread, 18);
    // The rim closes the outer end.
    let outer = if side > 0.0 { tyre.faces.len() - 1 } else { tyre.faces.len() - 2 };
    tyre.faces.remove(outer);
    b.add(&tyre, 50.0);
    // The outside of the rim: a lip, a dark dish, and spokes.
    let outwards = DAffine3::from_rotation_y(if side > 0.0 { 0.0 } else { std::f64::consts::PI });
    let hub = b.at;
    b.at = hub * outwards;
    b.on(finishes.rim);
    let lip = [[rim, half], [0.9 * rim, half - 0.03]];
    let mut ring = spun(&lip, 18);
    ring.faces.truncate(18);
    b.add(&ring, 30.0);
    b.on(finishes.trim);
    let mut dish = spun(&[[0.9 * rim, half - 0.032], [0.9 * rim, half - 0.03]], 14);
    dish.faces.drain(..dish.faces.len() - 1);
    b.flat(&dish);
    b.on(finishes.rim);
    // From the plane of x and y, which faces +Z, to the outer side.
    let face = DAffine3::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let (spokes, wide) = [(5_u32, 0.2), (7, 0.13), (8, 0.105)][rims % 3];
    for spoke in 0..spokes {
        let turn = DAffine3::from_rotation_x(TAU * f64::from(spoke) / f64::from(spokes));
        b.at = hub * outwards * turn * face;
        let (near, far) = (0.2 * rim, 0.93 * rim);
        let outline = [
            [-0.6 * wide * rim, near],
            [0.6 * wide * rim, near],
            [wide * rim, far],
            [-wide * rim, far],
        ];
        let mut bar = extrude(&outline, half - 0.028, half - 0.008);
        // Its ends and back are hidden.
        bar.faces.retain(|f| f.iter().any(|p| bar.points[*p].z > half - 0.01));
        b.flat(&bar);
    }
    b.at = hub * outwards;
    let mut cap = spun(&[[0.24 * rim, half - 0.028], [0.22 * rim, half - 0.004]], 10);
    cap.faces.retain(|f| f.iter().any(|p| cap.points[*p].x > half - 0.01));
    b.add(&cap, 30.0);
}
