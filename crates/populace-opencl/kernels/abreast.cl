// abreast.cl - Members side by side, each in a lane of its own: their local transforms. Slots of layer
// 0 are sampled and summed for a block of joints of a member at a time. Passes over all members are
// short enough for a processor to have several members in flight. The poses are transposed into lanes
// of members.
//
// Twin of populace-native/src/poses.rs and populace-native/src/abreast.rs: same arithmetic, same order
// of operations.

// Poses a member whose layer 0 plays one slot, except that pose_span() brings rotations to length 1.
// Nothing is weighted or divided: this gives the same bits as a sum of one term of weight 1, and its
// mean. Zeros among ranges are positive, as sums are that begin with 0.
INLINE uint pose_alone(const Company *all, const ClipTables *tables, uint lane, uint joint,
                       bool no_floats, bool two_spans, Local *first, Local *second)
{
    const Playing playing = playing_at(all->plays[lane], all->layers[lane][0].alone);
    const BlockSlot slot = block_slot(playing, joint, no_floats), next = next_span(slot);
    const uint flags = slot.columns.flags;
    first->r = rotation_of(tables, slot);
    if (two_spans) second->r = rotation_of(tables, next);
    if (!(flags & REST_TRANSLATION)) {
        first->t = vector_alone(tables, slot, TRANSLATION);
        if (two_spans) second->t = vector_alone(tables, next, TRANSLATION);
    }
    if (!(flags & REST_SCALE)) {
        first->s = vector_alone(tables, slot, SCALE);
        if (two_spans) second->s = vector_alone(tables, next, SCALE);
    }
    return flags;
}

// Sums the slots of layer 0 of a member for one or two spans of LANES joints, as sum_spans() does, or
// as pose_alone() does.
INLINE uint sum_member(const Company *all, const Posing *posing, uint lane, uint joint,
                       bool no_floats, bool two_spans, Local *first, Local *second)
{
    const ClipTables *tables = posing->clips;
    if (all->layers[lane][0].alone != NONE)
        return pose_alone(all, tables, lane, joint, no_floats, two_spans, first, second);
    return sum_spans(tables, all->plays[lane], 0, all->body, joint, no_floats, two_spans, first,
                     second);
}

// Does the same for a member with a clip that stores floats; see show_any_layer().
APART uint sum_any_member(const Company *all, const Posing *posing, uint lane, uint joint,
                          bool two_spans, Local *first, Local *second)
{
    return sum_member(all, posing, lane, joint, false, two_spans, first, second);
}

INLINE uint at_rest_in_all(const Company *all, const uint *at_rest)
{
    uint still = REST_TRANSLATION | REST_SCALE;
    for (uint lane = 0; lane < all->count; lane++) still &= at_rest[lane];
    return still;
}

// Sums the slots of layer 0 of all members, as sum_member() does.
INLINE void sum_members(const Company *all, const Posing *posing, uint joint, bool two_spans,
                        Posed first, Posed second, uint *at_rest)
{
    for (uint lane = 0; lane < all->count; lane++)
        at_rest[lane] =
            all->plays[lane].has_floats
                ? sum_any_member(all, posing, lane, joint, two_spans, &first[lane], &second[lane])
                : sum_member(all, posing, lane, joint, true, two_spans, &first[lane],
                             &second[lane]);
}

// Turns neighbouring components of local transforms into lanes of members. `all` points at the first
// component of the first member.
INLINE void turn_components(Real *all, uint components, uint count)
{
    const uint step = sizeof(Local) / sizeof(Real);
#pragma unroll
    for (uint c = 0; c < components; c++) {
        for (uint lane = count; lane < LANES; lane++) all[c + lane * step] = 0.0f;
        Real turned[LANES];
#pragma unroll
        for (uint lane = 0; lane < LANES; lane++) turned[lane] = all[c + lane * step];
        transpose(turned);
#pragma unroll
        for (uint at = 0; at < LANES; at++) all[c + at * step] = turned[at];
    }
}

// Turns the sums of LANES joints into local transforms in lanes of members, except properties that
// are at rest in all of them, which it returns. If `planes` is not 0, it receives the transforms of
// the first member, as ten planes of the body's padded joints.
INLINE uint pose_span(const Company *all, const Posing *posing, uint first, const uint *sums,
                      Posed posed, __global float *planes)
{
    const Local rest = rest_of(posing->clips, all->body, first);
    const Stored stored = stored_at(posing->clips, all->body.rest_first, POSE_PLANES, first);
    // Changes of poses change what is at rest. The block's other span begins with that of the sums.
    uint at_rest[LANES];
    for (uint lane = 0; lane < all->count; lane++) at_rest[lane] = sums[lane];
    const uint left_out = posing->any_changes || planes ? 0 : at_rest_in_all(all, at_rest);
    for (uint lane = 0; lane < all->count; lane++) {
        if (all->layers[lane][0].alone != NONE) {
            posed[lane].r = unit_alone(posed[lane].r, at_rest[lane] & NEAR_REST, stored);
            // Other members may move what is at rest in this one.
            const uint missing = at_rest[lane] & ~left_out;
            if (missing & REST_TRANSLATION) posed[lane].t = rest.t;
            if (missing & REST_SCALE) posed[lane].s = rest.s;
            continue;
        }
        const float total = all->layers[lane][0].total;
        const Sum sum = { posed[lane], { total, false, at_rest[lane] } };
        // Each branch stores on its own, so that the other keeps no registers.
        if (sum.terms.total > LEAST_TOTAL) put_local(&posed[lane], mean_of(sum, rest), left_out);
        else put_local(&posed[lane], rest, left_out);
    }
    if (posing->any_changes) change_poses(all, posing, first, at_rest, posed);
    if (planes) store_trs(posed[0], planes + first, all->body.padded_count);
    const uint still = at_rest_in_all(all, at_rest);
    if (!(still & REST_TRANSLATION)) turn_components(&posed->t.x, 3, all->count);
    turn_components(&posed->r.x, 4, all->count);
    if (!(still & REST_SCALE)) turn_components(&posed->s.x, 3, all->count);
    return still;
}

// Returns the local transforms of a joint.
INLINE Local posed_joint(const Company *all, const Posing *posing, const Posed posed, uint still,
                         uint first, uint at)
{
    const Stored rest = stored_at(posing->clips, all->body.rest_first, POSE_PLANES, first + at);
    Local trs = posed[at];
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
    if (spans == 1) sum_members(all, posing, first, false, posed[0], posed[0], sums);
    else sum_members(all, posing, first, true, posed[0], posed[SPANS - 1], sums);
    for (uint span = 0; span < spans; span++)
        place_span(all, posing, first + span * LANES, sums, posed[span], joints, planes);
}
