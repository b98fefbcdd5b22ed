// abreast.cl - Members side by side, each in a lane of its own: what they play, and their local
// transforms. Slots of layer 0 are sampled and summed for a block of joints of a member at a time.
// Passes over all members are short enough for a processor to have several members in flight. The
// poses are transposed into lanes of members.
//
// Twin of populace-native/src/poses.rs, populace-native/src/abreast.rs,
// populace-native/src/playback.rs and populace-native/src/cache.rs: same arithmetic, same order of
// operations.

// Collects the member's slots that have weight now, in order.
INLINE Playback play_all(__global const Slot *slots, uint slot_count, Machines machines, ulong tick,
                         const ClipTables *tables, __global const float *row_times,
                         __global const uint *buckets, Playing *playing)
{
    Playback playback = {
        playing, 0, inertialization_of(slots, slot_count, tick), false, NONE, 0.0f
    };
    for (uint s = 0; s < slot_count; s++) {
        Playing slot = play(slots[s], machines, tick, tables, row_times, buckets);
        if (slot.at.weight <= 0.0f) continue;
        const BoundClip clip = tables->bound_clips[slot.bound_clip];
        slot.blocks = tables->bound_blocks + clip.block_first;
        slot.ranges = tables->poses + clip.range_first;
        slot.from = row_start(tables, slot.at.row0);
        slot.to = row_start(tables, slot.at.row1);
        playback.has_floats = playback.has_floats || tables->clips[clip.rows].has_floats;
        if (slot.layer == 0) {
            const bool alone = playback.total == 0.0f && slot.at.weight > LEAST_TOTAL;
            playback.alone = alone ? playback.count : NONE;
            playback.total += slot.at.weight;
        }
        playing[playback.count++] = slot;
    }
    return playback;
}

// Components of a local transform: translation, rotation, scale.
#define COMPONENTS 10

// Members side by side, each in a lane of its own: of one body, with programs of one shape or none.
typedef struct {
    uint count, owners[LANES], controls[LANES], layer_counts[LANES];
    Playback plays[LANES];
    Playing playing[LANES][MAX_SLOTS];
    Body body;
    __global const uint *parents;
} Company;

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

// Asks for the rows that a member mixes.
INLINE void fetch_rows(const ClipTables *tables, Playback playback)
{
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        const ClipRows clip = tables->clips[tables->bound_clips[playing.bound_clip].rows];
        fetch_lines(tables->rows + playing.at.row0, clip.row_stride);
        fetch_lines(tables->rows + playing.at.row1, clip.row_stride);
    }
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
                                tables, row_times, buckets, all->playing[lane]);
    fetch_rows(tables, all->plays[lane]);
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

// Sums over the slots of layer 0, and then poses: each component of LANES joints of each member.
typedef Real Posed[COMPONENTS][LANES];

// Returns the local transforms of neighbouring joints of a member, or after transposition of a joint
// of all members.
INLINE Local local_of(const Posed posed, uint at)
{
    const Local trs = { { posed[0][at], posed[1][at], posed[2][at] },
                        { posed[3][at], posed[4][at], posed[5][at], posed[6][at] },
                        { posed[7][at], posed[8][at], posed[9][at] } };
    return trs;
}

INLINE void put_rotation(Posed posed, uint lane, Quat r)
{
    posed[3][lane] = r.x;
    posed[4][lane] = r.y;
    posed[5][lane] = r.z;
    posed[6][lane] = r.w;
}

// Stores translations or scales of a lane.
INLINE void put_vector(Posed posed, uint lane, uint property, Vec3 v)
{
    const uint first = property == TRANSLATION ? 0 : 7;
    posed[first][lane] = v.x;
    posed[first + 1][lane] = v.y;
    posed[first + 2][lane] = v.z;
}

// Stores the local transforms of a lane, except properties that are left out.
INLINE void put_local(Posed posed, uint lane, Local trs, uint still)
{
    if (!(still & REST_TRANSLATION)) put_vector(posed, lane, TRANSLATION, trs.t);
    put_rotation(posed, lane, trs.r);
    if (!(still & REST_SCALE)) put_vector(posed, lane, SCALE, trs.s);
}

// Inputs of the members' poses.
typedef struct {
    const ClipTables *clips;
    Adjustments adjustments;
    __global const Layer *layers;
    PoseChanges changes[LANES];
    bool any_changes;
} Posing;

// Computes the own pose of a member's layer. Returns false if the layer shows nothing.
INLINE bool show_layer_of(const Company *all, const Posing *posing, uint lane, uint l, uint first,
                          bool no_floats, Local rest, Shown *shown)
{
    __global const Layer *layers = posing->layers + all->owners[lane] * LAYERS_PER_MEMBER;
    return show_layer(posing->clips, all->plays[lane], layers[l], l, all->body, first, no_floats,
                      rest, shown);
}

// Does the same for a member with a clip that stores floats, which few members play. Its other clips
// go this way too. The common path must not pay for the registers of this one.
APART bool show_any_layer(const Company *all, const Posing *posing, uint lane, uint l, uint first,
                          Shown *shown)
{
    const Local rest = rest_of(posing->clips, all->body, first);
    return show_layer_of(all, posing, lane, l, first, false, rest, shown);
}

// Lays a layer over the poses of members that have it, in two passes. `at_rest` tells what is at
// rest in each pose, before and after.
INLINE void lay_over_all(const Company *all, const Posing *posing, uint l, uint first, Local rest,
                         uint *at_rest, Posed posed)
{
    Shown shown[LANES];
    bool shows[LANES];
    for (uint lane = 0; lane < all->count; lane++) {
        if (l >= all->layer_counts[lane]) shows[lane] = false;
        else if (all->plays[lane].has_floats)
            shows[lane] = show_any_layer(all, posing, lane, l, first, &shown[lane]);
        else shows[lane] = show_layer_of(all, posing, lane, l, first, true, rest, &shown[lane]);
    }
    for (uint lane = 0; lane < all->count; lane++) {
        if (!shows[lane]) continue;
        const uint kept = kept_beneath(shown[lane], at_rest[lane]);
        put_local(posed, lane, laid_over(local_of(posed, lane), shown[lane], kept, rest), kept);
        at_rest[lane] &= kept;
    }
}

// Applies what comes after the slots of layer 0, step by step to all members. `at_rest` tells what
// is at rest in each pose, before and after.
APART void change_poses(const Company *all, const Posing *posing, uint first, uint *at_rest,
                        Posed posed)
{
    const Local rest = rest_of(posing->clips, all->body, first), stored = rest;
    uint layer_count = 1;
    for (uint lane = 0; lane < all->count; lane++) {
        layer_count = max(layer_count, all->layer_counts[lane]);
        if (!posing->changes[lane].inertializes) continue;
        Local pose = local_of(posed, lane);
        inertialize(posing->clips, all->plays[lane].inertialization, 0, false, first, &stored,
                    &pose);
        put_local(posed, lane, pose, 0);
        at_rest[lane] = 0;
    }
    for (uint l = 1; l < layer_count; l++)
        lay_over_all(all, posing, l, first, rest, at_rest, posed);
    for (uint lane = 0; lane < all->count; lane++) {
        if (!posing->changes[lane].adjusts) continue;
        Local pose = local_of(posed, lane);
        adjust(posing->adjustments, posing->adjustments.controls + all->controls[lane], first,
               &pose);
        put_local(posed, lane, pose, 0);
        at_rest[lane] = 0;
    }
}

// Poses a block of joints of a member whose layer 0 plays one slot. Nothing is weighted or divided:
// this gives the same bits as a sum of one term of weight 1, and its mean. Zeros among ranges are
// positive, as sums are that begin with 0.
INLINE void pose_alone(const Company *all, const Posing *posing, uint lane, uint first,
                       bool no_floats, uint spans, Posed *posed, uint *at_rest)
{
    const ClipTables *tables = posing->clips;
    const Playback playback = all->plays[lane];
    BlockSlot slot = block_slot(playing_at(playback, playback.alone), first, no_floats);
    Stored rest = stored_at(tables, all->body.rest_first, POSE_PLANES, first);
    const uint flags = slot.columns.block.flags;
    for (uint span = 0; span < spans; span++) {
        put_rotation(posed[span], lane, rotation_alone(tables, slot, rest));
        if (!(flags & REST_TRANSLATION))
            put_vector(posed[span], lane, TRANSLATION, vector_alone(tables, slot, TRANSLATION));
        if (!(flags & REST_SCALE))
            put_vector(posed[span], lane, SCALE, vector_alone(tables, slot, SCALE));
        slot = next_span(slot);
        rest += LANES;
    }
    *at_rest = flags & (REST_TRANSLATION | REST_SCALE);
}

// Sums the slots of layer 0 of a member, for LANES joints or for a whole block. The pose of one slot
// is complete.
INLINE void sum_member(const Company *all, const Posing *posing, uint lane, uint first,
                       bool no_floats, uint spans, Posed *posed, uint *at_rest)
{
    const ClipTables *tables = posing->clips;
    const Playback playback = all->plays[lane];
    if (playback.alone != NONE) {
        pose_alone(all, posing, lane, first, no_floats, spans, posed, at_rest);
        return;
    }
    if (spans == 1) {
        const SpanSums sums = sum_spans(tables, playback, 0, all->body, first, no_floats, false);
        put_local(posed[0], lane, sums.first, sums.at_rest);
        *at_rest = sums.at_rest;
        return;
    }
#if SPANS > 1
    const SpanSums sums = sum_spans(tables, playback, 0, all->body, first, no_floats, true);
    put_local(posed[0], lane, sums.first, sums.at_rest);
    put_local(posed[1], lane, sums.second, sums.at_rest);
    *at_rest = sums.at_rest;
#endif
}

// Does the same for a member with a clip that stores floats; see show_any_layer().
APART void sum_any_member(const Company *all, const Posing *posing, uint lane, uint first,
                          uint spans, Posed *posed, uint *at_rest)
{
    sum_member(all, posing, lane, first, false, spans, posed, at_rest);
}

INLINE uint at_rest_in_all(const Company *all, const uint *at_rest)
{
    uint still = REST_TRANSLATION | REST_SCALE;
    for (uint lane = 0; lane < all->count; lane++) still &= at_rest[lane];
    return still;
}

// Sums the slots of layer 0 of all members, for a block of joints.
INLINE void sum_block(const Company *all, const Posing *posing, uint first, uint spans,
                      Posed *posed, uint *at_rest)
{
    for (uint lane = 0; lane < all->count; lane++) {
        if (all->plays[lane].has_floats)
            sum_any_member(all, posing, lane, first, spans, posed, &at_rest[lane]);
        else sum_member(all, posing, lane, first, true, spans, posed, &at_rest[lane]);
    }
}

// Turns components into lanes of members.
INLINE void turn_components(const Company *all, Posed posed, uint first, uint end)
{
#pragma unroll
    for (uint c = first; c < end; c++) {
        for (uint lane = all->count; lane < LANES; lane++) posed[c][lane] = 0.0f;
        transpose(posed[c]);
    }
}

// Turns the sums of LANES joints into local transforms in lanes of members, except properties that
// are at rest in all of them, which it returns. If `planes` is not 0, it receives the transforms of
// the first member, as ten planes of the body's padded joints.
INLINE uint pose_span(const Company *all, const Posing *posing, uint first, const uint *sums,
                      Posed posed, __global float *planes)
{
    const Local rest = rest_of(posing->clips, all->body, first);
    // Changes of poses change what is at rest. The block's other span begins with that of the sums.
    uint at_rest[LANES];
    for (uint lane = 0; lane < all->count; lane++) at_rest[lane] = sums[lane];
    const uint left_out = posing->any_changes || planes ? 0 : at_rest_in_all(all, at_rest);
    for (uint lane = 0; lane < all->count; lane++) {
        if (all->plays[lane].alone != NONE) {
            // Other members may move what is at rest in this one.
            const uint missing = at_rest[lane] & ~left_out;
            if (missing & REST_TRANSLATION) put_vector(posed, lane, TRANSLATION, rest.t);
            if (missing & REST_SCALE) put_vector(posed, lane, SCALE, rest.s);
            continue;
        }
        const Sum sum = { local_of(posed, lane), { all->plays[lane].total, at_rest[lane] } };
        // Each branch stores on its own, so that the other keeps no registers.
        if (sum.terms.total > LEAST_TOTAL) put_local(posed, lane, mean_of(sum, rest), left_out);
        else put_local(posed, lane, rest, left_out);
    }
    if (posing->any_changes) change_poses(all, posing, first, at_rest, posed);
    if (planes) store_trs(local_of(posed, 0), planes + first, all->body.padded_count);
    const uint still = at_rest_in_all(all, at_rest);
    if (!(still & REST_TRANSLATION)) turn_components(all, posed, 0, 3);
    turn_components(all, posed, 3, 7);
    if (!(still & REST_SCALE)) turn_components(all, posed, 7, COMPONENTS);
    return still;
}

// Returns the local transforms of a joint.
INLINE Local posed_joint(const Company *all, const Posing *posing, const Posed posed, uint still,
                         uint first, uint at)
{
    const Stored rest = stored_at(posing->clips, all->body.rest_first, POSE_PLANES, first + at);
    Local trs = local_of(posed, at);
    if (still & REST_TRANSLATION) {
        trs.t.x = rest[4 * JOINT_BLOCK];
        trs.t.y = rest[5 * JOINT_BLOCK];
        trs.t.z = rest[6 * JOINT_BLOCK];
    }
    if (still & REST_SCALE) {
        trs.s.x = rest[7 * JOINT_BLOCK];
        trs.s.y = rest[8 * JOINT_BLOCK];
        trs.s.z = rest[9 * JOINT_BLOCK];
    }
    return trs;
}

// Returns the inputs of the members' poses.
INLINE Posing posing_of(const Company *all, const ClipTables *tables, Adjustments adjustments,
                        __global const Layer *layers)
{
    Posing posing = { tables, adjustments, layers };
    posing.any_changes = false;
    for (uint lane = 0; lane < all->count; lane++) {
        posing.changes[lane] =
            changes_of(adjustments, all->controls[lane], all->plays[lane], all->layer_counts[lane]);
        posing.any_changes = posing.any_changes || are_changes(posing.changes[lane]);
    }
    return posing;
}

INLINE bool are_led(const Company *all) { return all->controls[0] != NONE; }

// Computes the local transforms of LANES joints, and without programs their model transforms.
INLINE void place_span(const Company *all, const Posing *posing, uint first, const uint *sums,
                       Posed posed, Hierarchy joints, __global float *planes)
{
    const uint still = pose_span(all, posing, first, sums, posed, planes);
    const uint end = min(first + LANES, all->body.joint_count);
    for (uint joint = first; joint < end; joint++) {
        Matrix own;
        components_of(posed_joint(all, posing, posed, still, first, joint - first), own.m);
        const uint parent = are_led(all) ? NONE : all->parents[joint];
        if (parent != NONE) keep_beneath(joints, parent, joint, &own);
        else keep_models(joints, joint, &own);
    }
}

// Does the same for a block of joints.
INLINE void place_block(const Company *all, const Posing *posing, uint first, Hierarchy joints,
                        __global float *planes)
{
    Posed posed[SPANS];
    uint sums[LANES];
    // The second half of the last block may have no joints.
    const uint spans = first + LANES < all->body.joint_count ? SPANS : 1;
    sum_block(all, posing, first, spans, posed, sums);
    for (uint span = 0; span < spans; span++)
        place_span(all, posing, first + span * LANES, sums, posed[span], joints, planes);
}
