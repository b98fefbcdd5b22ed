/* affine.cl - affine transforms as 3x4 matrices, each one float16: three rows of four, and four lanes that nothing looks
 * at; the twin of populace-model math/affine.rs. A product is three permutes, three repeated rows, and one more permute for
 * the translation. */

INLINE float16 repeated(float4 row) { return (float16)(row, row, row, row); }

/* The last column's lanes of `a`, and -0 elsewhere: adding -0 changes no bit. */
INLINE float16 last_column(float16 a)
{
    const int16 here = (int16)(0, 0, 0, -1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 0, 0, -1);
    return as_float16((as_int16(a) & here) | (as_int16((float16)(-0.0f)) & ~here));
}

/* a * b: applies b first. */
INLINE float16 affine_mul_rows(float16 a, float4 b0, float4 b1, float4 b2)
{
    return (a.s000044448888cccc * repeated(b0) + a.s111155559999dddd * repeated(b1) + a.s22226666aaaaeeee * repeated(b2))
           + last_column(a);
}

INLINE float16 affine_mul(float16 a, float16 b) { return affine_mul_rows(a, b.s0123, b.s4567, b.s89ab); }

/* One row of a * b, from the same row of a. */
INLINE float4 affine_row(float4 a, float4 b0, float4 b1, float4 b2)
{
    return affine_mul_rows((float16)(a, (float4)(0.0f), (float8)(0.0f)), b0, b1, b2).s0123;
}
