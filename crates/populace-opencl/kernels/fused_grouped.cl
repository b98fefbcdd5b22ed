/* fused_grouped.cl - the whole frame of a member in one work-group of GROUP, for GPUs: work-items share out the slots, then
 * the joints from rows to local transforms, then level by level down the hierarchy, then the rows of the palette. Nothing
 * between clip and palette leaves the group's local memory.
 * NDRange  (members of one page x GROUP), a group for each member; one enqueue for each phase
 * Reads    the page's members; slots, machines, layers, rows and all that they point at; what earlier phases wrote of what is
 *          watched
 * Writes   palette: every entry of the phase's members in [place_first, place_end) exactly once, padding untouched
 * Oracle   populace-testkit; the same arithmetic as populace-native fused.rs */

/* What a member plays, for the whole group. Slots that weigh nothing stay where they are: what mixes passes them over. */
INLINE Playback play_all(__global const Slot *slots, uint slot_count, Machines machines, ulong tick, const Clips *of,
                         __global const float *row_times, __global const uint *buckets, __local Playing *playing)
{
    for (uint s = (uint)get_local_id(0); s < slot_count; s += GROUP)
        playing[s] = play(slots[s], machines, tick, of, row_times, buckets);
    barrier(CLK_LOCAL_MEM_FENCE);
    const Playback playback = { playing, slot_count, inertialization_of(slots, slot_count, tick) };
    return playback;
}

/* A member's joints to take down the hierarchy. */
typedef struct { const Controls *of; uint control; TURNS float4 *turns; Hierarchy models; } Descent;

INLINE void descend_to(Descent to, uint joint, uint parent)
{
    if (parent == NONE && to.control == NONE) return; /* a local transform without a parent is a model transform */
    float16 model = model_of(to.models, joint), above = model;
    if (parent != NONE) {
        above = model_of(to.models, parent);
        model = affine_mul(above, model);
    }
    if (to.control != NONE) {
        const Steering s = steering_of(to.of, to.control, to.turns);
        model = steer(&s, to.models, joint, model, above, parent != NONE);
    }
    keep_model(to.models, joint, model.s0123, model.s4567, model.s89ab);
}

/* A member's model_from_joint, for the whole group, and where `planes` is not 0 its local transforms there: ten planes as
 * in stored poses. */
INLINE void member_models(const Clips *of, Locals locals, Descent to, Playback playback, __global const Layer *layers,
                          uint layer_count, Body body, __global const uint *parent, __global const uint *level,
                          __global float *planes)
{
    for (uint joint = (uint)get_local_id(0); joint < body.joint_count; joint += GROUP) {
        const Trs trs = pose_joint(of, locals, to.control, playback, layers, layer_count, body, joint);
        if (planes) store_trs(trs, planes + joint, body.padded_count);
        float m[12];
        components_of(trs, m);
        keep_model(to.models, joint, (float4)(m[0], m[1], m[2], m[3]), (float4)(m[4], m[5], m[6], m[7]),
                   (float4)(m[8], m[9], m[10], m[11]));
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint begin = 0;
    for (uint l = 0; l < body.level_count; l++) {
        const uint end = level[l + 1];
        for (uint joint = begin + (uint)get_local_id(0); joint < end; joint += GROUP) descend_to(to, joint, parent[joint]);
        begin = end;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

/* The three rows of an entry are written by three work-items side by side. */
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1)))
void fused_grouped(__global const Member *members, __global const Body *bodies, __global const uint *parents,
                   __global const Slot *slots, __global const MachineState *machine_states,
                   __global const Running *running, __global const Layer *layers, __global const BoundClip *bound_clips,
                   __global const BoundBlock *bound_blocks, __global const ClipRows *clips,
                   __global const RowBlock *row_blocks, __global const uint *rows, __global const float *row_times,
                   __global const uint *buckets, __global const float *poses, __global const float *masks,
                   __global const uint *levels, __global const uint *joint_maps, ulong tick, uint slots_per_member,
                   __global const float *joint_scales, CONTROL_PARAMETERS,
                   __global const uint *page_members, __global const Entry *entries, uint place_first, uint place_end,
                   uint phase, uint page_first, __global float4 *restrict palette, uint stride, __local float4 *model_rows)
{
    __local Playing playing[SLOTS_MOST];
    __local float4 turns[TURNS_MOST];
    const uint owner = page_members[get_group_id(0)];
    const Member member = members[owner];
    if (owner < place_first || owner >= place_end || member_phase(member) != phase) return;
    const Clips of = { bound_clips, bound_blocks, 0, 0, clips, row_blocks, joint_maps, rows, poses, masks };
    const Locals locals = { controls, overrides, joint_scales STAGE_TABLES(tick, elapsed_ticks) };
    const Controls steering = CONTROLS;
    const Machines machines = { machine_states, running };
    const Body body = bodies[member.body];
    const Playback playback =
        play_all(slots + owner * slots_per_member, slots_per_member, machines, tick, &of, row_times, buckets, playing);
    const Hierarchy models = { model_rows, stride };
    const Descent down = { &steering, member.control, turns, models };
    member_models(&of, locals, down, playback, layers + owner * LAYERS_PER_MEMBER, member_layers(member), body,
                  parents + body.joint_first, levels + body.level_first, 0);
    __global float4 *to = palette + 3 * (size_t)(member.palette_first - page_first);
    for (uint i = (uint)get_local_id(0); i < 3 * body.entry_count; i += GROUP) {
        __global const Entry *entry = entries + body.entry_first + i / 3;
        to[i] = affine_row(model_rows[i % 3 * stride + entry->joint], entry->row0, entry->row1, entry->row2);
    }
}

/* What lies between slots and palette, of one member, for those who want to read it. */
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1)))
void fused_grouped_joints(__global const Member *members, __global const Body *bodies, __global const uint *parents,
                          __global const Slot *slots, __global const MachineState *machine_states,
                          __global const Running *running, __global const Layer *layers,
                          __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks,
                          __global const ClipRows *clips, __global const RowBlock *row_blocks, __global const uint *rows,
                          __global const float *row_times, __global const uint *buckets, __global const float *poses,
                          __global const float *masks, __global const uint *levels, __global const uint *joint_maps,
                          ulong tick, uint slots_per_member, __global const float *joint_scales, CONTROL_PARAMETERS, uint owner, __global SlotSample *samples,
                          __global float *planes, __global float4 *matrices, uint stride, __local float4 *model_rows)
{
    __local Playing playing[SLOTS_MOST];
    __local float4 turns[TURNS_MOST];
    const Clips of = { bound_clips, bound_blocks, 0, 0, clips, row_blocks, joint_maps, rows, poses, masks };
    const Locals locals = { controls, overrides, joint_scales STAGE_TABLES(tick, elapsed_ticks) };
    const Controls steering = CONTROLS;
    const Machines machines = { machine_states, running };
    const Member member = members[owner];
    const Body body = bodies[member.body];
    const Playback playback =
        play_all(slots + owner * slots_per_member, slots_per_member, machines, tick, &of, row_times, buckets, playing);
    for (uint s = (uint)get_local_id(0); s < slots_per_member; s += GROUP) samples[s] = playing[s].at;
    const Hierarchy models = { model_rows, stride };
    const Descent down = { &steering, member.control, turns, models };
    member_models(&of, locals, down, playback, layers + owner * LAYERS_PER_MEMBER, member_layers(member), body,
                  parents + body.joint_first, levels + body.level_first, planes);
    for (uint joint = (uint)get_local_id(0); joint < body.joint_count; joint += GROUP)
        vstore16(model_of(models, joint), joint, (__global float *)matrices);
}
