// slot.cl - Rows and weight of a slot, in closed form from the clock. Slots are never written.
//
// Twin of populace-native/src/slot.rs, populace-device/src/playback.rs,
// populace-device/src/playback/inertialize.rs and populace-device/src/tables/rows.rs: same
// arithmetic, same order of operations.

// Returns a weight that goes from `start` by `rate` per second to `end`.
INLINE float ramp(ulong elapsed_ticks, float start, float rate, float end)
{
    const float weight = start + rate * ((float)elapsed_ticks * TICK_SECS);
    const bool rising = rate >= 0.0f;
    return (rising && weight > end) || (!rising && weight < end) ? end : weight;
}

INLINE uint slot_mode(Slot slot) { return slot.layer_and_mode & ((1u << SLOT_MODE_BITS) - 1u); }

INLINE uint slot_layer(Slot slot) { return slot.layer_and_mode >> SLOT_MODE_BITS; }

// Returns the time on the clip's own axis, in seconds, of a slot of SLOT_HELD.
INLINE float slot_held_secs(Slot slot) { return as_float(slot.start_phase); }

// Returns the delay of a slot of SLOT_LIVE.
INLINE ulong slot_delay_ticks(Slot slot) { return slot.phase_rate; }

INLINE float slot_weight(Slot slot, ulong tick)
{
    if (tick < slot.start_tick || slot_mode(slot) == SLOT_INERTIALIZATION) return 0.0f;
    const ulong elapsed = tick > slot.weight_tick ? tick - slot.weight_tick : 0;
    return ramp(elapsed, slot.start_weight, slot.weight_rate, slot.end_weight);
}

// Returns the same bytes as an inertialization slot. The slot's mode must be SLOT_INERTIALIZATION.
INLINE InertializationSlot as_inertialization(Slot slot)
{
    const union {
        Slot slot;
        InertializationSlot inertialization;
    } bytes = { slot };
    return bytes.inertialization;
}

// Returns the fraction of an inertialization's duration that has passed.
INLINE float inertialized_at(InertializationSlot slot, ulong tick)
{
    return (float)(tick - slot.start_tick) * slot.per_tick;
}

INLINE bool slot_inertializes(Slot slot, ulong tick)
{
    return slot_mode(slot) == SLOT_INERTIALIZATION && slot.bound_clip != NONE
           && inertialized_at(as_inertialization(slot), tick) < 1.0f;
}

// Returns the mean weight of a slot from one tick to a later one; `from_tick` is not before the
// slot's start.
INLINE float slot_mean_weight(Slot slot, ulong from_tick, ulong to_tick)
{
    const float end = slot_weight(slot, to_tick);
    const float start =
        from_tick < slot.weight_tick ? slot.start_weight : slot_weight(slot, from_tick);
    if (start == end || slot_mode(slot) == SLOT_INERTIALIZATION) return end;
    // Ticks before the weight changes, and half of those while it does.
    const float still = (float)(slot.weight_tick > from_tick ? slot.weight_tick - from_tick : 0);
    const float per_tick = slot.weight_rate * TICK_SECS;
    const float half_changing = per_tick == 0.0f ? 0.0f : 0.5f * ((end - start) / per_tick);
    return end + (start - end) * ((still + half_changing) / (float)(to_tick - from_tick));
}

INLINE float slot_time(Slot slot, ulong tick, ClipRows clip)
{
    if (slot_mode(slot) == SLOT_HELD) return slot_held_secs(slot);
    const ulong elapsed = tick - slot.start_tick;
    ulong phase = ((ulong)slot.start_phase << 32) + elapsed * slot.phase_rate;
    if (slot_mode(slot) == SLOT_ONCE) {
        const bool backwards = (slot.phase_rate >> 63) != 0;
        const ulong rate = backwards ? -slot.phase_rate : slot.phase_rate;
        if (mul_hi(elapsed, rate) != 0)
            return backwards ? clip.start_secs : clip.start_secs + clip.duration_secs;
        // A whole cycle would read as phase 0, so backward playback begins one step below it.
        phase = backwards ? ~(elapsed * rate) : elapsed * rate;
    }
    return clip.start_secs + (float)(uint)(phase >> 40) * (1.0f / 16777216.0f) * clip.duration_secs;
}

// Returns how often a looping slot passes an end of its clip from one tick to a later one;
// `from_tick` is not before the slot's start.
INLINE ulong slot_cycles(Slot slot, ulong from_tick, ulong to_tick)
{
    if (slot_mode(slot) != SLOT_LOOP) return 0;
    const bool backwards = (slot.phase_rate >> 63) != 0;
    const ulong rate = backwards ? -slot.phase_rate : slot.phase_rate,
                elapsed = to_tick - from_tick;
    const ulong part = elapsed * rate, phase = ((ulong)slot.start_phase << 32)
                                               + (from_tick - slot.start_tick) * slot.phase_rate;
    const bool passes = backwards ? part > phase : phase + part < part;
    return mul_hi(elapsed, rate) + (passes ? 1 : 0);
}

// Returns the last row at or before a time. *between is the fraction of the way to the next row.
INLINE uint find_row(ClipRows clip, __global const float *row_times, __global const uint *buckets,
                     float secs, float *between)
{
    const uint last = clip.row_count - 1;
    const float passed = secs - clip.start_secs;
    *between = 0.0f;
    if (last == 0 || (passed <= 0.0f && clip.rows_per_sec > 0.0f)) return 0;
    if (clip.rows_per_sec > 0.0f) {
        const float at = passed * clip.rows_per_sec;
        if (at >= (float)last) return last;
        const uint row = (uint)at;
        *between = at - (float)row;
        return row;
    }
    __global const float *times = row_times + clip.time_first;
    if (secs >= times[last]) return last;
    const uint bucket = min((uint)max(passed * clip.buckets_per_sec, 0.0f), clip.bucket_count - 1);
    uint row = buckets[clip.bucket_first + bucket];
    while (times[row + 1] <= secs) row++;
    *between = max((secs - times[row]) / (times[row + 1] - times[row]), 0.0f);
    return row;
}

INLINE uint ring_place(ClipRows clip, uint behind)
{
    return 1 + (clip.newest_row + (behind > clip.newest_row ? clip.ring_rows : 0) - behind);
}

// Returns the row of a live clip at or before the time that a slot shows, and in *next the one
// after it. The first stored row, which additive layers measure from, is skipped. Counts whole
// ticks back from the newest row.
INLINE uint find_live_row(ClipRows clip, Slot slot, ulong tick, uint *next, float *between)
{
    const ulong delay = slot_delay_ticks(slot), shown = tick > delay ? tick - delay : 0;
    const ulong back = clip.newest_tick > shown ? clip.newest_tick - shown : 0;
    const ulong older = back > clip.newest_ticks ? back - clip.newest_ticks : 0;
    // Rows behind the newest one, counting those between it and its predecessor.
    const ulong behind =
        (back > 0 ? 1 : 0) + older / clip.row_ticks + (older % clip.row_ticks > 0 ? 1 : 0);
    const uint oldest = clip.row_count - 1;
    *between = 0.0f;
    if (behind > oldest || behind == 0) return *next = ring_place(clip, behind == 0 ? 0 : oldest);
    const ulong past = older > 0 ? (behind - 1) * clip.row_ticks - older : clip.newest_ticks - back;
    *between = (float)(uint)past * (older > 0 ? clip.per_row_tick : clip.per_newest_tick);
    *next = ring_place(clip, (uint)behind - (past > 0 ? 1 : 0));
    return ring_place(clip, (uint)behind);
}

// Returns the rows and the weight of a slot. *secs is the time after the start of its clip; NAN for
// live clips and without weight.
INLINE SlotSample sample_of(Slot slot, ulong tick, __global const BoundClip *bound_clips,
                            __global const ClipRows *clips, __global const float *row_times,
                            __global const uint *buckets, float *secs)
{
    SlotSample sample = { 0, 0, 0.0f, 0.0f };
    *secs = NAN;
    const float weight = slot.bound_clip == NONE ? 0.0f : slot_weight(slot, tick);
    if (weight > 0.0f) {
        const ClipRows clip = clips[bound_clips[slot.bound_clip].rows];
        float between;
        uint row, next;
        if (slot_mode(slot) == SLOT_LIVE) {
            row = find_live_row(clip, slot, tick, &next, &between);
        } else {
            const float time = slot_time(slot, tick, clip);
            *secs = time - clip.start_secs;
            row = find_row(clip, row_times, buckets, time, &between);
            next = between > 0.0f ? row + 1 : row;
        }
        sample.row0 = clip.row_first + row * clip.row_stride;
        sample.row1 = clip.row_first + next * clip.row_stride;
        sample.between = between;
        sample.weight = weight;
    }
    return sample;
}
