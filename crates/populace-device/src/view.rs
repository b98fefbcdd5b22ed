//! The view of a picture: visibility of members, and the size in pixels at which they are seen.
#![expect(
    clippy::disallowed_methods,
    reason = "square roots of the host alone; no device computes them again"
)]

/// Planes of a view: left, right, bottom, top and near.
pub const VIEW_PLANES: usize = 5;

/// A picture's view of the world, from which a crowd chooses the members to evaluate and their
/// levels of detail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye in world space, in metres.
    pub eye: [f32; 3],
    /// Planes around what the picture shows: an inward unit normal in `x y z`, and the distance in
    /// metres of the world's origin on the inner side in `w`.
    pub planes: [[f32; 4]; VIEW_PLANES],
    /// Pixels that one metre covers at a distance of one metre.
    pub pixels_per_metre: f32,
    /// Unit direction to the sun in world space, for members that are out of view but throw a
    /// shadow into it; `None` without shadows.
    pub to_sun: Option<[f32; 3]>,
    /// Greatest distance in pixels between the surface that is shown and that of the character.
    pub error_px: f32,
}

/// The part of a view that a member takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Visibility {
    /// It may be seen.
    #[default]
    InView,
    /// It is out of view, but its shadow may be seen.
    ShadowOnly,
    /// Neither it nor its shadow can be seen. It is not posed, unless it has root motion, is
    /// watched or carries others.
    Hidden,
}

/// Length along the ground of a shadow, in heights of what throws it, beyond which shadows are not
/// followed: the sun is less than 9 degrees above the horizon.
const LONGEST_SHADOW: f32 = 6.0;

/// Planes in lanes: those of a view, and others that are never beyond anything.
const LANES: usize = 8;

/// The planes of a view side by side, and how far shadows reach over each of them.
#[derive(Clone, Copy, Debug)]
pub struct Culling {
    normal: [[f32; LANES]; 3],
    offset: [f32; LANES],
    /// How far the end of a shadow lies inwards of the body that throws it, in radii of the body;
    /// 0 for one that lies outwards, and without shadows.
    shadow: [f32; LANES],
}

impl Culling {
    /// Returns what can be seen of a body within a sphere in world space.
    #[must_use]
    #[inline]
    pub fn visibility(&self, center: [f32; 3], radius: f32) -> Visibility {
        let [nx, ny, nz] = &self.normal;
        // How far inwards of each plane the body and the end of its shadow lie.
        let (mut body, mut end) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let level = nx[lane] * center[0] + ny[lane] * center[1] + nz[lane] * center[2];
            body[lane] = level + self.offset[lane];
            end[lane] = body[lane] + self.shadow[lane] * radius;
        }
        // A centre that is no number stays in view.
        match (least(body) < -radius, least(end) < -radius) {
            (false, _) => Visibility::InView,
            (true, false) => Visibility::ShadowOnly,
            (true, true) => Visibility::Hidden,
        }
    }
}

/// Returns the least number. Compares halves: compilers put them into vectors, but not a chain of
/// minima.
#[inline]
fn least(numbers: [f32; LANES]) -> f32 {
    // One instruction; `f32::min` must also handle NaN.
    let lesser = |a: f32, b: f32| if b < a { b } else { a };
    let four: [f32; 4] = std::array::from_fn(|i| lesser(numbers[i], numbers[i + 4]));
    lesser(lesser(four[0], four[2]), lesser(four[1], four[3]))
}

impl View {
    /// Returns the planes that tell what can be seen.
    #[must_use]
    pub fn culling(&self) -> Culling {
        // The way to the far end of the shadow on the ground beneath a body of radius 1.
        let shadow = self.to_sun.map(|[x, y, z]| {
            let level = (x * x + z * z).sqrt();
            ([x, y, z], (2.0 / y.max(level / LONGEST_SHADOW)).max(0.0))
        });
        let mut culling =
            Culling { normal: [[0.0; LANES]; 3], offset: [f32::MAX; LANES], shadow: [0.0; LANES] };
        for (lane, [x, y, z, offset]) in self.planes.into_iter().enumerate() {
            for (axis, of_normal) in [x, y, z].into_iter().enumerate() {
                culling.normal[axis][lane] = of_normal;
            }
            culling.offset[lane] = offset;
            if let Some(([sx, sy, sz], along)) = shadow {
                culling.shadow[lane] = (-along * (x * sx + y * sy + z * sz)).max(0.0);
            }
        }
        culling
    }

    /// Returns how many pixels a metre covers on the nearest side of a sphere in world space.
    #[must_use]
    #[inline]
    pub fn pixels_per_metre_at(&self, center: [f32; 3], radius: f32) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|i: usize| center[i] - self.eye[i]);
        let distance = (x * x + y * y + z * z).sqrt() - radius;
        self.pixels_per_metre / distance.max(NEAREST_M)
    }
}

/// Distance in metres below which members are not larger.
const NEAREST_M: f32 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;

    /// A view along -z from the origin, 90 degrees wide and high.
    fn view(to_sun: Option<[f32; 3]>) -> View {
        let k = std::f32::consts::FRAC_1_SQRT_2;
        let planes = [[k, 0.0, -k, 0.0], [-k, 0.0, -k, 0.0], [0.0, k, -k, 0.0], [0.0, -k, -k, 0.0]];
        let mut all = [[0.0, 0.0, -1.0, 0.0]; VIEW_PLANES];
        all[..4].copy_from_slice(&planes);
        View { eye: [0.0; 3], planes: all, pixels_per_metre: 500.0, to_sun, error_px: 1.0 }
    }

    #[test]
    fn spheres_are_hidden_once_they_are_wholly_beyond_an_edge() {
        let at = |x| view(None).culling().visibility([x, 0.0, -10.0], 1.0);
        assert_eq!(at(10.0 + 1.4), Visibility::InView, "the sphere touches the edge");
        assert_eq!(at(10.0 + 1.5), Visibility::Hidden);
        assert_eq!(view(None).culling().visibility([0.0, 0.0, 1.5], 1.0), Visibility::Hidden);
        assert_eq!(view(None).culling().visibility([f32::NAN; 3], 1.0), Visibility::InView);
    }

    #[test]
    fn bodies_out_of_view_that_throw_a_shadow_into_it_are_kept() {
        let sun = |x: f32| Some([x, 1.0, 0.0].map(|c| c / x.hypot(1.0)));
        let outside = [13.0, 0.0, -10.0];
        assert_eq!(view(sun(1.0)).culling().visibility(outside, 1.0), Visibility::ShadowOnly);
        assert_eq!(view(sun(-1.0)).culling().visibility(outside, 1.0), Visibility::Hidden);
        assert_eq!(view(sun(0.0)).culling().visibility(outside, 1.0), Visibility::Hidden);
    }

    #[test]
    fn bodies_shrink_with_their_distance() {
        let at = |z| view(None).pixels_per_metre_at([0.0, 0.0, z], 1.0);
        assert_eq!((at(-11.0), at(-6.0)), (50.0, 100.0));
        assert!(at(0.0).is_finite());
    }
}
