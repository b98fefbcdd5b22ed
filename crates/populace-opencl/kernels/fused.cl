/* fused.cl - what the fused schedules share. */

/* What a slot plays now; its weight is 0 where that is nothing. */
INLINE Playing play(Slot given, Machines machines, ulong tick, const Clips *of, __global const float *row_times,
                    __global const uint *buckets)
{
    const Slot slot = slot_now(given, tick, machines);
    const Playing playing = { sample_of(slot, tick, of->bound_clips, of->clips, row_times, buckets), slot.bound_clip,
                              slot_layer(slot) };
    return playing;
}

/* Keeps local transforms as ten planes, as in stored poses. */
INLINE void store_trs(Trs trs, __global float *planes, uint padded)
{
    const Real all[10] = { trs.r.x, trs.r.y, trs.r.z, trs.r.w, trs.t.x, trs.t.y, trs.t.z, trs.s.x, trs.s.y, trs.s.z };
    for (uint plane = 0; plane < 10; plane++) STORE(all[plane], planes + plane * padded);
}
