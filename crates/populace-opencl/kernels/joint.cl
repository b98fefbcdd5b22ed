// joint.cl - Pose stage of one joint, or of sixteen neighbouring ones (Lister & Day 2012, section
// 3, fig. 1): mixes a member's slots layer by layer, then applies proportions, overrides in local
// space and users' stages.
//
// Twin of populace-native/src/joint.rs: same arithmetic, same order of operations.

// Weighted sum over a layer's slots. `at_rest` has REST_TRANSLATION or REST_SCALE set if all slots
// are at rest.
typedef struct {
    Local trs;
    float total;
    uint at_rest;
} Sum;

// Returns the mean. Properties that no slot moves are at rest to the bit.
INLINE Local mean_of(Sum sum, Local rest)
{
    const float k = 1.0f / sum.total;
    Local mean;
    mean.t = sum.at_rest & REST_TRANSLATION ? rest.t : vec3_scale(sum.trs.t, k);
    mean.r = quat_normalize_or(sum.trs.r, rest.r);
    mean.s = sum.at_rest & REST_SCALE ? rest.s : vec3_scale(sum.trs.s, k);
    return mean;
}

// Mixes a layer above 0 over the pose beneath. A layer with a total weight below 1 leaves the
// remainder to the pose beneath.
INLINE Local mix_layer(Local beneath, Local above, float total, Real layer_weight, Local rest)
{
    const Real f = layer_weight * (total < 1.0f ? total : 1.0f);
    const Quat from = quat_hemisphere(beneath.r, rest.r), to = quat_hemisphere(above.r, rest.r);
    Local trs;
    trs.t = vec3_mix(beneath.t, above.t, f);
    trs.r = quat_normalize_or(quat_mix(from, to, f), rest.r);
    trs.s = vec3_mix(beneath.s, above.s, f);
    return trs;
}

// Returns the sum of weight times value over a layer's slots, or of weight times difference from
// the first row if the layer is additive.
INLINE Sum sum_layer(const ClipTables *tables, Playback playback, uint layer_index, bool additive,
                     Body body, uint joint, Local rest)
{
    Sum sum = { { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } },
                0.0f,
                REST_TRANSLATION | REST_SCALE };
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.at.weight <= 0.0f || playing.layer != layer_index) continue;
        const BoundClip bound = tables->bound_clips[playing.bound_clip];
        const float weight = playing.at.weight;
        Sample sample = sample_joint(tables, bound, body, joint, playing.at, rest);
        if (additive) {
            const uint first = tables->clips[bound.clip].row_first;
            const SlotSample start = { first, first, 0.0f, 0.0f };
            const Local reference =
                normalized(sample_joint(tables, bound, body, joint, start, rest));
            sample.trs =
                change(quotient(normalized(sample), reference, quat_identity(), sample.at_rest));
            sample.unit = 1.0f;
        }
        sum.trs.t = vec3_add(sum.trs.t, vec3_scale(sample.trs.t, weight));
        sum.trs.r = quat_add(sum.trs.r, quat_scale(sample.trs.r, sample.unit * weight));
        sum.trs.s = vec3_add(sum.trs.s, vec3_scale(sample.trs.s, weight));
        sum.total += weight;
        sum.at_rest &= sample.at_rest;
    }
    return sum;
}

// Adds the inertializations of a layer; see inertialize.cl.
SELDOM void inertialize(const ClipTables *tables, Inertialization inertialization, uint layer,
                        bool additive, Body body, uint joint, const Local *at_rest, Local *mean);

// Applies the layers above 0 to the pose beneath. Takes pointers, since passing by value copies
// more than it computes.
APART void lay_over(const ClipTables *tables, Playback playback, __global const Layer *layers,
                    uint layer_count, Body body, uint joint, const Local *at_rest, Local *beneath)
{
    const Local rest = *at_rest;
    Local trs = *beneath;
    for (uint l = 1; l < layer_count; l++) {
        const Layer layer = layers[l];
        const uint mask = layer.mask_and_mode & LAYER_MASK;
        const Real weight = mask == LAYER_MASK ? (Real)(layer.weight)
                                               : layer.weight * LOAD(tables->masks + mask + joint);
        const Choice laid = weight > (Real)(0.0f);
        if (!ANY(laid)) continue;
        const bool additive = (layer.mask_and_mode & LAYER_ADDITIVE) != 0;
        const Sum sum = sum_layer(tables, playback, l, additive, body, joint, rest);
        if (!additive && sum.total <= LEAST_WEIGHT) continue;
        Local own = additive ? sum.trs : mean_of(sum, rest);
        if (playback.inertialization.count > 0) {
            Local inertialized = own;
            inertialize(tables, playback.inertialization, l, additive, body, joint, at_rest,
                        &inertialized);
            own = inertialized;
        }
        const Local above =
            additive ? add_layer(trs, own, weight) : mix_layer(trs, own, sum.total, weight, rest);
        trs.t = vec3_choose(laid, above.t, trs.t);
        trs.r = quat_choose(laid, above.r, trs.r);
        trs.s = vec3_choose(laid, above.s, trs.s);
    }
    *beneath = trs;
}

// Inputs of a member's local transforms other than clips.
typedef struct {
    __global const Control *controls;
    __global const Override *overrides;
    __global const float *joint_scales;
#ifdef USER_STAGES
    StageTables stages;
#endif
} Adjustments;

// Returns whether anything other than clips changes the pose.
INLINE bool is_adjusted(__global const Control *control)
{
#ifdef USER_STAGES
    return true;
#else
    return control->scale_first != NONE || control->local_count > 0;
#endif
}

// Applies a member's proportions, overrides in local space and users' stages.
APART void adjust(Adjustments adjustments, __global const Control *control, uint joint, Local *pose)
{
    Local trs = *pose;
    if (control->scale_first != NONE)
        trs.t = vec3_scale(trs.t, LOAD(adjustments.joint_scales + control->scale_first + joint));
    for (uint i = 0; i < control->local_count; i++) {
        const Override given = adjustments.overrides[control->local_first + i];
        const uint lane = given.joint - joint;
        if (lane >= LANES) continue;
        const float4 t4 = given.translation_and_weight, r4 = given.rotation, s4 = given.scale;
        const Local there = { { t4.x, t4.y, t4.z },
                              { r4.x, r4.y, r4.z, r4.w },
                              { s4.x, s4.y, s4.z } };
        const Choice only = ONLY(lane);
        const bool whole = t4.w >= 1.0f;
        const Quat mixed = quat_mix(trs.r, quat_hemisphere(there.r, trs.r), t4.w);
        trs.r = quat_choose(only, whole ? there.r : quat_normalize_or(mixed, there.r), trs.r);
        trs.t = vec3_choose(only, whole ? there.t : vec3_mix(trs.t, there.t, t4.w), trs.t);
        trs.s = vec3_choose(only, whole ? there.s : vec3_mix(trs.s, there.s, t4.w), trs.s);
    }
#ifdef USER_STAGES
    trs = stage_locals(adjustments.stages, *control, joint, trs);
#endif
    *pose = trs;
}

// Returns the local transforms of one joint, or of sixteen from `joint` on. `layers` are the
// member's own.
INLINE Local pose_joint(const ClipTables *tables, Adjustments adjustments, uint control,
                        Playback playback, __global const Layer *layers, uint layer_count,
                        Body body, uint joint)
{
    const uint padded = body.padded_count;
    __global const float *planes = tables->poses + body.rest_first + joint;
    const Local rest = { load_vec3(planes + 4 * padded, padded), load_quat(planes, padded),
                         load_vec3(planes + 7 * padded, padded) };
    const Sum sum = sum_layer(tables, playback, 0, false, body, joint, rest);
    // Layer 0 is always divided by its total weight, so that the rest pose never shines through.
    Local trs = sum.total > 1e-3f ? mean_of(sum, rest) : rest;
    const bool inertializes = playback.inertialization.count > 0,
               adjusts = control != NONE && is_adjusted(adjustments.controls + control);
    if (!inertializes && layer_count == 1 && !adjusts) return trs;
    // Copies, so that passing pointers to rarely called functions does not keep values in memory
    // that every joint computes.
    const Local at_rest = rest;
    Local posed = trs;
    if (inertializes)
        inertialize(tables, playback.inertialization, 0, false, body, joint, &at_rest, &posed);
    if (layer_count > 1)
        lay_over(tables, playback, layers, layer_count, body, joint, &at_rest, &posed);
    if (adjusts) adjust(adjustments, adjustments.controls + control, joint, &posed);
    return posed;
}
