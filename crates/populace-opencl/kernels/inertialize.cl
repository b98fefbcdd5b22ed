// inertialize.cl - Inertialization: after a transition the pose keeps the difference from the
// previous clips, in pose and in speed, and fades it out (Bollo, "Inertialization", GDC 2018).
//
// Twin of populace-native/src/inertialize.rs: same arithmetic, same order of operations.

// A clip at an instant; see SampledState in populace-device/src/playback/inertialize.rs.
typedef struct {
    uint bound_clip;
    float row, pace;
} SampledState;

INLINE SampledState sampled_state(uint bound_clip, ulong pair)
{
    const SampledState state = { bound_clip, as_float((uint)pair), as_float((uint)(pair >> 32)) };
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

// Factors of the outgoing (left) and incoming (taking) clip: of the pose, and of the way to its far
// row.
typedef struct {
    float left, left_way, taking, taking_way;
} InertializationWeights;

INLINE Real inertialization_part(Real sum, Real at, Real far, Real taking_at, Real taking_far,
                                 InertializationWeights by)
{
    const Real left = at * by.left + (far - at) * by.left_way;
    return sum + (left - (taking_at * by.taking + (taking_far - taking_at) * by.taking_way));
}

// The weights are quintics with value, slope and curvature 0 at the end, and curvature 0 at the
// start.
INLINE InertializationWeights inertialization_weights(Slot slot, ulong tick, bool additive)
{
    const float inertialized = slot_inertialized(slot, tick), to_go = 1.0f - inertialized,
                cube = to_go * to_go * to_go;
    const float still = cube * (1.0f + 3.0f * inertialized + 6.0f * inertialized * inertialized);
    const float moving = inertialized * cube * (1.0f + 3.0f * inertialized),
                share = slot.start_weight;
    const InertializationWeights by = { still * share + moving * slot.weight_rate,
                                        moving * share * sampled_state(0, slot.phase_rate).pace,
                                        additive ? still * share : 0.0f,
                                        moving * share * sampled_state(0, slot.weight_tick).pace };
    return by;
}

INLINE Local add_inertialization(const ClipTables *tables, Slot slot, ulong tick, bool additive,
                                 Body body, uint joint, Local rest, Local sum)
{
    const InertializationWeights by = inertialization_weights(slot, tick, additive);
    const SampledPoses left = sampled_poses(tables, sampled_state(slot.bound_clip, slot.phase_rate),
                                            additive, body, joint, rest);
    const SampledPoses taking = sampled_poses(
        tables, sampled_state(slot.start_phase, slot.weight_tick), additive, body, joint, rest);
    const Local reference = additive ? left.reference : taking.reference;
    Local a = quotient(left.at, reference, quat_identity(), 0),
          f = quotient(left.far, reference, a.r, 0);
    Local n = quotient(taking.at, taking.reference, quat_identity(), 0),
          b = quotient(taking.far, taking.reference, n.r, 0);
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
                sum = add_inertialization(tables, slot, inertialization.tick, additive, body, joint,
                                          rest, sum);
        }
        const Local added = { vec3_add(trs.t, sum.t), quat_add(trs.r, sum.r),
                              vec3_add(trs.s, sum.s) };
        trs = additive ? added : add_layer(trs, sum, 1.0f);
        earlier = start;
    }
    *mean = trs;
}
