/* inertialize.cl - what clips that were left leave behind for a while: the difference from what took their place, in pose and in
 * speed (Bollo, "Inertialization", GDC 2018). Twin of populace-native inertialize.rs. */

/* How a clip stood; see SampledState in populace-device playback/inertialize.rs. */
typedef struct { uint bound_clip; float row, pace; } SampledState;

INLINE SampledState stand_of(uint bound_clip, ulong pair)
{
    const SampledState stand = { bound_clip, as_float((uint)pair), as_float((uint)(pair >> 32)) };
    return stand;
}

INLINE uint row_before(float at, uint last) { return min((uint)at, last); }

/* The end of the gap between rows that is not the nearer one. */
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

/* The rows around a place in a clip's rows. */
INLINE SlotSample place_of(ClipRows clip, float at)
{
    const uint last = clip.row_count - 1, row = row_before(at, last);
    SlotSample place = row_of(clip, row);
    place.row1 = row_of(clip, min(row + 1, last)).row0;
    place.between = at - (float)row;
    return place;
}

/* A clip where it stood, at its far row, and what differences are measured from: where it stood, in additive layers its
 * first row. */
typedef struct { Trs at, far, reference; } Stands;

INLINE Stands stands_of(const Clips *of, SampledState stand, bool additive, Body body, uint joint, Trs rest)
{
    const BoundClip bound = of->bound_clips[stand.bound_clip];
    const ClipRows clip = of->clips[bound.clip];
    const SlotSample places[3] = { place_of(clip, stand.row), row_of(clip, far_row(stand.row, clip.row_count - 1)),
                                   row_of(clip, 0) };
    Trs found[3];
    for (uint i = 0; i < (additive ? 3 : 2); i++) found[i] = normalized(sample_joint(of, bound, body, joint, places[i], rest));
    const Stands stands = { found[0], found[1], found[additive ? 2 : 0] };
    return stands;
}

/* One change after another. */
INLINE Trs after(Trs first, Trs then)
{
    const Trs both = { vec3_add(first.t, then.t), quat_mul(first.r, then.r),
                       { first.s.x * then.s.x, first.s.y * then.s.y, first.s.z * then.s.z } };
    return both;
}

/* By what each way that a clip stood is multiplied. */
typedef struct { float left, left_way, taking, taking_way; } InertializationWeights;

INLINE Real inertialization_part(Real sum, Real at, Real far, Real taking_at, Real taking_far, InertializationWeights by)
{
    const Real left = at * by.left + (far - at) * by.left_way;
    return sum + (left - (taking_at * by.taking + (taking_far - taking_at) * by.taking_way));
}

/* The weights are quintics whose value, slope and curvature are 0 at the end, and whose curvature is 0 at the start. */
INLINE InertializationWeights inertialization_weights(Slot slot, ulong tick, bool additive)
{
    const float inertialized = slot_inertialized(slot, tick), to_go = 1.0f - inertialized, cube = to_go * to_go * to_go;
    const float still = cube * (1.0f + 3.0f * inertialized + 6.0f * inertialized * inertialized);
    const float moving = inertialized * cube * (1.0f + 3.0f * inertialized), share = slot.start_weight;
    const InertializationWeights by = { still * share + moving * slot.weight_rate,
                                 moving * share * stand_of(0, slot.phase_rate).pace, additive ? still * share : 0.0f,
                                 moving * share * stand_of(0, slot.weight_tick).pace };
    return by;
}

INLINE Trs add_inertialization(const Clips *of, Slot slot, ulong tick, bool additive, Body body, uint joint, Trs rest, Trs sum)
{
    const InertializationWeights by = inertialization_weights(slot, tick, additive);
    const Stands left = stands_of(of, stand_of(slot.bound_clip, slot.phase_rate), additive, body, joint, rest);
    const Stands taking = stands_of(of, stand_of(slot.start_phase, slot.weight_tick), additive, body, joint, rest);
    const Trs reference = additive ? left.reference : taking.reference;
    Trs a = quotient(left.at, reference, quat_identity(), 0), f = quotient(left.far, reference, a.r, 0);
    Trs n = quotient(taking.at, taking.reference, quat_identity(), 0), b = quotient(taking.far, taking.reference, n.r, 0);
    if (!additive) {
        /* The difference lies over what took the place, and is carried along as that moves. */
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

INLINE bool inertializes_in(Slot slot, uint layer, ulong tick) { return slot_layer(slot) == layer && slot_inertializes(slot, tick); }

/* A layer's mean, or its sum of differences where it is additive, with all that inertializes in it. Over a mean the newest start
 * comes first: those before it lie over what was then left. */
SELDOM void inertialize(const Clips *of, Inertialization inertialization, uint layer, bool additive, Body body, uint joint, const Trs *at_rest,
                   Trs *mean)
{
    const Trs rest = *at_rest;
    Trs trs = *mean;
    ulong earlier = ULONG_MAX;
    for (;;) {
        ulong start = 0;
        bool any = false;
        for (uint s = 0; s < inertialization.count; s++) {
            const Slot slot = inertialization.slots[s];
            if (!inertializes_in(slot, layer, inertialization.tick) || slot.start_tick >= earlier) continue;
            start = any ? max(start, slot.start_tick) : slot.start_tick;
            any = true;
        }
        if (!any) break;
        Trs sum = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
        for (uint s = 0; s < inertialization.count; s++) {
            const Slot slot = inertialization.slots[s];
            if (inertializes_in(slot, layer, inertialization.tick) && slot.start_tick == start)
                sum = add_inertialization(of, slot, inertialization.tick, additive, body, joint, rest, sum);
        }
        const Trs added = { vec3_add(trs.t, sum.t), quat_add(trs.r, sum.r), vec3_add(trs.s, sum.s) };
        trs = additive ? added : add_layer(trs, sum, 1.0f);
        earlier = start;
    }
    *mean = trs;
}
