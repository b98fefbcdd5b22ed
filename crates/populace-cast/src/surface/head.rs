//! Surface of neck and head: rings from the trunk to the crown, with the face at the front.

use std::f64::consts::PI;

use glam::DVec3;

use super::trunk::AROUND;
use super::{Region, Surface, Weights, chain, smooth};
use crate::Hair;
use crate::anatomy::{Body, HEAD, NECK, SPINE};

/// Angles in degrees, from the front, of the points of one half of a ring; dense at the face.
const ANGLES_DEG: [f64; 13] =
    [0.0, 7.0, 13.5, 20.5, 28.5, 38.0, 58.0, 80.0, 91.0, 103.0, 131.0, 157.0, 180.0];

/// Height in front and behind, half breadth, depth in front and behind, and narrowing of the front,
/// as a fraction of the breadth. Lengths are in units of the head's height, from the chin.
const ROWS: [[f64; 6]; 20] = [
    [-0.100, 0.020, 0.225, 0.175, 0.270, 0.00],
    [0.015, 0.120, 0.240, 0.205, 0.285, 0.05],
    [-0.005, 0.150, 0.250, 0.340, 0.305, 0.20],
    [0.045, 0.180, 0.262, 0.396, 0.330, 0.24],
    [0.105, 0.220, 0.276, 0.393, 0.355, 0.16],
    [0.162, 0.260, 0.288, 0.404, 0.375, 0.10],
    [0.196, 0.300, 0.298, 0.407, 0.390, 0.07],
    [0.226, 0.335, 0.307, 0.413, 0.405, 0.05],
    [0.285, 0.375, 0.319, 0.417, 0.418, 0.03],
    [0.335, 0.410, 0.327, 0.420, 0.428, 0.02],
    [0.434, 0.470, 0.336, 0.412, 0.440, 0.01],
    [0.475, 0.495, 0.340, 0.408, 0.445, 0.00],
    [0.518, 0.520, 0.341, 0.410, 0.448, 0.00],
    [0.565, 0.560, 0.341, 0.424, 0.450, 0.00],
    [0.598, 0.592, 0.339, 0.426, 0.450, 0.00],
    [0.680, 0.670, 0.330, 0.415, 0.444, 0.00],
    [0.765, 0.755, 0.308, 0.382, 0.425, 0.00],
    [0.855, 0.845, 0.260, 0.315, 0.370, 0.00],
    [0.935, 0.930, 0.185, 0.215, 0.265, 0.00],
    [0.983, 0.983, 0.098, 0.110, 0.140, 0.00],
];

/// Relief of the face: row, point of the half ring, and offset to the front in units of the head's
/// height.
const FACE: [(usize, usize, f64); 41] = [
    (2, 0, 0.01),
    (3, 0, 0.022),
    (3, 1, 0.015),
    (4, 0, -0.004),
    (5, 0, 0.010),
    (5, 1, 0.008),
    (6, 0, -0.004),
    (6, 1, -0.006),
    (6, 2, -0.006),
    (7, 0, 0.016),
    (7, 1, 0.012),
    (8, 0, 0.040),
    (8, 1, 0.022),
    (8, 2, 0.004),
    (9, 0, 0.112),
    (9, 1, 0.040),
    (9, 2, 0.006),
    (9, 5, 0.008),
    (10, 0, 0.066),
    (10, 1, 0.020),
    (10, 2, -0.012),
    (10, 3, -0.006),
    (10, 4, -0.002),
    (10, 5, 0.008),
    (11, 0, 0.042),
    (11, 1, 0.006),
    (11, 2, -0.022),
    (11, 3, -0.004),
    (11, 4, -0.002),
    (11, 5, -0.014),
    (12, 0, 0.030),
    (12, 1, -0.002),
    (12, 2, -0.022),
    (12, 3, -0.010),
    (12, 4, -0.008),
    (12, 5, -0.010),
    (13, 0, 0.018),
    (13, 1, 0.012),
    (13, 3, 0.012),
    (13, 4, 0.012),
    (13, 5, 0.010),
];

/// Relief of the ear: row and outward offset in units of the head's height.
const EAR: [(usize, f64); 5] = [(8, 0.02), (9, 0.055), (10, 0.075), (11, 0.085), (12, 0.08)];
/// Point of the half ring at the ear.
const EAR_POINT: usize = 8;

/// Regions of the face: region, row, first and last point of the half ring.
const MARKS: [(Region, usize, usize, usize); 11] = [
    (Region::Iris, 10, 3, 4),
    (Region::Iris, 11, 3, 4),
    (Region::Iris, 12, 3, 4),
    (Region::EyeWhite, 10, 3, 4),
    (Region::EyeWhite, 11, 2, 5),
    (Region::EyeWhite, 12, 3, 4),
    (Region::Brow, 13, 2, 5),
    (Region::Brow, 14, 2, 5),
    (Region::Lips, 5, 0, 2),
    (Region::Lips, 6, 0, 3),
    (Region::Lips, 7, 0, 2),
];

/// Returns the lowest row of hair at each point of the half ring.
fn hairline(hair: Hair) -> [usize; 13] {
    match hair {
        Hair::Short => [16, 16, 16, 16, 16, 15, 14, 11, 14, 8, 4, 3, 3],
        Hair::Long => [16, 16, 16, 16, 16, 15, 1, 0, 0, 0, 0, 0, 0],
        Hair::Bun => [16, 16, 16, 16, 16, 15, 14, 11, 14, 8, 5, 4, 4],
        Hair::Receding => [19, 19, 19, 18, 18, 17, 16, 11, 14, 8, 5, 4, 4],
    }
}

pub(super) fn build(surface: &mut Surface, body: &Body, neck: &[usize]) {
    let line = hairline(body.look.hair);
    let mut below = neck.to_vec();
    for row in 0..ROWS.len() {
        let ring: Vec<usize> = (0..AROUND)
            .map(|j| surface.point(position(body, row, j, &line), weights(row)))
            .collect();
        for (j, &point) in ring.iter().enumerate() {
            let column = j.min(AROUND - j);
            if row >= line[column] {
                surface.mark(point, Region::Hair);
            }
            for &(region, at, from, to) in &MARKS {
                if at == row && (from..=to).contains(&column) {
                    surface.mark(point, region);
                }
            }
        }
        for j in 0..AROUND {
            let next = (j + 1) % AROUND;
            surface.quad(
                [below[j], below[next], ring[next], ring[j]],
                Region::Skin,
                j >= AROUND / 2,
            );
        }
        below = ring;
    }
    let top = 1.0 + body.look.hair.height();
    let crown = surface
        .point(DVec3::new(0.0, body.chin_y + top * body.head, middle_z(body)), vec![(HEAD, 1.0)]);
    surface.mark(crown, Region::Hair);
    surface.cap(&below, crown, Region::Skin, false);
}

/// Returns z of the head's axis, which is slightly in front of the neck's.
fn middle_z(body: &Body) -> f64 {
    0.008 * body.height
}

/// Returns the position of point `j` of a ring. `line` is the hairline.
fn position(body: &Body, row: usize, j: usize, line: &[usize; 13]) -> DVec3 {
    let column = j.min(AROUND - j);
    let side = if j <= AROUND / 2 { 1.0 } else { -1.0 };
    let [before, behind, mut breadth, front, mut back, narrow] = ROWS[row];
    let even = 15.0 * column as f64;
    let angle_deg = if row == 0 { 0.5 * (even + ANGLES_DEG[column]) } else { ANGLES_DEG[column] };
    let (sin, cos) = (angle_deg * PI / 180.0).sin_cos();
    let mut y = behind + (before - behind) * (0.5 + 0.5 * cos);
    let in_hair = row >= line[column];
    let border = row == line[column] || column > 0 && line[column - 1] > row;
    if body.look.hair == Hair::Long && in_hair && !border && row < 11 {
        // Long hair hangs straight down from the broadest part of the head.
        (breadth, back) = (0.335, 0.44);
        y -= 0.08 * smooth(6.0, 1.0, row as f64);
    }
    let mut x = breadth * sin * (1.0 - narrow * cos.max(0.0));
    let mut z = if cos > 0.0 { front * cos.powf(0.85) } else { -back * (-cos).powf(0.9) };
    if let Some((.., push)) = FACE.iter().find(|(r, c, _)| (*r, *c) == (row, column)) {
        z += push;
    }
    if let Some((_, push)) =
        EAR.iter().find(|(r, _)| *r == row && column == EAR_POINT && body.look.hair != Hair::Long)
    {
        x += push;
        z -= 0.35 * push;
    }
    if in_hair {
        let thick = thickness(body.look.hair, row, column) * if border { 0.3 } else { 1.0 };
        let out = DVec3::new(x, (y - 0.55).max(0.0), z).normalize();
        (x, y, z) = (x + thick * out.x, y + thick * out.y, z + thick * out.z);
    }
    DVec3::new(side * x * body.head, body.chin_y + y * body.head, z * body.head + middle_z(body))
}

/// Returns the thickness of the hair in units of the head's height.
fn thickness(hair: Hair, row: usize, column: usize) -> f64 {
    let plain = hair.height();
    match hair {
        Hair::Bun if (14..=16).contains(&row) && column >= 11 => plain + 0.17,
        Hair::Bun if (13..=17).contains(&row) && column >= 10 => plain + 0.04,
        Hair::Long if row < 16 => plain + 0.02,
        _ => plain,
    }
}

/// Returns the weights of a ring.
fn weights(row: usize) -> Weights {
    let at = row as f64;
    chain(at, &[SPINE[3], NECK[0], NECK[1], HEAD], &[(-0.8, 0.9), (0.4, 0.9), (1.8, 1.2)])
}
