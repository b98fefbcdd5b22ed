// company.cl - Members side by side, each in a lane of its own: what they play, and requests for the
// memory that they will read.
//
// Twin of populace-native/src/playback.rs and populace-native/src/cache.rs: same arithmetic, same order
// of operations.

// The slots of a member's layer: the only one, or NONE if there are several or none, and their total
// weight.
typedef struct {
    uint alone;
    float total;
} LayerSlots;

// Returns the slots of a layer with one more, whose weight is above 0.
INLINE LayerSlots with_slot(LayerSlots layer, uint playing, float weight)
{
    const bool alone = layer.total == 0.0f && weight > LEAST_TOTAL;
    const LayerSlots more = { alone ? playing : NONE, layer.total + weight };
    return more;
}

// Asks for memory, in lines of the cache of 16 words, so that it is in the second-level cache when it
// is read. Rows of sixteen members do not fit into the first.
// Compilers for GPUs may have the function, but only for pointers without an address space.
INLINE void fetch_lines(__global const void *from, uint words)
{
#if defined(CALLS) && __has_builtin(__builtin_prefetch)
    __global const uint *word = from, *last = word + words - 1;
    for (; word < last; word += 16) __builtin_prefetch(word, 0, 2);
    // Words that do not begin a line reach into one line more.
    if (words > 0) __builtin_prefetch(last, 0, 2);
#endif
}

// Asks for two rows of a clip, two lines of each at a time: every slot of every member does.
INLINE void fetch_rows(RowStart from, RowStart to, uint words)
{
#if defined(CALLS) && __has_builtin(__builtin_prefetch)
    if (words == 0) return;
    for (uint word = 0; word < words; word += 32) {
        __builtin_prefetch(from + word, 0, 2);
        __builtin_prefetch(from + word + 16, 0, 2);
        __builtin_prefetch(to + word, 0, 2);
        __builtin_prefetch(to + word + 16, 0, 2);
    }
    __builtin_prefetch(from + (words - 1), 0, 2);
    __builtin_prefetch(to + (words - 1), 0, 2);
#endif
}

// Collects the member's slots that have weight now, in order, and asks for their rows.
INLINE Playback play_all(__global const Slot *slots, uint slot_count, Machines machines, ulong tick,
                         const ClipTables *tables, __global const float *row_times,
                         __global const uint *buckets, uint layer_count, Playing *playing,
                         LayerSlots *layers)
{
    Playback playback = { playing, 0, inertialization_of(slots, slot_count, tick), false };
    const LayerSlots silent = { NONE, 0.0f };
    for (uint l = 1; l < layer_count; l++) layers[l] = silent;
    // Layer 0 stays in registers.
    LayerSlots lowest = silent;
    for (uint s = 0; s < slot_count; s++) {
        Playing slot = play(slots[s], machines, tick, tables, row_times, buckets);
        if (slot.at.weight <= 0.0f) continue;
        const BoundClip clip = tables->bound_clips[slot.bound_clip];
        slot.blocks = tables->bound_blocks + clip.block_first;
        slot.planes = tables->poses + clip.plane_first;
        slot.from = row_start(tables, slot.at.row0);
        slot.to = row_start(tables, slot.at.row1);
        __global const ClipRows *stored = tables->clips + clip.rows;
        fetch_rows(slot.from, slot.to, stored->row_stride);
        playback.has_floats = playback.has_floats || stored->has_floats;
        if (slot.layer == 0) lowest = with_slot(lowest, playback.count, slot.at.weight);
        else layers[slot.layer] = with_slot(layers[slot.layer], playback.count, slot.at.weight);
        playing[playback.count++] = slot;
    }
    layers[0] = lowest;
    return playback;
}

// Members side by side, each in a lane of its own: of one body, with programs of one shape or none.
typedef struct {
    uint count, owners[LANES], controls[LANES], layer_counts[LANES];
    Playback plays[LANES];
    Playing playing[LANES][MAX_SLOTS];
    LayerSlots layers[LANES][LAYERS_PER_MEMBER];
    Body body;
    __global const uint *parents;
} Company;

// Asks for a member and its slots.
INLINE void fetch_member(__global const Member *members, __global const Slot *slots,
                         uint slots_per_member, uint owner)
{
    fetch_lines(members + owner, sizeof(Member) / 4);
    fetch_lines(slots + owner * slots_per_member, slots_per_member * sizeof(Slot) / 4);
}

// Takes a member into the next free lane.
INLINE void join(Company *all, uint owner, Member member, __global const Slot *slots,
                 uint slots_per_member, Machines machines, ulong tick, const ClipTables *tables,
                 __global const float *row_times, __global const uint *buckets)
{
    const uint lane = all->count++;
    all->owners[lane] = owner;
    all->controls[lane] = member.control;
    all->layer_counts[lane] = member_layers(member);
    all->plays[lane] = play_all(slots + owner * slots_per_member, slots_per_member, machines, tick,
                                tables, row_times, buckets, all->layer_counts[lane],
                                all->playing[lane], all->layers[lane]);
}

// Asks for the members' controls and states, for the steps of their programs, and for the settings of
// their constraints. Each finds its addresses in what the one before asked for.
INLINE void fetch_controls(const Company *all, const ConstraintTables *tables)
{
    for (uint lane = 0; lane < all->count; lane++) {
        const uint control = all->controls[lane];
        fetch_lines(tables->controls + control, sizeof(Control) / 4);
        fetch_lines(tables->states_before + control * STATES_PER_CONTROL, 4 * STATES_PER_CONTROL);
        fetch_lines(tables->states + control * STATES_PER_CONTROL, 4 * STATES_PER_CONTROL);
    }
}

INLINE void fetch_steps(const Company *all, const ConstraintTables *tables)
{
    for (uint lane = 0; lane < all->count; lane++) {
        __global const Control *control = tables->controls + all->controls[lane];
        fetch_lines(tables->steps + control->step_first, 4 * control->step_count);
    }
}

INLINE void fetch_constraints(const Company *all, const ConstraintTables *tables)
{
    const uint step_count = tables->controls[all->controls[0]].step_count;
    for (uint nth = 0; nth < step_count; nth++)
        for (uint lane = 0; lane < all->count; lane++) {
            const Step step = tables->steps[tables->controls[all->controls[lane]].step_first + nth];
            if (step.kind < STEP_GAZE || step.kind > STEP_FOOT || step.kind == STEP_CHAIN) break;
            // A step of feet has a constraint for each; most have two.
            const uint count = step.kind == STEP_PELVIS ? 2 : 1;
            fetch_lines(tables->constraints + step.index, count * sizeof(Constraint) / 4);
        }
}
