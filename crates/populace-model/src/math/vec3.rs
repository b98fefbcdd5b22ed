//! Vectors of three components, and the rotations between them; the twin of `kernels/turn.cl`.

use super::{Real, quat};

/// A vector.
pub type Vec3<R = f32> = [R; 3];

/// Below this a squared length counts as none.
const TINY: f32 = 1e-20;

/// The sum of the products of the components.
#[inline(always)]
#[must_use]
pub fn dot<R: Real>(a: Vec3<R>, b: Vec3<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector at a right angle to both.
#[inline(always)]
#[must_use]
pub fn cross<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The sum.
#[inline(always)]
#[must_use]
pub fn add<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// What leads from `b` to `a`.
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

/// `a` where chosen, else `b`.
#[inline(always)]
#[must_use]
pub fn choose<R: Real>(which: R::Choice, a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [R::choose(which, a[0], b[0]), R::choose(which, a[1], b[1]), R::choose(which, a[2], b[2])]
}

/// The square root of what is not negative, by [`Real::inverse_sqrt`]: 0 below 1e-20.
#[inline(always)]
#[must_use]
pub fn root<R: Real>(x: R) -> R {
    R::choose(R::splat(TINY).less(x), x * x.inverse_sqrt(), R::splat(0.0))
}

/// The length.
#[inline(always)]
#[must_use]
pub fn length<R: Real>(a: Vec3<R>) -> R {
    root(dot(a, a))
}

/// `a` divided by its length, or `fallback` where it has none.
#[inline(always)]
#[must_use]
pub fn unit_or<R: Real>(a: Vec3<R>, fallback: Vec3<R>) -> Vec3<R> {
    let squared = dot(a, a);
    choose::<R>(R::splat(TINY).less(squared), scale(a, squared.inverse_sqrt()), fallback)
}

/// `a` less its part along the unit vector `axis`.
#[inline(always)]
#[must_use]
pub fn across<R: Real>(a: Vec3<R>, axis: Vec3<R>) -> Vec3<R> {
    add_scaled(a, axis, -dot(a, axis))
}

/// `v` turned by a unit quaternion.
#[inline(always)]
#[must_use]
pub fn turned<R: Real>(q: [R; 4], v: Vec3<R>) -> Vec3<R> {
    let axis = [q[0], q[1], q[2]];
    let twice = scale(cross(axis, v), R::splat(2.0));
    add(add_scaled(v, twice, q[3]), cross(axis, twice))
}

/// The shortest turn that takes one unit vector to another. Where they are opposite it is half a
/// turn about an axis at a right angle to both, the nearest to `about`.
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

/// A unit vector at a right angle to a unit vector.
#[inline]
#[must_use]
pub fn any_across(a: Vec3) -> Vec3 {
    let along = if a[0] * a[0] < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    unit_or(across(along, a), [0.0, 0.0, 1.0])
}

/// A turn taken in part, the short way: `k` of 0 turns nothing, 1 turns it all.
#[inline(always)]
#[must_use]
pub fn part_of<R: Real>(turn: [R; 4], k: R) -> [R; 4] {
    part_as_told(quat::hemisphere(turn, quat::identity()), k)
}

/// A turn taken in part, the way that its sign tells: beyond half a turn where its `w` is below 0.
#[inline(always)]
#[must_use]
pub fn part_as_told<R: Real>(turn: [R; 4], k: R) -> [R; 4] {
    quat::normalize_or(quat::mix(quat::identity(), turn, k), quat::identity())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shortest_turn_takes_one_vector_to_the_other_even_where_they_are_opposite() {
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
                let arrived = turned(between(from, to, [0.3, 0.5, -0.1]), from);
                assert!(length(sub(arrived, to)) < 1e-6, "{from:?} {to:?} {arrived:?}");
            }
        }
    }
}
