//! Unit quaternions as `[x, y, z, w]`; twin of `kernels/quat.cl`.

use super::Real;

/// The identity rotation.
#[inline(always)]
#[must_use]
pub fn identity<R: Real>() -> [R; 4] {
    [R::splat(0.0), R::splat(0.0), R::splat(0.0), R::splat(1.0)]
}

/// Dot product.
#[inline(always)]
#[must_use]
pub fn dot<R: Real>(a: [R; 4], b: [R; 4]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// Each component times `k`.
#[inline(always)]
#[must_use]
pub fn scale<R: Real>(a: [R; 4], k: R) -> [R; 4] {
    [a[0] * k, a[1] * k, a[2] * k, a[3] * k]
}

/// Sum of the components.
#[inline(always)]
#[must_use]
pub fn add<R: Real>(a: [R; 4], b: [R; 4]) -> [R; 4] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

/// Interpolates linearly: `a + (b - a) * t`, not normalised.
#[inline(always)]
#[must_use]
pub fn mix<R: Real>(a: [R; 4], b: [R; 4], t: R) -> [R; 4] {
    [a[0].mix(b[0], t), a[1].mix(b[1], t), a[2].mix(b[2], t), a[3].mix(b[3], t)]
}

/// Returns `a` where `which` is true, else `b`.
#[inline(always)]
#[must_use]
pub fn choose<R: Real>(which: R::Choice, a: [R; 4], b: [R; 4]) -> [R; 4] {
    let one = |i: usize| R::choose(which, a[i], b[i]);
    [one(0), one(1), one(2), one(3)]
}

/// Returns `a` divided by its length, or `fallback` if the length is too small to divide by.
#[inline(always)]
#[must_use]
pub fn normalize_or<R: Real>(a: [R; 4], fallback: [R; 4]) -> [R; 4] {
    let length_squared = dot(a, a);
    let long = R::splat(1e-20).less(length_squared);
    choose::<R>(long, scale(a, length_squared.inverse_sqrt()), fallback)
}

/// Returns the sign, 1 or -1, that brings `a` into the hemisphere of `towards`.
#[inline(always)]
#[must_use]
pub fn side<R: Real>(a: [R; 4], towards: [R; 4]) -> R {
    R::choose(dot(a, towards).less(R::splat(0.0)), R::splat(-1.0), R::splat(1.0))
}

/// Returns `a` or `-a`, whichever is in the hemisphere of `towards`. Both are the same rotation.
#[inline(always)]
#[must_use]
pub fn hemisphere<R: Real>(a: [R; 4], towards: [R; 4]) -> [R; 4] {
    scale(a, side(a, towards))
}

/// Returns `a` or `-a`, whichever rotates by at most half a turn.
#[inline(always)]
#[must_use]
pub fn short_way<R: Real>(a: [R; 4]) -> [R; 4] {
    scale(a, R::choose(a[3].less(R::splat(0.0)), R::splat(-1.0), R::splat(1.0)))
}

/// The inverse of a unit quaternion.
#[inline(always)]
#[must_use]
pub fn conjugate<R: Real>(a: [R; 4]) -> [R; 4] {
    [-a[0], -a[1], -a[2], a[3]]
}

/// Composes two rotations: `b` is applied first, then `a`.
#[inline(always)]
#[must_use]
pub fn mul<R: Real>(a: [R; 4], b: [R; 4]) -> [R; 4] {
    [
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    ]
}
