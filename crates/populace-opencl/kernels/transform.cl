/* transform.cl - Transform: one level of local transforms down the hierarchy (Lister & Day 2012, section 4.2).
 * NDRange  (joints of the widest level at this depth, a run of members padded to whole work-groups), one enqueue for
 *          each level and run
 * Reads    translations, rotations, scales; the rows that the level above wrote
 * Writes   row0, row1, row2 of model_from_joint: a rotated child under non-uniform scale shears, so rows, not T R S
 * Oracle   populace-testkit oracle/transform.rs; twin of populace-native transform.rs */

__kernel void transform(__global const Member *members, __global const Body *bodies, __global const uint *parents,
                        __global const uint *levels, uint level, uint member_first, uint member_end,
                        __global const float4 *translations, __global const float4 *rotations,
                        __global const float4 *scales, __global float4 *row0, __global float4 *row1,
                        __global float4 *row2)
{
    const uint owner = member_first + (uint)get_global_id(1);
    if (owner >= member_end || members[owner].body == NONE) return;
    const Member member = members[owner];
    const Body body = bodies[member.body];
    if (level >= body.level_count) return;
    const uint joint = levels[body.level_first + level] + (uint)get_global_id(0);
    if (joint >= levels[body.level_first + level + 1]) return;

    const uint place = member.joint_first + joint, parent = parents[body.joint_first + joint];
    const float4 t = translations[place], r = rotations[place], s = scales[place];
    const Trs trs = { { t.x, t.y, t.z }, { r.x, r.y, r.z, r.w }, { s.x, s.y, s.z } };
    float m[12];
    components_of(trs, m);
    float16 model = (float16)(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], (float4)(0.0f));
    if (parent != NONE) {
        const uint above = member.joint_first + parent;
        model = affine_mul((float16)(row0[above], row1[above], row2[above], (float4)(0.0f)), model);
    }
    row0[place] = model.s0123;
    row1[place] = model.s4567;
    row2[place] = model.s89ab;
}
