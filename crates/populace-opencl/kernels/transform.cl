/* transform.cl - Transform (Lister & Day 2012, section 3, fig. 1): one level of local transforms
 *          down the hierarchy.
 * NDRange  (joints of the widest level at this depth, a run of members padded to whole work-groups), one enqueue for
 *          each phase, level and run; members of other phases are passed over
 * Reads    translations, rotations, scales; the rows that the level above wrote; controls and all that they point at; what
 *          earlier phases wrote of what is watched
 * Writes   row0, row1, row2 of model_from_joint: a rotated child under non-uniform scale shears, so rows, not T R S; turns
 *          for the levels below; states and what is watched
 * Oracle   populace-testkit oracle/transform.rs; twin of populace-native transform.rs */

__kernel void transform(__global const Member *members, __global const Body *bodies, __global const uint *parents,
                        __global const uint *levels, uint level, uint member_first, uint member_end, uint phase,
                        __global const float4 *translations, __global const float4 *rotations,
                        __global const float4 *scales, __global const Slot *slots, __global const MachineState *machine_states,
                        __global const Running *running, __global const Layer *layers,
                        __global const BoundClip *bound_clips, __global const ClipRows *clips,
                        __global const float *masks, uint slots_per_member, ulong tick, CONTROL_PARAMETERS, __global float4 *turns,
                        __global float4 *row0, __global float4 *row1, __global float4 *row2)
{
    const uint owner = member_first + (uint)get_global_id(1);
    if (owner >= member_end || members[owner].body == NONE) return;
    const Member member = members[owner];
    if (member_phase(member) != phase) return;
    const Body body = bodies[member.body];
    if (level >= body.level_count) return;
    const uint joint = levels[body.level_first + level] + (uint)get_global_id(0);
    if (joint >= levels[body.level_first + level + 1]) return;

    const uint first = member.joint_first, place = first + joint, parent = parents[body.joint_first + joint];
    const Hierarchy joints = { translations + first, rotations + first, scales + first };
    float16 model = local_of(joints, joint), above = model;
    if (parent != NONE) {
        above = (float16)(row0[first + parent], row1[first + parent], row2[first + parent], (float4)(0.0f));
        model = affine_mul(above, model);
    }
    if (member.control != NONE) {
        const Controls of = CONTROLS;
        const Steering s = steering_of(&of, member.control, turns + member.control * TURNS_MOST);
        model = steer(&s, joints, joint, model, above, parent != NONE);
    }
    row0[place] = model.s0123;
    row1[place] = model.s4567;
    row2[place] = model.s89ab;
}
