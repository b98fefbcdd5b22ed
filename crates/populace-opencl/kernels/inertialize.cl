// inertialize.cl - Inertialization: after a transition the pose keeps the difference from the
// previous clips, in pose and in speed, and fades it out (Bollo, "Inertialization", GDC 2018).
//
// Twin of populace-native/src/inertialize.rs: same arithmetic, same order of operations.

// A clip at an instant; see SampledState in populace-device/src/playback/inertialize.rs.
typedef struct {
    uint bound_clip;
    float row, pace;
} SampledState;

INLINE SampledState outgoing_state(InertializationSlot slot)
{
    const SampledState state = { slot.outgoing_clip, slot.outgoing_row, slot.outgoing_pace };
    return state;
}

INLINE SampledState incoming_state(InertializationSlot slot)
{
    const SampledState state = { slot.incoming_clip, slot.incoming_row, slot.incoming_pace };
    return state;
}

INLINE uint row_before(float at, uint last) { return min((uint)at, last); }

// Returns the end of the gap between rows that is not the nearer one.
INLINE uint far_row(float at, uint last)
{
    const uint row = row_before(at, last);
    if (at - (float)row >= 0.5f) return row;
    return row < last ? row + 1 : last - min(last, 1u);
}

INLINE SlotSample row_of(ClipRows clip, uint row)
{
    const uint first = clip.row_first + row * clip.row_stride;
    const SlotSample at = { first, first, 0.0f, 0.0f };
    return at;
}

// Returns the rows around a fractional row index.
INLINE SlotSample place_of(ClipRows clip, float at)
{
    const uint last = clip.row_count - 1, row = row_before(at, last);
    SlotSample place = row_of(clip, row);
    place.row1 = row_of(clip, min(row + 1, last)).row0;
    place.between = at - (float)row;
    return place;
}

// Factors of the four samples. Those of `_step` belong to the step from the instant of the
// transition to the far row.
typedef struct {
    float outgoing, outgoing_step, incoming, incoming_step;
} InertializationWeights;

// Returns the parts that are left of the initial difference and of its velocity. They are quintics
// whose value, slope and curvature are 0 at the end, and whose curvature is 0 at the start.
INLINE float2 decay(float inertialized)
{
    const float left = 1.0f - inertialized, cube = left * left * left;
    return (float2)(cube * (1.0f + 3.0f * inertialized + 6.0f * inertialized * inertialized),
                    inertialized * cube * (1.0f + 3.0f * inertialized));
}

INLINE InertializationWeights inertialization_weights(InertializationSlot slot, ulong tick,
                                                      bool additive)
{
    const float2 parts = decay(inertialized_at(slot, tick));
    const float still = parts.x, moving = parts.y, share = slot.share;
    const InertializationWeights by = { still * share + moving * slot.share_change,
                                        moving * share * slot.outgoing_pace,
                                        additive ? still * share : 0.0f,
                                        moving * share * slot.incoming_pace };
    return by;
}

// Samples of a clip, in the order in which a difference needs them.
enum { SAMPLE_REFERENCE, SAMPLE_AT, SAMPLE_FAR, SAMPLES_OF_CLIP };

// Returns a sample of a clip: where it was at the transition, its far row, or the reference of its
// differences. In additive layers that is its first row, else where it was.
INLINE Local inertialization_sample(const ClipTables *tables, SampledState state, uint sample,
                                    bool additive, uint joint, Local rest)
{
    if (sample == SAMPLE_REFERENCE && additive) return first_pose(tables, state.bound_clip, joint);
    const ClipRows clip = tables->clips[tables->bound_clips[state.bound_clip].rows];
    SlotSample place = place_of(clip, state.row);
    if (sample == SAMPLE_FAR) place = row_of(clip, far_row(state.row, clip.row_count - 1));
    return normalized(
        sample_joint(tables, state.bound_clip, joint, rows_of(tables, place), rest, false), rest);
}

// Returns the part that is left of a clip's differences from its reference.
INLINE Local part_left(Local at, Local far, Real weight, Real weight_of_step)
{
    at = change(at);
    far = change(far);
    return local_add(local_scale(at, weight), local_scale(local_less(far, at), weight_of_step));
}

// Adds what is left of one slot's difference to a sum. Takes one sample after another, so that a
// GPU keeps few of them in registers.
INLINE Local add_inertialization(const ClipTables *tables, InertializationSlot slot, ulong tick,
                                 bool additive, uint joint, Local rest, Local sum)
{
    const InertializationWeights by = inertialization_weights(slot, tick, additive);
    Local reference = rest, at = rest, outgoing = rest;
#pragma unroll 1
    for (uint nth = 0; nth < 2 * SAMPLES_OF_CLIP; nth++) {
        const bool incoming = nth >= SAMPLES_OF_CLIP;
        const uint sample = incoming ? nth - SAMPLES_OF_CLIP : nth;
        // Over a mean, both clips differ from the incoming one, where it was.
        const bool shares = !additive && sample == SAMPLE_REFERENCE;
        if (incoming && !additive && sample != SAMPLE_FAR) continue;
        const Local posed = inertialization_sample(
            tables, incoming || shares ? incoming_state(slot) : outgoing_state(slot), sample,
            additive, joint, rest);
        if (sample == SAMPLE_REFERENCE) {
            reference = posed;
        } else if (sample == SAMPLE_AT) {
            at = quotient(posed, reference, quat_identity(), 0);
        } else {
            // Over a mean, the difference is applied over the incoming clip, and moves with it.
            const bool moves = incoming && !additive;
            const Quat side = moves ? quotient(reference, reference, quat_identity(), 0).r : at.r;
            Local far = quotient(posed, reference, side, 0);
            if (moves) far = after(far, at);
            if (!incoming) {
                outgoing = part_left(at, far, by.outgoing, by.outgoing_step);
                continue;
            }
            const Local left = part_left(at, far, by.incoming, by.incoming_step);
            sum = local_add(sum, local_less(outgoing, left));
        }
    }
    return sum;
}

INLINE bool inertializes_in(Slot slot, uint layer, ulong tick)
{
    return slot_layer(slot) == layer && slot_inertializes(slot, tick);
}

// Finds the newest start of a layer's inertializations that is earlier than *start, and returns
// whether there is one.
INLINE bool earlier_start(Inertialization inertialization, uint layer, ulong *start)
{
    ulong newest = 0;
    bool any = false;
    for (uint s = 0; s < inertialization.count; s++) {
        const Slot slot = inertialization.slots[s];
        if (!inertializes_in(slot, layer, inertialization.tick) || slot.start_tick >= *start)
            continue;
        newest = any ? max(newest, slot.start_tick) : slot.start_tick;
        any = true;
    }
    *start = newest;
    return any;
}

// Returns what is left of the differences of a layer's inertializations that started at a tick.
INLINE Local left_since(const ClipTables *tables, Inertialization inertialization, uint layer,
                        ulong start, bool additive, uint joint, Local rest)
{
    Local sum = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
    for (uint s = 0; s < inertialization.count; s++) {
        const Slot slot = inertialization.slots[s];
        if (inertializes_in(slot, layer, inertialization.tick) && slot.start_tick == start)
            sum = add_inertialization(tables, as_inertialization(slot), inertialization.tick,
                                      additive, joint, rest, sum);
    }
    return sum;
}

// Adds what is left of differences to a layer's mean, or to its sum of differences if it is
// additive.
INLINE Local inertialized(Local pose, Local left, bool additive)
{
    return additive ? local_add(pose, left) : add_layer(pose, left, 1.0f);
}

// Adds all inertializations of a layer. A mean takes the newest start first: each earlier one is
// applied on top of what was outgoing then.
SELDOM void inertialize(const ClipTables *tables, Inertialization inertialization, uint layer,
                        bool additive, uint joint, const Local *at_rest, Local *pose)
{
    const Local rest = *at_rest;
    Local trs = *pose;
    ulong start = ULONG_MAX;
    while (earlier_start(inertialization, layer, &start)) {
        const Local left = left_since(tables, inertialization, layer, start, additive, joint, rest);
        trs = inertialized(trs, left, additive);
    }
    *pose = trs;
}
