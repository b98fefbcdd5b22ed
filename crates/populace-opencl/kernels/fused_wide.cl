// fused_wide.cl - Fused schedule for CPUs: one work-item computes the whole frame of a member. It
// computes local transforms from rows for sixteen joints at a time, transposes them into one matrix
// each, then descends the hierarchy and writes the palette. Everything between clip and palette
// stays in the core's caches. Members with constraints wait at yield points until eight of them can
// be solved side by side; see yield_points.cl.
//
// NDRange  (runs of members of one page), work-groups of one; one enqueue for each phase
// Reads    the page's members; slots, machines, layers, rows, controls and the tables that they
//          index; watched joints that earlier phases wrote
// Writes   palette: each entry of the phase's members in [place_first, place_end) once; matrices:
//          scratch for as many members as wait at once; states and watched joints of those members
// Oracle   populace-testkit/src/oracle
// Twin of populace-native/src/fused.rs: same arithmetic, same order of operations.

// Two rows of a matrix in memory, where matrices are 48 bytes apart.
typedef float8 Rows __attribute__((aligned(16)));

// Transposes a 16 x 16 matrix by four perfect shuffles.
INLINE void transpose(float16 m[16])
{
    float16 t[16];
#pragma unroll
    for (int round = 0; round < 4; round++) {
#pragma unroll
        for (int i = 0; i < 8; i++) {
            const float16 p = m[i], q = m[i + 8];
            t[2 * i] = (float16)(p.s0, q.s0, p.s1, q.s1, p.s2, q.s2, p.s3, q.s3, p.s4, q.s4, p.s5,
                                 q.s5, p.s6, q.s6, p.s7, q.s7);
            t[2 * i + 1] = (float16)(p.s8, q.s8, p.s9, q.s9, p.sa, q.sa, p.sb, q.sb, p.sc, q.sc,
                                     p.sd, q.sd, p.se, q.se, p.sf, q.sf);
        }
#pragma unroll
        for (int i = 0; i < 16; i++) m[i] = t[i];
    }
}

// Collects the member's slots that have weight now, in order.
INLINE Playback play_all(__global const Slot *slots, uint slot_count, Machines machines, ulong tick,
                         const ClipTables *tables, __global const float *row_times,
                         __global const uint *buckets, Playing *playing)
{
    uint count = 0;
    for (uint s = 0; s < slot_count; s++) {
        playing[count] = play(slots[s], machines, tick, tables, row_times, buckets);
        if (playing[count].at.weight > 0.0f) count++;
    }
    const Playback playback = { playing, count, inertialization_of(slots, slot_count, tick) };
    return playback;
}

INLINE void descend_to(uint joint, __global const uint *parent, __global float16 *models)
{
    if (parent[joint] != NONE) models[joint] = affine_mul(models[parent[joint]], models[joint]);
}

// Destination and entries of a member's palette.
typedef struct {
    __global const Entry *entries;
    uint count;
    __global float *to;
} Output;

INLINE void write_palette(Output output, __global const float16 *models)
{
    __global const Entry *entry = output.entries;
    __global float *to = output.to;
    for (uint e = 0; e < output.count; e++, entry++, to += 12) {
        const float16 out =
            affine_mul_rows(models[entry->joint], entry->row0, entry->row1, entry->row2);
        *(__global Rows *)to = out.lo;
        vstore4(out.hi.lo, 0, to + 8);
    }
}

// A member with a constraint program on its way down its hierarchy.
typedef struct {
    Solver s;
    __global const uint *parent;
    __global float16 *models;
    uint joint_count, joint, step; // next joint and next step
    uint stands_at; // kind of the step that the member waits at, NONE if it does not wait
    Output output;
    float4 turns[MAX_STEP_ROTATIONS];
} Descent;

INLINE void descend(Descent *down, uint end)
{
    for (; down->joint < end; down->joint++) descend_to(down->joint, down->parent, down->models);
}

// Descends to the next batched step, or to the end and writes the palette.
APART void go_down(Descent *down)
{
    const Solver *s = &down->s;
    const Hierarchy joints = { down->models };
    for (; down->step < s->control.step_count; down->step++) {
        const Step step = s->tables->steps[s->control.step_first + down->step];
        descend(down, step.joint + 1);
        down->stands_at = step.kind;
        if (is_batched(step.kind)) return;
        down->models[step.joint] = take_step(s, joints, step, down->models[step.joint]);
    }
    descend(down, down->joint_count);
    down->stands_at = NONE;
    write_palette(down->output, down->models);
}

// Returns the step that a member waits at.
INLINE YieldPoint stop_of(const Descent *down)
{
    const Step step = down->s.tables->steps[down->s.control.step_first + down->step];
    const uint above = down->parent[step.joint];
    const Hierarchy joints = { down->models };
    const YieldPoint stop = { &down->s,
                              joints,
                              step,
                              down->models[step.joint],
                              down->models[above == NONE ? step.joint : above],
                              above != NONE };
    return stop;
}

// Runs the pending step of the first waiting member together with all pending steps of the same
// kind, then descends further with those members. Returns whether any member was waiting.
APART bool step_batch(Descent *all, uint count)
{
    YieldPoint at[BATCH];
    Descent *who[BATCH];
    uint kind = NONE, stopped = 0;
    for (Descent *down = all; down < all + count; down++) {
        if (kind == NONE) kind = down->stands_at;
        if (kind == NONE || down->stands_at != kind) continue;
        at[stopped] = stop_of(down);
        who[stopped++] = down;
    }
    if (stopped == 0) return false;
    take_batch(kind, at, stopped);
    for (uint m = 0; m < stopped; m++) {
        who[m]->models[at[m].step.joint] = at[m].own;
        who[m]->step++;
        go_down(who[m]);
    }
    return true;
}

// Computes a member's local transforms, one float16 each. If `planes` is not 0, it receives them
// too, as ten planes in the layout of stored poses.
INLINE void pose_member(const ClipTables *tables, Adjustments adjustments, uint control,
                        Playback playback, __global const Layer *layers, uint layer_count,
                        Body body, __global float16 *restrict models, __global float *planes)
{
    for (uint joint = 0; joint < body.joint_count; joint += JOINT_BLOCK) {
        const Local trs =
            pose_joint(tables, adjustments, control, playback, layers, layer_count, body, joint);
        if (planes) store_trs(trs, planes + joint, body.padded_count);
        float16 m[16];
        components_of(trs, m);
        m[12] = m[13] = m[14] = m[15] = 0.0f;
        transpose(m);
#pragma unroll
        for (int i = 0; i < 16; i++) models[joint + i] = m[i];
    }
}

// Starts a member at the top of its hierarchy.
INLINE void set_out(Descent *down, const ConstraintTables *tables, uint control, Body body,
                    __global const uint *parents, __global float16 *models, Output output)
{
    down->s = solver_of(tables, control, down->turns);
    down->parent = parents + body.joint_first;
    down->models = models;
    down->joint_count = body.joint_count;
    down->joint = down->step = 0;
    down->output = output;
    go_down(down);
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void fused_wide(
    // Members and their bodies.
    __global const Member *members, __global const Body *bodies, __global const uint *parents,
    // What they play.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running, __global const Layer *layers,
    // Clips and stored poses.
    __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks,
    __global const ClipRows *clips, __global const RowBlock *row_blocks, __global const uint *rows,
    __global const float *row_times, __global const uint *buckets, __global const float *poses,
    __global const float *masks, __global const Source *sources, __global const uint *source_lanes,
    // The clock, and the slots of each member.
    ulong tick, uint slots_per_member,
    // Constraint programs.
    __global const float *joint_scales, CONSTRAINT_PARAMETERS,
    // Members of the page, and their palettes.
    __global const uint *page_members, __global const Entry *entries, uint place_first,
    uint place_end, uint phase, uint page_first, __global float4 *restrict palette,
    // Distribution over work-items, and their scratch.
    uint member_count, uint run, uint abreast, uint padded_most, __global float4 *restrict matrices)
{
    const ClipTables clip_tables = { bound_clips, bound_blocks, sources, source_lanes,
                                     clips,       row_blocks,   0,       rows,
                                     poses,       masks };
    const Adjustments adjustments = {
        controls, overrides, joint_scales STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)
    };
    const Machines machines = { machine_states, running };
    const ConstraintTables constraint_tables = constraint_tables_of(
        controls, steps, overrides, constraints, links, targets, ground, heights, soles, contacts,
        states_before,
        watched_before, states, watched, stage_values, motions, elapsed_ticks, members, slots,
        layers, bound_clips, clips, masks, slots_per_member, machines, tick);
    __global float16 *desk =
        (__global float16 *)matrices + get_global_id(0) * padded_most * abreast;
    const uint begin = (uint)get_global_id(0) * run, end = min(begin + run, member_count);
    Descent down[BATCH];
    uint count = 0;
    for (uint index = begin; index < end; index++) {
        const uint owner = page_members[index];
        if (owner < place_first || owner >= place_end) continue;
        const Member member = members[owner];
        if (member_phase(member) != phase) continue;
        const Body body = bodies[member.posed];
        __global float16 *restrict models = desk + count * padded_most;
        Playing playing[MAX_SLOTS];
        const Playback playback =
            play_all(slots + owner * slots_per_member, slots_per_member, machines, tick,
                     &clip_tables, row_times, buckets, playing);
        pose_member(&clip_tables, adjustments, member.control, playback,
                    layers + owner * LAYERS_PER_MEMBER, member_layers(member), body, models, 0);
        const Output output = {
            entries + body.entry_first, body.entry_count,
            (__global float *)(palette + 3 * (size_t)(member.palette_first - page_first))
        };
        if (member.control == NONE) {
            for (uint joint = 0; joint < body.joint_count; joint++)
                descend_to(joint, parents + body.joint_first, models);
            write_palette(output, models);
            continue;
        }
        set_out(&down[count], &constraint_tables, member.control, body, parents, models, output);
        if (down[count].stands_at != NONE) count++;
        if (count < abreast) continue;
        while (step_batch(down, count)) {}
        count = 0;
    }
    while (step_batch(down, count)) {}
}

// Computes samples, local transforms and model_from_joint of one member, for reading back.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void fused_wide_joints(
    // Members and their bodies.
    __global const Member *members, __global const Body *bodies, __global const uint *parents,
    // What they play.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running, __global const Layer *layers,
    // Clips and stored poses.
    __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks,
    __global const ClipRows *clips, __global const RowBlock *row_blocks, __global const uint *rows,
    __global const float *row_times, __global const uint *buckets, __global const float *poses,
    __global const float *masks, __global const Source *sources, __global const uint *source_lanes,
    // The clock, and the slots of each member.
    ulong tick, uint slots_per_member,
    // Constraint programs.
    __global const float *joint_scales, CONSTRAINT_PARAMETERS,
    // The member, and outputs.
    uint owner, __global SlotSample *samples, __global float *planes, __global float4 *matrices)
{
    const ClipTables clip_tables = { bound_clips, bound_blocks, sources, source_lanes,
                                     clips,       row_blocks,   0,       rows,
                                     poses,       masks };
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
    __global const Slot *mine = slots + owner * slots_per_member;
    __global float16 *models = (__global float16 *)matrices;
    for (uint s = 0; s < slots_per_member; s++)
        samples[s] = play(mine[s], machines, tick, &clip_tables, row_times, buckets).at;
    Playing playing[MAX_SLOTS];
    const Playback playback =
        play_all(mine, slots_per_member, machines, tick, &clip_tables, row_times, buckets, playing);
    pose_member(&clip_tables, adjustments, member.control, playback,
                layers + owner * LAYERS_PER_MEMBER, member_layers(member), body, models, planes);
    if (member.control == NONE) {
        for (uint joint = 0; joint < body.joint_count; joint++)
            descend_to(joint, parents + body.joint_first, models);
        return;
    }
    const Output none = { 0, 0, 0 };
    Descent down;
    set_out(&down, &constraint_tables, member.control, body, parents, models, none);
    while (step_batch(&down, 1)) {}
}
