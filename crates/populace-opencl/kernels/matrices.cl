// matrices.cl - Affine transforms in lanes: a matrix of three rows of four in each.
//
// Twin of populace-native/src/matrices.rs: same arithmetic, same order of operations.

// Elements row by row.
typedef struct {
    Real m[12];
} Matrix;

// A row of a matrix.
typedef struct {
    Real x, y, z, w;
} MatrixRow;

INLINE MatrixRow matrix_row(const Matrix *all, uint row)
{
    const MatrixRow r = { all->m[4 * row], all->m[4 * row + 1], all->m[4 * row + 2],
                          all->m[4 * row + 3] };
    return r;
}

INLINE void put_matrix_row(Matrix *all, uint row, MatrixRow r)
{
    all->m[4 * row] = r.x;
    all->m[4 * row + 1] = r.y;
    all->m[4 * row + 2] = r.z;
    all->m[4 * row + 3] = r.w;
}

// Returns a row of a * b, which applies b first, from that row of a.
INLINE MatrixRow row_product(MatrixRow a, const Matrix *b)
{
    const MatrixRow r = { a.x * b->m[0] + a.y * b->m[4] + a.z * b->m[8],
                          a.x * b->m[1] + a.y * b->m[5] + a.z * b->m[9],
                          a.x * b->m[2] + a.y * b->m[6] + a.z * b->m[10],
                          a.x * b->m[3] + a.y * b->m[7] + a.z * b->m[11] + a.w };
    return r;
}

// Writes a * b, row by row, so that registers hold one. `to` may be a, but not b.
INLINE void matrix_product(const Matrix *a, const Matrix *b, Matrix *to)
{
#pragma unroll
    for (uint row = 0; row < 3; row++) put_matrix_row(to, row, row_product(matrix_row(a, row), b));
}

INLINE Vec3 matrix_origin(const Matrix *m)
{
    const Vec3 v = { m->m[3], m->m[7], m->m[11] };
    return v;
}

INLINE Vec3 matrix_transform_vector(const Matrix *m, Vec3 v)
{
    const Vec3 turned = { m->m[0] * v.x + m->m[1] * v.y + m->m[2] * v.z,
                          m->m[4] * v.x + m->m[5] * v.y + m->m[6] * v.z,
                          m->m[8] * v.x + m->m[9] * v.y + m->m[10] * v.z };
    return turned;
}

INLINE Vec3 matrix_transform_point(const Matrix *m, Vec3 p)
{
    const Vec3 placed = { m->m[0] * p.x + m->m[1] * p.y + m->m[2] * p.z + m->m[3],
                          m->m[4] * p.x + m->m[5] * p.y + m->m[6] * p.z + m->m[7],
                          m->m[8] * p.x + m->m[9] * p.y + m->m[10] * p.z + m->m[11] };
    return placed;
}

// Rotates transforms by unit quaternions about their own origins.
INLINE void matrix_rotated(Matrix *m, Quat rotation)
{
    const Local turn = { { 0.0f, 0.0f, 0.0f }, rotation, { 1.0f, 1.0f, 1.0f } };
    const Matrix before = *m;
    Matrix turned;
    components_of(turn, turned.m);
    matrix_product(&turned, &before, m);
    m->m[3] = before.m[3];
    m->m[7] = before.m[7];
    m->m[11] = before.m[11];
}

// Returns the transform in one lane.
INLINE float16 matrix_in(const Matrix *all, uint lane)
{
    return (float16)(LANE(all->m[0], lane), LANE(all->m[1], lane), LANE(all->m[2], lane),
                     LANE(all->m[3], lane), LANE(all->m[4], lane), LANE(all->m[5], lane),
                     LANE(all->m[6], lane), LANE(all->m[7], lane), LANE(all->m[8], lane),
                     LANE(all->m[9], lane), LANE(all->m[10], lane), LANE(all->m[11], lane),
                     (float4)(0.0f));
}

INLINE void put_matrix(Matrix *all, uint lane, float16 one)
{
    PUT(all->m[0], lane, one.s0);
    PUT(all->m[1], lane, one.s1);
    PUT(all->m[2], lane, one.s2);
    PUT(all->m[3], lane, one.s3);
    PUT(all->m[4], lane, one.s4);
    PUT(all->m[5], lane, one.s5);
    PUT(all->m[6], lane, one.s6);
    PUT(all->m[7], lane, one.s7);
    PUT(all->m[8], lane, one.s8);
    PUT(all->m[9], lane, one.s9);
    PUT(all->m[10], lane, one.sa);
    PUT(all->m[11], lane, one.sb);
}
