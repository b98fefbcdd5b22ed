// fused_wide.cl - Fused schedule for CPUs: a work-item computes whole frames of members of one body,
// LANES at a time, side by side. Local transforms come from abreast.cl. Constraint programs and
// palettes have members in lanes too. What is between clip and palette stays in the core's caches.
//
// NDRange  (runs of members of one page, those of a kind side by side), work-groups of one; one
//          enqueue for each phase
// Reads    the page's members; slots, machines, layers, rows, controls and the tables that they
//          index; watched joints that earlier phases wrote
// Writes   palette: each entry of the phase's members in [place_first, place_end) once, and zeros
//          into padding; is_taken, desks: scratch; states and watched joints of those members
// Oracle   populace-testkit/src/oracle
// Twin of populace-native/src/abreast.rs, populace-native/src/fused.rs, populace-native/src/cache.rs
// and, for `descend`, populace-native/src/constraints/descent.rs: same arithmetic, same order of
// operations.

// Writes sixteen numbers. If `streamed`, they are a whole line of the cache and go past the caches,
// which would read the line first.
INLINE void write_line(float16 line, __global float *to, bool streamed)
{
#if __has_builtin(__builtin_nontemporal_store)
    if (streamed) {
        __builtin_nontemporal_store(line, (__global float16 *)to);
        return;
    }
#endif
    vstore16(line, 0, to);
}

// Returns sixteen numbers of the member in a lane, after transposition.
INLINE float16 line_of(const Real *numbers, uint lane)
{
#if LANES == 8
    return (float16)(numbers[lane], numbers[8 + lane]);
#else
    return numbers[lane];
#endif
}

// Turns sixteen numbers in lanes into lines of the members.
INLINE void turn_lines(const Real *numbers, Real lines[16])
{
#pragma unroll
    for (uint i = 0; i < 16; i++) lines[i] = numbers[i];
#pragma unroll
    for (uint i = 0; i < 16; i += LANES) transpose(lines + i);
}

// Writes sixteen numbers of each member, `first` numbers after the beginning of its palette. With a
// member in each lane, lines stay in registers on the way.
INLINE void write_lines(const Company *all, const Real *numbers, __global float *const *to,
                        uint first, bool streamed)
{
    if (streamed && all->count == LANES) {
        Real lines[16];
        turn_lines(numbers, lines);
#pragma unroll
        for (uint lane = 0; lane < LANES; lane++)
            write_line(line_of(lines, lane), to[lane] + first, true);
        return;
    }
    Real lines[16];
    turn_lines(numbers, lines);
    for (uint lane = 0; lane < all->count; lane++)
        write_line(line_of(lines, lane), to[lane] + first, streamed);
}

// Takes a free desk, which holds the matrices of the members in the lanes of a work-item. Few desks,
// used again and again, stay in the caches.
INLINE uint take_desk(volatile __global uint *is_taken, uint count)
{
    uint desk = 0;
    while (atomic_xchg(is_taken + desk, 1u) != 0u) desk = desk + 1 < count ? desk + 1 : 0;
    mem_fence(CLK_GLOBAL_MEM_FENCE);
    return desk;
}

// Frees a desk after all stores to it. The exchange also completes lines written past the caches.
INLINE void free_desk(volatile __global uint *is_taken, uint desk)
{
    mem_fence(CLK_GLOBAL_MEM_FENCE);
    atomic_xchg(is_taken + desk, 0u);
}

// Returns whether a frame evaluates a member.
INLINE bool is_due(uint owner, Member member, uint place_first, uint place_end, uint phase)
{
    return owner >= place_first && owner < place_end && member_phase(member) == phase;
}

INLINE void descend_to(const Company *all, Hierarchy joints, uint joint)
{
    const uint parent = all->parents[joint];
    if (parent == NONE) return;
    Matrix locals;
    locals_of(joints, joint, &locals);
    keep_beneath(joints, parent, joint, &locals);
}

// Leads members with programs down their hierarchies.
APART void descend(const Company *all, const ConstraintTables *tables, Hierarchy joints)
{
    Solver members[LANES];
    Quat rotations[MAX_STEP_ROTATIONS];
    for (uint lane = 0; lane < all->count; lane++)
        members[lane] = solver_of(tables, all->controls[lane]);
    Stop at;
    at.members = members;
    at.count = all->count;
    at.share_rows = share_rows(members, all->count);
    at.plays = all->plays;
    at.joints = joints;
    at.rotations = rotations;
    uint joint = 0;
    for (at.nth = 0; at.nth < members->control->step_count; at.nth++) {
        at.step = step_in(&at, 0);
        for (; joint <= at.step.joint; joint++) descend_to(all, joints, joint);
        at.parent = all->parents[at.step.joint];
        take_steps(&at);
    }
    for (; joint < all->body.joint_count; joint++) descend_to(all, joints, joint);
}

// Returns whether all joints of a block of entries are before `joint_end`.
INLINE bool are_placed(__global const Entry *entries, uint count, uint joint_end)
{
    bool placed = true;
    for (uint e = 0; e < count; e++) placed = placed && entries[e].joint < joint_end;
    return placed;
}

// Writes a block of the members' palettes, with zeros for padding.
INLINE void write_block(const Company *all, __global const Entry *entries, Hierarchy joints,
                        uint block, uint count, __global float *const *to, bool streamed)
{
    Matrix palettes[PALETTE_BLOCK];
    for (uint e = 0; e < PALETTE_BLOCK; e++) {
        if (e >= count) {
            for (uint i = 0; i < 12; i++) palettes[e].m[i] = 0.0f;
            continue;
        }
        __global const Entry *entry = entries + block + e;
        const float4 row0 = entry->row0, row1 = entry->row1, row2 = entry->row2;
        const float bind[12] = { row0.x, row0.y, row0.z, row0.w, row1.x, row1.y,
                                 row1.z, row1.w, row2.x, row2.y, row2.z, row2.w };
        models_after(joints, entry->joint, bind, &palettes[e]);
    }
    // Four matrices are 48 numbers, or three lines of the cache.
    for (uint i = 0; i < 48; i += 16)
        write_lines(all, palettes->m + i, to, 12 * block + i, streamed);
}

// Writes the members' palettes from an entry on, up to the first block with a joint from `joint_end`
// on. Returns the entry after the last one written.
INLINE uint write_palettes(const Company *all, __global const Entry *entries, Hierarchy joints,
                           uint from, uint joint_end, __global float *const *to, bool streamed)
{
    uint block = from;
    for (; block < all->body.entry_count; block += PALETTE_BLOCK) {
        const uint count = min(all->body.entry_count - block, (uint)PALETTE_BLOCK);
        if (!are_placed(entries + block, count, joint_end)) break;
        write_block(all, entries, joints, block, count, to, streamed);
    }
    return block;
}

// Writes the members' palettes. Without programs, they are written after each block of joints,
// while their transforms are in the first-level cache.
INLINE void write_members(const Company *all, const Posing *posing, const ConstraintTables *tables,
                          __global const Entry *entries, Hierarchy joints,
                          __global float *const *to, bool streamed)
{
    const bool is_led = are_led(all);
    if (is_led) fetch_controls(all, tables);
    uint written = 0;
    for (uint first = 0; first < all->body.joint_count; first += JOINT_BLOCK) {
        place_block(all, posing, first, joints, 0);
        if (!is_led)
            written =
                write_palettes(all, entries, joints, written, first + JOINT_BLOCK, to, streamed);
        if (is_led && first == 0) fetch_steps(all, tables);
        // One block later, if there is one: it finds addresses in the steps.
        if (is_led && first == (all->body.joint_count > JOINT_BLOCK ? JOINT_BLOCK : 0))
            fetch_constraints(all, tables);
    }
    if (!is_led) return;
    descend(all, tables, joints);
    write_palettes(all, entries, joints, 0, all->body.joint_count, to, streamed);
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void fused_wide(
    // Members and their bodies.
    __global const Member *members, __global const Body *bodies, __global const uint *parents,
    // What they play.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running, __global const Layer *layers,
    // Clips and stored poses.
    __global const BoundClip *bound_clips, __global const BoundBlock *bound_blocks,
    __global const ClipRows *clips, __global const uint *rows, __global const float *row_times,
    __global const uint *buckets, __global const float *poses, __global const float *masks,
    // The clock, and the slots of each member.
    ulong tick, uint slots_per_member,
    // Constraint programs.
    __global const float *joint_scales, CONSTRAINT_PARAMETERS,
    // Members of the page, and their palettes.
    __global const uint *page_members, __global const Entry *entries, uint place_first,
    uint place_end, uint phase, uint page_first, __global float4 *restrict palette,
    // Distribution over work-items, and their scratch.
    uint member_count, uint run, uint padded_most, uint desk_count,
    volatile __global uint *is_taken, __global float4 *restrict desks)
{
    const ClipTables clip_tables = { bound_clips, bound_blocks, clips, rows, poses, masks };
    const Adjustments adjustments = {
        controls, overrides, joint_scales STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)
    };
    const Machines machines = { machine_states, running };
    const ConstraintTables constraint_tables =
        constraint_tables_of(CONSTRAINT_ARGUMENTS, members, slots, layers, bound_clips, clips,
                             masks, slots_per_member, machines, tick);
    const uint desk = take_desk(is_taken, desk_count);
    const Hierarchy joints = { (__global Matrix *)desks + desk * padded_most };
    const uint end = min((uint)(get_global_id(0) + 1) * run, member_count);
    // Palettes begin at blocks of entries, which are three whole lines each.
    const bool streamed = ((size_t)palette & 63) == 0;
    Company all;
    for (uint index = (uint)get_global_id(0) * run; index < end;) {
        __global float *to[LANES];
        uint posed, shape;
        for (all.count = 0; index < end && all.count < LANES; index++) {
            // For the group after the next.
            if (index + 2 * LANES < end)
                fetch_member(members, slots, slots_per_member, page_members[index + 2 * LANES]);
            const uint owner = page_members[index];
            const Member member = members[owner];
            if (!is_due(owner, member, place_first, place_end, phase)) continue;
            if (all.count > 0 && (member.posed != posed || member.shape != shape)) break;
            posed = member.posed;
            shape = member.shape;
            const uint first = member.palette_first - page_first;
            to[all.count] = (__global float *)(palette + 3 * (size_t)first);
            join(&all, owner, member, slots, slots_per_member, machines, tick, &clip_tables,
                 row_times, buckets);
        }
        if (all.count == 0) break;
        all.body = bodies[posed];
        all.parents = parents + all.body.joint_first;
        const Posing posing = posing_of(&all, &clip_tables, adjustments, layers);
        write_members(&all, &posing, &constraint_tables, entries + all.body.entry_first, joints, to,
                      streamed);
    }
    free_desk(is_taken, desk);
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
    __global const ClipRows *clips, __global const uint *rows, __global const float *row_times,
    __global const uint *buckets, __global const float *poses, __global const float *masks,
    // The clock, and the slots of each member.
    ulong tick, uint slots_per_member,
    // Constraint programs.
    __global const float *joint_scales, CONSTRAINT_PARAMETERS,
    // The member, and outputs.
    uint owner, __global SlotSample *samples, __global float *planes, __global float4 *matrices,
    // Scratch.
    __global float4 *restrict desks)
{
    const ClipTables clip_tables = { bound_clips, bound_blocks, clips, rows, poses, masks };
    const Adjustments adjustments = {
        controls, overrides, joint_scales STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)
    };
    const Machines machines = { machine_states, running };
    const ConstraintTables constraint_tables =
        constraint_tables_of(CONSTRAINT_ARGUMENTS, members, slots, layers, bound_clips, clips,
                             masks, slots_per_member, machines, tick);
    const Member member = members[owner];
    __global const Slot *mine = slots + owner * slots_per_member;
    for (uint s = 0; s < slots_per_member; s++)
        samples[s] = play(mine[s], machines, tick, &clip_tables, row_times, buckets).at;
    const Hierarchy joints = { (__global Matrix *)desks };
    Company all;
    all.count = 0;
    join(&all, owner, member, slots, slots_per_member, machines, tick, &clip_tables, row_times,
         buckets);
    all.body = bodies[member.posed];
    all.parents = parents + all.body.joint_first;
    const Posing posing = posing_of(&all, &clip_tables, adjustments, layers);
    for (uint first = 0; first < all.body.joint_count; first += JOINT_BLOCK)
        place_block(&all, &posing, first, joints, planes);
    if (are_led(&all)) descend(&all, &constraint_tables, joints);
    for (uint joint = 0; joint < all.body.joint_count; joint++)
        vstore16(local_in(joints, joint, 0), joint, (__global float *)matrices);
}
