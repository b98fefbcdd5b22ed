// playback.cl - What a member plays now: in buffers for the staged schedule, in memory of the
// work-item or the work-group for the fused ones. Twin of populace-native/src/playback.rs.

// A member's slots if any of them inertializes; else count is 0.
typedef struct {
    __global const Slot *slots;
    uint count;
    ulong tick;
} Inertialization;

INLINE Inertialization inertialization_of(__global const Slot *slots, uint count, ulong tick)
{
    bool any = false;
    for (uint s = 0; s < count; s++) any = any || slot_inertializes(slots[s], tick);
    const Inertialization inertialization = { slots, any ? count : 0, tick };
    return inertialization;
}

#ifdef FUSED

typedef struct {
    FUSED const Playing *all;
    uint count;
    Inertialization inertialization;
#if LANES == 1
    // See sample_joint() and alone_in_layers().
    bool at_once;
    uint alone;
#else
    // True if a clip that plays stores floats.
    bool has_floats;
#endif
} Playback;

INLINE Playing playing_at(Playback playback, uint s) { return playback.all[s]; }

#else

typedef struct {
    __global const Slot *slots;
    __global const SlotSample *samples;
    uint count;
    Machines machines;
    Inertialization inertialization;
    bool at_once;
    uint alone;
} Playback;

INLINE Playing playing_at(Playback playback, uint s)
{
    const Slot slot = playback.slots[s];
    const SlotSample at = playback.samples[s];
    Playing playing = { at, slot.bound_clip, slot_layer(slot), NAN, halves_of(at.between) };
    if (slot_mode(slot) == SLOT_MACHINE && playing.at.weight > 0.0f)
        playing.bound_clip = machine_clip(slot.bound_clip, playback.machines);
    return playing;
}

#endif

#if LANES == 1

// Returns a bit for each layer that plays one slot, whose weight does not count in the layer's mean.
INLINE uint alone_in_layers(Playback playback)
{
    uint any = 0, several = 0, weak = 0;
    for (uint s = 0; s < playback.count; s++) {
        const Playing playing = playing_at(playback, s);
        if (playing.at.weight <= 0.0f) continue;
        const uint layer = 1u << playing.layer;
        several |= any & layer;
        any |= layer;
        if (playing.at.weight <= LEAST_TOTAL) weak |= layer;
    }
    return any & ~several & ~weak;
}

#endif
