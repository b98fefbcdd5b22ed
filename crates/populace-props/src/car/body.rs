//! The lower body: sides with arches, front, back, bonnet and boot.

use glam::DVec3;

use super::shape::{COLUMNS, CarKind, FLOOR_M, ROWS, SILL_M, Shape};
use super::{Finishes, Hung, Panels};
use crate::build::Solid;

/// Thickness of doors and sides in metres.
const THICK_M: f64 = 0.07;
/// The x up to which wheel arches reach inwards.
const WELL_M: f64 = 0.5;

pub(super) fn build(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    for side in [1.0, -1.0] {
        sides(panels, shape, finishes, side);
        wells(panels, shape, finishes, side);
    }
    for sign in [1.0, -1.0] {
        ends(panels, shape, finishes, sign);
        deck(panels, shape, finishes, sign);
    }
    floor(panels, shape, finishes);
    door_inside(panels, shape, finishes);
}

/// Turns points of the left side to `side`.
fn mirrored(point: DVec3, side: f64) -> DVec3 {
    DVec3::new(point.x * side, point.y, point.z)
}

/// Returns the rows of points of a side. Seen from outside they run to the right.
fn side_rows(shape: &Shape, stations: &[[f64; 2]], side: f64) -> Vec<Vec<DVec3>> {
    let point = |t: f64, [z, low]: [f64; 2]| {
        let y = low + t * (shape.belt(z) - low);
        mirrored(shape.side(z, y), side)
    };
    let row = |t: f64| -> Vec<DVec3> {
        let mut row: Vec<DVec3> = stations.iter().map(|s| point(t, *s)).collect();
        // The front is to the right of who looks at the car's right side.
        if side > 0.0 {
            row.reverse();
        }
        row
    };
    ROWS.map(row).to_vec()
}

fn sides(panels: &mut Panels, shape: &Shape, finishes: &Finishes, side: f64) {
    let stations = shape.stations();
    let rows = side_rows(shape, &stations, side);
    let [front, back] = shape.door;
    let of = |row: usize, column: usize| {
        let z = 0.5 * (rows[2][column].z + rows[2][column + 1].z);
        let is_door = side > 0.0 && z < front && z > back && row > 0;
        let finish = if row == 0 { finishes.plastic } else { finishes.paint };
        Some((if is_door { Hung::Door } else { Hung::Body }, finish))
    };
    panels.cells(&rows, of);
    // The inner side of what is beside the seats, but for the driver's door.
    let lining: Vec<Vec<DVec3>> = [1, 3, 4].map(|row| inner(&rows[row], side)).to_vec();
    let of = |_: usize, column: usize| {
        let z = 0.5 * (lining[1][column].z + lining[1][column + 1].z);
        let is_door = side > 0.0 && z < front && z > back;
        let beside = z < shape.screen[0] && z > shape.rear[1] && !is_door;
        beside.then_some((Hung::Body, finishes.lining))
    };
    panels.cells(&lining, of);
}

/// Returns a row moved inwards, in the other order, as its inner side is seen.
fn inner(row: &[DVec3], side: f64) -> Vec<DVec3> {
    row.iter().rev().map(|p| *p - DVec3::X * THICK_M * side).collect()
}

/// Adds the inner side and the edges of the driver's door.
fn door_inside(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    let [front, back] = shape.door;
    let stations: Vec<[f64; 2]> = shape
        .stations()
        .into_iter()
        .filter(|s| s[0] < front + 1e-6 && s[0] > back - 1e-6)
        .collect();
    let outer = side_rows(shape, &stations, 1.0);
    let outer = &outer[1..];
    let lining: Vec<Vec<DVec3>> = outer.iter().map(|row| inner(row, 1.0)).collect();
    panels.cells(&lining, |_, _| Some((Hung::Door, finishes.lining)));
    let edges = panels.of(Hung::Door, finishes.trim);
    let last = outer.len() - 1;
    let count = outer[0].len() - 1;
    let deep = |p: DVec3| p - DVec3::X * THICK_M;
    for column in 0..count {
        // Below and above.
        let (a, b) = (outer[0][column], outer[0][column + 1]);
        edges.face(&[b, a, deep(a), deep(b)]);
        let (a, b) = (outer[last][column], outer[last][column + 1]);
        edges.face(&[a, b, deep(b), deep(a)]);
    }
    for row in 0..last {
        let (a, b) = (outer[row][0], outer[row + 1][0]);
        edges.face(&[a, b, deep(b), deep(a)]);
        let (a, b) = (outer[row][count], outer[row + 1][count]);
        edges.face(&[b, a, deep(a), deep(b)]);
    }
}

/// Adds the dark insides of the arches of a side.
fn wells(panels: &mut Panels, shape: &Shape, finishes: &Finishes, side: f64) {
    let stations = shape.stations();
    let solid = panels.of(Hung::Body, finishes.trim);
    for pair in stations.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let is_arch =
            |s: [f64; 2]| shape.axles.iter().any(|axle| (axle - s[0]).abs() < shape.wheel + 0.066);
        if !is_arch(a) || !is_arch(b) || (a[1] <= SILL_M && b[1] <= SILL_M) {
            continue;
        }
        let [outer_a, outer_b] = [a, b].map(|[z, y]| mirrored(shape.side(z, y), side));
        let [inner_a, inner_b] = [outer_a, outer_b].map(|p| DVec3::new(WELL_M * side, p.y, p.z));
        let mut face = [outer_a, inner_a, inner_b, outer_b];
        if side > 0.0 {
            face.reverse();
        }
        solid.face(&face);
    }
    for axle in shape.axles {
        let (radius, x) = (shape.wheel + 0.065, WELL_M * side);
        let mut wall =
            vec![DVec3::new(x, SILL_M, axle - radius), DVec3::new(x, SILL_M, axle + radius)];
        for step in 0..=6_u32 {
            let (sin, cos) = (std::f64::consts::PI * f64::from(step) / 6.0).sin_cos();
            wall.push(DVec3::new(x, shape.wheel + radius * sin, axle + radius * cos));
        }
        if side > 0.0 {
            wall.reverse();
        }
        solid.face(&wall);
    }
}

/// Adds the front or the back.
fn ends(panels: &mut Panels, shape: &Shape, finishes: &Finishes, sign: f64) {
    let rows = ROWS.map(|rise| {
        let mut row: Vec<DVec3> =
            COLUMNS.iter().map(|across| shape.end(sign, *across, rise)).collect();
        if sign < 0.0 {
            row.reverse();
        }
        row
    });
    panels.cells(&rows, |row, _| {
        Some((Hung::Body, if row == 0 { finishes.plastic } else { finishes.paint }))
    });
}

/// Adds bonnet or boot.
fn deck(panels: &mut Panels, shape: &Shape, finishes: &Finishes, sign: f64) {
    let (end, near) =
        if sign > 0.0 { (shape.front, shape.screen[0]) } else { (shape.back, shape.rear[1]) };
    let mut places: Vec<f64> = shape.stations().iter().map(|s| s[0]).collect();
    places.retain(|z| (*z - near) * sign > -1e-9);
    places.push(near);
    places.sort_by(|a, b| (b * sign).total_cmp(&(a * sign)));
    places.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    let mut rows: Vec<Vec<DVec3>> = Vec::new();
    for z in places {
        let is_end = (z - end).abs() < 1e-6;
        let row = COLUMNS.iter().map(|across| {
            if is_end { shape.end(sign, *across, 1.0) } else { shape.deck(z, *across) }
        });
        let mut row: Vec<DVec3> = row.collect();
        if sign < 0.0 {
            row.reverse();
        }
        rows.push(row);
    }
    if rows.len() > 1 && (shape.kind == CarKind::Saloon || sign > 0.0) {
        panels.cells(&rows, |_, _| Some((Hung::Body, finishes.paint)));
    }
}

/// Adds the floor, and the dark underside.
fn floor(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    let (wide, front, back) = (shape.half - 0.1, shape.front - 0.1, shape.back + 0.12);
    let plate = |y: f64, wide: f64, front: f64, back: f64| {
        [[-wide, front], [wide, front], [wide, back], [-wide, back]]
            .map(|[x, z]| DVec3::new(x, y, z))
    };
    let mut under = Solid::default();
    let mut face = plate(SILL_M, wide, front, back);
    face.reverse();
    under.face(&face);
    panels.of(Hung::Body, finishes.trim).join(&under);
    let inside = plate(FLOOR_M, wide + 0.04, shape.screen[0], shape.rear[1]);
    panels.of(Hung::Body, finishes.lining).face(&inside);
}
