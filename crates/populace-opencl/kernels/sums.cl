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
            const uint clip = tables->bound_clips[playing.bound_clip].rows;
            const uint first = tables->clips[clip].row_first;
            const SlotSample start = { first, first, 0.0f, 0.0f };
            const Local reference = normalized(sample_joint(tables, playing.bound_clip, joint,
                                                            rows_of(tables, start), rest, false),
                                               rest);
            trs = change(
                quotient(normalized(sample, rest), reference, quat_identity(), sample.at_rest));
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
    Stored range;
    Rows rows;
    float weight;
} BlockSlot;

INLINE BlockSlot block_slot(Playing playing, uint joint, bool no_floats)
{
    const BlockSlot slot = { columns_of(playing.blocks, joint, no_floats),
                             playing.ranges + stored_offset(RANGE_PLANES, joint), rows_in(playing),
                             playing.at.weight };
    return slot;
}

// Returns the slot in the next LANES joints of the block.
INLINE BlockSlot next_span(BlockSlot slot)
{
    slot.columns.lane += LANES;
    slot.range += LANES;
    return slot;
}

// A sum of rotations, which does not fit into registers beside the arithmetic.
typedef IN_MEMORY Quat QuatSum;

INLINE void add_quat(Quat q, Real k, QuatSum *sum)
{
    sum->x = sum->x + q.x * k;
    sum->y = sum->y + q.y * k;
    sum->z = sum->z + q.z * k;
    sum->w = sum->w + q.w * k;
}

// Adds a rotation that may lie in either hemisphere.
INLINE void add_any_quat(Quat q, Stored rest, float weight, QuatSum *sum)
{
    add_quat(q, unit_of(q, stored_quat(rest, 0)) * weight, sum);
}

// Adds a rotation in the hemisphere of the rest rotation.
INLINE void add_near_quat(Quat q, float weight, QuatSum *sum)
{
    add_quat(q, near_unit_of(q) * weight, sum);
}

INLINE Quat quat_of(const ClipTables *tables, BlockSlot slot)
{
    return moving_quat(tables, slot.columns, slot.rows, slot.range);
}

INLINE void add_vector(Vec3 v, float weight, Vec3 *sum)
{
    *sum = vec3_add(*sum, vec3_scale(v, weight));
}

// Adds weight times rotation of a slot.
INLINE void add_rotation(const ClipTables *tables, BlockSlot slot, Stored rest, bool two_spans,
                         QuatSum *first, QuatSum *second)
{
    const BlockSlot next = next_span(slot);
    if (slot.columns.block.rotation_first == NONE) {
        add_any_quat(stored_quat(slot.range, 0), rest, slot.weight, first);
        if (two_spans) add_any_quat(stored_quat(next.range, 0), rest + LANES, slot.weight, second);
    } else if (slot.columns.flags & NEAR_REST) {
        add_near_quat(quat_of(tables, slot), slot.weight, first);
        if (two_spans) add_near_quat(quat_of(tables, next), slot.weight, second);
    } else {
        add_any_quat(quat_of(tables, slot), rest, slot.weight, first);
        if (two_spans) add_any_quat(quat_of(tables, next), rest + LANES, slot.weight, second);
    }
}

// Returns the rotation of a layer's only slot, which may lie in either hemisphere.
INLINE Quat any_rotation_alone(Quat q, Stored rest)
{
    const Quat fallback = stored_quat(rest, 0);
    const Quat sum = quat_add(no_local().r, quat_hemisphere(q, fallback));
    return quat_normalize_or(sum, fallback);
}

// Returns the rotation of a layer's only slot. Rotations near the rest are not 0.
INLINE Quat rotation_alone(const ClipTables *tables, BlockSlot slot, Stored rest)
{
    if (slot.columns.block.rotation_first == NONE)
        return any_rotation_alone(stored_quat(slot.range, 0), rest);
    const Quat q = quat_of(tables, slot);
    if (slot.columns.flags & NEAR_REST) return quat_scale(q, inverse_sqrt(quat_dot(q, q)));
    return any_rotation_alone(q, rest);
}

// Returns the translation or scale of a layer's only slot.
INLINE Vec3 vector_alone(const ClipTables *tables, BlockSlot slot, uint property)
{
    const int plane = property == TRANSLATION ? 5 : 9;
    return sample_vector(tables, slot.columns, property, slot.rows, slot.range, plane);
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
        add_vector(stored_vec3(slot.range, plane), slot.weight, first);
        if (two_spans) add_vector(stored_vec3(next.range, plane), slot.weight, second);
    } else {
        add_vector(moving_vector(tables, slot.columns, property, slot.rows, slot.range, plane),
                   slot.weight, first);
        if (two_spans)
            add_vector(moving_vector(tables, next.columns, property, slot.rows, next.range, plane),
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

// Sums weight times value over a layer's slots, for LANES joints or for all sixteen of a block.
// `two_spans` is a constant; without it, `second` is unused. Properties are summed one after the
// other: registers hold the sums of one. Both spans use the columns that are found once. Properties
// at rest are left out. All slots have weight, since play_all() leaves out others. Returns `at_rest`
// of Terms.
INLINE uint sum_spans(const ClipTables *tables, Playback playback, uint layer, Body body,
                      uint joint, bool no_floats, bool two_spans, Local *first, Local *second)
{
    const Stored rest = stored_at(tables, body.rest_first, POSE_PLANES, joint);
    uint at_rest = REST_TRANSLATION | REST_SCALE | NEAR_REST;
    first->r = no_local().r;
    if (two_spans) second->r = no_local().r;
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.layer != layer) continue;
        const BlockSlot slot = block_slot(playing, joint, no_floats);
        add_rotation(tables, slot, rest, two_spans, &first->r, &second->r);
        at_rest &= slot.columns.flags;
    }
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
    if (slot.columns.block.rotation_first != NONE && slot.columns.flags & NEAR_REST) {
        const Quat q = quat_of(tables, slot);
        return quat_scale(q, near_unit_of(q));
    }
    const Quat q = sample_rotation(tables, slot.columns, slot.rows, slot.range);
    return quat_scale(q, unit_of(q, stored_quat(rest, 0)));
}

// Returns the change from the first row of a slot's clip, times the slot's weight. Leaves out
// properties at rest.
INLINE Local weighted_change(const ClipTables *tables, Playing playing, BlockSlot slot, Stored rest)
{
    BlockSlot start = slot;
    const Rows first = { playing.first, playing.first, 0.0f, ROW_PARTS };
    start.rows = first;
    const uint flags = slot.columns.flags;
    Local change = no_local();
    const Quat reference = unit_rotation(tables, start, rest);
    const Quat turned = quat_mul(quat_conjugate(reference), unit_rotation(tables, slot, rest));
    change.r = quat_hemisphere(turned, quat_identity());
    change.r.w -= 1.0f;
    change.r = quat_scale(change.r, slot.weight);
    if (!(flags & REST_TRANSLATION)) {
        const Vec3 from = vector_alone(tables, start, TRANSLATION);
        const Vec3 to = vector_alone(tables, slot, TRANSLATION);
        add_vector(vec3_add(to, vec3_scale(from, -1.0f)), slot.weight, &change.t);
    }
    if (flags & REST_SCALE) return change;
    Vec3 s = scale_ratios(vector_alone(tables, slot, SCALE), vector_alone(tables, start, SCALE));
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
        sum = local_add(sum, weighted_change(tables, playing, slot, rest));
        *at_rest &= slot.columns.flags;
    }
    return sum;
}

#endif
