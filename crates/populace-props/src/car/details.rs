//! Lamps, grille, plates, handles, mirrors and gaps.

use glam::{DAffine3, DVec3};

use super::shape::{CarKind, SILL_M, Shape};
use super::{Finishes, Hung, Panels};
use crate::build::{Builder, Finish, Solid, bevelled, block};

/// Distance in metres of flat details from the body.
const PROUD_M: f64 = 0.018;

pub(super) fn build(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    front(panels, shape, finishes);
    back(panels, shape, finishes);
    for side in [1.0, -1.0] {
        gaps(panels, shape, finishes, side);
        handles(panels, shape, finishes, side);
        mirror(panels, shape, finishes, side);
    }
}

/// Adds a piece on front or back that stands out a little, with edges down to the body.
fn patch(
    panels: &mut Panels,
    shape: &Shape,
    finish: Finish,
    sign: f64,
    [l, r]: [f64; 2],
    [d, u]: [f64; 2],
) {
    let steps = if r - l > 0.5 { 4 } else { 2 };
    let mut solid = Solid::default();
    let at = |k: u32, rise: f64, out: f64| {
        let across = l + (r - l) * f64::from(k) / f64::from(steps);
        shape.end(sign, across, rise) + DVec3::Z * sign * out
    };
    let mut quad = |mut corners: [DVec3; 4]| {
        if sign < 0.0 {
            corners.reverse();
        }
        solid.face(&corners);
    };
    let out = PROUD_M;
    for k in 0..steps {
        let n = k + 1;
        // The body is not straight between its rows, so patches have a row in their middle.
        let m = 0.5 * (d + u);
        quad([at(k, d, out), at(n, d, out), at(n, m, out), at(k, m, out)]);
        quad([at(k, m, out), at(n, m, out), at(n, u, out), at(k, u, out)]);
        quad([at(k, d, -0.03), at(n, d, -0.03), at(n, d, out), at(k, d, out)]);
        quad([at(k, u, out), at(n, u, out), at(n, u, -0.03), at(k, u, -0.03)]);
    }
    for (k, flipped) in [(0, true), (steps, false)] {
        let mut edge = [at(k, d, out), at(k, d, -0.03), at(k, u, -0.03), at(k, u, out)];
        if flipped {
            edge.reverse();
        }
        quad(edge);
    }
    panels.of(Hung::Body, finish).join(&solid);
}

/// Returns a span on one side, from its lower end.
fn span(side: f64, [near, far]: [f64; 2]) -> [f64; 2] {
    [(near * side).min(far * side), (near * side).max(far * side)]
}

fn front(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    let mut piece = |finish, across, rise| patch(panels, shape, finish, 1.0, across, rise);
    piece(finishes.trim, [-0.52, 0.52], [0.16, 0.36]);
    piece(finishes.trim, [-0.4, 0.4], [0.66, 0.82]);
    piece(finishes.plate, [-0.27, 0.27], [0.44, 0.58]);
    for side in [-1.0, 1.0] {
        let span = |near: f64, far: f64| span(side, [near, far]);
        piece(finishes.trim, span(0.5, 0.97), [0.62, 0.86]);
        piece(finishes.turn, span(0.9, 0.985), [0.66, 0.82]);
    }
    for side in [-1.0, 1.0] {
        let span = |near: f64, far: f64| span(side, [near, far]);
        lamp(panels, shape, finishes.head, 1.0, span(0.54, 0.88), [0.65, 0.83]);
        lamp(panels, shape, finishes.head, 1.0, span(0.66, 0.8), [0.2, 0.32]);
    }
    lamp(panels, shape, finishes.chrome, 1.0, [-0.4, 0.4], [0.73, 0.76]);
}

/// Adds a piece that stands out farther than others, such as a lamp over its frame.
fn lamp(
    panels: &mut Panels,
    shape: &Shape,
    finish: Finish,
    sign: f64,
    across: [f64; 2],
    rise: [f64; 2],
) {
    let mut own = Panels::default();
    patch(&mut own, shape, finish, sign, across, rise);
    let solid = own.of(Hung::Body, finish);
    for point in &mut solid.points {
        point.z += sign * 0.008;
    }
    let solid = solid.clone();
    panels.of(Hung::Body, finish).join(&solid);
}

fn back(panels: &mut Panels, shape: &Shape, finishes: &Finishes) {
    let mut piece = |finish, across, rise| patch(panels, shape, finish, -1.0, across, rise);
    piece(finishes.plate, [-0.27, 0.27], [0.5, 0.64]);
    piece(finishes.trim, [-0.6, 0.6], [0.16, 0.28]);
    let lamps = match shape.kind {
        CarKind::Hatchback => ([0.62, 0.97], [0.68, 0.92]),
        CarKind::Saloon => ([0.5, 0.97], [0.68, 0.9]),
        CarKind::Van => ([0.8, 0.97], [0.55, 0.97]),
    };
    for side in [-1.0, 1.0] {
        let (across, rise) = lamps;
        piece(finishes.tail, span(side, across), rise);
    }
}

/// Adds the dark gaps around the doors, and a strip along them.
fn gaps(panels: &mut Panels, shape: &Shape, finishes: &Finishes, side: f64) {
    let [front, back] = shape.door;
    let mut places = vec![front + 0.006, back - 0.006];
    if shape.kind == CarKind::Saloon {
        places.push(-0.9);
    }
    let on = |z: f64, y: f64| {
        let at = shape.side(z, y);
        DVec3::new((at.x + 0.003) * side, at.y, at.z)
    };
    let solid = panels.of(Hung::Body, finishes.trim);
    for z in places {
        let low = SILL_M + 0.12;
        let rows = 3;
        for row in 0..rows {
            let y = |r: u32| low + (shape.belt(z) - low) * f64::from(r) / f64::from(rows);
            let (d, u) = (y(row), y(row + 1));
            let mut face = [on(z + 0.005, d), on(z - 0.005, d), on(z - 0.005, u), on(z + 0.005, u)];
            if side < 0.0 {
                face.reverse();
            }
            solid.face(&face);
        }
    }
}

fn handles(panels: &mut Panels, shape: &Shape, finishes: &Finishes, side: f64) {
    let mut places = vec![shape.handle()];
    if shape.kind == CarKind::Saloon {
        let z = -0.78;
        places.push(shape.side(z, shape.belt(z) - 0.14) + DVec3::X * 0.03);
    }
    for (nth, at) in places.into_iter().enumerate() {
        let hung = if side > 0.0 && nth == 0 { Hung::Door } else { Hung::Body };
        let bar = block([-0.012, -0.014, -0.085], [0.012, 0.014, 0.085]);
        let foot = block([-0.04, -0.012, -0.012], [0.0, 0.012, 0.012]);
        let place = |z: f64| {
            let at = DVec3::new(at.x * side, at.y, at.z + z);
            let flip = DVec3::new(side, 1.0, 1.0);
            DAffine3::from_translation(at) * DAffine3::from_scale(flip)
        };
        panels.of(hung, finishes.chrome).join(&bar.moved(&place(0.0)));
        for z in [-0.07, 0.07] {
            panels.of(hung, finishes.chrome).join(&foot.moved(&place(z)));
        }
    }
}

fn mirror(panels: &mut Panels, shape: &Shape, finishes: &Finishes, side: f64) {
    let hung = if side > 0.0 { Hung::Door } else { Hung::Body };
    let z = shape.door[0] - 0.13;
    let foot = shape.side(z, shape.belt(z));
    let at = DVec3::new((foot.x + 0.02) * side, foot.y + 0.07, z);
    let flip = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::new(side, 1.0, 1.0));
    let case = bevelled([0.03, -0.065, -0.05], [0.23, 0.085, 0.06], 0.03);
    panels.of(hung, finishes.paint).join(&case.moved(&flip));
    let arm = block([-0.05, -0.06, -0.03], [0.06, -0.02, 0.03]);
    panels.of(hung, finishes.trim).join(&arm.moved(&flip));
    let glass = crate::build::plate(&[
        [0.2, -0.04, -0.052],
        [0.06, -0.04, -0.052],
        [0.06, 0.06, -0.052],
        [0.2, 0.06, -0.052],
    ]);
    panels.of(hung, finishes.mirror).join(&glass.moved(&flip));
}

/// Adds the soft shadow under the car, which keeps most of the sky's light from the ground.
pub(super) fn shadow(b: &mut Builder, shape: &Shape, finishes: &Finishes) {
    let (x, y) = (shape.half, 0.012);
    let ring = |grow: f64| {
        let (x, front, back) = (x + grow, shape.front + grow, shape.back - grow);
        [[-x, front], [x, front], [x, back], [-x, back]].map(|[x, z]| DVec3::new(x, y, z))
    };
    let (inner, outer) = (ring(-0.3), ring(0.22));
    let mut solid = Solid::default();
    solid.face(&inner);
    for k in 0..4 {
        let next = (k + 1) % 4;
        solid.face(&[outer[k], outer[next], inner[next], inner[k]]);
    }
    let is_inner = |p: DVec3| p.x.abs() < x;
    b.on(finishes.shadow)
        .colored(&solid, 0.5, |p| [1.0, 1.0, 1.0, if is_inner(p) { 0.62 } else { 0.0 }]);
}
