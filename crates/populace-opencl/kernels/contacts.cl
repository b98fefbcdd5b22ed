// contacts.cl - Contacts of feet in lanes, mixed from the clips that members play on their lowest
// layers.
//
// Reads    slots and the state of state machines, or what members play; bound clips, clips and
//          contacts
// Twin of populace-native/src/constraints/contacts.rs: same arithmetic, same order of operations.

// Weights of the clips of a layer, by what they do with one foot: the sum over clips that lift it,
// of weight times seconds within a contact (negative outside of one); the weight of those clips;
// and that of clips in which the foot stands throughout.
typedef struct {
    Real within, steps, stands;
} Mix;

// Returns the index of a foot's link to the ankle.
INLINE uint ankle_link(__global const Constraint *foot)
{
    return foot->link_count - 1 - foot->toe_links;
}

// Returns the seconds from the nearest ends of contacts to times, all in seconds after the start of a
// cycle: positive within the contact.
INLINE Real secs_within(Real from_secs, Real until_secs, Real secs, Real cycle_secs)
{
    const Real middle = 0.5f * (from_secs + until_secs);
    Real away = fabs(secs - middle);
    away = away > 0.5f * cycle_secs ? fabs(cycle_secs - away) : away;
    return 0.5f * (until_secs - from_secs) - away;
}

// A clip that a member plays on its lowest layer: its weight, 0 if it knows no contacts, and the time
// after its start.
typedef struct {
    float weight, secs, duration_secs;
    uint contact_first, contact_count;
} Stepping;

INLINE Stepping stepping(const ConstraintTables *tables, uint bound_clip, float weight, float secs)
{
    const BoundClip bound = tables->bound_clips[bound_clip];
    const Stepping stepping = { bound.contact_count > 0 ? weight : 0.0f, secs,
                                tables->clips[bound.rows].duration_secs, bound.contact_first,
                                bound.contact_count };
    return stepping;
}

#if LANES == 1

INLINE uint play_count(const Stop *at, uint lane) { return at->members->tables->slots_per_member; }

INLINE Stepping play_in(const Stop *at, uint lane, uint nth)
{
    const ConstraintTables *tables = at->members->tables;
    const Stepping none = { 0.0f, 0.0f, 0.0f, 0, 0 };
    const Slot given = tables->slots[at->members->control->member * tables->slots_per_member + nth];
    if (given.bound_clip == NONE || slot_layer(given) != 0) return none;
    const Slot slot = slot_now(given, tables->tick, tables->machines);
    const float weight = slot.bound_clip == NONE ? 0.0f : slot_weight(slot, tables->tick);
    if (weight <= 0.0f || slot_mode(slot) == SLOT_LIVE) return none;
    const ClipRows clip = tables->clips[tables->bound_clips[slot.bound_clip].rows];
    return stepping(tables, slot.bound_clip, weight,
                    slot_time(slot, tables->tick, clip) - clip.start_secs);
}

#else

INLINE uint play_count(const Stop *at, uint lane) { return at->plays[lane].count; }

INLINE Stepping play_in(const Stop *at, uint lane, uint nth)
{
    const Stepping none = { 0.0f, 0.0f, 0.0f, 0, 0 };
    const Playing playing = playing_at(at->plays[lane], nth);
    if (playing.layer != 0 || isnan(playing.secs)) return none;
    return stepping(at->members->tables, playing.bound_clip, playing.at.weight, playing.secs);
}

#endif

// Returns whether all members play the same clip.
INLINE bool share_clip(const Stop *at, const Stepping *clips)
{
    bool share = true;
    for (uint lane = 1; lane < at->count; lane++)
        share = share & (clips[lane].contact_first == clips->contact_first)
                & (clips[lane].contact_count == clips->contact_count);
    return share;
}

// Contacts in lanes. Joints are NONE in lanes without one.
typedef struct {
    Real from_secs, until_secs;
    Words joint;
} Contacts;

// Returns the `nth` contact of each member's clip. `share` tells that all clips are the same.
INLINE Contacts contacts_of(const Stop *at, const Stepping *clips, bool share, uint nth)
{
    __global const Contact *contacts = at->members->tables->contacts;
    Contacts all = { 0.0f, 0.0f, NONE };
    if (share) {
        const Contact one = contacts[clips->contact_first + nth];
        all.from_secs = one.from_secs;
        all.until_secs = one.until_secs;
        all.joint = one.joint;
        return all;
    }
    for (uint lane = 0; lane < at->count; lane++) {
        if (nth >= clips[lane].contact_count) continue;
        const Contact one = contacts[clips[lane].contact_first + nth];
        PUT(all.from_secs, lane, one.from_secs);
        PUT(all.until_secs, lane, one.until_secs);
        PUT_WORD(all.joint, lane, one.joint);
    }
    return all;
}

// Adds a clip of each member to the mix of each foot.
INLINE void mix_contacts(const Stop *at, const Stepping *clips, uint contacts_most,
                         const uint *ankles, uint feet, Mix *mixes)
{
    Real weight = 0.0f, secs = 0.0f, duration_secs = 0.0f, within[MAX_FEET];
    Choice stands[MAX_FEET];
    for (uint lane = 0; lane < at->count; lane++) {
        PUT(weight, lane, clips[lane].weight);
        PUT(secs, lane, clips[lane].secs);
        PUT(duration_secs, lane, clips[lane].duration_secs);
    }
    for (uint foot = 0; foot < feet; foot++) {
        within[foot] = -FOOT_NEAR_SECS;
        stands[foot] = 0;
    }
    const bool share = share_clip(at, clips);
    for (uint i = 0; i < contacts_most; i++) {
        const Contacts all = contacts_of(at, clips, share, i);
        const Real lasts_secs = all.until_secs - all.from_secs;
        const Real of_contact = secs_within(all.from_secs, all.until_secs, secs, duration_secs);
        const Choice is_whole = lasts_secs >= CONTACT_WHOLE * duration_secs;
        for (uint foot = 0; foot < feet; foot++) {
            const Choice own = all.joint == ankles[foot];
            within[foot] = own & (of_contact > within[foot]) ? of_contact : within[foot];
            stands[foot] = stands[foot] | (own & is_whole);
        }
    }
    const Real none = 0.0f;
    for (uint foot = 0; foot < feet; foot++) {
        const Real near =
            within[foot] < (Real)(FOOT_NEAR_SECS) ? within[foot] : (Real)(FOOT_NEAR_SECS);
        mixes[foot].within += stands[foot] ? none : weight * near;
        mixes[foot].steps += stands[foot] ? none : weight;
        mixes[foot].stands += stands[foot] ? weight : none;
    }
}

// Writes for each foot the seconds from the nearest ends of contacts: positive within one, negative
// outside of it, at most FOOT_NEAR_SECS in size. NAN if no clip knows. `feet` are the constraints of
// the first member.
INLINE void put_contacts(const Stop *at, __global const Constraint *feet, uint count,
                         Real *within_secs)
{
    uint ankles[MAX_FEET], plays_most = 0;
    Mix mixes[MAX_FEET];
    for (uint foot = 0; foot < count; foot++) {
        const uint link = feet[foot].link_first + ankle_link(feet + foot);
        ankles[foot] = at->members->tables->links[link].joint;
        mixes[foot].within = mixes[foot].steps = mixes[foot].stands = 0.0f;
    }
    for (uint lane = 0; lane < at->count; lane++)
        plays_most = max(plays_most, play_count(at, lane));
    for (uint nth = 0; nth < plays_most; nth++) {
        Stepping clips[LANES];
        uint contacts_most = 0;
        for (uint lane = 0; lane < at->count; lane++) {
            const Stepping none = { 0.0f, 0.0f, 0.0f, 0, 0 };
            clips[lane] = nth < play_count(at, lane) ? play_in(at, lane, nth) : none;
            contacts_most = max(contacts_most, clips[lane].contact_count);
        }
        if (contacts_most > 0) mix_contacts(at, clips, contacts_most, ankles, count, mixes);
    }
    for (uint foot = 0; foot < count; foot++) {
        const Mix mix = mixes[foot];
        const Real total = mix.steps + mix.stands;
        const Choice stands_still = mix.steps <= FOOT_STEPPING * total;
        const Real near = stands_still ? (Real)(FOOT_NEAR_SECS) : mix.within / mix.steps;
        within_secs[foot] = total > (Real)(0.0f) ? near : (Real)(NAN);
    }
}
