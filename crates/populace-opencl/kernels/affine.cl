// affine.cl - Affine transforms: 3x4 matrices and their products.
//
// A matrix is one float16: three rows of four, then four lanes that are never read. A product takes
// three permutes, three repeated rows, and one more permute for the translation.
//
// Twin of populace-model/src/math/affine.rs: same arithmetic, same order of operations.

INLINE float16 repeated(float4 row) { return (float16)(row, row, row, row); }

// Returns the last column of `a` in its own lanes and -0 elsewhere. Adding -0 changes no bit.
INLINE float16 last_column(float16 a)
{
    const int16 here = (int16)(0, 0, 0, -1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 0, 0, -1);
    return as_float16((as_int16(a) & here) | (as_int16((float16)(-0.0f)) & ~here));
}

// Returns a * b, which applies b first.
INLINE float16 affine_mul_rows(float16 a, float4 b0, float4 b1, float4 b2)
{
    return (a.s000044448888cccc * repeated(b0) + a.s111155559999dddd * repeated(b1)
            + a.s22226666aaaaeeee * repeated(b2))
           + last_column(a);
}

INLINE float16 affine_mul(float16 a, float16 b)
{
    return affine_mul_rows(a, b.s0123, b.s4567, b.s89ab);
}

// Returns one row of a * b, from the same row of a.
INLINE float4 affine_row(float4 a, float4 b0, float4 b1, float4 b2)
{
    return affine_mul_rows((float16)(a, (float4)(0.0f), (float8)(0.0f)), b0, b1, b2).s0123;
}

// Returns the image of the origin.
INLINE float4 origin_of(float16 m) { return vec(m.s3, m.s7, m.sb); }

INLINE float4 transform_point(float16 m, float4 p)
{
    return vec(m.s0 * p.x + m.s1 * p.y + m.s2 * p.z + m.s3,
               m.s4 * p.x + m.s5 * p.y + m.s6 * p.z + m.s7,
               m.s8 * p.x + m.s9 * p.y + m.sa * p.z + m.sb);
}

INLINE float4 transform_vector(float16 m, float4 v)
{
    return vec(m.s0 * v.x + m.s1 * v.y + m.s2 * v.z, m.s4 * v.x + m.s5 * v.y + m.s6 * v.z,
               m.s8 * v.x + m.s9 * v.y + m.sa * v.z);
}

// Rotates a transform about its own origin. Each element of the rotation matrix is a sum of two
// products.
INLINE float16 affine_rotated(float16 m, float4 rotation)
{
    const float16 q = repeated(rotation), one = q.s1003001301030000 * q.s1123102322030000;
    const float16 other = q.s2333323333130000 * q.s2213220310130000;
    const float16 sign = (float16)(1.0f, -1.0f, 1.0f, 0.0f, 1.0f, 1.0f, -1.0f, 0.0f, -1.0f, 1.0f,
                                   1.0f, 0.0f, (float4)(0.0f));
    const float16 twice = (float16)(-2.0f, 2.0f, 2.0f, 0.0f, 2.0f, -2.0f, 2.0f, 0.0f, 2.0f, 2.0f,
                                    -2.0f, 0.0f, (float4)(0.0f));
    // Adding -0 changes no bit.
    const float16 unit = (float16)(1.0f, -0.0f, -0.0f, 0.0f, -0.0f, 1.0f, -0.0f, 0.0f, -0.0f, -0.0f,
                                   1.0f, 0.0f, (float4)(0.0f));
    float16 result = affine_mul(unit + twice * (one + sign * other), m);
    result.s3 = m.s3;
    result.s7 = m.s7;
    result.sb = m.sb;
    return result;
}

// Computes the first three rows of translation * rotation * scale (glTF 2.0, section 3.5.3).
INLINE void components_of(Local trs, Real m[12])
{
    const Real x = trs.r.x, y = trs.r.y, z = trs.r.z, w = trs.r.w;
    m[0] = (1.0f - 2.0f * (y * y + z * z)) * trs.s.x;
    m[1] = (2.0f * (x * y - w * z)) * trs.s.y;
    m[2] = (2.0f * (x * z + w * y)) * trs.s.z;
    m[3] = trs.t.x;
    m[4] = (2.0f * (x * y + w * z)) * trs.s.x;
    m[5] = (1.0f - 2.0f * (x * x + z * z)) * trs.s.y;
    m[6] = (2.0f * (y * z - w * x)) * trs.s.z;
    m[7] = trs.t.y;
    m[8] = (2.0f * (x * z - w * y)) * trs.s.x;
    m[9] = (2.0f * (y * z + w * x)) * trs.s.y;
    m[10] = (1.0f - 2.0f * (x * x + y * y)) * trs.s.z;
    m[11] = trs.t.z;
}
