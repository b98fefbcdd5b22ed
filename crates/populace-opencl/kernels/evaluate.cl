// evaluate.cl - Evaluate stage: rows and weight of each slot, from the clock.
//
// NDRange  (slots of all members, padded to whole work-groups)
// Reads    slots[member * slots_per_member + slot], bound_clips, clips, row_times, buckets,
//          machine_states, running
// Writes   samples: one element for each slot
// Oracle   populace-testkit/src/oracle/evaluate.rs
// Twin of populace-native/src/evaluate.rs: same arithmetic, same order of operations.

__kernel void evaluate(
    // Slots and state machines.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running,
    // Clips.
    __global const BoundClip *bound_clips, __global const ClipRows *clips,
    __global const float *row_times, __global const uint *buckets,
    // The clock, and the number of slots.
    ulong tick, uint slot_count,
    // Output.
    __global SlotSample *samples)
{
    const uint index = (uint)get_global_id(0);
    if (index >= slot_count) return;
    const Machines machines = { machine_states, running };
    float secs;
    samples[index] = sample_of(slot_now(slots[index], tick, machines), tick, bound_clips, clips,
                               row_times, buckets, &secs);
}
