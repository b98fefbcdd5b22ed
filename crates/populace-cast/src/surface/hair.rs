//! Surface of the hair: a thick shell from the crown to the hairline, for each cut.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use populace_model::convert::u32_from;

use super::skull::Skull;
use super::{Region, Surface, smooth};
use crate::Hair;

/// Points around the hair: point 0 is in front, 6 on the left, 12 behind, 18 on the right.
pub(super) const AROUND: usize = 24;
/// Rows from the crown (0) to the edge (1).
const ROWS: [f64; 6] = [0.17, 0.35, 0.53, 0.71, 0.88, 1.0];

/// Form of a shell of hair or cloth around the head, in units of the head's height.
pub(super) struct Shape {
    /// Height of the edge at each point of a half ring.
    pub(super) edge: [f64; 13],
    /// Thickness at an angle from the front in degrees, positive on the left, and a row.
    pub(super) thick: fn(f64, f64) -> f64,
    /// True if the hair hangs straight down from the broadest part of the head.
    pub(super) hangs: bool,
    /// True for cloth without locks.
    pub(super) smooth: bool,
    /// Unevenness of the surface.
    pub(super) rough: f64,
}

/// Returns the surface of a hair cut.
pub(super) fn build(skull: Skull<'_>, hair: Hair) -> Surface {
    let mut surface = Surface::default();
    dome(&mut surface, skull, &shape(hair), Region::Hair);
    match hair {
        Hair::Bun => bun(&mut surface, skull),
        Hair::Ponytail => tail(&mut surface, skull),
        _ => {}
    }
    surface
}

/// Returns the form of a cut or of a scarf.
pub(super) fn shape(hair: Hair) -> Shape {
    let cropped = [0.81, 0.80, 0.79, 0.74, 0.66, 0.54, 0.46, 0.47, 0.26, 0.18, 0.14, 0.12, 0.12];
    let drawn = [0.83, 0.82, 0.80, 0.75, 0.66, 0.57, 0.50, 0.48, 0.28, 0.20, 0.16, 0.14, 0.14];
    let shape = |edge, hangs, rough, thick| Shape { edge, thick, hangs, rough, smooth: false };
    match hair {
        Hair::Short => shape(cropped, false, 0.010, |angle, s| {
            let front = smooth(70.0, 10.0, angle.abs());
            0.020 + (0.030 + 0.030 * front * s) * smooth(0.85 + 0.25 * front, 0.35, s)
        }),
        Hair::SidePart => shape(cropped, false, 0.009, |angle, s| {
            // The part runs from the front to the crown on the right.
            let groove = 1.0 - 0.75 * smooth(14.0, 4.0, (angle + 34.0).abs()) * smooth(0.1, 0.4, s);
            let swept = smooth(-30.0, 20.0, angle) * smooth(110.0, 50.0, angle);
            (0.022 + (0.036 + 0.030 * swept) * smooth(1.15, 0.45, s)) * groove
        }),
        Hair::Receding => shape(drawn, false, 0.004, |angle, s| {
            let bare = smooth(0.86, 0.66, s + 0.16 * smooth(90.0, 180.0, angle.abs()));
            0.026 - 0.060 * bare.max(smooth(80.0, 62.0, angle.abs()))
        }),
        Hair::Curly => shape(cropped, false, 0.028, |angle, s| {
            0.092 - 0.040 * smooth(0.6, 1.0, s) * smooth(100.0, 60.0, angle.abs())
        }),
        Hair::Bob => shape(
            [0.71, 0.70, 0.69, 0.62, 0.18, 0.05, 0.04, 0.03, 0.03, 0.03, 0.04, 0.04, 0.04],
            true,
            0.008,
            |angle, s| 0.050 + 0.045 * smooth(0.1, 0.9, s) * smooth(30.0, 62.0, angle.abs()),
        ),
        Hair::Long => shape(
            [0.83, 0.80, 0.76, 0.64, 0.10, -0.13, -0.17, -0.20, -0.30, -0.42, -0.48, -0.50, -0.50],
            true,
            0.010,
            |angle, s| {
                let part = 1.0 - 0.6 * smooth(12.0, 2.0, angle.abs()) * smooth(0.0, 0.3, s);
                (0.045 + 0.045 * smooth(0.1, 0.85, s) * smooth(20.0, 62.0, angle.abs())) * part
            },
        ),
        Hair::Bun => shape(drawn, false, 0.004, |angle, s| {
            let ears = smooth(40.0, 10.0, (angle.abs() - 105.0).abs());
            0.022 + 0.014 * smooth(0.9, 0.3, s) + 0.018 * ears
        }),
        Hair::Ponytail => shape(drawn, false, 0.004, |angle, s| {
            let fringe = smooth(40.0, 20.0, (angle - 20.0).abs());
            let ears = smooth(40.0, 10.0, (angle.abs() - 105.0).abs());
            0.022 + 0.016 * smooth(0.9, 0.3, s) + 0.02 * fringe + 0.018 * ears
        }),
        Hair::Headscarf => Shape {
            edge: [
                0.76, 0.755, 0.73, 0.66, 0.42, 0.08, -0.06, -0.08, -0.08, -0.08, -0.08, -0.08,
                -0.08,
            ],
            thick: |angle, s| 0.045 + 0.022 * s * smooth(40.0, 90.0, angle.abs()),
            hangs: true,
            smooth: true,
            rough: 0.003,
        },
    }
}

/// Adds a shell around the head, which is closed inside the head.
pub(super) fn dome(surface: &mut Surface, skull: Skull<'_>, shape: &Shape, region: Region) {
    // Smooth hats need fewer rows than locks.
    let rows: &[f64] = if shape.smooth && !shape.hangs { &[0.32, 0.68, 1.0] } else { &ROWS };
    let rings: Vec<Vec<usize>> = rows
        .iter()
        .enumerate()
        .map(|(row, &s)| {
            let ring = (0..AROUND).map(|j| {
                let p = outside(skull, shape, row, s, j);
                let streak = if shape.smooth { 0.0 } else { 0.30 * (noise(j, 91) - 0.5) };
                let shade = 0.80 + 0.22 * (1.0 - s) + streak;
                surface.brush = [shade; 3];
                surface.point(skull.in_model(p), skull.weights(p))
            });
            ring.collect()
        })
        .collect();
    surface.brush = [0.6; 3];
    let inner = |surface: &mut Surface, s: f64, off: f64| -> Vec<usize> {
        let ring = (0..AROUND).map(|j| {
            let p = on_head(skull, shape, s, j);
            let p = p - outwards(p) * off;
            surface.point(skull.in_model(p), skull.weights(p))
        });
        ring.collect()
    };
    let mut all = rings;
    if shape.hangs {
        // Hanging hair has an inner side, which is seen below the chin.
        all.push(inner(surface, 0.97, 0.02));
        all.push(inner(surface, 0.62, 0.04));
    } else {
        all.push(inner(surface, 1.0, 0.035));
    }
    surface.brush = super::PLAIN;
    let crown = surface.points.len();
    surface.tube(&all, region);
    surface.points[crown] =
        skull.in_model(DVec3::new(0.0, 0.997 + 0.85 * (shape.thick)(0.0, 0.0), -0.01));
}

/// Returns the signed angle from the front of point `j` in degrees.
fn degrees(j: usize) -> f64 {
    let angle = 360.0 * j as f64 / AROUND as f64;
    if angle > 180.0 { angle - 360.0 } else { angle }
}

/// Returns the point of the head below row `s`, or of a hanging curtain.
fn on_head(skull: Skull<'_>, shape: &Shape, s: f64, j: usize) -> DVec3 {
    let edge = shape.edge[j.min(AROUND - j)] + 2.5 * shape.rough * (noise(j, 17) - 0.5);
    let angle = degrees(j) * PI / 180.0;
    let from = 0.46;
    // Where hair hangs, most rows are still on the round of the head.
    let round = 0.71;
    if !shape.hangs || edge > from || s < round {
        let (low, part) = if shape.hangs && edge < from { (from, s / round) } else { (edge, s) };
        return skull.at_height(low + (0.995 - low) * (0.5 * PI * part).cos(), angle);
    }
    let y = from + (edge - from) * (s - round) / (1.0 - round);
    let mut p = skull.at_height(from, angle);
    let down = from - y;
    p.x *= 1.0 - 0.10 * down;
    p.z *= 1.0 + 0.06 * down;
    p.y = y;
    p
}

/// Returns the direction away from the head.
fn outwards(p: DVec3) -> DVec3 {
    DVec3::new(p.x, 0.9 * (p.y - 0.5).max(0.0), p.z).normalize_or(DVec3::Y)
}

fn outside(skull: Skull<'_>, shape: &Shape, row: usize, s: f64, j: usize) -> DVec3 {
    let p = on_head(skull, shape, s, j);
    let thick = shape.smooth || shape.hangs && p.y < 0.3;
    let edge = 1.0 - if thick { 0.15 } else { 0.5 } * s.powi(7);
    // Locks run from the crown to the edge.
    let uneven = shape.rough * (noise(j, 3) + noise(j, row) - 1.0);
    p + outwards(p) * ((shape.thick)(degrees(j), s) * edge + uneven)
}

/// Returns a number from 0 to 1 that depends on two integers only.
fn noise(a: usize, b: usize) -> f64 {
    let mut x = u32_from(a).wrapping_mul(0x9E37_79B9) ^ u32_from(b).wrapping_mul(0x85EB_CA6B);
    x = (x ^ (x >> 15)).wrapping_mul(0x2C1B_3C6D);
    x = (x ^ (x >> 12)).wrapping_mul(0x297A_2D39);
    f64::from(x ^ (x >> 15)) / f64::from(u32::MAX)
}

/// Adds hair gathered at the back of the head.
fn bun(surface: &mut Surface, skull: Skull<'_>) {
    let center = DVec3::new(0.0, 0.80, -0.47);
    let axis = DVec3::new(0.0, 0.45, -0.9).normalize();
    let up = DVec3::X.cross(axis);
    let rings: Vec<Vec<usize>> =
        [(150.0, 0.8), (110.0, 1.0), (75.0, 1.0), (45.0, 0.95), (20.0, 1.0)]
            .into_iter()
            .map(|(polar, shade): (f64, f64)| {
                let (sin, cos) = (polar * PI / 180.0).sin_cos();
                surface.brush = [0.9 * shade; 3];
                (0..10)
                    .map(|k| {
                        let (s, c) = (TAU * f64::from(k) / 10.0 + 0.02 * polar).sin_cos();
                        let p =
                            center + (axis * (0.75 * cos) + (DVec3::X * c + up * s) * sin) * 0.165;
                        surface.point(skull.in_model(p), skull.weights(DVec3::Y))
                    })
                    .collect()
            })
            .collect();
    surface.tube(&rings, Region::Hair);
    surface.brush = super::PLAIN;
}

/// Adds hair that hangs from the back of the head.
fn tail(surface: &mut Surface, skull: Skull<'_>) {
    let path = [
        (0.70, -0.42, 0.055),
        (0.735, -0.52, 0.060),
        (0.66, -0.62, 0.100),
        (0.45, -0.66, 0.110),
        (0.22, -0.62, 0.095),
        (0.02, -0.585, 0.070),
        (-0.12, -0.57, 0.025),
    ];
    let rings: Vec<Vec<usize>> = path
        .iter()
        .enumerate()
        .map(|(at, &(y, z, radius))| {
            let before = path[at.saturating_sub(1)];
            let after = path[(at + 1).min(path.len() - 1)];
            let along = DVec3::new(0.0, after.0 - before.0, after.1 - before.1).normalize();
            let up = DVec3::X.cross(along);
            (0..8)
                .map(|k| {
                    let (s, c) = (TAU * f64::from(k) / 8.0).sin_cos();
                    surface.brush = [0.78 + 0.3 * noise(k as usize, 7); 3];
                    let p = DVec3::new(0.0, y, z) + (DVec3::X * c + up * (0.8 * s)) * radius;
                    surface.point(skull.in_model(p), skull.weights(p + DVec3::Y * 0.3))
                })
                .collect()
        })
        .collect();
    surface.tube(&rings, Region::Hair);
    surface.brush = super::PLAIN;
}
