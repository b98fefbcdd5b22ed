/* fused.cl - what the fused schedules share. */

/* The member's slots that weigh anything now, in order; returns how many. */
INLINE uint play(__global const Slot *slots, uint slot_count, ulong tick, Clips of, __global const float *row_times,
          __global const uint *buckets, FUSED Playing *playing)
{
    uint count = 0;
    for (uint s = 0; s < slot_count; s++) {
        const Slot slot = slots[s];
        const SlotSample at = sample_of(slot, tick, of.bound_clips, of.clips, row_times, buckets);
        if (at.weight <= 0.0f) continue;
        playing[count].at = at;
        playing[count].bound_clip = slot.bound_clip;
        playing[count].layer = slot_layer(slot);
        count++;
    }
    return count;
}
