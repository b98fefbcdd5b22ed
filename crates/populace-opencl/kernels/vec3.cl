// vec3.cl - Vectors of three components, and the rotations between them, by + - * / only.
//
// vec3_ and quat_ functions work in lanes. The others work on one joint: vectors as float4 x y z 0,
// rotations as unit quaternions x y z w.
//
// Twin of populace-model/src/math/vec3.rs: same arithmetic, same order of operations.

// Vectors in lanes.

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

// Returns a + b * k.
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

// Returns `a` without its part along a unit vector.
INLINE Vec3 vec3_across(Vec3 a, Vec3 axis) { return vec3_add_scaled(a, axis, -vec3_dot(a, axis)); }

INLINE Vec3 vec3_choose(Choice which, Vec3 a, Vec3 b)
{
    const Vec3 v = { which ? a.x : b.x, which ? a.y : b.y, which ? a.z : b.z };
    return v;
}

INLINE Vec3 vec3_unit_or(Vec3 a, Vec3 fallback)
{
    const Real squared = vec3_dot(a, a);
    return vec3_choose(squared > (Real)(LEAST_SQUARE), vec3_scale(a, inverse_sqrt(squared)),
                       fallback);
}

INLINE Vec3 vec3_any_across(Vec3 a)
{
    const Vec3 x = { 1.0f, 0.0f, 0.0f }, y = { 0.0f, 1.0f, 0.0f }, z = { 0.0f, 0.0f, 1.0f };
    return vec3_unit_or(vec3_across(vec3_choose(a.x * a.x < (Real)(0.5f), x, y), a), z);
}

// Rotates a vector by a unit quaternion: v + 2 w (q x v) + 2 q x (q x v).
INLINE Vec3 quat_rotated(Quat q, Vec3 v)
{
    const Vec3 axis = { q.x, q.y, q.z }, twice = vec3_scale(vec3_cross(axis, v), 2.0f);
    return vec3_add(vec3_add_scaled(v, twice, q.w), vec3_cross(axis, twice));
}

// Vectors and rotations of one joint.

#define IDENTITY_ROTATION ((float4)(0.0f, 0.0f, 0.0f, 1.0f))

INLINE float4 vec(float x, float y, float z) { return (float4)(x, y, z, 0.0f); }

INLINE float vec_dot(float4 a, float4 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

INLINE float4 vec_cross(float4 a, float4 b)
{
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// Returns a + b * k.
INLINE float4 add_scaled(float4 a, float4 b, float k)
{
    return vec(a.x + b.x * k, a.y + b.y * k, a.z + b.z * k);
}

INLINE float vec_length(float4 a) { return root(vec_dot(a, a)); }

INLINE float4 unit_or(float4 a, float4 fallback)
{
    const float squared = vec_dot(a, a);
    return squared > LEAST_SQUARE ? a * inverse_root(squared) : fallback;
}

// Returns `a` without its part along a unit vector.
INLINE float4 across(float4 a, float4 axis) { return add_scaled(a, axis, -vec_dot(a, axis)); }

INLINE float4 any_across(float4 a)
{
    const float4 along = a.x * a.x < 0.5f ? vec(1.0f, 0.0f, 0.0f) : vec(0.0f, 1.0f, 0.0f);
    return unit_or(across(along, a), vec(0.0f, 0.0f, 1.0f));
}

INLINE float rotation_dot(float4 a, float4 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

// Scales to length 1. The result is the identity if `a` has no length.
INLINE float4 rotation_unit(float4 a)
{
    const float squared = rotation_dot(a, a);
    return squared > LEAST_SQUARE ? a * inverse_root(squared) : IDENTITY_ROTATION;
}

INLINE float4 rotation_mul(float4 a, float4 b)
{
    return (float4)(a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                    a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                    a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
                    a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
}

INLINE float4 rotated(float4 q, float4 v)
{
    const float4 axis = vec(q.x, q.y, q.z), twice = vec_cross(axis, v) * 2.0f;
    return add_scaled(v, twice, q.w) + vec_cross(axis, twice);
}

// Returns the shortest rotation from one unit vector to another. If they are opposite, it rotates
// about the axis nearest to `about`.
INLINE float4 rotation_between(float4 from, float4 to, float4 about)
{
    const float4 axis = vec_cross(from, to);
    const float w = 1.0f + vec_dot(from, to);
    if (w > 1e-6f) return rotation_unit((float4)(axis.xyz, w));
    const float4 over = unit_or(across(about, from), any_across(from));
    return (float4)(over.xyz, 0.0f);
}

// Returns a fraction of a rotation, the short way.
INLINE float4 part_of(float4 rotation, float k)
{
    const float4 near = rotation * (rotation.w < 0.0f ? -1.0f : 1.0f);
    return rotation_unit(IDENTITY_ROTATION + (near - IDENTITY_ROTATION) * k);
}
