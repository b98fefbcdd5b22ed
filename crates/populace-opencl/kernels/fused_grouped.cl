// fused_grouped.cl - Fused schedule for GPUs: a work-group of GROUP computes whole frames of up to
// BATCH members of one body side by side. Work-items share out their slots, then their joints from
// rows to local transforms, then each level of the hierarchy, then the rows of their palettes.
// Everything between clip and palette stays in local memory.
//
// Two kernels share out the members: fused_grouped_plain takes those that need none of layers above
// 0, inertialization and constraint programs, and fused_grouped takes all others. A GPU gives every
// work-item of a kernel the registers of its largest part, and so runs few groups of the second
// kernel at once.
//
// NDRange  (groups x GROUP), a group for each `run` places of a page's list; one enqueue for each
//          phase and page, and for fused_grouped_plain one for each page
// Reads    the page's members; slots, machines, layers, rows, controls and the tables that they
//          index; watched joints that earlier phases wrote
// Writes   palette: each entry of the phase's members in [place_first, place_end) once, padding
//          untouched; states and watched joints of those members
// Oracle   populace-testkit/src/oracle
// Twin of populace-native/src/fused.rs: same arithmetic.

// Parents are ready before their children read them. Race detectors are tested without it.
#ifndef LEVEL_BARRIER
#define LEVEL_BARRIER barrier(CLK_LOCAL_MEM_FENCE)
#endif

// clang-format off
// Parameters that all kernels share, in the order in which src/fused.rs sets them: members and
// their bodies; what they play; clips and stored poses; levels; the clock and the
// slots of each member; constraint programs.
#define GROUPED_PARAMETERS \
    __global const Member *members, __global const Body *bodies, __global const uint *parents, \
    __global const Slot *slots, __global const MachineState *machine_states, \
    __global const Running *running, __global const Layer *layers, \
    __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks, \
    __global const ClipRows *clips, \
    __global const uint *rows, __global const float *row_times, __global const uint *buckets, \
    __global const float *poses, __global const float *masks, \
    __global const uint *levels, \
    ulong tick, uint slots_per_member, \
    __global const float *joint_scales, CONSTRAINT_PARAMETERS
#define GROUPED_ARGUMENTS \
    members, bodies, parents, slots, machine_states, running, layers, bound_clips, bound_blocks, \
    clips, rows, row_times, buckets, poses, masks, levels, tick, \
    slots_per_member, joint_scales, CONSTRAINT_ARGUMENTS

// Parameters of the kernels of a frame: members of the page, of which those of a range and a phase
// are computed; their palettes; local memory.
#define PAGE_PARAMETERS \
    __global const uint *page_members, __global const Entry *entries, uint place_first, \
    uint place_end, uint phase, uint page_first, __global float4 *restrict palette, \
    uint member_count, uint run, uint room, __local float4 *memory
#define PAGE_ARGUMENTS page_members, member_count, run, place_first, place_end, phase
// clang-format on

// Tables between the slots of a member and its model_from_joint.
typedef struct {
    __global const Member *members;
    __global const Body *bodies;
    __global const uint *parents, *levels;
    __global const Slot *slots;
    __global const Layer *layers;
    __global const float *row_times;
    __global const uint *buckets;
    ulong tick;
    uint slots_per_member;
    ClipTables clips;
    Adjustments adjustments;
    Machines machines;
    ConstraintTables constraints;
} Grouped;

INLINE Grouped grouped_of(GROUPED_PARAMETERS)
{
    const ClipTables clip_tables = { bound_clips, bound_blocks, clips, rows, poses, masks };
    const Adjustments adjustments = {
        controls, overrides, joint_scales STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)
    };
    const Machines machines = { machine_states, running };
    const ConstraintTables constraint_tables =
        constraint_tables_of(CONSTRAINT_ARGUMENTS, members, slots, layers, bound_clips, clips,
                             masks, slots_per_member, machines, tick);
    const Grouped tables = { members,  bodies,           parents,     levels,
                             slots,    layers,           row_times,   buckets,
                             tick,     slots_per_member, clip_tables, adjustments,
                             machines, constraint_tables };
    return tables;
}

// A member in its page's list, and its body.
typedef struct {
    uint owner, posed;
} Place;

// Members of one body whose frames a group computes side by side, and their part of local memory:
// for each member `share` elements, which hold three arrays of rows of `stride` elements, then what
// it plays, then rotations of its steps unless it is plain.
typedef struct {
    __local const Place *places;
    uint count;
    __local float4 *memory;
    uint share, stride;
} Batch;

INLINE __global const Body *body_of(const Grouped *tables, const Batch *batch)
{
    return tables->bodies + batch->places->posed;
}

// Returns the first members of a list that have one body and fit into local memory. `share_of` in
// src/program.rs describes a member's share.
INLINE Batch batch_of(const Grouped *tables, __local const Place *places, uint listed, bool plain,
                      uint room, __local float4 *memory)
{
    Batch batch = { places, 1, memory, 0, 0 };
    batch.stride = body_of(tables, &batch)->padded_count + STRIDE_PAST_BODY;
    batch.share =
        3 * batch.stride + MAX_SLOTS * PLAYING_ELEMENTS + (plain ? 0 : MAX_STEP_ROTATIONS);
    const uint most = min(min((uint)BATCH, room / batch.share), listed);
    while (batch.count < most && places[batch.count].posed == places->posed) batch.count++;
    return batch;
}

INLINE Hierarchy models_in(const Batch *batch, uint nth)
{
    const Hierarchy models = { batch->memory + nth * batch->share, batch->stride };
    return models;
}

INLINE __local Playing *playing_in(const Batch *batch, uint nth)
{
    return (__local Playing *)(batch->memory + nth * batch->share + 3 * batch->stride);
}

INLINE Rotations rotations_in(const Batch *batch, uint nth)
{
    return batch->memory + nth * batch->share + 3 * batch->stride + MAX_SLOTS * PLAYING_ELEMENTS;
}

// Collects what the members play, for the whole group. Slots without weight stay in the lists;
// mixing skips them.
INLINE void play_all(const Grouped *tables, const Batch *batch)
{
    const uint each = tables->slots_per_member;
    for (uint i = (uint)get_local_id(0); i < batch->count * each; i += GROUP) {
        const uint nth = i / each, s = i % each;
        playing_in(batch, nth)[s] =
            play(tables->slots[batch->places[nth].owner * each + s], tables->machines, tables->tick,
                 &tables->clips, tables->row_times, tables->buckets);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// Where a work-item keeps a pose, so that it takes no registers meanwhile: three rows in local
// memory, `stride` elements apart. They are volatile, or compilers keep a copy in registers.
typedef struct {
    volatile __local float4 *rows;
    uint stride;
} Kept;

INLINE void keep_pose(Kept kept, Local trs)
{
    kept.rows[0] = (float4)(trs.t.x, trs.t.y, trs.t.z, 0.0f);
    kept.rows[kept.stride] = (float4)(trs.r.x, trs.r.y, trs.r.z, trs.r.w);
    kept.rows[2 * kept.stride] = (float4)(trs.s.x, trs.s.y, trs.s.z, 0.0f);
}

INLINE Local kept_pose(Kept kept)
{
    const float4 t = kept.rows[0], r = kept.rows[kept.stride], s = kept.rows[2 * kept.stride];
    const Local trs = { { t.x, t.y, t.z }, { r.x, r.y, r.z, r.w }, { s.x, s.y, s.z } };
    return trs;
}

// Adds all inertializations of a layer to its pose, as inertialize() does.
INLINE Local inertialize_kept(const ClipTables *tables, Inertialization inertialization, uint l,
                              bool additive, Body body, uint joint, Kept kept, Local rest,
                              Local pose)
{
    keep_pose(kept, pose);
    ulong start = ULONG_MAX;
    while (earlier_start(inertialization, l, &start)) {
        const Local left = left_since(tables, inertialization, l, start, additive, joint, rest);
        keep_pose(kept, inertialized(kept_pose(kept), left, additive));
    }
    return kept_pose(kept);
}

// Returns the local transform of a joint, as pose_joint() does. Keeps the pose beneath a layer in
// the joint's rows, and that of the layer among rotations of steps, which follow later.
INLINE Local pose_kept(const Grouped *tables, const Batch *batch, uint nth, Playback playback,
                       uint joint)
{
    const ClipTables *clips = &tables->clips;
    const uint owner = batch->places[nth].owner;
    const Member member = tables->members[owner];
    const Body body = *body_of(tables, batch);
    const Local rest = rest_of(clips, body, joint);
    const Hierarchy models = models_in(batch, nth);
    const Kept beneath = { models.rows + joint, models.stride };
    const Kept posed = { rotations_in(batch, nth) + joint % JOINTS, JOINTS };
    for (uint l = 0; l < member_layers(member); l++) {
        const Layer whole = { 1.0f, LAYER_MASK };
        const Laying how =
            laying_of(clips, l == 0 ? whole : tables->layers[owner * LAYERS_PER_MEMBER + l], joint);
        if (!how.laid) continue;
        Shown shown = { how };
        shown.own = layer_pose(clips, playback, l, how.additive, joint, rest, &shown.terms);
        if (l > 0 && is_silent(how, shown.terms.total)) continue;
        if (playback.inertialization.count > 0)
            shown.own = inertialize_kept(clips, playback.inertialization, l, how.additive, body,
                                         joint, posed, rest, shown.own);
        keep_pose(beneath, l == 0 ? shown.own : laid_over(kept_pose(beneath), shown, rest));
    }
    Local trs = kept_pose(beneath);
    if (member.control != NONE) {
        __global const Control *control = tables->adjustments.controls + member.control;
        if (is_adjusted(control)) adjust(tables->adjustments, control, joint, &trs);
    }
    return trs;
}

// Computes the local transforms of a member's joints, every `JOINTS`-th from `joint` on. If
// `planes` is not 0, it also receives them as ten planes, each of the body's padded joints.
INLINE void pose_member(const Grouped *tables, const Batch *batch, uint nth, uint joint, bool plain,
                        __global float *planes)
{
    const uint owner = batch->places[nth].owner, each = tables->slots_per_member;
    const Body body = *body_of(tables, batch);
    __global const Slot *slots = tables->slots + owner * each;
    Inertialization inertialization = { slots, 0, tables->tick };
    if (!plain) inertialization = inertialization_of(slots, each, tables->tick);
    Playback playback = { playing_in(batch, nth), each, inertialization, plain, 0 };
    playback.alone = alone_in_layers(playback);
    const Hierarchy models = models_in(batch, nth);
    for (; joint < body.joint_count; joint += JOINTS) {
        const Local trs = plain ? pose_joint(&tables->clips, tables->adjustments, NONE, playback, 0,
                                             1, body, joint)
                                : pose_kept(tables, batch, nth, playback, joint);
        if (planes) store_trs(trs, planes + joint, body.padded_count);
        float m[12];
        components_of(trs, m);
        keep_model(models, joint, (float4)(m[0], m[1], m[2], m[3]),
                   (float4)(m[4], m[5], m[6], m[7]), (float4)(m[8], m[9], m[10], m[11]));
    }
}

// Turns the local transform of a joint into model_from_joint. Without a parent, they are the same.
INLINE void place_below(Hierarchy models, uint joint, uint parent)
{
    if (parent == NONE) return;
    const float16 model = affine_mul(model_of(models, parent), model_of(models, joint));
    keep_model(models, joint, model.s0123, model.s4567, model.s89ab);
}

// Computes model_from_joint of a joint, and runs its steps.
INLINE void descend(const Grouped *tables, const Batch *batch, uint nth, uint joint)
{
    const uint parent = tables->parents[body_of(tables, batch)->joint_first + joint],
               control = tables->members[batch->places[nth].owner].control;
    const Hierarchy models = models_in(batch, nth);
    place_below(models, joint, parent);
    if (control == NONE) return;
    const Solver s = solver_of(&tables->constraints, control);
    solve_joint(&s, models, rotations_in(batch, nth), joint, parent);
}

// Computes model_from_joint of all joints, level by level.
INLINE void descend_all(const Grouped *tables, const Batch *batch)
{
    const uint item = (uint)get_local_id(0);
    for (uint l = 0; l < body_of(tables, batch)->level_count; l++) {
        const uint level = body_of(tables, batch)->level_first + l, end = tables->levels[level + 1];
        if (item % BATCH < batch->count)
            for (uint joint = tables->levels[level] + item / BATCH; joint < end; joint += JOINTS)
                descend(tables, batch, item % BATCH, joint);
        LEVEL_BARRIER;
    }
}

// Does the same for plain members. Each level's end, and the parent of a work-item's first joint,
// are read while the level before is computed. Members with steps have no registers left for that.
INLINE void descend_plain(const Grouped *tables, const Batch *batch)
{
    const uint item = (uint)get_local_id(0);
    const Hierarchy models = models_in(batch, item % BATCH);
    const Body body = *body_of(tables, batch);
    __global const uint *parents = tables->parents + body.joint_first;
    __global const uint *levels = tables->levels + body.level_first;
    const uint last = body.joint_count - 1;
    uint first = levels[0] + item / BATCH, end = levels[1], parent = parents[min(first, last)];
    for (uint l = 0; l < body.level_count; l++) {
        const uint next = end + item / BATCH, next_parent = parents[min(next, last)],
                   next_end = levels[min(l + 2, body.level_count)];
        if (item % BATCH < batch->count)
            for (uint joint = first; joint < end; joint += JOINTS)
                place_below(models, joint, joint == first ? parent : parents[joint]);
        LEVEL_BARRIER;
        first = next;
        end = next_end;
        parent = next_parent;
    }
}

// Computes model_from_joint of all joints of the members, for the whole group. `plain` is a
// constant, so that the compiler drops the rest from the kernel of plain members.
//
// Neighbouring work-items take neighbouring joints of a member to pose, which read neighbouring
// words. On the way down, neighbours take the same joint of all members, which run the same steps.
INLINE void batch_models(const Grouped *tables, const Batch *batch, bool plain,
                         __global float *planes)
{
    const uint item = (uint)get_local_id(0);
    play_all(tables, batch);
    if (item / JOINTS < batch->count)
        pose_member(tables, batch, item / JOINTS, item % JOINTS, plain, planes);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (plain) descend_plain(tables, batch);
    else descend_all(tables, batch);
}

// The members of a page, of which a group computes `run` places, at most BATCH.
typedef struct {
    __global const uint *members;
    uint count, run, place_first, place_end, phase;
} Page;

// Returns the member at a place of the page's list, or NONE if this launch or this kernel is not to
// compute it.
INLINE Place place_at(const Grouped *tables, bool plain, Page page, uint place)
{
    const Place none = { NONE, NONE };
    if (place >= page.count) return none;
    const uint owner = page.members[place], each = tables->slots_per_member;
    const Member member = tables->members[owner];
    if (owner < page.place_first || owner >= page.place_end || member_phase(member) != page.phase)
        return none;
    // The kernel of plain members runs in phase 0 alone.
    const bool is_plain =
        page.phase == 0 && member.control == NONE && member_layers(member) == 1
        && inertialization_of(tables->slots + owner * each, each, tables->tick).count == 0;
    const Place found = { owner, member.posed };
    return is_plain == plain ? found : none;
}

// Lists the members of a group's places that this launch and this kernel are to compute, in order,
// and returns their count.
INLINE uint list_places(const Grouped *tables, bool plain, Page page, __local Place *listed)
{
    const uint item = (uint)get_local_id(0);
    Place own = { NONE, NONE };
    if (item < page.run) {
        own = place_at(tables, plain, page, (uint)get_group_id(0) * page.run + item);
        listed[item] = own;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint before = 0, count = 0;
    for (uint i = 0; i < page.run; i++) {
        const uint one = listed[i].owner != NONE ? 1 : 0;
        before += i < item ? one : 0;
        count += one;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (own.owner != NONE) listed[before] = own;
    barrier(CLK_LOCAL_MEM_FENCE);
    return count;
}

// Writes the palettes of the members. Three neighbouring work-items write the three rows of an
// entry.
INLINE void write_palettes(const Grouped *tables, const Batch *batch, __global const Entry *entries,
                           uint page_first, __global float4 *restrict palette)
{
    const uint item = (uint)get_local_id(0), nth = item / JOINTS;
    if (nth >= batch->count) return;
    const uint first = tables->members[batch->places[nth].owner].palette_first - page_first;
    __global float4 *to = palette + 3 * (size_t)first;
    const Hierarchy models = models_in(batch, nth);
    const Body body = *body_of(tables, batch);
    for (uint i = item % JOINTS; i < 3 * body.entry_count; i += JOINTS) {
        __global const Entry *entry = entries + body.entry_first + i / 3;
        to[i] = affine_row(models.rows[i % 3 * models.stride + entry->joint], entry->row0,
                           entry->row1, entry->row2);
    }
}

// Computes the members of a group's run that are plain, or those that are not.
INLINE void run_frame(const Grouped *tables, bool plain, Page page, __local Place *listed,
                      uint room, __local float4 *memory, __global const Entry *entries,
                      uint page_first, __global float4 *restrict palette)
{
    const uint count = list_places(tables, plain, page, listed);
    for (uint first = 0; first < count;) {
        const Batch batch = batch_of(tables, listed + first, count - first, plain, room, memory);
        batch_models(tables, &batch, plain, 0);
        write_palettes(tables, &batch, entries, page_first, palette);
        first += batch.count;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

// Computes members that need all of the pipeline.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void fused_grouped(GROUPED_PARAMETERS,
                                                                               PAGE_PARAMETERS)
{
    __local Place listed[BATCH];
    const Grouped tables = grouped_of(GROUPED_ARGUMENTS);
    const Page page = { PAGE_ARGUMENTS };
    run_frame(&tables, false, page, listed, room, memory, entries, page_first, palette);
}

// Computes members that only mix the slots of layer 0.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void fused_grouped_plain(
    GROUPED_PARAMETERS, PAGE_PARAMETERS)
{
    __local Place listed[BATCH];
    const Grouped tables = grouped_of(GROUPED_ARGUMENTS);
    const Page page = { PAGE_ARGUMENTS };
    run_frame(&tables, true, page, listed, room, memory, entries, page_first, palette);
}

// Computes samples, local transforms and model_from_joint of one member, for reading back.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void fused_grouped_joints(
    GROUPED_PARAMETERS, uint owner, __global SlotSample *samples, __global float *planes,
    __global float4 *matrices, uint room, __local float4 *memory)
{
    __local Place only[1];
    const Grouped tables = grouped_of(GROUPED_ARGUMENTS);
    const uint item = (uint)get_local_id(0);
    const Place place = { owner, members[owner].posed };
    if (item == 0) only[0] = place;
    barrier(CLK_LOCAL_MEM_FENCE);
    const Batch batch = batch_of(&tables, only, 1, false, room, memory);
    batch_models(&tables, &batch, false, planes);
    for (uint s = item; s < slots_per_member; s += GROUP) samples[s] = playing_in(&batch, 0)[s].at;
    for (uint joint = item; joint < body_of(&tables, &batch)->joint_count; joint += GROUP)
        vstore16(model_of(models_in(&batch, 0), joint), joint, (__global float *)matrices);
}
