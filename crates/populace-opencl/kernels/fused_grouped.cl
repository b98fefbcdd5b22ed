// fused_grouped.cl - Fused schedule for GPUs: one work-group of GROUP computes the whole frame of a
// member. Work-items share out the slots, then the joints from rows to local transforms, then each
// level of the hierarchy, then the rows of the palette. Everything between clip and palette stays
// in local memory.
//
// NDRange  (members of one page x GROUP), a work-group for each member; one enqueue for each phase
// Reads    the page's members; slots, machines, layers, rows, controls and the tables that they
//          index; watched joints that earlier phases wrote
// Writes   palette: each entry of the phase's members in [place_first, place_end) once, padding
//          untouched; states and watched joints of those members
// Oracle   populace-testkit/src/oracle
// Twin of populace-native/src/fused.rs: same arithmetic.

// Collects what a member plays, for the whole group. Slots without weight stay in the list; mixing
// skips them.
INLINE Playback play_all(__global const Slot *slots, uint slot_count, Machines machines, ulong tick,
                         const ClipTables *tables, __global const float *row_times,
                         __global const uint *buckets, __local Playing *playing)
{
    for (uint s = (uint)get_local_id(0); s < slot_count; s += GROUP)
        playing[s] = play(slots[s], machines, tick, tables, row_times, buckets);
    barrier(CLK_LOCAL_MEM_FENCE);
    const Playback playback = { playing, slot_count, inertialization_of(slots, slot_count, tick) };
    return playback;
}

// Inputs of a member's way down its hierarchy.
typedef struct {
    const ConstraintTables *tables;
    uint control;
    Rotations step_rotations;
    Hierarchy models;
} Descent;

INLINE void descend(Descent to, uint joint, uint parent)
{
    // Without a parent, the local transform is the model transform.
    if (parent == NONE && to.control == NONE) return;
    float16 model = model_of(to.models, joint), above = model;
    if (parent != NONE) {
        above = model_of(to.models, parent);
        model = affine_mul(above, model);
    }
    if (to.control != NONE) {
        const Solver s = solver_of(to.tables, to.control);
        model = solve_joint(&s, to.models, to.step_rotations, joint, model, above, parent != NONE);
    }
    keep_model(to.models, joint, model.s0123, model.s4567, model.s89ab);
}

// Computes model_from_joint of all joints of a member, for the whole group. If `planes` is not 0,
// it also receives the local transforms as ten planes, in the layout of stored poses.
INLINE void member_models(const ClipTables *tables, Adjustments adjustments, Descent to,
                          Playback playback, __global const Layer *layers, uint layer_count,
                          Body body, __global const uint *parent, __global const uint *level,
                          __global float *planes)
{
    for (uint joint = (uint)get_local_id(0); joint < body.joint_count; joint += GROUP) {
        const Local trs =
            pose_joint(tables, adjustments, to.control, playback, layers, layer_count, body, joint);
        if (planes) store_trs(trs, planes + joint, body.padded_count);
        float m[12];
        components_of(trs, m);
        keep_model(to.models, joint, (float4)(m[0], m[1], m[2], m[3]),
                   (float4)(m[4], m[5], m[6], m[7]), (float4)(m[8], m[9], m[10], m[11]));
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint begin = 0;
    for (uint l = 0; l < body.level_count; l++) {
        const uint end = level[l + 1];
        for (uint joint = begin + (uint)get_local_id(0); joint < end; joint += GROUP)
            descend(to, joint, parent[joint]);
        begin = end;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

// Three neighbouring work-items write the three rows of an entry.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void fused_grouped(
    // Members and their bodies.
    __global const Member *members, __global const Body *bodies, __global const uint *parents,
    // What they play.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running, __global const Layer *layers,
    // Clips and stored poses.
    __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks,
    __global const ClipRows *clips, __global const RowBlock *row_blocks, __global const uint *rows,
    __global const float *row_times, __global const uint *buckets, __global const float *poses,
    __global const float *masks,
    // Levels and joint maps.
    __global const uint *levels, __global const uint *joint_maps,
    // The clock, and the slots of each member.
    ulong tick, uint slots_per_member,
    // Constraint programs.
    __global const float *joint_scales, CONSTRAINT_PARAMETERS,
    // Members of the page, and their palettes.
    __global const uint *page_members, __global const Entry *entries, uint place_first,
    uint place_end, uint phase, uint page_first, __global float4 *restrict palette,
    // Local memory.
    uint stride, __local float4 *model_rows)
{
    __local Playing playing[MAX_SLOTS];
    __local float4 step_rotations[MAX_STEP_ROTATIONS];
    const uint owner = page_members[get_group_id(0)];
    const Member member = members[owner];
    if (owner < place_first || owner >= place_end || member_phase(member) != phase) return;
    const ClipTables clip_tables = { bound_clips, bound_blocks, 0,    0,     clips,
                                     row_blocks,  joint_maps,   rows, poses, masks };
    const Adjustments adjustments = {
        controls, overrides, joint_scales STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)
    };
    const Machines machines = { machine_states, running };
    const ConstraintTables constraint_tables = constraint_tables_of(
        controls, steps, overrides, constraints, links, targets, ground, heights, soles, contacts,
        states_before,
        watched_before, states, watched, stage_values, motions, elapsed_ticks, members, slots,
        layers, bound_clips, clips, masks, slots_per_member, machines, tick);
    const Body body = bodies[member.posed];
    const Playback playback = play_all(slots + owner * slots_per_member, slots_per_member, machines,
                                       tick, &clip_tables, row_times, buckets, playing);
    const Hierarchy models = { model_rows, stride };
    const Descent down = { &constraint_tables, member.control, step_rotations, models };
    member_models(&clip_tables, adjustments, down, playback, layers + owner * LAYERS_PER_MEMBER,
                  member_layers(member), body, parents + body.joint_first,
                  levels + body.level_first, 0);
    __global float4 *to = palette + 3 * (size_t)(member.palette_first - page_first);
    for (uint i = (uint)get_local_id(0); i < 3 * body.entry_count; i += GROUP) {
        __global const Entry *entry = entries + body.entry_first + i / 3;
        to[i] = affine_row(model_rows[i % 3 * stride + entry->joint], entry->row0, entry->row1,
                           entry->row2);
    }
}

// Computes samples, local transforms and model_from_joint of one member, for reading back.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void fused_grouped_joints(
    // Members and their bodies.
    __global const Member *members, __global const Body *bodies, __global const uint *parents,
    // What they play.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running, __global const Layer *layers,
    // Clips and stored poses.
    __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks,
    __global const ClipRows *clips, __global const RowBlock *row_blocks, __global const uint *rows,
    __global const float *row_times, __global const uint *buckets, __global const float *poses,
    __global const float *masks,
    // Levels and joint maps.
    __global const uint *levels, __global const uint *joint_maps,
    // The clock, and the slots of each member.
    ulong tick, uint slots_per_member,
    // Constraint programs.
    __global const float *joint_scales, CONSTRAINT_PARAMETERS,
    // The member, and outputs.
    uint owner, __global SlotSample *samples, __global float *planes, __global float4 *matrices,
    // Local memory.
    uint stride, __local float4 *model_rows)
{
    __local Playing playing[MAX_SLOTS];
    __local float4 step_rotations[MAX_STEP_ROTATIONS];
    const ClipTables clip_tables = { bound_clips, bound_blocks, 0,    0,     clips,
                                     row_blocks,  joint_maps,   rows, poses, masks };
    const Adjustments adjustments = {
        controls, overrides, joint_scales STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)
    };
    const Machines machines = { machine_states, running };
    const ConstraintTables constraint_tables = constraint_tables_of(
        controls, steps, overrides, constraints, links, targets, ground, heights, soles, contacts,
        states_before,
        watched_before, states, watched, stage_values, motions, elapsed_ticks, members, slots,
        layers, bound_clips, clips, masks, slots_per_member, machines, tick);
    const Member member = members[owner];
    const Body body = bodies[member.posed];
    const Playback playback = play_all(slots + owner * slots_per_member, slots_per_member, machines,
                                       tick, &clip_tables, row_times, buckets, playing);
    for (uint s = (uint)get_local_id(0); s < slots_per_member; s += GROUP)
        samples[s] = playing[s].at;
    const Hierarchy models = { model_rows, stride };
    const Descent down = { &constraint_tables, member.control, step_rotations, models };
    member_models(&clip_tables, adjustments, down, playback, layers + owner * LAYERS_PER_MEMBER,
                  member_layers(member), body, parents + body.joint_first,
                  levels + body.level_first, planes);
    for (uint joint = (uint)get_local_id(0); joint < body.joint_count; joint += GROUP)
        vstore16(model_of(models, joint), joint, (__global float *)matrices);
}
