// contacts.cl - Contacts of feet, mixed from the clips that a member plays on its lowest layer.
//
// Reads    slots, the state of state machines, bound clips, clips and contacts
// Twin of populace-native/src/constraints/contacts.rs: same arithmetic, same order of operations.

// Weights of the clips of a layer, by what they do with one foot: the sum over clips that lift it,
// of weight times seconds within a contact (negative outside of one); the weight of those clips;
// and that of clips in which the foot stands throughout.
typedef struct {
    float within, steps, stands;
} Mix;

// Returns the index of a foot's link to the ankle.
INLINE uint ankle_link(__global const Constraint *foot)
{
    return foot->link_count - 1 - foot->toe_links;
}

// Returns the seconds from the nearest end of a contact to a time, both in seconds after the start
// of a cycle: positive within the contact.
INLINE float secs_within(Contact contact, float secs, float cycle_secs)
{
    const float middle = 0.5f * (contact.from_secs + contact.until_secs);
    float away = fabs(secs - middle);
    away = away > 0.5f * cycle_secs ? fabs(cycle_secs - away) : away;
    return 0.5f * (contact.until_secs - contact.from_secs) - away;
}

INLINE void mix_contacts(const Solver *s, Slot slot, const uint *ankles, uint count, Mix *mixes)
{
    const ConstraintTables *tables = s->tables;
    slot = slot_now(slot, tables->tick, tables->machines);
    const float weight = slot.bound_clip == NONE ? 0.0f : slot_weight(slot, tables->tick);
    if (weight <= 0.0f || slot_mode(slot) == SLOT_LIVE) return;
    const BoundClip bound = tables->bound_clips[slot.bound_clip];
    if (bound.contact_count == 0) return;
    const ClipRows clip = tables->clips[bound.clip];
    const float secs = slot_time(slot, tables->tick, clip) - clip.start_secs;
    for (uint foot = 0; foot < count; foot++) {
        float within = -FOOT_NEAR_SECS;
        bool stands = false;
        for (uint i = 0; i < bound.contact_count; i++) {
            const Contact contact = tables->contacts[bound.contact_first + i];
            if (contact.joint != ankles[foot]) continue;
            const float of_contact = secs_within(contact, secs, clip.duration_secs);
            within = of_contact > within ? of_contact : within;
            const float lasts_secs = contact.until_secs - contact.from_secs;
            stands = stands || lasts_secs >= CONTACT_WHOLE * clip.duration_secs;
        }
        if (stands) {
            mixes[foot].stands += weight;
        } else {
            within = within < FOOT_NEAR_SECS ? within : FOOT_NEAR_SECS;
            mixes[foot].within += weight * within;
            mixes[foot].steps += weight;
        }
    }
}

// Writes for each foot of a member the seconds from the nearest end of a contact: positive within it, negative
// outside of it, at most FOOT_NEAR_SECS in size. NAN if no clip knows.
INLINE void contacts_of(const Solver *s, const uint *ankles, uint count, float *within_secs)
{
    Mix mixes[MAX_FEET];
    for (uint foot = 0; foot < count; foot++)
        mixes[foot].within = mixes[foot].steps = mixes[foot].stands = 0.0f;
    __global const Slot *slots =
        s->tables->slots + s->control.member * s->tables->slots_per_member;
    for (uint i = 0; i < s->tables->slots_per_member; i++)
        if (slots[i].bound_clip != NONE && slot_layer(slots[i]) == 0)
            mix_contacts(s, slots[i], ankles, count, mixes);
    for (uint foot = 0; foot < count; foot++) {
        const Mix mix = mixes[foot];
        const float total = mix.steps + mix.stands;
        const bool stands_still = mix.steps <= FOOT_STEPPING * total;
        within_secs[foot] = total > 0.0f
                                ? (stands_still ? FOOT_NEAR_SECS : mix.within / mix.steps)
                                : NAN;
    }
}

// Writes the same for all members at a step of feet, in lanes. `feet` are the constraints of the
// first member.
INLINE void put_contacts(const Stop *at, __global const Constraint *feet, uint count,
                              Real *within_secs)
{
    uint ankles[MAX_FEET];
    for (uint foot = 0; foot < count; foot++) {
        const uint link = feet[foot].link_first + ankle_link(feet + foot);
        ankles[foot] = at->members->tables->links[link].joint;
        within_secs[foot] = 0.0f;
    }
    for (uint lane = 0; lane < at->count; lane++) {
        float own[MAX_FEET];
        contacts_of(at->members + lane, ankles, count, own);
        for (uint foot = 0; foot < count; foot++) PUT(within_secs[foot], lane, own[foot]);
    }
}
