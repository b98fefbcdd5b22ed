//! Surface of collars and hoods: shells around the base of the neck.

use std::f64::consts::PI;

use glam::DVec3;

use super::covers::Covers;
use super::trunk::{self, AROUND, COLLAR};
use super::{Cover, Surface, smooth};
use crate::Top;
use crate::anatomy::Body;

/// Offsets outwards and upwards of the points of a cross-section, as fractions of the body's
/// height.
type Section = Vec<[f64; 2]>;

/// Adds the collar of the person's top.
pub(super) fn build(surface: &mut Surface, body: &Body, covers: &Covers) {
    match body.look.top {
        Top::Tee | Top::Striped | Top::Blouse => {
            let rib =
                |_: f64| vec![[-0.006, -0.004], [0.004, -0.003], [0.003, 0.005], [-0.003, 0.006]];
            ring(surface, body, covers.shirt, rib);
        }
        Top::Sweater => ring(surface, body, covers.shirt, |_| {
            vec![[-0.006, -0.004], [0.007, -0.004], [0.005, 0.014], [0.0, 0.017], [-0.007, 0.013]]
        }),
        Top::Shirt => open(surface, body, covers.shirt, [9.0, 0.020], folded),
        Top::Jacket => {
            open(surface, body, covers.sleeve, [26.0, 0.055], |front| {
                let mut section = folded(front);
                section.iter_mut().for_each(|p| p[0] += 0.006);
                section
            });
        }
        Top::Hoodie => open(surface, body, covers.shirt, [14.0, 0.012], |front| {
            let back = 1.0 - front;
            let section =
                [[-0.004, 0.0], [0.0, 0.016], [0.014, 0.022], [0.022, 0.010], [0.012, -0.008]];
            let size = 0.75 + 0.9 * back;
            section
                .map(|[out, up]| [out * size * (1.0 + 0.4 * back), up * size - 0.008 * back])
                .into()
        }),
    }
}

/// Returns the cross-section of a collar that is folded over; `front` is 1 in front and 0 behind.
fn folded(front: f64) -> Section {
    let tall = 1.0 - 0.35 * front;
    vec![
        [-0.008, -0.006],
        [-0.003, 0.018 * tall],
        [0.003, 0.019 * tall],
        [0.013 + 0.004 * front, -0.008 - 0.004 * front],
        [0.009, -0.009],
    ]
}

/// Returns the point of a cross-section at an angle from the front, in degrees.
fn place(body: &Body, degrees: f64, [out, up]: [f64; 2]) -> DVec3 {
    let at = degrees.rem_euclid(360.0) / 360.0 * AROUND as f64;
    let low = (0..AROUND).rfind(|&j| j as f64 <= at).unwrap_or(0);
    let on = |j: usize| trunk::position(body, COLLAR, j % AROUND);
    let p = on(low).lerp(on(low + 1), at - low as f64);
    let away = DVec3::new(p.x, 0.0, p.z + 0.012 * body.height).normalize();
    p + (away * out + DVec3::Y * up) * body.height
}

fn add(surface: &mut Surface, body: &Body, degrees: f64, section: &Section) -> Vec<usize> {
    let j = (degrees.rem_euclid(360.0) / 360.0 * AROUND as f64).round();
    let column = (0..AROUND).find(|&c| c as f64 >= j).unwrap_or(0);
    section
        .iter()
        .map(|&offset| {
            let weights = trunk::weights(COLLAR, column);
            surface.point(place(body, degrees, offset), weights)
        })
        .collect()
}

fn front(degrees: f64) -> f64 {
    0.5 + 0.5 * (degrees * PI / 180.0).cos()
}

/// Adds a closed ring around the neck.
fn ring(surface: &mut Surface, body: &Body, cover: Cover, section: impl Fn(f64) -> Section) {
    let stations = 12;
    surface.brush = cover.paint;
    let rings: Vec<Vec<usize>> = (0..stations)
        .map(|k| {
            let degrees = 360.0 * f64::from(k) / f64::from(stations);
            add(surface, body, degrees, &section(front(degrees)))
        })
        .collect();
    surface.brush = super::PLAIN;
    surface.shell(|surface| {
        for k in 0..rings.len() {
            surface.bridge(&rings[k], &rings[(k + 1) % rings.len()], cover, false);
        }
    });
}

/// Adds a collar that is open in front, by an angle to each side in degrees. Its ends hang down by
/// a fraction of the body's height.
fn open(
    surface: &mut Surface,
    body: &Body,
    cover: Cover,
    [gap, drop]: [f64; 2],
    section: impl Fn(f64) -> Section,
) {
    let stations = 10;
    surface.brush = cover.paint.map(|c| 0.92 * c);
    let rings: Vec<Vec<usize>> = (0..=stations)
        .map(|k| {
            let degrees = gap + (360.0 - 2.0 * gap) * f64::from(k) / f64::from(stations);
            let ring = add(surface, body, degrees, &section(front(degrees)));
            let end = smooth(45.0, 0.0, degrees.min(360.0 - degrees) - gap);
            for (at, &point) in ring.iter().enumerate() {
                // The outer edge of the ends comes to a point on the chest.
                let low = if at >= 3 { 1.0 } else { 0.35 };
                let down = end * drop * low * body.height;
                surface.points[point] += DVec3::new(0.0, -down, 0.54 * down);
            }
            ring
        })
        .collect();
    surface.brush = super::PLAIN;
    surface.tube(&rings, cover);
}
