// sums.cl - Weighted sums over a layer's slots, and their means (Lister & Day 2012, section 3).
//
// Twin of populace-native/src/joint.rs: same arithmetic, same order of operations.

// Total weight of a layer's slots. `unweighted` tells that the layer's only slot was not weighted in
// the sum. `at_rest` has REST_TRANSLATION or REST_SCALE set if all of them leave that property at
// rest, and NEAR_REST if all rotations are in the hemisphere of the rest.
typedef struct {
    float total;
    bool unweighted;
    uint at_rest;
} Terms;

// Weighted sum over a layer's slots.
typedef struct {
    Local trs;
    Terms terms;
} Sum;

INLINE Local no_local(void)
{
    const Local none = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
    return none;
}

// Returns the mean. Properties that no slot moves are at rest to the bit.
INLINE Local mean_of(Sum sum, Local rest)
{
    const float k = sum.terms.unweighted ? 1.0f : 1.0f / sum.terms.total;
    Local mean;
    mean.t = sum.terms.at_rest & REST_TRANSLATION ? rest.t : vec3_scale(sum.trs.t, k);
    mean.r = quat_normalize_or(sum.trs.r, rest.r);
    mean.s = sum.terms.at_rest & REST_SCALE ? rest.s : vec3_scale(sum.trs.s, k);
    return mean;
}

// Returns the mean if the total weight is above `least`. Layer 0 is always divided by its total
// weight, so that the rest pose never shines through.
INLINE Local mean_or_rest(Sum sum, float least, Local rest)
{
    return sum.terms.total > least ? mean_of(sum, rest) : rest;
}

#if LANES == 1

// Returns the sum of weight times value over a layer's slots, or of weight times difference from
// the first row if the layer is additive.
INLINE Sum sum_layer(const ClipTables *tables, Playback playback, uint layer, bool additive,
                     uint joint, Local rest)
{
    const bool alone = !additive && playback.alone & 1u << layer;
    Sum sum = { no_local(), { 0.0f, alone, REST_TRANSLATION | REST_SCALE } };
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.at.weight <= 0.0f || playing.layer != layer) continue;
        const float weight = alone ? 1.0f : playing.at.weight;
        const Sample sample = sample_joint(tables, playing.bound_clip, joint, rows_in(playing),
                                           rest, playback.at_once);
        Local trs = sample.trs;
        Real k = weight;
        if (!additive) {
            k = alone ? quat_side(trs.r, rest.r) : unit_of(trs.r, rest.r) * weight;
        } else {
            const Local first = first_pose(tables, playing.bound_clip, joint);
            trs =
                change(quotient(normalized(sample, rest), first, quat_identity(), sample.at_rest));
        }
        sum.trs.t = vec3_add(sum.trs.t, vec3_scale(trs.t, weight));
        sum.trs.r = quat_add(sum.trs.r, quat_scale(trs.r, k));
        sum.trs.s = vec3_add(sum.trs.s, vec3_scale(trs.s, weight));
        sum.terms.total += playing.at.weight;
        sum.terms.at_rest &= sample.at_rest;
    }
    return sum;
}

#else

// A slot in a block of joints: where its numbers are, from the first of LANES joints on.
typedef struct {
    Columns columns;
    Stored planes;
    Rows rows;
    float weight;
} BlockSlot;

INLINE BlockSlot block_slot(Playing playing, uint joint, bool no_floats)
{
    const BlockSlot slot = { columns_of(playing.blocks, joint, no_floats),
                             playing.planes + stored_offset(BOUND_PLANES, joint), rows_in(playing),
                             playing.at.weight };
    return slot;
}

// Returns the slot in the next LANES joints of the block.
INLINE BlockSlot next_span(BlockSlot slot)
{
    slot.columns.lane += LANES;
    slot.planes += LANES;
    return slot;
}

// Returns the rotation of a slot, near length 1 and in either hemisphere.
INLINE Quat rotation_of(const ClipTables *tables, BlockSlot slot)
{
    return sample_rotation(tables, slot.columns, slot.rows, slot.planes);
}

// Returns the factor that brings a slot's rotation to length 1 and into the hemisphere of the rest.
// `flags` are those of the slot's columns.
INLINE Real factor_of(Quat q, uint flags, Stored rest)
{
    return flags & NEAR_REST ? near_unit_of(q) : unit_of(q, stored_quat(rest, 0));
}

INLINE void add_vector(Vec3 v, float weight, Vec3 *sum)
{
    *sum = vec3_add(*sum, vec3_scale(v, weight));
}

// Returns the rotation of a layer's only slot, from that of its rows. `near_rest` tells that it is in
// the hemisphere of the rest, and so not 0.
INLINE Quat unit_alone(Quat q, bool near_rest, Stored rest)
{
    if (near_rest) return quat_scale(q, inverse_sqrt(quat_dot(q, q)));
    const Quat fallback = stored_quat(rest, 0);
    const Quat sum = quat_add(no_local().r, quat_hemisphere(q, fallback));
    return quat_normalize_or(sum, fallback);
}

// Does the same for a slot.
INLINE Quat rotation_alone(const ClipTables *tables, BlockSlot slot, Stored rest)
{
    return unit_alone(rotation_of(tables, slot), slot.columns.flags & NEAR_REST, rest);
}

// Returns the translation or scale of a layer's only slot.
INLINE Vec3 vector_alone(const ClipTables *tables, BlockSlot slot, uint property)
{
    const int plane = property == TRANSLATION ? 5 : 9;
    return sample_vector(tables, slot.columns, property, slot.rows, slot.planes, plane);
}

// Adds weight times translation or scale of a slot. Each branch adds on its own: numbers that
// branches hand on would take registers from the sums.
INLINE void add_property(const ClipTables *tables, BlockSlot slot, uint property, Stored rest,
                         bool two_spans, Vec3 *first, Vec3 *second)
{
    const bool is_translation = property == TRANSLATION;
    const int plane = is_translation ? 5 : 9, rest_plane = is_translation ? 4 : 7;
    const BlockSlot next = next_span(slot);
    if (slot.columns.flags & (is_translation ? REST_TRANSLATION : REST_SCALE)) {
        add_vector(stored_vec3(rest, rest_plane), slot.weight, first);
        if (two_spans) add_vector(stored_vec3(rest + LANES, rest_plane), slot.weight, second);
    } else if (planes_of(slot.columns, property).first == NONE) {
        add_vector(stored_vec3(slot.planes, plane), slot.weight, first);
        if (two_spans) add_vector(stored_vec3(next.planes, plane), slot.weight, second);
    } else {
        add_vector(moving_vector(tables, slot.columns, property, slot.rows, slot.planes, plane),
                   slot.weight, first);
        if (two_spans)
            add_vector(moving_vector(tables, next.columns, property, slot.rows, next.planes, plane),
                       slot.weight, second);
    }
}

// Sums the translations or scales of a layer's slots.
INLINE void sum_property(const ClipTables *tables, Playback playback, uint layer, uint property,
                         uint joint, Stored rest, bool no_floats, bool two_spans, Vec3 *first,
                         Vec3 *second)
{
    Vec3 sum = no_local().t, next = sum;
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.layer != layer) continue;
        const BlockSlot slot = block_slot(playing, joint, no_floats);
        add_property(tables, slot, property, rest, two_spans, &sum, &next);
    }
    *first = sum;
    if (two_spans) *second = next;
}

// Rotations of the slots in a block, before they are weighted, and the flags of their columns.
typedef struct {
    Quat spans[MAX_SLOTS][SPANS];
    uint flags[MAX_SLOTS];
} SlotRotations;

// Samples the rotations of a layer's slots. Returns `at_rest` of Terms.
INLINE uint sample_rotations(const ClipTables *tables, Playback playback, uint layer, uint joint,
                             bool no_floats, bool two_spans, SlotRotations *all)
{
    uint at_rest = REST_TRANSLATION | REST_SCALE | NEAR_REST;
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.layer != layer) continue;
        const BlockSlot slot = block_slot(playing, joint, no_floats);
        all->spans[s][0] = rotation_of(tables, slot);
        if (two_spans) all->spans[s][SPANS - 1] = rotation_of(tables, next_span(slot));
        all->flags[s] = slot.columns.flags;
        at_rest &= slot.columns.flags;
    }
    return at_rest;
}

// Returns the sum of weight times rotation over a layer's slots.
INLINE Quat sum_rotations(const SlotRotations *all, Playback playback, uint layer, uint span,
                          Stored rest)
{
    Quat sum = no_local().r;
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.layer != layer) continue;
        const Quat q = all->spans[s][span];
        const Real factor = factor_of(q, all->flags[s], rest);
        sum = quat_add(sum, quat_scale(q, factor * playing.at.weight));
    }
    return sum;
}

// Sums weight times value over a layer's slots, for LANES joints or for all sixteen of a block.
// `two_spans` is a constant; without it, `second` is unused. Properties are summed one after the
// other: registers hold the sums of one. Both spans use the columns that are found once. Properties
// at rest are left out. All slots have weight, since play_all() leaves out others. Rotations are
// sampled before they are summed: each pass is short enough for a processor to have several slots in
// flight. Returns `at_rest` of Terms.
INLINE uint sum_spans(const ClipTables *tables, Playback playback, uint layer, Body body,
                      uint joint, bool no_floats, bool two_spans, Local *first, Local *second)
{
    const Stored rest = stored_at(tables, body.rest_first, POSE_PLANES, joint);
    SlotRotations rotations;
    const uint at_rest =
        sample_rotations(tables, playback, layer, joint, no_floats, two_spans, &rotations);
    first->r = sum_rotations(&rotations, playback, layer, 0, rest);
    if (two_spans) second->r = sum_rotations(&rotations, playback, layer, SPANS - 1, rest + LANES);
    if (!(at_rest & REST_TRANSLATION))
        sum_property(tables, playback, layer, TRANSLATION, joint, rest, no_floats, two_spans,
                     &first->t, &second->t);
    if (!(at_rest & REST_SCALE))
        sum_property(tables, playback, layer, SCALE, joint, rest, no_floats, two_spans, &first->s,
                     &second->s);
    return at_rest;
}

// Returns the rotation of a slot, of length 1 and in the hemisphere of the rest.
INLINE Quat unit_rotation(const ClipTables *tables, BlockSlot slot, Stored rest)
{
    const Quat q = rotation_of(tables, slot);
    return quat_scale(q, factor_of(q, slot.columns.flags, rest));
}

// Returns the change from the first row of a slot's clip, times the slot's weight. Leaves out
// properties at rest.
INLINE Local weighted_change(const ClipTables *tables, BlockSlot slot, Stored rest)
{
    const Local first = stored_pose(slot.planes, FIRST_POSE_PLANE);
    const uint flags = slot.columns.flags;
    Local change = no_local();
    const Quat turned = quat_mul(quat_conjugate(first.r), unit_rotation(tables, slot, rest));
    change.r = quat_short_way(turned);
    change.r.w -= 1.0f;
    change.r = quat_scale(change.r, slot.weight);
    if (!(flags & REST_TRANSLATION)) {
        const Vec3 to = vector_alone(tables, slot, TRANSLATION);
        add_vector(vec3_add(to, vec3_scale(first.t, -1.0f)), slot.weight, &change.t);
    }
    if (flags & REST_SCALE) return change;
    Vec3 s = scale_ratios(vector_alone(tables, slot, SCALE), first.s);
    s.x -= 1.0f;
    s.y -= 1.0f;
    s.z -= 1.0f;
    change.s = vec3_scale(s, slot.weight);
    return change;
}

// Returns the sum of weighted changes over the slots of an additive layer, for LANES joints.
// `at_rest` receives that of Terms.
APART Local sum_changes(const ClipTables *tables, Playback playback, uint layer, Stored rest,
                        uint joint, bool no_floats, uint *at_rest)
{
    Local sum = no_local();
    *at_rest = REST_TRANSLATION | REST_SCALE;
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.layer != layer) continue;
        const BlockSlot slot = block_slot(playing, joint, no_floats);
        sum = local_add(sum, weighted_change(tables, slot, rest));
        *at_rest &= slot.columns.flags;
    }
    return sum;
}

#endif
