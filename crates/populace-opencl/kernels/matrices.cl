// matrices.cl - Affine transforms in lanes: a matrix of three rows of four in each.
//
// Twin of populace-native/src/matrices.rs: same arithmetic, same order of operations.

// Elements row by row.
typedef struct {
    Real m[12];
} Matrix;

// Writes a * b, which applies b first.
INLINE void matrix_product(const Matrix *a, const Matrix *b, Matrix *to)
{
    Matrix product;
#pragma unroll
    for (uint row = 0; row < 12; row += 4) {
        const Real x = a->m[row], y = a->m[row + 1], z = a->m[row + 2], w = a->m[row + 3];
#pragma unroll
        for (uint column = 0; column < 3; column++)
            product.m[row + column] =
                x * b->m[column] + y * b->m[4 + column] + z * b->m[8 + column];
        product.m[row + 3] = x * b->m[3] + y * b->m[7] + z * b->m[11] + w;
    }
    *to = product;
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
    const Real x = m->m[3], y = m->m[7], z = m->m[11];
    Matrix turned;
    components_of(turn, turned.m);
    matrix_product(&turned, m, m);
    m->m[3] = x;
    m->m[7] = y;
    m->m[11] = z;
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
