//! Vectors of three components, and rotations between them; twin of `kernels/vec3.cl`.

use super::{Real, quat};

/// A vector.
pub type Vec3<R = f32> = [R; 3];

/// Squared lengths up to this count as zero.
const TINY: f32 = 1e-20;

/// Dot product.
#[inline(always)]
#[must_use]
pub fn dot<R: Real>(a: Vec3<R>, b: Vec3<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cross product.
#[inline(always)]
#[must_use]
pub fn cross<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Sum.
#[inline(always)]
#[must_use]
pub fn add<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Difference `a - b`.
#[inline(always)]
#[must_use]
pub fn sub<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Each component times `k`.
#[inline(always)]
#[must_use]
pub fn scale<R: Real>(a: Vec3<R>, k: R) -> Vec3<R> {
    [a[0] * k, a[1] * k, a[2] * k]
}

/// `a + b * k`.
#[inline(always)]
#[must_use]
pub fn add_scaled<R: Real>(a: Vec3<R>, b: Vec3<R>, k: R) -> Vec3<R> {
    [a[0] + b[0] * k, a[1] + b[1] * k, a[2] + b[2] * k]
}

/// Returns `a` where `which` is true, else `b`.
#[inline(always)]
#[must_use]
pub fn choose<R: Real>(which: R::Choice, a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [R::choose(which, a[0], b[0]), R::choose(which, a[1], b[1]), R::choose(which, a[2], b[2])]
}

/// Square root by [`Real::inverse_sqrt`]; 0 up to 1e-20. `x` must not be negative.
#[inline(always)]
#[must_use]
pub fn root<R: Real>(x: R) -> R {
    R::choose(R::splat(TINY).less(x), x * x.inverse_sqrt(), R::splat(0.0))
}

/// Length.
#[inline(always)]
#[must_use]
pub fn length<R: Real>(a: Vec3<R>) -> R {
    root(dot(a, a))
}

/// Returns `a` divided by its length, or `fallback` if the length is zero.
#[inline(always)]
#[must_use]
pub fn unit_or<R: Real>(a: Vec3<R>, fallback: Vec3<R>) -> Vec3<R> {
    let squared = dot(a, a);
    choose::<R>(R::splat(TINY).less(squared), scale(a, squared.inverse_sqrt()), fallback)
}

/// Returns `a` minus its component along the unit vector `axis`.
#[inline(always)]
#[must_use]
pub fn across<R: Real>(a: Vec3<R>, axis: Vec3<R>) -> Vec3<R> {
    add_scaled(a, axis, -dot(a, axis))
}

/// Rotates `v` by a unit quaternion.
#[inline(always)]
#[must_use]
pub fn rotated<R: Real>(q: [R; 4], v: Vec3<R>) -> Vec3<R> {
    let axis = [q[0], q[1], q[2]];
    let twice = scale(cross(axis, v), R::splat(2.0));
    add(add_scaled(v, twice, q[3]), cross(axis, twice))
}

/// Returns the shortest rotation from one unit vector to another. For opposite vectors it is half a
/// turn about the axis perpendicular to both that is nearest to `about`.
#[inline]
#[must_use]
pub fn between(from: Vec3, to: Vec3, about: Vec3) -> [f32; 4] {
    let (axis, w) = (cross(from, to), 1.0 + dot(from, to));
    if w > 1e-6 {
        return quat::normalize_or([axis[0], axis[1], axis[2], w], quat::identity());
    }
    let [x, y, z] = unit_or(across(about, from), any_across(from));
    [x, y, z, 0.0]
}

/// Returns a unit vector perpendicular to a unit vector.
#[inline(always)]
#[must_use]
pub fn any_across<R: Real>(a: Vec3<R>) -> Vec3<R> {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let leans = (a[0] * a[0]).less(R::splat(0.5));
    let along = choose::<R>(leans, [one, zero, zero], [zero, one, zero]);
    unit_or(across(along, a), [zero, zero, one])
}

/// Scales a rotation along the shorter arc: `k` of 0 gives the identity, 1 the whole rotation.
#[inline(always)]
#[must_use]
pub fn part_of<R: Real>(rotation: [R; 4], k: R) -> [R; 4] {
    part_as_told(quat::short_way(rotation), k)
}

/// Scales a rotation along the arc given by its sign, which is longer than half a turn if `w` is
/// negative.
#[inline(always)]
#[must_use]
pub fn part_as_told<R: Real>(rotation: [R; 4], k: R) -> [R; 4] {
    quat::normalize_or(quat::mix(quat::identity(), rotation, k), quat::identity())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shortest_rotation_maps_one_vector_to_the_other() {
        let unit = |v: Vec3| unit_or(v, [0.0; 3]);
        let vectors = [
            [1.0, 2.0, 3.0],
            [-1.0, 0.2, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [-1.0, -2.0, -3.0],
        ];
        for from in vectors.map(unit) {
            for to in vectors.map(unit) {
                let arrived = rotated(between(from, to, [0.3, 0.5, -0.1]), from);
                assert!(length(sub(arrived, to)) < 1e-6, "{from:?} {to:?} {arrived:?}");
            }
        }
    }
}
