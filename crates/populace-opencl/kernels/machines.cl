/* machines.cl - what the two slots of a state machine play now. Twin of populace-native machines.rs. */

typedef struct { __global const MachineState *states; __global const Running *running; } Machines;

/* The bound clip of a machine's slot that weighs anything. */
INLINE uint machine_clip(uint bound_clip, Machines of)
{
    const Running at = of.running[bound_clip >> 1];
    return of.states[(bound_clip & 1u) == at.which ? at.state : at.previous].bound_clip;
}

/* The slot that one of a machine stands for where that weighs so much. */
APART Slot machine_slot(Slot slot, float weight, Machines of)
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
    now.weight_tick = at.entry_tick;
    now.start_phase = state.start_phase;
    now.bound_clip = state.bound_clip;
    now.layer_and_mode = slot_layer(slot) << SLOT_MODE_BITS | state.mode;
    /* Each of the two has half the machine's weight. */
    const float whole = 2.0f * weight, rate = whole * at.fade_rate;
    now.start_weight = is_current && rate > 0.0f ? 0.0f : whole;
    now.weight_rate = is_current ? rate : -rate;
    now.end_weight = is_current ? whole : 0.0f;
    return now;
}

/* A slot, or in place of a machine's the one that it stands for. */
INLINE Slot slot_now(Slot slot, ulong tick, Machines of)
{
    if (slot_mode(slot) == SLOT_MACHINE) slot = machine_slot(slot, slot_weight(slot, tick), of);
    return slot;
}
