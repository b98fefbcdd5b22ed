// hierarchy.cl - Storage of a member's transforms on the way down its hierarchy, for each schedule,
// and the address space of rotations that steps hand down (STEP_ROTATIONS).
//
// Twin of populace-native/src/hierarchy.rs.

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

INLINE float16 local_of(Hierarchy models, uint joint) { return model_of(models, joint); }

#elif LANES > 1

// One float16 for each joint: its local transform until its parent is done.
typedef struct {
    __global const float16 *models;
} Hierarchy;

#define STEP_ROTATIONS __private

INLINE float16 local_of(Hierarchy joints, uint joint) { return joints.models[joint]; }

#else

// The joint buffer from the member's first joint on.
typedef struct {
    __global const float4 *translations, *rotations, *scales;
} Hierarchy;

#define STEP_ROTATIONS __global

INLINE float16 local_of(Hierarchy joints, uint joint)
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
