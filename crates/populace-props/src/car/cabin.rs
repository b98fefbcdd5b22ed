//! Windows, pillars and roof, and what is inside.

use glam::{DAffine3, DQuat, DVec3};

use super::shape::{self, COLUMNS, CarKind, FLOOR_M, STEERING_M, Shape};
use super::{Finishes, Hung, Panels};
use crate::build::{Builder, Finish, Joint, Solid, along_x, bevelled, tube};

/// Heights of the faces of side windows, as fractions from belt to roof.
const SIDE_ROWS: [f64; 4] = [0.0, 0.07, 0.9, 1.0];
/// Heights of the faces of front and rear window.
const SCREEN_ROWS: [f64; 5] = [0.0, 0.07, 0.5, 0.93, 1.0];
/// Distance in metres between the surface of pillars and roof and their lining.
const LINING_M: f64 = 0.02;

/// Adds windows, pillars and roof.
pub(super) fn shell(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    for side in [1.0, -1.0] {
        windows(panels, shape, finishes, side);
    }
    screens(panels, shape, finishes);
    roof(panels, shape, finishes);
}

/// Returns the lines between the faces of a side: z at the belt and at the roof, from the front.
fn lines(shape: &Shape) -> [[f64; 2]; 7] {
    let ([front, back], [foot, head], [rear_head, rear_foot]) =
        (shape.door, shape.screen, shape.rear);
    let pillar = match shape.kind {
        CarKind::Hatchback => [rear_foot + 0.36, rear_head + 0.16],
        CarKind::Saloon => [rear_foot + 0.3, rear_head + 0.13],
        CarKind::Van => [rear_foot + 0.12, rear_head + 0.08],
    };
    [
        [foot, head],
        [front, head - 0.09],
        [back + 0.06, back + 0.1],
        [back, back + 0.04],
        [back - 0.08, back - 0.04],
        pillar,
        [rear_foot, rear_head],
    ]
}

fn windows(panels: &mut Panels, shape: &Shape, finishes: &Finishes, side: f64) {
    let rows = SIDE_ROWS.map(|v| {
        let point = |[low, high]: [f64; 2]| {
            let (foot, head) = (shape.side(low, shape.belt(low)), shape.roof_side(high));
            let bow = DVec3::X * 0.1 * v * (1.0 - v);
            let at = foot.lerp(head, v) + bow;
            DVec3::new(at.x * side, at.y, at.z)
        };
        let mut row: Vec<DVec3> = lines(shape).map(point).to_vec();
        if side < 0.0 {
            row.reverse();
        }
        row
    });
    let of = |row: usize, column: usize| {
        // Counted from the front.
        let column = if side > 0.0 { column } else { 5 - column };
        let is_door = side > 0.0 && (column == 1 || column == 2);
        let rear = if shape.kind == CarKind::Van { finishes.paint } else { finishes.glass };
        let finish = match (column, row) {
            (0 | 5, _) => finishes.paint,
            (1, 1) => finishes.glass,
            (4, 1) => rear,
            (4, _) if shape.kind == CarKind::Van => finishes.paint,
            _ => finishes.trim,
        };
        (if is_door { Hung::Door } else { Hung::Body }, finish)
    };
    lined(panels, finishes, &rows, of);
}

fn screens(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    for sign in [1.0, -1.0] {
        let (z, along) = if sign > 0.0 { (shape.screen[0], 0.0) } else { (shape.rear[1], 1.0) };
        let rows = SCREEN_ROWS.map(|v| {
            let point = |across: &f64| shape.deck(z, *across).lerp(shape.roof(along, *across), v);
            let mut row: Vec<DVec3> = COLUMNS.iter().map(point).collect();
            if sign < 0.0 {
                row.reverse();
            }
            row
        });
        let of = |row: usize, column: usize| {
            let finish = match (row, column) {
                (_, 0 | 4) => finishes.paint,
                (0 | 3, _) => finishes.trim,
                _ => finishes.glass,
            };
            (Hung::Body, finish)
        };
        lined(panels, finishes, &rows, of);
    }
}

fn roof(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    let rows: Vec<Vec<DVec3>> = lines(shape)
        .iter()
        .map(|[_, z]| {
            let along = (z - shape.screen[1]) / (shape.rear[0] - shape.screen[1]);
            COLUMNS.iter().map(|across| shape.roof(along, *across)).collect()
        })
        .collect();
    lined(panels, finishes, &rows, |_, _| (Hung::Body, finishes.paint));
}

/// Adds cells, and a lining inside of those that are not glass.
fn lined(
    panels: &mut Panels,
    finishes: &Finishes,
    rows: &[Vec<DVec3>],
    of: impl Fn(usize, usize) -> (Hung, Finish),
) {
    panels.cells(rows, |row, column| Some(of(row, column)));
    for row in 1..rows.len() {
        for column in 1..rows[row].len() {
            let (hung, finish) = of(row - 1, column - 1);
            if finish == finishes.glass {
                continue;
            }
            let corners = [
                rows[row - 1][column - 1],
                rows[row - 1][column],
                rows[row][column],
                rows[row][column - 1],
            ];
            let normal =
                (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize_or_zero();
            let mut inner = corners.map(|p| p - LINING_M * normal);
            inner.reverse();
            panels.of(hung, finishes.roof_lining).face(&inner);
        }
    }
}

/// Adds dashboard and seats.
pub(super) fn build(b: &mut Builder, shape: &Shape, finishes: &Finishes) {
    let wide = shape.half - 0.12;
    let foot = shape.screen[0];
    let high = shape.belt(foot) - 0.01;
    let dash = [
        [foot - 0.01, high],
        [0.74, high - 0.03],
        [0.64, high - 0.08],
        [0.62, high - 0.16],
        [0.72, 0.56],
        [0.95, 0.3],
        [foot - 0.01, FLOOR_M],
    ];
    b.on(finishes.lining).add(&along_x(&dash, -wide, wide), 20.0);
    b.on(finishes.plastic);
    // The instruments' hood, the middle console and the rear shelf.
    b.flat(&bevelled([0.2, high - 0.1, 0.6], [0.56, high + 0.02, 0.74], 0.03));
    b.flat(&bevelled([-0.1, FLOOR_M, -0.1], [0.1, 0.46, 0.66], 0.03));
    b.block([-0.012, 0.44, 0.3], [0.012, 0.58, 0.33]);
    for x in [0.38, -0.38] {
        seat(b, finishes, [x - 0.24, x + 0.24], 0.0);
    }
    if shape.kind == CarKind::Van {
        // A wall behind the seats.
        let z = shape.door[1] - 0.16;
        b.on(finishes.lining).block([-wide, FLOOR_M, z], [wide, 1.3, z + 0.03]);
    } else {
        seat(b, finishes, [-0.62, 0.62], -0.82);
    }
}

/// Adds a seat whose surface is 0.5 m high at the driver's place, moved along Z.
fn seat(b: &mut Builder, finishes: &Finishes, [l, r]: [f64; 2], z: f64) {
    b.on(finishes.seat);
    b.at = DAffine3::from_translation(DVec3::Z * z);
    let cushion =
        [[-0.16, 0.36], [0.36, 0.38], [0.38, 0.5], [0.33, 0.525], [0.2, 0.51], [-0.14, 0.49]];
    b.add(&along_x(&cushion, l, r), 40.0);
    let back = [
        [-0.12, 0.46],
        [-0.1, 0.6],
        [-0.14, 0.8],
        [-0.23, 1.03],
        [-0.29, 1.05],
        [-0.35, 1.02],
        [-0.27, 0.44],
    ];
    b.add(&along_x(&back, l + 0.01, r - 0.01), 40.0);
    // The sides hold the body.
    if r - l < 0.6 {
        for x in [l - 0.01, r - 0.06] {
            let bolster = [[-0.1, 0.46], [-0.02, 0.66], [-0.1, 0.86], [-0.18, 0.88], [-0.2, 0.46]];
            b.add(&along_x(&bolster, x, x + 0.07), 40.0);
        }
    }
    let count = if r - l < 0.6 { 1 } else { 2 };
    for nth in 0..count {
        let x = if count == 1 { 0.5 * (l + r) } else { [-0.36, 0.36][nth] };
        b.flat(&bevelled([x - 0.13, 1.08, -0.33], [x + 0.13, 1.25, -0.25], 0.03));
        b.block([x - 0.05, 1.0, -0.3], [x + 0.05, 1.1, -0.28]);
    }
    b.on(finishes.plastic);
    b.block([l + 0.03, FLOOR_M, -0.12], [r - 0.03, 0.37, 0.3]);
    b.home();
}

/// Adds steering wheel and column. The wheel turns with its joint.
pub(super) fn steering(b: &mut Builder, finishes: &Finishes, joint: Joint) {
    let turn = DQuat::from_rotation_arc(DVec3::Y, shape::wheel_axis());
    let middle = shape::wheel_middle();
    b.on(finishes.plastic);
    let behind = middle - 0.05 * shape::wheel_axis();
    b.add(&tube(&[(behind - 0.3 * shape::wheel_axis(), 0.035), (behind, 0.035)], 6), 60.0);
    b.at = DAffine3::from_rotation_translation(turn, middle);
    b.moved_by(Some(joint));
    b.add(&ring(STEERING_M - 0.013, 0.015, 16, 4), 80.0);
    let hub = crate::build::lathe(&[[0.06, -0.05], [0.065, -0.005], [0.05, 0.012]], 10);
    b.add(&hub, 40.0);
    for spoke in 0..3 {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(spoke)).sin_cos();
        // Towards +X, -X and to the foot.
        let out = DVec3::new(cos, 0.0, -sin) * (STEERING_M - 0.02);
        b.add(&tube(&[(0.2 * out, 0.02), (out, 0.012)], 4), 60.0);
    }
    b.moved_by(None);
    b.home();
}

/// Returns a torus about +Y.
fn ring(radius: f64, thick: f64, sides: usize, around: usize) -> Solid {
    let mut solid = Solid::default();
    for k in 0..sides {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / sides as f64).sin_cos();
        for j in 0..around {
            let (up, out) = (std::f64::consts::TAU * j as f64 / around as f64).sin_cos();
            let r = radius + thick * out;
            solid.point(DVec3::new(r * sin, thick * up, r * cos));
        }
    }
    for k in 0..sides {
        for j in 0..around {
            let (k2, j2) = ((k + 1) % sides, (j + 1) % around);
            let corner = |k: usize, j: usize| k * around + j;
            solid.faces.push(vec![corner(k, j), corner(k2, j), corner(k2, j2), corner(k, j2)]);
        }
    }
    solid
}
