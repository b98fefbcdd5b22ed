// fused.cl - Helpers of both fused schedules. Twin of populace-native/src/fused.rs: same
// arithmetic, same order of operations.

// Returns what a slot plays now. The weight is 0 if it plays nothing.
INLINE Playing play(Slot given, Machines machines, ulong tick, const ClipTables *tables,
                    __global const float *row_times, __global const uint *buckets)
{
    const Slot slot = slot_now(given, tick, machines);
    float secs;
    const SlotSample at =
        sample_of(slot, tick, tables->bound_clips, tables->clips, row_times, buckets, &secs);
    const Playing playing = { at, slot.bound_clip, slot_layer(slot), secs, halves_of(at.between) };
    return playing;
}

// Stores local transforms as ten planes, each of the body's padded joints.
INLINE void store_trs(Local trs, __global float *planes, uint padded)
{
    const Real all[10] = { trs.r.x, trs.r.y, trs.r.z, trs.r.w, trs.t.x,
                           trs.t.y, trs.t.z, trs.s.x, trs.s.y, trs.s.z };
    for (uint plane = 0; plane < 10; plane++) STORE(all[plane], planes + plane * padded);
}
