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

// Poses of a clip: where it was sampled, at its far row, and the reference of its differences:
// where it was sampled, or in additive layers its first row.
typedef struct {
    Local at, far, reference;
} SampledPoses;

INLINE SampledPoses sampled_poses(const ClipTables *tables, SampledState state, bool additive,
                                  Body body, uint joint, Local rest)
{
    const BoundClip bound = tables->bound_clips[state.bound_clip];
    const ClipRows clip = tables->clips[bound.clip];
    const SlotSample places[3] = { place_of(clip, state.row),
                                   row_of(clip, far_row(state.row, clip.row_count - 1)),
                                   row_of(clip, 0) };
    Local found[3];
    for (uint i = 0; i < (additive ? 3 : 2); i++)
        found[i] = normalized(sample_joint(tables, bound, body, joint, places[i], rest));
    const SampledPoses poses = { found[0], found[1], found[additive ? 2 : 0] };
    return poses;
}

// Factors of the four samples. Those of `_step` belong to the step from the instant of the
// transition to the far row.
typedef struct {
    float outgoing, outgoing_step, incoming, incoming_step;
} InertializationWeights;

INLINE Real inertialization_part(Real sum, Real at, Real far, Real incoming_at,
                                 Real incoming_far, InertializationWeights by)
{
    const Real outgoing = at * by.outgoing + (far - at) * by.outgoing_step;
    const Real incoming =
        incoming_at * by.incoming + (incoming_far - incoming_at) * by.incoming_step;
    return sum + (outgoing - incoming);
}

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

INLINE Local add_inertialization(const ClipTables *tables, InertializationSlot slot, ulong tick,
                                 bool additive, Body body, uint joint, Local rest, Local sum)
{
    const InertializationWeights by = inertialization_weights(slot, tick, additive);
    const SampledPoses outgoing =
        sampled_poses(tables, outgoing_state(slot), additive, body, joint, rest);
    const SampledPoses incoming =
        sampled_poses(tables, incoming_state(slot), additive, body, joint, rest);
    const Local reference = additive ? outgoing.reference : incoming.reference;
    Local a = quotient(outgoing.at, reference, quat_identity(), 0),
          f = quotient(outgoing.far, reference, a.r, 0);
    Local n = quotient(incoming.at, incoming.reference, quat_identity(), 0),
          b = quotient(incoming.far, incoming.reference, n.r, 0);
    if (!additive) {
        // The difference is applied on top of the incoming clip and moves along with it.
        n = a;
        b = after(b, a);
    }
    a = change(a);
    f = change(f);
    n = change(n);
    b = change(b);
    sum.t.x = inertialization_part(sum.t.x, a.t.x, f.t.x, n.t.x, b.t.x, by);
    sum.t.y = inertialization_part(sum.t.y, a.t.y, f.t.y, n.t.y, b.t.y, by);
    sum.t.z = inertialization_part(sum.t.z, a.t.z, f.t.z, n.t.z, b.t.z, by);
    sum.r.x = inertialization_part(sum.r.x, a.r.x, f.r.x, n.r.x, b.r.x, by);
    sum.r.y = inertialization_part(sum.r.y, a.r.y, f.r.y, n.r.y, b.r.y, by);
    sum.r.z = inertialization_part(sum.r.z, a.r.z, f.r.z, n.r.z, b.r.z, by);
    sum.r.w = inertialization_part(sum.r.w, a.r.w, f.r.w, n.r.w, b.r.w, by);
    sum.s.x = inertialization_part(sum.s.x, a.s.x, f.s.x, n.s.x, b.s.x, by);
    sum.s.y = inertialization_part(sum.s.y, a.s.y, f.s.y, n.s.y, b.s.y, by);
    sum.s.z = inertialization_part(sum.s.z, a.s.z, f.s.z, n.s.z, b.s.z, by);
    return sum;
}

INLINE bool inertializes_in(Slot slot, uint layer, ulong tick)
{
    return slot_layer(slot) == layer && slot_inertializes(slot, tick);
}

// Adds all inertializations of a layer to its mean, or to its sum of differences if it is additive.
// A mean takes the newest start first: each earlier one is applied on top of what was outgoing
// then.
SELDOM void inertialize(const ClipTables *tables, Inertialization inertialization, uint layer,
                        bool additive, Body body, uint joint, const Local *at_rest, Local *mean)
{
    const Local rest = *at_rest;
    Local trs = *mean;
    ulong earlier = ULONG_MAX;
    for (;;) {
        ulong start = 0;
        bool any = false;
        for (uint s = 0; s < inertialization.count; s++) {
            const Slot slot = inertialization.slots[s];
            if (!inertializes_in(slot, layer, inertialization.tick) || slot.start_tick >= earlier)
                continue;
            start = any ? max(start, slot.start_tick) : slot.start_tick;
            any = true;
        }
        if (!any) break;
        Local sum = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
        for (uint s = 0; s < inertialization.count; s++) {
            const Slot slot = inertialization.slots[s];
            if (inertializes_in(slot, layer, inertialization.tick) && slot.start_tick == start)
                sum = add_inertialization(tables, as_inertialization(slot), inertialization.tick,
                                          additive, body, joint, rest, sum);
        }
        const Local added = { vec3_add(trs.t, sum.t), quat_add(trs.r, sum.r),
                              vec3_add(trs.s, sum.s) };
        trs = additive ? added : add_layer(trs, sum, 1.0f);
        earlier = start;
    }
    *mean = trs;
}
