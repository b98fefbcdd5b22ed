/* quat.cl - unit quaternions as float4 (x y z w); the twin of populace-core math/quat.rs and math/scalar.rs: the same
 * functions in the same order, each with the same order of operations. dot(), normalize() and mix() of OpenCL C are not
 * used, since they may sum in another order. */

#define QUAT_IDENTITY ((float4)(0.0f, 0.0f, 0.0f, 1.0f))

float4 mix4(float4 a, float4 b, float t) { return a + (b - a) * t; }

float quat_dot(float4 a, float4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }

float4 quat_normalize_or(float4 a, float4 fallback)
{
    const float length_squared = quat_dot(a, a);
    return length_squared > 1e-20f ? a * (1.0f / sqrt(length_squared)) : fallback;
}

float4 quat_hemisphere(float4 a, float4 towards) { return quat_dot(a, towards) < 0.0f ? -a : a; }

float4 quat_conjugate(float4 a) { return (float4)(-a.x, -a.y, -a.z, a.w); }

float4 quat_mul(float4 a, float4 b)
{
    return (float4)(a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                    a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                    a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
                    a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
}
