/* evaluate.cl - Evaluate: each slot's rows and weight from the clock.
 * NDRange  (slots of all members, padded to whole work-groups)
 * Reads    slots[member * slots_per_member + slot], bound_clips, clips, row_times, buckets; machine_states and running
 * Writes   samples, one for each slot
 * Oracle   populace-testkit oracle/evaluate.rs; twin of populace-native evaluate.rs */

__kernel void evaluate(__global const Slot *slots, __global const MachineState *machine_states,
                       __global const Running *running, __global const BoundClip *bound_clips, __global const ClipRows *clips,
                       __global const float *row_times, __global const uint *buckets, ulong tick, uint slot_count,
                       __global SlotSample *samples)
{
    const uint index = (uint)get_global_id(0);
    if (index >= slot_count) return;
    const Machines machines = { machine_states, running };
    samples[index] = sample_of(slot_now(slots[index], tick, machines), tick, bound_clips, clips, row_times, buckets);
}
