/* playback.cl - what a member plays now, as the schedules keep it: staged in two buffers, fused beside the work-item. */

#ifdef FUSED

typedef struct { FUSED const Playing *all; uint count; } Playback;

INLINE Playing playing_at(Playback playback, uint s) { return playback.all[s]; }

#else

typedef struct {
    __global const Slot *slots;
    __global const SlotSample *samples;
    uint count;
} Playback;

INLINE Playing playing_at(Playback playback, uint s)
{
    const Playing playing = { playback.samples[s], playback.slots[s].bound_clip, slot_layer(playback.slots[s]) };
    return playing;
}

#endif
