/* affine.cl - affine transforms as three rows of four; the twin of populace-core math/affine.rs. */

typedef struct { float4 t, r, s; } Trs; /* translation x y z 0, rotation x y z w, scale x y z 0 */

typedef struct { float4 row0, row1, row2; } Affine;

Affine affine_from_local(Trs trs)
{
    const float x = trs.r.x, y = trs.r.y, z = trs.r.z, w = trs.r.w;
    Affine m;
    m.row0 = (float4)((1.0f - 2.0f * (y * y + z * z)) * trs.s.x, (2.0f * (x * y - w * z)) * trs.s.y,
                      (2.0f * (x * z + w * y)) * trs.s.z, trs.t.x);
    m.row1 = (float4)((2.0f * (x * y + w * z)) * trs.s.x, (1.0f - 2.0f * (x * x + z * z)) * trs.s.y,
                      (2.0f * (y * z - w * x)) * trs.s.z, trs.t.y);
    m.row2 = (float4)((2.0f * (x * z - w * y)) * trs.s.x, (2.0f * (y * z + w * x)) * trs.s.y,
                      (1.0f - 2.0f * (x * x + y * y)) * trs.s.z, trs.t.z);
    return m;
}

float4 affine_row_mul(float4 a, Affine b)
{
    float4 row = a.x * b.row0 + a.y * b.row1 + a.z * b.row2;
    row.w += a.w;
    return row;
}

/* a * b: applies b first. */
Affine affine_mul(Affine a, Affine b)
{
    Affine m;
    m.row0 = affine_row_mul(a.row0, b);
    m.row1 = affine_row_mul(a.row1, b);
    m.row2 = affine_row_mul(a.row2, b);
    return m;
}
