// joint.cl - Pose stage of one joint, or of neighbouring ones in lanes (Lister & Day 2012, section
// 3, fig. 1): mixes a member's slots layer by layer, then applies proportions, overrides in local
// space and users' stages.
//
// Twin of populace-native/src/joint.rs: same arithmetic, same order of operations.

// Adds the inertializations of a layer; see inertialize.cl.
SELDOM void inertialize(const ClipTables *tables, Inertialization inertialization, uint layer,
                        bool additive, uint joint, const Local *at_rest, Local *pose);

// How a layer is laid over the pose beneath. `laid` tells in which lanes it has weight.
typedef struct {
    Real weight;
    Choice laid;
    bool additive;
} Laying;

INLINE Laying laying_of(const ClipTables *tables, Layer layer, uint joint)
{
    const uint mask = layer.mask_and_mode & LAYER_MASK;
    Laying how;
    how.weight = mask == LAYER_MASK ? (Real)(layer.weight)
                                    : layer.weight * LOAD(tables->masks + mask + joint);
    how.laid = how.weight > (Real)(0.0f);
    how.additive = (layer.mask_and_mode & LAYER_ADDITIVE) != 0;
    return how;
}

// Returns whether a layer shows nothing. `total` is the weight of its slots.
INLINE bool is_silent(Laying how, float total) { return !how.additive && total <= LEAST_WEIGHT; }

// The own pose of a layer above 0, and how it is laid over the pose beneath.
typedef struct {
    Laying how;
    Terms terms;
    Local own;
} Shown;

// Returns the part of a layer in the mix. A layer with a total weight below 1 leaves the remainder to
// the pose beneath.
INLINE Real share_of(Real layer_weight, float total)
{
    return layer_weight * (total < 1.0f ? total : 1.0f);
}

// Mixes rotations. `near_beneath` and `near` tell that the rotation beneath, or the layer's, is known
// to be in the hemisphere of the rest rotation.
INLINE Quat mix_rotations(Quat beneath, bool near_beneath, Quat own, bool near, Real share,
                          Quat rest)
{
    const Quat from = near_beneath ? beneath : quat_hemisphere(beneath, rest);
    const Quat to = near ? own : quat_hemisphere(own, rest);
    return quat_normalize_or(quat_mix(from, to, share), rest);
}

#if LANES == 1

// Returns the pose that the slots of a layer show: a mean, or a sum of differences if the layer is
// additive.
INLINE Local layer_pose(const ClipTables *tables, Playback playback, uint l, bool additive,
                        uint joint, Local rest, Terms *terms)
{
    const Sum sum = sum_layer(tables, playback, l, additive, joint, rest);
    *terms = sum.terms;
    if (additive) return sum.trs;
    return mean_or_rest(sum, l == 0 ? LEAST_TOTAL : LEAST_WEIGHT, rest);
}

// Mixes a layer above 0 over the pose beneath.
INLINE Local mix_layer(Local beneath, Local own, Real share, Local rest)
{
    const Local mixed = { vec3_mix(beneath.t, own.t, share),
                          mix_rotations(beneath.r, false, own.r, false, share, rest.r),
                          vec3_mix(beneath.s, own.s, share) };
    return mixed;
}

// Lays the pose of a layer over the pose beneath.
INLINE Local laid_over(Local beneath, Shown shown, Local rest)
{
    const Laying how = shown.how;
    const Local laid =
        how.additive ? add_layer(beneath, shown.own, how.weight)
                     : mix_layer(beneath, shown.own, share_of(how.weight, shown.terms.total), rest);
    const Local trs = { vec3_choose(how.laid, laid.t, beneath.t),
                        quat_choose(how.laid, laid.r, beneath.r),
                        vec3_choose(how.laid, laid.s, beneath.s) };
    return trs;
}

// Computes a layer's own pose. Returns false if the layer shows nothing.
INLINE bool show_layer(const ClipTables *tables, Playback playback, Layer layer, uint l, uint joint,
                       Local rest, Shown *shown)
{
    shown->how = laying_of(tables, layer, joint);
    const bool additive = shown->how.additive;
    if (!shown->how.laid) return false;
    Local own = layer_pose(tables, playback, l, additive, joint, rest, &shown->terms);
    if (is_silent(shown->how, shown->terms.total)) return false;
    if (playback.inertialization.count > 0) {
        Local posed = own, at_rest = rest;
        inertialize(tables, playback.inertialization, l, additive, joint, &at_rest, &posed);
        own = posed;
    }
    shown->own = own;
    return true;
}

// Applies the layers above 0 to the pose beneath.
INLINE Local lay_over(const ClipTables *tables, Playback playback, __global const Layer *layers,
                      uint layer_count, uint joint, Local rest, Local beneath)
{
    for (uint l = 1; l < layer_count; l++) {
        Shown shown;
        if (show_layer(tables, playback, layers[l], l, joint, rest, &shown))
            beneath = laid_over(beneath, shown, rest);
    }
    return beneath;
}

#endif

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
    trs = stage_locals(adjustments.stages, control, joint, trs);
#endif
    *pose = trs;
}

INLINE Local rest_of(const ClipTables *tables, Body body, uint joint)
{
    return stored_pose(stored_at(tables, body.rest_first, POSE_PLANES, joint), 0);
}

// A member's adjustments of the pose that layer 0 shows, none in most members.
typedef struct {
    bool inertializes, has_layers, adjusts;
} PoseChanges;

INLINE PoseChanges changes_of(Adjustments adjustments, uint control, Playback playback,
                              uint layer_count)
{
    const PoseChanges changes = { playback.inertialization.count > 0, layer_count > 1,
                                  control != NONE && is_adjusted(adjustments.controls + control) };
    return changes;
}

INLINE bool are_changes(PoseChanges changes)
{
    return changes.inertializes || changes.has_layers || changes.adjusts;
}

#if LANES == 1

// Applies what comes after the slots of layer 0.
INLINE Local change_pose(Local posed, PoseChanges changes, const ClipTables *tables,
                         Adjustments adjustments, uint control, Playback playback,
                         __global const Layer *layers, uint layer_count, uint joint, Local rest)
{
    if (changes.inertializes)
        inertialize(tables, playback.inertialization, 0, false, joint, &rest, &posed);
    if (changes.has_layers)
        posed = lay_over(tables, playback, layers, layer_count, joint, rest, posed);
    if (changes.adjusts) adjust(adjustments, adjustments.controls + control, joint, &posed);
    return posed;
}

// Returns the local transforms of a joint. `layers` are the member's own.
INLINE Local pose_joint(const ClipTables *tables, Adjustments adjustments, uint control,
                        Playback playback, __global const Layer *layers, uint layer_count,
                        Body body, uint joint)
{
    const Local rest = rest_of(tables, body, joint);
    Terms terms;
    const Local trs = layer_pose(tables, playback, 0, false, joint, rest, &terms);
    const PoseChanges changes = changes_of(adjustments, control, playback, layer_count);
    if (!are_changes(changes)) return trs;
    return change_pose(trs, changes, tables, adjustments, control, playback, layers, layer_count,
                       joint, rest);
}

#endif
