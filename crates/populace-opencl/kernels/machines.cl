// machines.cl - State machines: the kernel that takes transitions, and what the two slots of a
// machine play. All devices of a crowd advance all machines: whole ticks and comparisons give the
// same result everywhere.
//
// Kernel   advance: each state machine takes at most one transition whose conditions hold
// NDRange  (machine_instances, padded to whole work-groups)
// Reads    machine_instances, machine_parameters[machine_instance * MACHINE_PARAMETERS +
//          parameter], machine_states, transitions, conditions
// Writes   running: one element for each machine instance in use
// Oracle   populace-testkit/src/oracle/machine.rs; the interpreter in populace/tests/machine
// Twin of populace-native/src/machines.rs: same arithmetic, same order of operations.

typedef struct {
    __global const MachineState *states;
    __global const Running *running;
} Machines;

// Returns the bound clip of a machine's slot that has weight.
INLINE uint machine_clip(uint bound_clip, Machines machines)
{
    const Running at = machines.running[bound_clip >> 1];
    return machines.states[(bound_clip & 1u) == at.which ? at.state : at.previous].bound_clip;
}

// Returns the slot that stands in for a machine's slot of weight `weight`.
APART Slot machine_slot(Slot slot, float weight, Machines machines)
{
    const Running at = machines.running[slot.bound_clip >> 1];
    const bool is_current = (slot.bound_clip & 1u) == at.which;
    const uint index = is_current ? at.state : at.previous;
    Slot now = slot;
    now.bound_clip = NONE;
    if (index == NONE) return now;
    const MachineState state = machines.states[index];
    now.start_tick = is_current ? at.entry_tick : at.previous_tick;
    now.phase_rate = state.phase_rate;
    now.weight_tick = at.entry_tick;
    now.start_phase = state.start_phase;
    now.bound_clip = state.bound_clip;
    now.layer_and_mode = slot_layer(slot) << SLOT_MODE_BITS | state.mode;
    // Each of the two slots has half the machine's weight.
    const float whole = 2.0f * weight, rate = whole * at.fade_rate;
    now.start_weight = is_current && rate > 0.0f ? 0.0f : whole;
    now.weight_rate = is_current ? rate : -rate;
    now.end_weight = is_current ? whole : 0.0f;
    return now;
}

// Returns a slot itself, or the stand-in of a machine's slot.
INLINE Slot slot_now(Slot slot, ulong tick, Machines machines)
{
    if (slot_mode(slot) == SLOT_MACHINE)
        slot = machine_slot(slot, slot_weight(slot, tick), machines);
    return slot;
}

INLINE bool condition_holds(Condition condition, __global const float *parameters, ulong elapsed)
{
    if (condition.kind == CONDITION_ABOVE) return parameters[condition.parameter] > condition.value;
    if (condition.kind == CONDITION_BELOW) return parameters[condition.parameter] < condition.value;
    return elapsed >= condition.ticks;
}

__kernel void advance(
    // Machines.
    __global const MachineInstance *machine_instances, __global const float *machine_parameters,
    __global const MachineState *machine_states, __global const Transition *transitions,
    __global const Condition *conditions,
    // The clock, and the number of machine instances.
    ulong tick, uint machine_instance_count,
    // Output.
    __global Running *running)
{
    const uint index = (uint)get_global_id(0);
    if (index >= machine_instance_count || machine_instances[index].state == NONE) return;
    const MachineInstance machine_instance = machine_instances[index];
    __global const float *parameters = machine_parameters + index * MACHINE_PARAMETERS;
    Running at = running[index];
    if (at.epoch != machine_instance.epoch) {
        const Running start = { machine_instance.start_tick,
                                0,
                                machine_instance.state,
                                NONE,
                                0,
                                0,
                                0.0f,
                                machine_instance.epoch,
                                0,
                                0 };
        at = start;
    }
    const ulong elapsed = tick > at.entry_tick ? tick - at.entry_tick : 0;
    const MachineState state = machine_states[at.state];
    bool taken = elapsed < at.fade_ticks; // a transition is under way
    for (uint i = 0; i < state.transition_count && !taken; i++) {
        const Transition transition = transitions[state.transition_first + i];
        taken = true;
        for (uint c = 0; c < transition.condition_count && taken; c++)
            taken =
                condition_holds(conditions[transition.condition_first + c], parameters, elapsed);
        if (!taken) continue;
        at.previous_tick = at.entry_tick;
        at.entry_tick = tick;
        at.previous = at.state;
        at.state = transition.to;
        at.which = 1 - at.which;
        at.fade_ticks = transition.fade_ticks;
        at.fade_rate = transition.fade_rate;
    }
    running[index] = at;
}
