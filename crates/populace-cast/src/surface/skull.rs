//! Shape of neck and head, in units of the head's height from the chin (y = 0) to the crown
//! (y = 1); x to the left of the body, z to the front from the head's axis.

use glam::DVec3;

use super::{Weights, chain, smooth};
use crate::Face;
use crate::anatomy::{Body, HEAD, NECK, SPINE};

/// Height in front and behind, half breadth, depth in front and behind, and narrowing of the front
/// as a fraction of the breadth, from the base of the neck to the crown.
const PROFILE: [[f64; 6]; 22] = [
    [-0.360, -0.260, 0.255, 0.070, 0.300, 0.00],
    [-0.235, -0.110, 0.220, 0.120, 0.285, 0.00],
    [-0.125, 0.005, 0.208, 0.160, 0.272, 0.00],
    [-0.040, 0.090, 0.216, 0.195, 0.280, 0.02],
    [-0.018, 0.130, 0.240, 0.330, 0.295, 0.20],
    [0.020, 0.160, 0.252, 0.382, 0.310, 0.27],
    [0.060, 0.190, 0.262, 0.396, 0.330, 0.23],
    [0.105, 0.220, 0.276, 0.396, 0.355, 0.15],
    [0.162, 0.260, 0.290, 0.404, 0.375, 0.09],
    [0.226, 0.335, 0.308, 0.412, 0.405, 0.05],
    [0.285, 0.375, 0.319, 0.417, 0.418, 0.03],
    [0.345, 0.410, 0.327, 0.420, 0.428, 0.02],
    [0.430, 0.470, 0.335, 0.418, 0.440, 0.01],
    [0.500, 0.520, 0.341, 0.418, 0.447, 0.00],
    [0.565, 0.570, 0.343, 0.424, 0.450, 0.00],
    [0.620, 0.622, 0.340, 0.424, 0.450, 0.00],
    [0.700, 0.700, 0.329, 0.408, 0.442, 0.00],
    [0.790, 0.790, 0.300, 0.366, 0.414, 0.00],
    [0.870, 0.870, 0.258, 0.312, 0.362, 0.00],
    [0.935, 0.935, 0.205, 0.243, 0.288, 0.00],
    [0.978, 0.978, 0.135, 0.155, 0.190, 0.00],
    [0.997, 0.997, 0.055, 0.062, 0.078, 0.00],
];

/// Height of the middle of the eyes.
pub(super) const EYE_Y: f64 = 0.485;
/// Height of the line between the lips.
const MOUTH_Y: f64 = 0.196;
/// Distance of the corners of the mouth from the middle.
const MOUTH_X: f64 = 0.100;

/// Head of a body.
#[derive(Clone, Copy)]
pub(super) struct Skull<'a> {
    pub(super) body: &'a Body,
}

impl Skull<'_> {
    /// Returns a point in model space, in metres.
    pub(super) fn in_model(self, p: DVec3) -> DVec3 {
        let body = self.body;
        DVec3::new(0.0, body.chin_y, 0.008 * body.height) + p * body.head
    }

    /// Returns the point of the smooth head, without a face, at `row` of [`PROFILE`] and the angle
    /// from the front in radians.
    fn smooth_at(self, row: f64, angle: f64) -> DVec3 {
        let [before, behind, breadth, front, back, narrow] = profile(row);
        let (sin, cos) = angle.sin_cos();
        let face = &self.body.look.face;
        // The jaw is broad or slender; the skull and the neck are not.
        let jaw = 1.0 + (face.jaw - 1.0) * smooth(3.0, 5.0, row) * (1.0 - smooth(10.0, 14.0, row));
        let limbs = self.body.look.limbs;
        let neck = 1.0 + 0.45 * (limbs - 1.0) * (1.0 - smooth(2.0, 4.5, row));
        let y = behind + (before - behind) * (0.5 + 0.5 * cos);
        let x = breadth * jaw * neck * sin * (1.0 - narrow * cos.max(0.0));
        let z = if cos > 0.0 { front * cos.powf(0.85) } else { -back * neck * (-cos).powf(0.9) };
        DVec3::new(x, y, z)
    }

    /// Returns the point of the head at `row` of [`PROFILE`] and the angle from the front in
    /// radians.
    pub(super) fn at(self, row: f64, angle: f64) -> DVec3 {
        let mut p = self.smooth_at(row, angle);
        if angle.cos() > 0.0 && row > 3.0 && row < 17.0 {
            p = self.with_mouth(p);
            p.z += relief(&self.body.look.face, p.x.abs(), p.y);
        }
        p
    }

    /// Returns the point of the head at a height and an angle from the front in radians.
    pub(super) fn at_height(self, y: f64, angle: f64) -> DVec3 {
        let (mut low, mut high) = (0.0, (PROFILE.len() - 1) as f64);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if self.smooth_at(middle, angle).y < y { low = middle } else { high = middle }
        }
        self.smooth_at(low, angle)
    }

    /// Returns the point of the face before (`x`, `y`).
    pub(super) fn face_at(self, x: f64, y: f64) -> DVec3 {
        let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if self.at_height(y, middle).x < x.abs() { low = middle } else { high = middle }
        }
        let z = self.at_height(y, low).z + relief(&self.body.look.face, x.abs(), y);
        DVec3::new(x, y, z)
    }

    /// Bends the rows of the lips together at the corners of the mouth, which smile.
    fn with_mouth(self, p: DVec3) -> DVec3 {
        let face = &self.body.look.face;
        let off = p.y - MOUTH_Y;
        let near = 1.0 - smooth(0.04, 0.075, off.abs());
        let out = p.x.abs() / MOUTH_X;
        let pull = 0.85 * smooth(0.25, 1.0, out) * (1.0 - 0.8 * smooth(1.0, 1.5, out)) * near;
        let smile =
            0.020 * face.smile * smooth(0.3, 1.0, out) * (1.0 - smooth(1.0, 1.9, out)) * near;
        DVec3::new(p.x, p.y - pull * off + smile, p.z)
    }

    /// Returns the weights at a point of head, neck or hair.
    pub(super) fn weights(self, p: DVec3) -> Weights {
        // The chin is at the height of the nape, and belongs to the head.
        let at = p.y + 0.2 * smooth(0.15, 0.3, p.z);
        let bounds = [(-0.22, 0.16), (-0.06, 0.13), (0.10, 0.13)];
        chain(at, &[SPINE[3], NECK[0], NECK[1], HEAD], &bounds)
    }
}

/// Returns the interpolated row of the profile.
fn profile(row: f64) -> [f64; 6] {
    let last = PROFILE.len() - 1;
    let at = row.clamp(0.0, last as f64);
    let low = (0..last).rfind(|&r| r as f64 <= at).unwrap_or(0);
    let t = at - low as f64;
    let [a, b, c, d] =
        [low.saturating_sub(1), low, low + 1, (low + 2).min(last)].map(|r| PROFILE[r]);
    // Catmull and Rom's spline.
    std::array::from_fn(|i| {
        let (p, q, r, s) = (a[i], b[i], c[i], d[i]);
        q + 0.5 * t * (r - p + t * (2.0 * p - 5.0 * q + 4.0 * r - s + t * (3.0 * (q - r) + s - p)))
    })
}

/// Returns the Gaussian bump of height 1 at `at`, with the widths `size`, for `x` >= 0.
fn bump(x: f64, y: f64, at: [f64; 2], size: [f64; 2]) -> f64 {
    (-((x - at[0]) / size[0]).powi(2) - ((y - at[1]) / size[1]).powi(2)).exp()
}

/// Returns how far the face stands out to the front at a distance from the middle and a height.
fn relief(face: &Face, x: f64, y: f64) -> f64 {
    let lips = face.lips;
    let brow = 0.5 + 0.5 * face.brow;
    nose(face, x, y) - 0.050 * bump(x, y, [0.135, EYE_Y - 0.002], [0.082, 0.062])
        + 0.016 * brow * bump(x, y, [0.13, 0.592], [0.10, 0.030])
        + 0.020 * bump(x, y, [0.205, 0.355], [0.075, 0.070])
        + 0.016 * bump(x, y, [0.0, 0.205], [0.10, 0.06])
        + 0.016 * lips * bump(x, y, [0.02, 0.232], [0.06, 0.017])
        + 0.018 * lips * bump(x, y, [0.0, 0.165], [0.065, 0.020])
        - 0.015 * bump(x, y, [0.0, MOUTH_Y], [0.10, 0.010])
        - 0.010 * bump(x, y, [0.0, 0.120], [0.08, 0.020])
        + 0.022 * face.chin * bump(x, y, [0.0, 0.055], [0.085, 0.045])
        - 0.006 * bump(x, y, [MOUTH_X + 0.012, MOUTH_Y + 0.012], [0.022, 0.03])
        - 0.012 * bump(x, y, [0.27, 0.22], [0.06, 0.10])
}

/// Returns the relief of the nose.
fn nose(face: &Face, x: f64, y: f64) -> f64 {
    let tip_y = 0.350 - 0.030 * (face.nose_length - 1.0);
    // The ridge from the bridge between the eyes to the tip.
    let down = ((0.545 - y) / (0.545 - tip_y)).clamp(0.0, 1.0);
    let below = smooth(tip_y - 0.062, tip_y - 0.006, y);
    let profile = 0.024
        + (0.088 * face.nose_length - 0.012) * down.powf(1.25)
        + 0.022 * face.nose_hump * (std::f64::consts::PI * down).sin();
    let ridge = if y > 0.60 { 0.0 } else { profile * smooth(0.615, 0.53, y) };
    let half = (0.028 + 0.026 * down * down) * (0.5 + 0.5 * face.nose_width);
    let wings = 0.036
        * face.nose_length
        * bump(x, y, [0.058 * face.nose_width, tip_y - 0.018], [0.026, 0.026]);
    ridge * below * (-(x / half).powi(2)).exp() + wings
}
