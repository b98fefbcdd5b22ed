// layers.cl - Layers above 0, inertialization and adjustments of members side by side, for LANES
// joints at a time: passes over all members that have them.
//
// Twin of populace-native/src/poses.rs and populace-native/src/joint.rs: same arithmetic, same order
// of operations.

// Sums over the slots of layer 0, and then poses: LANES joints of each member, after transposition
// all members of each joint.
typedef Local Posed[LANES];

// Stores local transforms, except properties that are left out.
INLINE void put_local(Local *to, Local trs, uint still)
{
    if (!(still & REST_TRANSLATION)) to->t = trs.t;
    to->r = trs.r;
    if (!(still & REST_SCALE)) to->s = trs.s;
}

// Inputs of the members' poses.
typedef struct {
    const ClipTables *clips;
    Adjustments adjustments;
    __global const Layer *layers;
    PoseChanges changes[LANES];
    bool any_changes;
} Posing;

// Computes the own pose of a layer that plays one slot, or of an additive layer the change, except
// properties at rest.
INLINE void show_alone(const ClipTables *tables, Playing playing, uint first, bool no_floats,
                       Stored rest, Shown *shown)
{
    const BlockSlot slot = block_slot(playing, first, no_floats);
    const uint flags = slot.columns.flags;
    shown->terms.at_rest = flags;
    if (shown->how.additive) {
        shown->own = weighted_change(tables, slot, rest);
        return;
    }
    shown->own.r = rotation_alone(tables, slot, rest);
    if (!(flags & REST_TRANSLATION)) shown->own.t = vector_alone(tables, slot, TRANSLATION);
    if (!(flags & REST_SCALE)) shown->own.s = vector_alone(tables, slot, SCALE);
}

// Computes the own pose of a member's layer, or of an additive layer the sum of changes. Leaves out
// properties at rest. Returns false if the layer shows nothing.
INLINE bool show_own(const Company *all, const Posing *posing, uint lane, uint l, uint first,
                     bool no_floats, Local rest, Shown *shown)
{
    const ClipTables *tables = posing->clips;
    const Playback playback = all->plays[lane];
    const LayerSlots slots = all->layers[lane][l];
    shown->terms.total = slots.total;
    shown->terms.unweighted = false;
    if (is_silent(shown->how, slots.total)) return false;
    const Stored stored = stored_at(tables, all->body.rest_first, POSE_PLANES, first);
    if (slots.alone != NONE) {
        show_alone(tables, playing_at(playback, slots.alone), first, no_floats, stored, shown);
        return true;
    }
    if (shown->how.additive) {
        shown->own =
            sum_changes(tables, playback, l, stored, first, no_floats, &shown->terms.at_rest);
        return true;
    }
    shown->terms.at_rest =
        sum_spans(tables, playback, l, all->body, first, no_floats, false, &shown->own, 0);
    const Sum sum = { shown->own, shown->terms };
    shown->own = mean_of(sum, rest);
    return true;
}

// Completes a layer's own pose with properties at rest, except those that are left out.
INLINE void complete(Shown *shown, uint left_out, Local rest)
{
    const uint missing = shown->how.additive ? 0 : shown->terms.at_rest & ~left_out;
    if (missing & REST_TRANSLATION) shown->own.t = rest.t;
    if (missing & REST_SCALE) shown->own.s = rest.s;
}

// Computes the pose of a member's layer before it is laid over the pose beneath. Returns false if
// the layer shows nothing.
INLINE bool show_layer(const Company *all, const Posing *posing, uint lane, uint l, uint first,
                       bool no_floats, Local rest, Shown *shown)
{
    __global const Layer *layers = posing->layers + all->owners[lane] * LAYERS_PER_MEMBER;
    shown->how = laying_of(posing->clips, layers[l], first);
    if (!ANY(shown->how.laid)) return false;
    if (!show_own(all, posing, lane, l, first, no_floats, rest, shown)) return false;
    const Inertialization inertialization = all->plays[lane].inertialization;
    if (inertialization.count > 0) {
        complete(shown, 0, rest);
        Local posed = shown->own, at_rest = rest;
        inertialize(posing->clips, inertialization, l, shown->how.additive, first, &at_rest,
                    &posed);
        shown->own = posed;
        shown->terms.at_rest = 0;
    }
    return true;
}

// Does the same for a member with a clip that stores floats, which few members play. Its other clips
// go this way too. The common path must not pay for the registers of this one.
APART bool show_any_layer(const Company *all, const Posing *posing, uint lane, uint l, uint first,
                          Shown *shown)
{
    const Local rest = rest_of(posing->clips, all->body, first);
    return show_layer(all, posing, lane, l, first, false, rest, shown);
}

// Functions that lay a layer over the pose beneath, each one property.

INLINE Quat laid_rotation(Quat beneath, bool near_beneath, const Shown *shown, Quat rest)
{
    const Quat own = shown->own.r;
    const Quat laid =
        shown->how.additive
            ? add_layer_rotation(beneath, own, shown->how.weight)
            : mix_rotations(beneath, near_beneath, own, shown->terms.at_rest & NEAR_REST,
                            share_of(shown->how.weight, shown->terms.total), rest);
    return quat_choose(shown->how.laid, laid, beneath);
}

INLINE Vec3 laid_translation(Vec3 beneath, const Shown *shown)
{
    const Vec3 own = shown->own.t;
    const Vec3 laid = shown->how.additive
                          ? vec3_add(beneath, vec3_scale(own, shown->how.weight))
                          : vec3_mix(beneath, own, share_of(shown->how.weight, shown->terms.total));
    return vec3_choose(shown->how.laid, laid, beneath);
}

INLINE Vec3 laid_scale(Vec3 beneath, const Shown *shown)
{
    const Vec3 own = shown->own.s;
    const Vec3 laid = shown->how.additive
                          ? add_layer_scale(beneath, own, shown->how.weight)
                          : vec3_mix(beneath, own, share_of(shown->how.weight, shown->terms.total));
    return vec3_choose(shown->how.laid, laid, beneath);
}

// Lays a member's layer over the pose beneath. `at_rest` tells what is at rest beneath, and then in
// the pose. Properties stay as they are that are at rest in both poses, or that an additive layer
// does not change. Each is stored on its own, so that registers hold one.
INLINE void lay_in_lane(Shown *shown, Local rest, uint lane, uint *at_rest, Posed posed)
{
    const uint own = shown->terms.at_rest;
    const uint kept =
        (shown->how.additive ? own : own & *at_rest) & (REST_TRANSLATION | REST_SCALE);
    const Local beneath = posed[lane];
    complete(shown, kept, rest);
    posed[lane].r = laid_rotation(beneath.r, *at_rest & NEAR_REST, shown, rest.r);
    if (!(kept & REST_TRANSLATION)) posed[lane].t = laid_translation(beneath.t, shown);
    if (!(kept & REST_SCALE)) posed[lane].s = laid_scale(beneath.s, shown);
    *at_rest &= kept;
}

// Lays a layer over the poses of members that have it, in two passes. `at_rest` tells what is at
// rest in each pose, before and after.
INLINE void lay_over_all(const Company *all, const Posing *posing, uint l, uint first, Local rest,
                         uint *at_rest, Posed posed)
{
    Shown shown[LANES];
    bool shows[LANES];
    for (uint lane = 0; lane < all->count; lane++) {
        if (l >= all->layer_counts[lane]) shows[lane] = false;
        else if (all->plays[lane].has_floats)
            shows[lane] = show_any_layer(all, posing, lane, l, first, &shown[lane]);
        else shows[lane] = show_layer(all, posing, lane, l, first, true, rest, &shown[lane]);
    }
    for (uint lane = 0; lane < all->count; lane++)
        if (shows[lane]) lay_in_lane(&shown[lane], rest, lane, &at_rest[lane], posed);
}

// Applies what comes after the slots of layer 0, step by step to all members. `at_rest` tells what
// is at rest in each pose, before and after.
APART void change_poses(const Company *all, const Posing *posing, uint first, uint *at_rest,
                        Posed posed)
{
    const Local rest = rest_of(posing->clips, all->body, first), stored = rest;
    uint layer_count = 1;
    for (uint lane = 0; lane < all->count; lane++) {
        layer_count = max(layer_count, all->layer_counts[lane]);
        if (!posing->changes[lane].inertializes) continue;
        Local pose = posed[lane];
        inertialize(posing->clips, all->plays[lane].inertialization, 0, false, first, &stored,
                    &pose);
        posed[lane] = pose;
        at_rest[lane] = 0;
    }
    for (uint l = 1; l < layer_count; l++)
        lay_over_all(all, posing, l, first, rest, at_rest, posed);
    for (uint lane = 0; lane < all->count; lane++) {
        if (!posing->changes[lane].adjusts) continue;
        Local pose = posed[lane];
        adjust(posing->adjustments, posing->adjustments.controls + all->controls[lane], first,
               &pose);
        posed[lane] = pose;
        at_rest[lane] = 0;
    }
}
