//! Surface of the eyes: eyeballs, lids with lashes, and brows.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::skull::{EYE_Y, Skull};
use super::{Cover, Paint, Region, Surface};
use crate::anatomy::{HEAD, Side};

/// Distance of the eyes from the middle of the face, in units of the head's height.
const EYE_X: f64 = 0.136;
/// Radius of an eyeball.
const RADIUS: f64 = 0.078;
/// Points around an eyeball.
const AROUND: usize = 10;
/// Cross-sections of a lid.
const LID_STATIONS: usize = 6;
/// Half angle between the corners of an eye, seen from its centre, in degrees.
const CORNER_DEG: f64 = 58.0;

const WHITE: Paint = [0.74, 0.71, 0.68];
const PUPIL: Paint = [0.008, 0.007, 0.007];
const LASH: Paint = [0.10, 0.075, 0.07];

pub(super) fn build(surface: &mut Surface, skull: Skull<'_>, side: Side) {
    let eye = Eye::new(skull, side);
    eye.ball(surface);
    eye.upper_lid(surface);
    eye.lower_lid(surface);
    eye.brow(surface);
}

struct Eye<'a> {
    skull: Skull<'a>,
    side: Side,
    center: DVec3,
    radius: f64,
}

impl<'a> Eye<'a> {
    fn new(skull: Skull<'a>, side: Side) -> Self {
        let radius = RADIUS * skull.body.look.face.eyes;
        let socket = skull.face_at(EYE_X, EYE_Y);
        let center = DVec3::new(EYE_X, EYE_Y, socket.z + 0.034 - radius);
        Self { skull, side, center, radius }
    }

    /// Adds a point of the left eye, or its mirror image.
    fn point(&self, surface: &mut Surface, p: DVec3, paint: Paint) -> usize {
        surface.brush = paint;
        let p = DVec3::new(p.x * self.side.sign(), p.y, p.z);
        let point = surface.point(self.skull.in_model(p), vec![(HEAD, 1.0)]);
        surface.brush = super::PLAIN;
        point
    }

    /// Returns a point at a distance from the centre, in units of the radius. The angles, in
    /// degrees, go outwards and upwards.
    fn around(&self, outward_deg: f64, up_deg: f64, distance: f64) -> DVec3 {
        let (sin_a, cos_a) = (outward_deg * PI / 180.0).sin_cos();
        let (sin_b, cos_b) = (up_deg * PI / 180.0).sin_cos();
        self.center + DVec3::new(sin_a * cos_b, sin_b, cos_a * cos_b) * self.radius * distance
    }

    /// Adds the eyeball: rings around the line of sight, from behind to the pupil. Rings are
    /// doubled at the borders of iris and pupil, which are sharp.
    fn ball(&self, surface: &mut Surface) {
        let iris = self.skull.body.look.face.iris.map(f64::from);
        let rim = iris.map(|c| 0.45 * c);
        let rows: [(f64, Paint, Paint); 4] =
            [(80.0, WHITE, WHITE), (33.0, WHITE, rim), (27.0, iris, iris), (14.0, iris, PUPIL)];
        surface.shell(|surface| {
            let mut below: Vec<usize> = Vec::new();
            for (index, (degrees, outer, inner)) in rows.into_iter().enumerate() {
                let outside = self.ring(surface, degrees, outer);
                if index == 0 {
                    surface.close(&outside, Region::Eyes, true);
                } else {
                    surface.bridge(&below, &outside, Region::Eyes, false);
                }
                let sharp = outer != inner;
                below = if sharp { self.ring(surface, degrees, inner) } else { outside };
            }
            let pupil = self.point(surface, self.center + DVec3::Z * self.radius, PUPIL);
            surface.cap(&below, pupil, Region::Eyes, false);
        });
        self.glint(surface);
    }

    /// Adds a ring of the eyeball at an angle to the line of sight.
    fn ring(&self, surface: &mut Surface, degrees: f64, paint: Paint) -> Vec<usize> {
        let (sin, cos) = (degrees * PI / 180.0).sin_cos();
        let point = |k: usize| {
            let (s, c) = (TAU * k as f64 / AROUND as f64).sin_cos();
            let p = self.center + DVec3::new(s * sin, c * sin, cos) * self.radius;
            self.point(surface, p, paint)
        };
        (0..AROUND).map(point).collect()
    }

    /// Adds the reflection of the sky on the cornea, on the same side of both eyes.
    fn glint(&self, surface: &mut Surface) {
        let spot =
            |out: f64, up: f64, far: f64| self.around(self.side.sign() * 9.0 + out, 11.0 + up, far);
        let ring: Vec<usize> = [(-5.0, 0.0), (0.0, 5.5), (5.0, 0.0), (0.0, -5.5)]
            .into_iter()
            .map(|(out, up)| self.point(surface, spot(out, up, 1.01), super::PLAIN))
            .collect();
        let front = self.point(surface, spot(0.0, 0.0, 1.035), super::PLAIN);
        let back = self.point(surface, spot(0.0, 0.0, 0.9), super::PLAIN);
        surface.shell(|surface| {
            surface.cap(&ring, front, Region::Eyes, false);
            surface.cap(&ring, back, Region::Eyes, true);
        });
    }

    /// Returns the angle outwards at a station of a lid, and how far the eye is open there, from 0
    /// at the corners to 1.
    fn station(at: usize) -> (f64, f64) {
        let t = 2.0 * at as f64 / (LID_STATIONS - 1) as f64 - 1.0;
        (CORNER_DEG * t, (1.0 - t * t).powf(0.62))
    }

    fn upper_lid(&self, surface: &mut Surface) {
        let face = &self.skull.body.look.face;
        let skin = [0.94, 0.90, 0.89];
        let rings: Vec<Vec<usize>> = (0..LID_STATIONS)
            .map(|at| {
                let (out, open) = Self::station(at);
                // The outer corner is a little higher than the inner one.
                let low = 2.0 + 0.03 * out + (24.0 * face.open) * open;
                let crease = low + 12.0 + 22.0 * open;
                let lash = 0.05 + 0.10 * face.lashes * (0.4 + 0.6 * (out / CORNER_DEG).max(0.0));
                let rows = [
                    (crease, 1.02, skin),
                    (low + 6.0 + 8.0 * open, 1.13, skin),
                    (low + 1.5, 1.12, LASH),
                    (low + 0.5 + 60.0 * lash * 0.2, 1.12 + lash, LASH),
                    (low - 2.0, 1.05, LASH),
                    (low + 6.0, 0.92, LASH),
                ];
                rows.into_iter()
                    .map(|(up, far, paint)| self.point(surface, self.around(out, up, far), paint))
                    .collect()
            })
            .collect();
        surface.tube(&rings, Region::Skin);
    }

    fn lower_lid(&self, surface: &mut Surface) {
        let face = &self.skull.body.look.face;
        let skin = [0.97, 0.91, 0.90];
        let rings: Vec<Vec<usize>> = (0..LID_STATIONS)
            .map(|at| {
                let (out, open) = Self::station(at);
                let high = 2.0 + 0.03 * out - 19.0 * face.open * open;
                let rows = [
                    (high + 1.0, 0.92, [0.7, 0.5, 0.48]),
                    (high + 1.0, 1.05, [0.72, 0.50, 0.48]),
                    (high - 3.0, 1.075, skin),
                    (high - 12.0 - 8.0 * open, 1.03, skin),
                    (high - 18.0 - 12.0 * open, 0.90, skin),
                ];
                rows.into_iter()
                    .map(|(up, far, paint)| self.point(surface, self.around(out, up, far), paint))
                    .collect()
            })
            .collect();
        surface.tube(&rings, Region::Skin);
    }

    /// Adds the brow: an arch from above the inner corner of the eye to its outer corner, in the
    /// colour of the hair.
    fn brow(&self, surface: &mut Surface) {
        let face = &self.skull.body.look.face;
        let arch = [
            (0.054, 0.608, 0.50),
            (0.090, 0.614, 1.0),
            (0.145, 0.624, 1.0),
            (0.200, 0.617, 0.75),
            (0.246, 0.592, 0.20),
        ];
        let half = 0.019 * face.brow;
        let rings: Vec<Vec<usize>> = arch
            .into_iter()
            .map(|(x, y, thick)| {
                let half = half * thick;
                let spots = [(half, -0.004), (0.1 * half, 0.014), (-half, -0.004)];
                spots
                    .into_iter()
                    .map(|(up, out)| {
                        let on = self.skull.face_at(x, y + up);
                        self.point(surface, on + DVec3::Z * out, super::PLAIN)
                    })
                    .collect()
            })
            .collect();
        let cover: Cover = Region::Hair.into();
        surface.tube(&rings, cover);
    }
}
