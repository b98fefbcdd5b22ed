//! Surface of what people wear besides clothes: headscarves, hats and glasses.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::hair::{AROUND, Shape, dome, shape};
use super::skull::{EYE_Y, Skull};
use super::{Region, Surface};
use crate::anatomy::{HEAD, NECK, SPINE};
use crate::{Glasses, Hair, Hat};

pub(super) use super::bags::bag;

/// Returns a scarf over the hair, which leaves the face free and covers the neck.
pub(super) fn headscarf(skull: Skull<'_>) -> Surface {
    let mut surface = Surface::default();
    dome(&mut surface, skull, &shape(Hair::Headscarf), Region::Accessory);
    // Folds around throat and neck, down to the shoulders.
    let rows = [
        (0.06, -0.04, 0.19, 0.10, 0.20),
        (0.03, 0.02, 0.29, 0.36, 0.33),
        (-0.08, -0.01, 0.33, 0.30, 0.40),
        (-0.22, -0.08, 0.36, 0.27, 0.41),
        (-0.34, -0.15, 0.50, 0.33, 0.46),
        (-0.38, -0.24, 0.46, 0.20, 0.40),
    ];
    let rings: Vec<Vec<usize>> = rows
        .into_iter()
        .enumerate()
        .map(|(row, (before, behind, breadth, front, back))| {
            let ring = (0..AROUND).map(|j| {
                let angle = TAU * j as f64 / AROUND as f64;
                let (sin, cos) = angle.sin_cos();
                let fold = 1.0 + 0.03 * (3.0 * angle + 1.9 * row as f64).sin();
                let depth = if cos > 0.0 { front } else { back };
                let y = behind + (before - behind) * (0.5 + 0.5 * cos);
                let p = DVec3::new(breadth * sin * fold, y, depth * cos * fold);
                let down = super::smooth(0.02, -0.22, y - 0.1 * (1.0 - cos));
                let weights = vec![
                    (HEAD, (1.0 - down) * 0.7),
                    (NECK[0], (1.0 - down) * 0.3 + 0.4 * down * (1.0 - down)),
                    (SPINE[3], down),
                ];
                surface.brush = [0.86 + 0.14 * fold.mul_add(10.0, -9.5).clamp(0.0, 1.0); 3];
                surface.point(skull.in_model(p), weights)
            });
            ring.collect()
        })
        .collect();
    surface.brush = super::PLAIN;
    surface.tube(&rings, Region::Accessory);
    surface
}

/// Returns a hat, which is worn over flat hair.
pub(super) fn hat(skull: Skull<'_>, hat: Hat) -> Surface {
    let mut surface = Surface::default();
    let thick = |_: f64, s: f64| 0.114 - 0.026 * s;
    let flat = |edge: f64, slope: f64| {
        std::array::from_fn(|j| edge - slope * (1.0 - (PI * j as f64 / 12.0).cos()))
    };
    match hat {
        Hat::Cap => {
            let shape =
                Shape { edge: flat(0.72, 0.06), thick, hangs: false, smooth: true, rough: 0.0 };
            dome(&mut surface, skull, &shape, Region::Accessory);
            visor(&mut surface, skull);
        }
        Hat::Beanie => {
            let edge = flat(0.70, 0.10);
            let shape = Shape {
                edge,
                thick: |_, s| 0.122 - 0.03 * s,
                hangs: false,
                smooth: true,
                rough: 0.004,
            };
            dome(&mut surface, skull, &shape, Region::Accessory);
            let cuff = [(0.67, 0.05), (0.675, 0.098), (0.79, 0.108)];
            hoop(&mut surface, skull, &cuff, 0.20, 0.80);
        }
        Hat::SunHat => {
            let shape = Shape {
                edge: flat(0.74, 0.03),
                thick: |_, s| 0.128 - 0.012 * s,
                hangs: false,
                smooth: true,
                rough: 0.0,
            };
            dome(&mut surface, skull, &shape, Region::Accessory);
            let brim = [(0.70, 0.04), (0.66, 0.37), (0.755, 0.07)];
            hoop(&mut surface, skull, &brim, 0.06, 1.0);
        }
    }
    surface
}

/// Adds a band around the head: heights in front and distances of its cross-section. It is lower
/// behind, by `slope`.
fn hoop(surface: &mut Surface, skull: Skull<'_>, section: &[(f64, f64)], slope: f64, paint: f64) {
    surface.brush = [paint; 3];
    let rings: Vec<Vec<usize>> = (0..AROUND)
        .map(|j| {
            let angle = TAU * j as f64 / AROUND as f64;
            let lower = 0.5 * slope * (1.0 - angle.cos());
            let place = |&(y, off): &(f64, f64)| {
                let base = skull.at_height((y - lower).max(0.55), angle.min(TAU - angle));
                let (sin, cos) = angle.sin_cos();
                let side = if sin < 0.0 { -1.0 } else { 1.0 };
                let p = DVec3::new(base.x * side + sin * off, y - lower, base.z + cos * off);
                surface.point(skull.in_model(p), vec![(HEAD, 1.0)])
            };
            section.iter().map(place).collect()
        })
        .collect();
    surface.brush = super::PLAIN;
    surface.shell(|surface| {
        for j in 0..AROUND {
            surface.bridge(&rings[j], &rings[(j + 1) % AROUND], Region::Accessory, false);
        }
    });
}

/// Adds the visor of a cap.
fn visor(surface: &mut Surface, skull: Skull<'_>) {
    surface.brush = [0.72; 3];
    let half = 70.0_f64;
    let stations = 8;
    let rings: Vec<Vec<usize>> = (0..=stations)
        .map(|k| {
            let t = 2.0 * f64::from(k) / f64::from(stations) - 1.0;
            let angle = t * half * PI / 180.0;
            let root = skull.at_height(0.72, angle.abs());
            let side = if t < 0.0 { -1.0 } else { 1.0 };
            let [x, z] = [(root.x + 0.05 * angle.sin().abs()) * side, root.z + 0.04];
            let long = 0.03 + 0.25 * (1.0 - t.powi(4)).max(0.0).sqrt();
            let arch = 0.055 * t * t;
            let spots = [
                (0.0, 0.735),
                (0.55 * long, 0.725),
                (long, 0.685),
                (0.5 * long, 0.70),
                (0.0, 0.70),
            ];
            spots
                .into_iter()
                .map(|(out, y)| {
                    let p = DVec3::new(x * (1.0 - 0.10 * out), y - arch, z + out);
                    surface.point(skull.in_model(p), vec![(HEAD, 1.0)])
                })
                .collect()
        })
        .collect();
    surface.brush = super::PLAIN;
    surface.tube(&rings, Region::Accessory);
}

/// Returns glasses: rims or dark lenses, a bridge and temples.
pub(super) fn glasses(skull: Skull<'_>, glasses: Glasses) -> Surface {
    let mut surface = Surface::default();
    let x = 0.140;
    let z = skull.face_at(0.03, EYE_Y + 0.02).z.max(0.42) + 0.018;
    let back = skull.at_height(0.50, 95_f64.to_radians());
    for side in [-1.0, 1.0] {
        let spot = |x: f64, y: f64, z: f64| DVec3::new(x * side, y, z);
        lens(&mut surface, skull, glasses, |u, v, w| {
            // Lenses lean back at their outer side.
            spot(x + u, EYE_Y - 0.004 + v, z - 0.35 * u.max(0.0) + w)
        });
        let hinge = spot(0.33, 0.51, z - 0.12);
        let end = spot(back.x + 0.022, 0.51, back.z - 0.02);
        rod(&mut surface, skull, &[spot(0.225, 0.505, z - 0.03), hinge, end], 0.011);
    }
    let bridge = |side: f64| DVec3::new(side * 0.062, EYE_Y + 0.015, z + 0.004);
    rod(&mut surface, skull, &[bridge(-1.0), bridge(1.0)], 0.010);
    surface
}

/// Adds a rim with the outline of its glasses, or a lens for sunglasses.
fn lens(
    surface: &mut Surface,
    skull: Skull<'_>,
    glasses: Glasses,
    place: impl Fn(f64, f64, f64) -> DVec3,
) {
    let points = 12;
    let outline = |k: usize, scale: f64| {
        let (sin, cos) = (TAU * (k as f64 + 0.5) / points as f64).sin_cos();
        let power = if glasses == Glasses::Round { 1.0 } else { 0.55 };
        let bent = |v: f64| v.signum() * v.abs().powf(power);
        let [breadth, height] = match glasses {
            Glasses::Round => [0.086, 0.086],
            Glasses::Square => [0.088, 0.066],
            Glasses::Sun => [0.094, 0.076],
        };
        [bent(sin) * breadth * scale, bent(cos) * height * scale]
    };
    let ring = |surface: &mut Surface, scale: f64, w: f64| -> Vec<usize> {
        (0..points)
            .map(|k| {
                let [u, v] = outline(k, scale);
                surface.point(skull.in_model(place(u, v, w)), vec![(HEAD, 1.0)])
            })
            .collect()
    };
    if glasses == Glasses::Sun {
        let rings =
            [ring(surface, 0.97, -0.012), ring(surface, 1.0, 0.006), ring(surface, 0.8, 0.016)];
        surface.tube(&rings, Region::Accessory);
        return;
    }
    let rings =
        [ring(surface, 1.07, -0.008), ring(surface, 0.99, 0.014), ring(surface, 0.90, -0.008)];
    surface.shell(|surface| {
        for at in 0..rings.len() {
            surface.bridge(&rings[at], &rings[(at + 1) % rings.len()], Region::Accessory, false);
        }
    });
}

/// Adds a thin rod with four edges along a path.
fn rod(surface: &mut Surface, skull: Skull<'_>, path: &[DVec3], half: f64) {
    let last = path.len() - 1;
    let rings: Vec<Vec<usize>> = (0..path.len())
        .map(|at| {
            let along = path[(at + 1).min(last)] - path[at.saturating_sub(1)];
            let side = along.cross(DVec3::Y).normalize();
            let corners = [DVec3::Y, side, DVec3::NEG_Y, -side].map(|v| path[at] + v * half);
            corners.map(|p| surface.point(skull.in_model(p), vec![(HEAD, 1.0)])).to_vec()
        })
        .collect();
    surface.tube(&rings, Region::Accessory);
}
