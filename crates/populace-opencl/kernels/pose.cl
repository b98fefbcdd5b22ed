// pose.cl - Pose stage (Lister & Day 2012, section 3, fig. 1): mixes each member's slots, layer by
// layer, into local transforms.
//
// NDRange  (elements of the joint buffer, padded to whole work-groups); 16 elements are one block
//          of one member's joints
// Reads    members, samples, slots, machine_states, running, layers, rows of clips, stored poses,
//          joint maps, masks, overrides in local space, users' stages
// Writes   translations, rotations, scales: each joint once, padding untouched
// Oracle   populace-testkit/src/oracle/pose.rs
// Twin of populace-native/src/pose.rs: same arithmetic, same order of operations.

__kernel void pose(
    // Members and their bodies.
    __global const Member *members, __global const uint *joint_blocks, __global const Body *bodies,
    // What they play.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running, __global const SlotSample *samples,
    __global const Layer *layers,
    // Clips and stored poses.
    __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks,
    __global const ClipRows *clips, __global const uint *rows, __global const float *poses,
    __global const float *masks,
    // Ranges.
    uint slots_per_member, uint place_count, uint member_first, uint member_end,
    // Constraint programs and users' stages.
    __global const Control *controls, __global const Override *overrides,
    __global const float *joint_scales, __global const Step *steps,
    __global const float4 *stage_values,
    // The clock.
    ulong tick, uint elapsed_ticks,
    // Output.
    __global float4 *translations, __global float4 *rotations, __global float4 *scales)
{
    const uint place = (uint)get_global_id(0);
    if (place >= place_count || joint_blocks[place / JOINT_BLOCK] == NONE) return;
    const uint owner = joint_blocks[place / JOINT_BLOCK];
    if (owner < member_first || owner >= member_end) return;
    const Member member = members[owner];
    const Body body = bodies[member.posed];
    const uint joint = place - member.joint_first, first_slot = owner * slots_per_member;
    if (joint >= body.joint_count) return;

    const ClipTables clip_tables = { bound_clips, bound_blocks, clips, rows, poses, masks };
    const Machines machines = { machine_states, running };
    Playback playback = { slots + first_slot,
                          samples + first_slot,
                          slots_per_member,
                          machines,
                          inertialization_of(slots + first_slot, slots_per_member, tick),
                          false,
                          0 };
    playback.alone = alone_in_layers(playback);
    const Adjustments adjustments = {
        controls, overrides, joint_scales STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)
    };
    const Local trs =
        pose_joint(&clip_tables, adjustments, member.control, playback,
                   layers + owner * LAYERS_PER_MEMBER, member_layers(member), body, joint);
    translations[place] = (float4)(trs.t.x, trs.t.y, trs.t.z, 0.0f);
    rotations[place] = (float4)(trs.r.x, trs.r.y, trs.r.z, trs.r.w);
    scales[place] = (float4)(trs.s.x, trs.s.y, trs.s.z, 0.0f);
}
