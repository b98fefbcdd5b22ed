/* quat.cl - quaternions and vectors; the twin of populace-model math/quat.rs and math/real.rs: the
 * same functions, each with the same order of operations. dot(), normalize() and mix() of OpenCL C
 * are not used, since they may sum in another order. */

INLINE Real mix_real(Real a, Real b, float t) { return a + (b - a) * t; }

INLINE Vec3 vec3_scale(Vec3 a, Real k)
{
    const Vec3 v = { a.x * k, a.y * k, a.z * k };
    return v;
}

INLINE Vec3 vec3_add(Vec3 a, Vec3 b)
{
    const Vec3 v = { a.x + b.x, a.y + b.y, a.z + b.z };
    return v;
}

INLINE Real vec3_dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

INLINE Vec3 vec3_cross(Vec3 a, Vec3 b)
{
    const Vec3 v = { a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
    return v;
}

/* a + b * k */
INLINE Vec3 vec3_add_scaled(Vec3 a, Vec3 b, Real k)
{
    const Vec3 v = { a.x + b.x * k, a.y + b.y * k, a.z + b.z * k };
    return v;
}

INLINE Vec3 vec3_mix(Vec3 a, Vec3 b, Real t)
{
    const Vec3 v = { a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t };
    return v;
}

/* `a` less its part along a unit vector. */
INLINE Vec3 vec3_across(Vec3 a, Vec3 axis) { return vec3_add_scaled(a, axis, -vec3_dot(a, axis)); }

INLINE Vec3 vec3_choose(Choice which, Vec3 a, Vec3 b)
{
    const Vec3 v = { which ? a.x : b.x, which ? a.y : b.y, which ? a.z : b.z };
    return v;
}

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
    const Quat q = { a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t, a.w + (b.w - a.w) * t };
    return q;
}

INLINE Quat quat_choose(Choice which, Quat a, Quat b)
{
    const Quat q = { which ? a.x : b.x, which ? a.y : b.y, which ? a.z : b.z, which ? a.w : b.w };
    return q;
}

/* 1 / sqrt(x) by + - * alone: a first guess from the exponent, and three steps of Newton's method. Every device rounds it
 * alike, and it costs a CPU less than a root and a quotient. x is positive and normal. */
INLINE Real inverse_sqrt(Real x)
{
    const Real half_x = 0.5f * x;
    Real y = AS_REAL(0x5f3759df - (AS_INTS(x) >> 1));
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    return y;
}

INLINE Real square_root(Real x) { return x > (Real)(1e-20f) ? x * inverse_sqrt(x) : (Real)(0.0f); }

INLINE Vec3 vec3_unit_or(Vec3 a, Vec3 fallback)
{
    const Real squared = vec3_dot(a, a);
    return vec3_choose(squared > (Real)(1e-20f), vec3_scale(a, inverse_sqrt(squared)), fallback);
}

INLINE Vec3 vec3_any_across(Vec3 a)
{
    const Vec3 x = { 1.0f, 0.0f, 0.0f }, y = { 0.0f, 1.0f, 0.0f }, z = { 0.0f, 0.0f, 1.0f };
    return vec3_unit_or(vec3_across(vec3_choose(a.x * a.x < (Real)(0.5f), x, y), a), z);
}

INLINE Quat quat_normalize_or(Quat a, Quat fallback)
{
    const Real length_squared = quat_dot(a, a);
    return quat_choose(length_squared > (Real)(1e-20f), quat_scale(a, inverse_sqrt(length_squared)), fallback);
}

/* 1 or -1: the sign that turns `a` to the half-space of `towards`. */
INLINE Real quat_side(Quat a, Quat towards) { return quat_dot(a, towards) < (Real)(0.0f) ? (Real)(-1.0f) : (Real)(1.0f); }

INLINE Quat quat_hemisphere(Quat a, Quat towards) { return quat_scale(a, quat_side(a, towards)); }

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

/* A vector turned by a unit quaternion: v + 2 w (q x v) + 2 q x (q x v). */
INLINE Vec3 quat_turned(Quat q, Vec3 v)
{
    const Vec3 axis = { q.x, q.y, q.z }, twice = vec3_scale(vec3_cross(axis, v), 2.0f);
    return vec3_add(vec3_add_scaled(v, twice, q.w), vec3_cross(axis, twice));
}

/* A turn taken in part, the way that its sign tells: beyond half a turn where w is below 0. */
INLINE Quat quat_part_as_told(Quat turn, Real k)
{
    return quat_normalize_or(quat_mix(quat_identity(), turn, k), quat_identity());
}

/* A turn taken in part, the short way. */
INLINE Quat quat_part(Quat turn, Real k) { return quat_part_as_told(quat_hemisphere(turn, quat_identity()), k); }
