/* joint.cl - what Pose (Lister & Day 2012, section 3, fig. 1) computes for a joint: a member's
 * slots mixed layer by layer, and the matrix that comes of it. Twin of populace-native joint.rs. */

/* What takes `reference` to `value`, its rotation on the side of another one; scales that stand at rest in both are not
 * divided. */
INLINE Trs quotient(Trs value, Trs reference, Quat side, uint at_rest)
{
    Trs trs = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 1.0f, 1.0f, 1.0f } };
    trs.r = quat_hemisphere(quat_mul(quat_conjugate(reference.r), value.r), side);
    trs.t = vec3_add(value.t, vec3_scale(reference.t, -1.0f));
    if (at_rest & REST_SCALE) return trs;
    trs.s.x = reference.s.x == (Real)(0.0f) ? (Real)(1.0f) : value.s.x / reference.s.x;
    trs.s.y = reference.s.y == (Real)(0.0f) ? (Real)(1.0f) : value.s.y / reference.s.y;
    trs.s.z = reference.s.z == (Real)(0.0f) ? (Real)(1.0f) : value.s.z / reference.s.z;
    return trs;
}

/* A change, less what changes nothing: sums of it do not depend on their order. */
INLINE Trs change(Trs trs)
{
    trs.r.w -= 1.0f;
    trs.s.x -= 1.0f;
    trs.s.y -= 1.0f;
    trs.s.z -= 1.0f;
    return trs;
}

INLINE Trs add_layer(Trs beneath, Trs sum, Real layer_weight)
{
    Trs trs;
    const Quat delta = quat_normalize_or(quat_add(quat_identity(), quat_scale(sum.r, layer_weight)), quat_identity());
    trs.t = vec3_add(beneath.t, vec3_scale(sum.t, layer_weight));
    trs.r = quat_mul(beneath.r, delta);
    trs.s.x = beneath.s.x * (1.0f + sum.s.x * layer_weight);
    trs.s.y = beneath.s.y * (1.0f + sum.s.y * layer_weight);
    trs.s.z = beneath.s.z * (1.0f + sum.s.z * layer_weight);
    return trs;
}

/* The weighted sum over a layer's slots; `at_rest` holds REST_TRANSLATION and REST_SCALE where no slot leaves the rest. */
typedef struct { Trs trs; float total; uint at_rest; } Sum;

/* What no slot moves is at rest, to the bit. */
INLINE Trs mean_of(Sum sum, Trs rest)
{
    const float k = 1.0f / sum.total;
    Trs mean;
    mean.t = sum.at_rest & REST_TRANSLATION ? rest.t : vec3_scale(sum.trs.t, k);
    mean.r = quat_normalize_or(sum.trs.r, rest.r);
    mean.s = sum.at_rest & REST_SCALE ? rest.s : vec3_scale(sum.trs.s, k);
    return mean;
}

/* A layer above 0 whose slots weigh less than 1 in all leaves the remainder to what lies beneath. */
INLINE Trs mix_layer(Trs beneath, Trs above, float total, Real layer_weight, Trs rest)
{
    const Real f = layer_weight * (total < 1.0f ? total : 1.0f);
    const Quat from = quat_hemisphere(beneath.r, rest.r), to = quat_hemisphere(above.r, rest.r);
    Trs trs;
    trs.t = vec3_mix(beneath.t, above.t, f);
    trs.r = quat_normalize_or(quat_mix(from, to, f), rest.r);
    trs.s = vec3_mix(beneath.s, above.s, f);
    return trs;
}

/* The sum over a layer's slots of weight times value, or times difference from the first row. */
INLINE Sum sum_layer(const Clips *of, Playback playback, uint layer_index, bool additive, Body body, uint joint, Trs rest)
{
    Sum sum = { { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } }, 0.0f,
                REST_TRANSLATION | REST_SCALE };
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.at.weight <= 0.0f || playing.layer != layer_index) continue;
        const BoundClip bound = of->bound_clips[playing.bound_clip];
        const float weight = playing.at.weight;
        Sample sample = sample_joint(of, bound, body, joint, playing.at, rest);
        if (additive) {
            const uint first = of->clips[bound.clip].row_first;
            const SlotSample start = { first, first, 0.0f, 0.0f };
            const Trs reference = normalized(sample_joint(of, bound, body, joint, start, rest));
            sample.trs = change(quotient(normalized(sample), reference, quat_identity(), sample.at_rest));
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

/* What inertializes in a layer; see inertialize.cl. */
SELDOM void inertialize(const Clips *of, Inertialization inertialization, uint layer, bool additive, Body body, uint joint, const Trs *at_rest,
                   Trs *mean);

/* What the layers above 0 make of what lies beneath. Called with pointers: a call by value copies more than it computes. */
APART void lay_over(const Clips *of, Playback playback, __global const Layer *layers, uint layer_count, Body body, uint joint,
                    const Trs *at_rest, Trs *beneath)
{
    const Trs rest = *at_rest;
    Trs trs = *beneath;
    for (uint l = 1; l < layer_count; l++) {
        const Layer layer = layers[l];
        const uint mask = layer.mask_and_mode & LAYER_MASK;
        const Real weight = mask == LAYER_MASK ? (Real)(layer.weight) : layer.weight * LOAD(of->masks + mask + joint);
        const Choice laid = weight > (Real)(0.0f);
        if (!ANY(laid)) continue;
        const bool additive = (layer.mask_and_mode & LAYER_ADDITIVE) != 0;
        const Sum sum = sum_layer(of, playback, l, additive, body, joint, rest);
        if (!additive && sum.total <= LEAST_WEIGHT) continue;
        Trs own = additive ? sum.trs : mean_of(sum, rest);
        if (playback.inertialization.count > 0) {
            Trs inertialized = own;
            inertialize(of, playback.inertialization, l, additive, body, joint, at_rest, &inertialized);
            own = inertialized;
        }
        const Trs above = additive ? add_layer(trs, own, weight) : mix_layer(trs, own, sum.total, weight, rest);
        trs.t = vec3_choose(laid, above.t, trs.t);
        trs.r = quat_choose(laid, above.r, trs.r);
        trs.s = vec3_choose(laid, above.s, trs.s);
    }
    *beneath = trs;
}

/* What beside clips a member's local transforms come from. */
typedef struct {
    __global const Control *controls;
    __global const Override *overrides;
    __global const float *joint_scales;
#ifdef USER_STAGES
    StageTables stages;
#endif
} Locals;

/* Whether anything but clips is to change a pose. */
INLINE bool is_adjusted(__global const Control *control)
{
#ifdef USER_STAGES
    return true;
#else
    return control->scale_first != NONE || control->local_count > 0;
#endif
}

/* What a member's proportions, its overrides in local space and users' stages make of a pose. */
APART void adjust(Locals of, __global const Control *control, uint joint, Trs *pose)
{
    Trs trs = *pose;
    if (control->scale_first != NONE) trs.t = vec3_scale(trs.t, LOAD(of.joint_scales + control->scale_first + joint));
    for (uint i = 0; i < control->local_count; i++) {
        const Override given = of.overrides[control->local_first + i];
        const uint lane = given.joint - joint;
        if (lane >= LANES) continue;
        const float4 t4 = given.translation_and_weight, r4 = given.rotation, s4 = given.scale;
        const Trs there = { { t4.x, t4.y, t4.z }, { r4.x, r4.y, r4.z, r4.w }, { s4.x, s4.y, s4.z } };
        const Choice only = ONLY(lane);
        const bool whole = t4.w >= 1.0f;
        const Quat mixed = quat_mix(trs.r, quat_hemisphere(there.r, trs.r), t4.w);
        trs.r = quat_choose(only, whole ? there.r : quat_normalize_or(mixed, there.r), trs.r);
        trs.t = vec3_choose(only, whole ? there.t : vec3_mix(trs.t, there.t, t4.w), trs.t);
        trs.s = vec3_choose(only, whole ? there.s : vec3_mix(trs.s, there.s, t4.w), trs.s);
    }
#ifdef USER_STAGES
    trs = stage_locals(of.stages, *control, joint, trs);
#endif
    *pose = trs;
}

/* The local transforms of one joint, or of sixteen from `joint` on. `layers` are the member's. */
INLINE Trs pose_joint(const Clips *of, Locals locals, uint control, Playback playback, __global const Layer *layers,
                      uint layer_count, Body body, uint joint)
{
    const uint padded = body.padded_count;
    __global const float *planes = of->poses + body.rest_first + joint;
    const Trs rest = { load_vec3(planes + 4 * padded, padded), load_quat(planes, padded), load_vec3(planes + 7 * padded, padded) };
    const Sum sum = sum_layer(of, playback, 0, false, body, joint, rest);
    /* Layer 0 is always divided by its total, so that nobody sees the rest pose by accident. */
    Trs trs = sum.total > 1e-3f ? mean_of(sum, rest) : rest;
    const bool inertializes = playback.inertialization.count > 0, adjusts = control != NONE && is_adjusted(locals.controls + control);
    if (!inertializes && layer_count == 1 && !adjusts) return trs;
    /* Copies, so that what is seldom called does not keep what all compute in memory. */
    const Trs at_rest = rest;
    Trs posed = trs;
    if (inertializes) inertialize(of, playback.inertialization, 0, false, body, joint, &at_rest, &posed);
    if (layer_count > 1) lay_over(of, playback, layers, layer_count, body, joint, &at_rest, &posed);
    if (adjusts) adjust(locals, locals.controls + control, joint, &posed);
    return posed;
}

/* The matrix of translation times rotation times scale, row by row (glTF 2.0, section 3.5.3). */
INLINE void components_of(Trs trs, Real m[12])
{
    const Real x = trs.r.x, y = trs.r.y, z = trs.r.z, w = trs.r.w;
    m[0] = (1.0f - 2.0f * (y * y + z * z)) * trs.s.x;
    m[1] = (2.0f * (x * y - w * z)) * trs.s.y;
    m[2] = (2.0f * (x * z + w * y)) * trs.s.z;
    m[3] = trs.t.x;
    m[4] = (2.0f * (x * y + w * z)) * trs.s.x;
    m[5] = (1.0f - 2.0f * (x * x + z * z)) * trs.s.y;
    m[6] = (2.0f * (y * z - w * x)) * trs.s.z;
    m[7] = trs.t.y;
    m[8] = (2.0f * (x * z - w * y)) * trs.s.x;
    m[9] = (2.0f * (y * z + w * x)) * trs.s.y;
    m[10] = (1.0f - 2.0f * (x * x + y * y)) * trs.s.z;
    m[11] = trs.t.z;
}
