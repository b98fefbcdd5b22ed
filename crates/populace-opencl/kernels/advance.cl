/* advance.cl - Advance: every state machine takes a transition that holds, one at most. All devices of a crowd run all of
 * them: whole ticks and comparisons come to the same everywhere.
 * NDRange  (machine_instances, padded to whole work-groups)
 * Reads    machine_instances, machine_parameters[machine_instance * MACHINE_PARAMETERS + parameter], machine_states, transitions, conditions
 * Writes   running, one for each machine_instance that there is
 * Oracle   populace tests/machine; twin of populace-native machines.rs */

INLINE bool condition_holds(Condition condition, __global const float *parameters, ulong elapsed)
{
    if (condition.kind == CONDITION_ABOVE) return parameters[condition.parameter] > condition.value;
    if (condition.kind == CONDITION_BELOW) return parameters[condition.parameter] < condition.value;
    return elapsed >= condition.ticks;
}

__kernel void advance(__global const MachineInstance *machine_instances, __global const float *machine_parameters,
                      __global const MachineState *machine_states, __global const Transition *transitions,
                      __global const Condition *conditions, ulong tick, uint machine_instance_count, __global Running *running)
{
    const uint index = (uint)get_global_id(0);
    if (index >= machine_instance_count || machine_instances[index].state == NONE) return;
    const MachineInstance machine_instance = machine_instances[index];
    __global const float *parameters = machine_parameters + index * MACHINE_PARAMETERS;
    Running at = running[index];
    if (at.epoch != machine_instance.epoch) {
        const Running start = { machine_instance.start_tick, 0, machine_instance.state, NONE, 0, 0, 0.0f, machine_instance.epoch, 0, 0 };
        at = start;
    }
    const ulong elapsed = tick > at.entry_tick ? tick - at.entry_tick : 0;
    const MachineState state = machine_states[at.state];
    bool taken = elapsed < at.fade_ticks; /* another is under way */
    for (uint i = 0; i < state.transition_count && !taken; i++) {
        const Transition way = transitions[state.transition_first + i];
        taken = true;
        for (uint c = 0; c < way.condition_count && taken; c++)
            taken = condition_holds(conditions[way.condition_first + c], parameters, elapsed);
        if (!taken) continue;
        at.previous_tick = at.entry_tick;
        at.entry_tick = tick;
        at.previous = at.state;
        at.state = way.to;
        at.which = 1 - at.which;
        at.fade_ticks = way.fade_ticks;
        at.fade_rate = way.fade_rate;
    }
    running[index] = at;
}
