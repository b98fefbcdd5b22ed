// abreast.cl - Members side by side, each in a lane of its own: their local transforms. Slots of layer
// 0 are sampled and summed for a block of joints of a member at a time. Passes over all members are
// short enough for a processor to have several members in flight. The poses are transposed into lanes
// of members.
//
// Twin of populace-native/src/poses.rs and populace-native/src/abreast.rs: same arithmetic, same order
// of operations.

// Poses a block of joints of a member whose layer 0 plays one slot. Nothing is weighted or divided:
// this gives the same bits as a sum of one term of weight 1, and its mean. Zeros among ranges are
// positive, as sums are that begin with 0.
INLINE void pose_alone(const Company *all, const Posing *posing, uint lane, uint first,
                       bool no_floats, uint spans, Posed *posed, uint *at_rest)
{
    const ClipTables *tables = posing->clips;
    const Playback playback = all->plays[lane];
    const Playing playing = playing_at(playback, all->layers[lane][0].alone);
    BlockSlot slot = block_slot(playing, first, no_floats);
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
    *at_rest = flags;
}

// Sums the slots of layer 0 of a member, for LANES joints or for a whole block. The pose of one slot
// is complete.
INLINE void sum_member(const Company *all, const Posing *posing, uint lane, uint first,
                       bool no_floats, uint spans, Posed *posed, uint *at_rest)
{
    const ClipTables *tables = posing->clips;
    const Playback playback = all->plays[lane];
    if (all->layers[lane][0].alone != NONE) {
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
        if (all->layers[lane][0].alone != NONE) {
            // Other members may move what is at rest in this one.
            const uint missing = at_rest[lane] & ~left_out;
            if (missing & REST_TRANSLATION) put_vector(posed, lane, TRANSLATION, rest.t);
            if (missing & REST_SCALE) put_vector(posed, lane, SCALE, rest.s);
            continue;
        }
        const float total = all->layers[lane][0].total;
        const Sum sum = { local_of(posed, lane), { total, false, at_rest[lane] } };
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
