/* affine.cl - affine transforms as 3x4 matrices, each one float16: three rows of four, and four lanes that nothing looks
 * at; the twin of populace-core math/affine.rs. A product is three permutes, three repeated rows, and one more permute for
 * the translation. */

float16 repeated(float4 row) { return (float16)(row, row, row, row); }

/* a * b: applies b first. Adding -0 changes no bit, so only the last column takes a's translation. */
float16 affine_mul_rows(float16 a, float4 b0, float4 b1, float4 b2)
{
    const float16 nothing = (float16)(-0.0f);
    const float16 moved = (float16)(nothing.s012, a.s3, nothing.s012, a.s7, nothing.s012, a.sb, nothing.s0123);
    return (a.s000044448888cccc * repeated(b0) + a.s111155559999dddd * repeated(b1) + a.s22226666aaaaeeee * repeated(b2))
           + moved;
}

float16 affine_mul(float16 a, float16 b) { return affine_mul_rows(a, b.s0123, b.s4567, b.s89ab); }

/* One row of a * b, from the same row of a. */
float4 affine_row(float4 a, float4 b0, float4 b1, float4 b2)
{
    return affine_mul_rows((float16)(a, (float4)(0.0f), (float8)(0.0f)), b0, b1, b2).s0123;
}
