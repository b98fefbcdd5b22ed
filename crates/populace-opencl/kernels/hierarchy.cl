// hierarchy.cl - Storage of transforms on the way down the hierarchy, for each schedule, and of
// rotations that steps hand down.
//
// Twin of populace-native/src/hierarchy.rs and populace-native/src/matrices.rs.

#if defined(GROUP)

// Matrices in local memory: three arrays of rows, each `stride` elements long. A joint holds its
// local transform until its level is done.
typedef struct {
    __local float4 *rows;
    uint stride;
} Hierarchy;

#define STEP_ROTATIONS __local

INLINE float16 model_of(Hierarchy models, uint joint)
{
    __local const float4 *row = models.rows + joint;
    return (float16)(row[0], row[models.stride], row[2 * models.stride], (float4)(0.0f));
}

INLINE void keep_model(Hierarchy models, uint joint, float4 row0, float4 row1, float4 row2)
{
    __local float4 *row = models.rows + joint;
    row[0] = row0;
    row[models.stride] = row1;
    row[2 * models.stride] = row2;
}

INLINE float16 local_in(Hierarchy models, uint joint, uint lane) { return model_of(models, joint); }

#elif LANES > 1

// A matrix in lanes of members for each joint: local transforms until the joint is reached.
typedef struct {
    __global Matrix *joints;
} Hierarchy;

INLINE void models_of(Hierarchy all, uint joint, Matrix *models) { *models = all.joints[joint]; }

INLINE void keep_models(Hierarchy all, uint joint, const Matrix *models)
{
    all.joints[joint] = *models;
}

// Keeps the transforms of a joint beneath its parent, from its local ones. Rows are read and written
// one after the other, so that registers hold one.
INLINE void keep_beneath(Hierarchy all, uint parent, uint joint, const Matrix *locals)
{
    __global const Real *from = all.joints[parent].m;
    __global Real *to = all.joints[joint].m;
#pragma unroll
    for (uint row = 0; row < 12; row += 4) {
        const MatrixRow above = { from[row], from[row + 1], from[row + 2], from[row + 3] };
        const MatrixRow model = row_product(above, locals);
        to[row] = model.x;
        to[row + 1] = model.y;
        to[row + 2] = model.z;
        to[row + 3] = model.w;
    }
}

// Writes the transforms of a joint after a matrix that all members share.
INLINE void models_after(Hierarchy all, uint joint, const float *shared, Matrix *to)
{
    IN_MEMORY __global const Real *m = all.joints[joint].m;
#pragma unroll
    for (uint column = 0; column < 4; column += 2) {
        const Real x = shared[column], y = shared[4 + column], z = shared[8 + column];
        const Real next_x = shared[column + 1], next_y = shared[5 + column],
                   next_z = shared[9 + column];
#pragma unroll
        for (uint row = 0; row < 12; row += 4) {
            const Real a = m[row], b = m[row + 1], c = m[row + 2];
            to->m[row + column] = a * x + b * y + c * z;
            const Real next = a * next_x + b * next_y + c * next_z;
            to->m[row + column + 1] = column == 2 ? next + m[row + 3] : next;
        }
    }
}

INLINE void locals_of(Hierarchy joints, uint joint, Matrix *locals)
{
    models_of(joints, joint, locals);
}

INLINE float16 local_in(Hierarchy joints, uint joint, uint lane)
{
    const Matrix locals = joints.joints[joint];
    return matrix_in(&locals, lane);
}

#else

// The joint buffer from the member's first joint on: local transforms, and rows of model transforms.
typedef struct {
    __global const float4 *translations, *rotations, *scales;
    __global float4 *row0, *row1, *row2;
} Hierarchy;

#define STEP_ROTATIONS __global

INLINE float16 model_of(Hierarchy joints, uint joint)
{
    return (float16)(joints.row0[joint], joints.row1[joint], joints.row2[joint], (float4)(0.0f));
}

INLINE void keep_model(Hierarchy joints, uint joint, float4 row0, float4 row1, float4 row2)
{
    joints.row0[joint] = row0;
    joints.row1[joint] = row1;
    joints.row2[joint] = row2;
}

INLINE float16 local_in(Hierarchy joints, uint joint, uint lane)
{
    const float4 t = joints.translations[joint], r = joints.rotations[joint],
                 s = joints.scales[joint];
    const Local trs = { { t.x, t.y, t.z }, { r.x, r.y, r.z, r.w }, { s.x, s.y, s.z } };
    float m[12];
    components_of(trs, m);
    return (float16)(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11],
                     (float4)(0.0f));
}

#endif

#if LANES == 1

INLINE void models_of(Hierarchy models, uint joint, Matrix *one)
{
    put_matrix(one, 0, model_of(models, joint));
}

INLINE void keep_models(Hierarchy models, uint joint, const Matrix *one)
{
    const float16 m = matrix_in(one, 0);
    keep_model(models, joint, m.s0123, m.s4567, m.s89ab);
}

INLINE void locals_of(Hierarchy joints, uint joint, Matrix *locals)
{
    put_matrix(locals, 0, local_in(joints, joint, 0));
}

// Rotations of one member.
typedef STEP_ROTATIONS float4 *Rotations;

INLINE Quat handed_rotations(Rotations rotations, uint index)
{
    const float4 q = rotations[index];
    const Quat all = { q.x, q.y, q.z, q.w };
    return all;
}

INLINE void hand_rotations(Rotations rotations, uint index, Quat all)
{
    rotations[index] = (float4)(all.x, all.y, all.z, all.w);
}

INLINE float4 handed_rotation_in(Rotations rotations, uint index, uint lane)
{
    return rotations[index];
}

INLINE void hand_rotation_in(Rotations rotations, uint index, uint lane, float4 one)
{
    rotations[index] = one;
}

#else

// Rotations in lanes of members.
typedef Quat *Rotations;

INLINE Quat handed_rotations(Rotations rotations, uint index) { return rotations[index]; }

INLINE void hand_rotations(Rotations rotations, uint index, Quat all) { rotations[index] = all; }

INLINE float4 handed_rotation_in(Rotations rotations, uint index, uint lane)
{
    return (float4)(LANE(rotations[index].x, lane), LANE(rotations[index].y, lane),
                    LANE(rotations[index].z, lane), LANE(rotations[index].w, lane));
}

INLINE void hand_rotation_in(Rotations rotations, uint index, uint lane, float4 one)
{
    PUT(rotations[index].x, lane, one.x);
    PUT(rotations[index].y, lane, one.y);
    PUT(rotations[index].z, lane, one.z);
    PUT(rotations[index].w, lane, one.w);
}

#endif
