/* turn.cl - vectors, turns and angles of one joint, whatever LANES is: vectors as x y z 0, turns as unit quaternions x y z w.
 * Twin of populace-model math/vec3.rs: the same functions, each with the same order of operations, by + - * / alone. */

#define IDENTITY_TURN ((float4)(0.0f, 0.0f, 0.0f, 1.0f))

INLINE float4 vec(float x, float y, float z) { return (float4)(x, y, z, 0.0f); }

INLINE float vec_dot(float4 a, float4 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

INLINE float4 vec_cross(float4 a, float4 b)
{
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* a + b * k */
INLINE float4 add_scaled(float4 a, float4 b, float k) { return vec(a.x + b.x * k, a.y + b.y * k, a.z + b.z * k); }

/* As inverse_sqrt() in quat.cl, of one number. */
INLINE float inverse_root(float x)
{
    const float half_x = 0.5f * x;
    float y = as_float(0x5f3759df - (as_int(x) >> 1));
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    return y;
}

INLINE float root(float x) { return x > 1e-20f ? x * inverse_root(x) : 0.0f; }

INLINE float vec_length(float4 a) { return root(vec_dot(a, a)); }

INLINE float4 unit_or(float4 a, float4 fallback)
{
    const float squared = vec_dot(a, a);
    return squared > 1e-20f ? a * inverse_root(squared) : fallback;
}

/* `a` less its part along a unit vector. */
INLINE float4 across(float4 a, float4 axis) { return add_scaled(a, axis, -vec_dot(a, axis)); }

INLINE float4 any_across(float4 a)
{
    const float4 along = a.x * a.x < 0.5f ? vec(1.0f, 0.0f, 0.0f) : vec(0.0f, 1.0f, 0.0f);
    return unit_or(across(along, a), vec(0.0f, 0.0f, 1.0f));
}

INLINE float turn_dot(float4 a, float4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }

/* Of length 1, or none where it has no length. */
INLINE float4 turn_unit(float4 a)
{
    const float squared = turn_dot(a, a);
    return squared > 1e-20f ? a * inverse_root(squared) : IDENTITY_TURN;
}

INLINE float4 turn_mul(float4 a, float4 b)
{
    return (float4)(a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                    a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
}

INLINE float4 turned(float4 q, float4 v)
{
    const float4 axis = vec(q.x, q.y, q.z), twice = vec_cross(axis, v) * 2.0f;
    return add_scaled(v, twice, q.w) + vec_cross(axis, twice);
}

/* The shortest turn from one unit vector to another; where they are opposite, about the axis nearest to `about`. */
INLINE float4 turn_between(float4 from, float4 to, float4 about)
{
    const float4 axis = vec_cross(from, to);
    const float w = 1.0f + vec_dot(from, to);
    if (w > 1e-6f) return turn_unit((float4)(axis.xyz, w));
    return unit_or(across(about, from), any_across(from));
}

/* A turn taken in part, the short way. */
INLINE float4 part_of(float4 turn, float k)
{
    const float4 near = turn * (turn.w < 0.0f ? -1.0f : 1.0f);
    return turn_unit(IDENTITY_TURN + (near - IDENTITY_TURN) * k);
}

/* Of an affine transform, three rows of four: where its origin goes, and the image of a direction. */
INLINE float4 origin_of(float16 m) { return vec(m.s3, m.s7, m.sb); }

INLINE float4 transform_vector(float16 m, float4 v)
{
    return vec(m.s0 * v.x + m.s1 * v.y + m.s2 * v.z, m.s4 * v.x + m.s5 * v.y + m.s6 * v.z, m.s8 * v.x + m.s9 * v.y + m.sa * v.z);
}

/* A transform turned about its own origin: by the rotation's matrix, every element of which is a sum of two products. */
INLINE float16 affine_turned(float16 m, float4 turn)
{
    const float16 q = repeated(turn), one = q.s1003001301030000 * q.s1123102322030000;
    const float16 other = q.s2333323333130000 * q.s2213220310130000;
    const float16 sign = (float16)(1.0f, -1.0f, 1.0f, 0.0f, 1.0f, 1.0f, -1.0f, 0.0f, -1.0f, 1.0f, 1.0f, 0.0f, (float4)(0.0f));
    const float16 twice = (float16)(-2.0f, 2.0f, 2.0f, 0.0f, 2.0f, -2.0f, 2.0f, 0.0f, 2.0f, 2.0f, -2.0f, 0.0f, (float4)(0.0f));
    /* Adding -0 changes no bit. */
    const float16 unit = (float16)(1.0f, -0.0f, -0.0f, 0.0f, -0.0f, 1.0f, -0.0f, 0.0f, -0.0f, -0.0f, 1.0f, 0.0f, (float4)(0.0f));
    float16 result = affine_mul(unit + twice * (one + sign * other), m);
    result.s3 = m.s3;
    result.s7 = m.s7;
    result.sb = m.sb;
    return result;
}
