// quat.cl - Quaternions x y z w, in lanes. dot(), normalize() and mix() of OpenCL C are not used,
// because they may sum in another order.
//
// Twin of populace-model/src/math/quat.rs: same arithmetic, same order of operations.

INLINE Quat quat_identity(void)
{
    const Quat q = { 0.0f, 0.0f, 0.0f, 1.0f };
    return q;
}

INLINE Real quat_dot(Quat a, Quat b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }

INLINE Quat quat_scale(Quat a, Real k)
{
    const Quat q = { a.x * k, a.y * k, a.z * k, a.w * k };
    return q;
}

INLINE Quat quat_add(Quat a, Quat b)
{
    const Quat q = { a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w };
    return q;
}

INLINE Quat quat_mix(Quat a, Quat b, Real t)
{
    const Quat q = { a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t,
                     a.w + (b.w - a.w) * t };
    return q;
}

INLINE Quat quat_choose(Choice which, Quat a, Quat b)
{
    const Quat q = { which ? a.x : b.x, which ? a.y : b.y, which ? a.z : b.z, which ? a.w : b.w };
    return q;
}

INLINE Quat quat_normalize_or(Quat a, Quat fallback)
{
    const Real length_squared = quat_dot(a, a);
    return quat_choose(length_squared > (Real)(LEAST_SQUARE),
                       quat_scale(a, inverse_sqrt(length_squared)),
                       fallback);
}

// Returns 1 or -1: the sign that brings `a` into the hemisphere of `towards`.
INLINE Real quat_side(Quat a, Quat towards)
{
    return quat_dot(a, towards) < (Real)(0.0f) ? (Real)(-1.0f) : (Real)(1.0f);
}

INLINE Quat quat_hemisphere(Quat a, Quat towards) { return quat_scale(a, quat_side(a, towards)); }

// Returns `a` or `-a`, whichever rotates by at most half a turn.
INLINE Quat quat_short_way(Quat a)
{
    return quat_scale(a, a.w < (Real)(0.0f) ? (Real)(-1.0f) : (Real)(1.0f));
}

INLINE Quat quat_conjugate(Quat a)
{
    const Quat q = { -a.x, -a.y, -a.z, a.w };
    return q;
}

INLINE Quat quat_mul(Quat a, Quat b)
{
    const Quat q = { a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                     a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                     a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
                     a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z };
    return q;
}

// Returns a fraction of a rotation in the direction that its sign gives: beyond half a turn if w is
// below 0.
INLINE Quat quat_part_as_told(Quat rotation, Real k)
{
    return quat_normalize_or(quat_mix(quat_identity(), rotation, k), quat_identity());
}

// Returns a fraction of a rotation, the short way.
INLINE Quat quat_part(Quat rotation, Real k)
{
    return quat_part_as_told(quat_short_way(rotation), k);
}
