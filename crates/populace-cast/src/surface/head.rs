//! Surface of neck and head: rings from inside the collar to the crown, with the face at the front.

use std::f64::consts::PI;

use super::skull::Skull;
use super::{Paint, Region, Surface, ear, eyes, smooth};
use crate::anatomy::{Body, Side};

/// Points around the head: point 0 is in front, 11 behind; the left follows the front.
const AROUND: usize = 22;

/// Angles in degrees, from the front, of the points of one half of a ring; dense at the face.
const ANGLES_DEG: [f64; 12] =
    [0.0, 6.0, 12.0, 18.5, 26.0, 35.0, 46.0, 62.0, 84.0, 110.0, 144.0, 180.0];

/// Rows of the skull's profile; dense at mouth, nose and eyes.
const ROWS: [f64; 24] = [
    0.0, 1.0, 2.2, 3.4, 4.8, 6.0, 7.4, LOWER, LINE, UPPER, 9.35, 9.85, NOSTRIL, 10.95, 11.5, 12.0,
    12.6, 13.2, 14.1, 14.9, 15.8, 17.0, 18.5, 20.0,
];
/// Rows of the line between the lips, of the upper lip and of the nostrils.
const LINE: f64 = 8.53;
const UPPER: f64 = 8.97;
const LOWER: f64 = 8.05;
const NOSTRIL: f64 = 10.35;
/// Last point of the lips in a half ring.
const LIP_END: usize = 3;

/// Adds head and neck with eyes, brows and ears.
pub(super) fn build(surface: &mut Surface, body: &Body) {
    let skull = Skull { body };
    let rings: Vec<Vec<usize>> = ROWS
        .iter()
        .map(|&row| (0..AROUND).map(|j| point(surface, skull, row, j)).collect())
        .collect();
    surface.tube(&rings, Region::Skin);
    let crown = surface.points.len() - 1;
    surface.points[crown] = skull.in_model(glam::DVec3::new(0.0, 1.0, -0.01));
    for side in Side::BOTH {
        ear::build(surface, skull, side);
        eyes::build(surface, skull, side);
    }
}

fn point(surface: &mut Surface, skull: Skull<'_>, row: f64, j: usize) -> usize {
    let column = j.min(AROUND - j);
    let side = if j <= AROUND / 2 { 1.0 } else { -1.0 };
    let even = 360.0 / AROUND as f64 * column as f64;
    // The neck's points are evenly spread.
    let dense = smooth(1.0, 4.0, row);
    let degrees = even + (ANGLES_DEG[column] - even) * dense;
    let mut p = skull.at(row, degrees * PI / 180.0);
    surface.brush = paint(skull, row, column, [p.x, p.y]);
    p.x *= side;
    let added = surface.point(skull.in_model(p), skull.weights(p));
    surface.brush = super::PLAIN;
    added
}

/// Returns the paint of the skin: lips, rosy cheeks, and shade in nostrils and around the eyes.
fn paint(skull: Skull<'_>, row: f64, column: usize, [x, y]: [f64; 2]) -> Paint {
    let face = &skull.body.look.face;
    let off = |limit: f64, of: f64| (row - of).abs() < limit;
    if column <= LIP_END && off(1e-9, LINE) {
        return [0.64, 0.37, 0.37];
    }
    if column < LIP_END && (off(1e-9, UPPER) || off(1e-9, LOWER)) {
        return face.lip_paint();
    }
    if column == 1 && off(1e-9, NOSTRIL) {
        return [0.50, 0.38, 0.36];
    }
    let spot = |cx: f64, cy: f64, size: f64| {
        (-((x - cx) / size).powi(2) - ((y - cy) / size).powi(2)).exp()
    };
    let front = if column < 8 && row > 4.0 { 1.0 } else { 0.0 };
    let rosy = front * (0.9 * spot(0.20, 0.33, 0.085) + 0.7 * spot(0.0, 0.35, 0.06));
    let shade = front * 0.22 * spot(0.13, 0.50, 0.075) + 0.12 * smooth(4.6, 3.6, row);
    [1.0 - shade, 1.0 - 0.16 * rosy - shade * 1.1, 1.0 - 0.16 * rosy - shade * 1.1]
}
