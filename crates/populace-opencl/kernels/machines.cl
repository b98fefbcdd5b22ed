/* machines.cl - what the two slots of a state machine play now. Twin of populace-native machines.rs. */

typedef struct { __global const MachineState *states; __global const Running *running; } Machines;

/* The bound clip of a machine's slot that weighs anything. */
INLINE uint machine_clip(uint bound_clip, Machines of)
{
    const Running at = of.running[bound_clip >> 1];
    return of.states[(bound_clip & 1u) == at.which ? at.state : at.previous].bound_clip;
}

/* How much of a machine its state is, or the one before. */
INLINE float machine_share(Running at, bool is_current, ulong tick)
{
    const ulong elapsed = tick > at.entry_tick ? tick - at.entry_tick : 0;
    const float end = is_current ? 1.0f : 0.0f;
    if (elapsed >= at.fade_ticks) return end;
    return ramp(elapsed, 1.0f - end, is_current ? at.fade_rate : -at.fade_rate, end);
}

/* The slot that one of a machine stands for, with the product of both weights. */
APART Slot machine_slot(Slot slot, ulong tick, Machines of)
{
    const Running at = of.running[slot.bound_clip >> 1];
    const bool is_current = (slot.bound_clip & 1u) == at.which;
    const uint index = is_current ? at.state : at.previous;
    Slot now = slot;
    now.bound_clip = NONE;
    if (index == NONE) return now;
    const MachineState state = of.states[index];
    now.start_tick = is_current ? at.entry_tick : at.previous_tick;
    now.phase_rate = state.phase_rate;
    now.weight_tick = tick;
    now.start_phase = state.start_phase;
    now.bound_clip = state.bound_clip;
    now.layer_and_mode = slot_layer(slot) << SLOT_MODE_BITS | state.mode;
    /* Each of the two has half the machine's weight. */
    now.start_weight = now.end_weight = 2.0f * slot_weight(slot, tick) * machine_share(at, is_current, tick);
    now.weight_rate = 0.0f;
    return now;
}

/* A slot, or in place of a machine's the one that it stands for. */
INLINE Slot slot_now(Slot slot, ulong tick, Machines of)
{
    if (slot_mode(slot) == SLOT_MACHINE) slot = machine_slot(slot, tick, of);
    return slot;
}
