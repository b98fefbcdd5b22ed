//! Unit quaternions as `[x, y, z, w]`; the twin of `kernels/quat.cl`.

use super::scalar::sqrt;

/// The rotation that changes nothing.
pub const IDENTITY: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Sum of the products of the components.
#[inline]
#[must_use]
pub fn dot(a: [f32; 4], b: [f32; 4]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// Each component times `k`.
#[inline]
#[must_use]
pub fn scale(a: [f32; 4], k: f32) -> [f32; 4] {
    [a[0] * k, a[1] * k, a[2] * k, a[3] * k]
}

/// The sum, component by component.
#[inline]
#[must_use]
pub fn add(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

/// `a + (b - a) * t`, component by component, not normalised.
#[inline]
#[must_use]
pub fn mix(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    add(a, scale([b[0] - a[0], b[1] - a[1], b[2] - a[2], b[3] - a[3]], t))
}

/// `a` divided by its length, or `fallback` where the length is too small to divide by.
#[inline]
#[must_use]
pub fn normalize_or(a: [f32; 4], fallback: [f32; 4]) -> [f32; 4] {
    let length_squared = dot(a, a);
    if length_squared > 1e-20 { scale(a, 1.0 / sqrt(length_squared)) } else { fallback }
}

/// `a` or `-a`, whichever lies in the half-space of `towards`. Both stand for the same rotation.
#[inline]
#[must_use]
pub fn hemisphere(a: [f32; 4], towards: [f32; 4]) -> [f32; 4] {
    if dot(a, towards) < 0.0 { [-a[0], -a[1], -a[2], -a[3]] } else { a }
}

/// The inverse of a unit quaternion.
#[inline]
#[must_use]
pub fn conjugate(a: [f32; 4]) -> [f32; 4] {
    [-a[0], -a[1], -a[2], a[3]]
}

/// The rotation that applies `b` first, then `a`.
#[inline]
#[must_use]
pub fn mul(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    [
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    ]
}
