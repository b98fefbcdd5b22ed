// kernel_parameters.cl - Parameter lists that several kernels share, and the same lists as
// arguments.

// Tables and history of constraint programs. src/history.rs sets them in this order.
// clang-format off
#define CONSTRAINT_PARAMETERS \
    __global const Control *controls, __global const Step *steps, \
    __global const Override *overrides, \
    __global const Constraint *constraints, __global const Link *links, \
    __global const Target *targets, \
    __global const Ground *ground, __global const float *heights, \
    __global const float4 *soles, __global const Contact *contacts, \
    __global const float4 *states_before, __global const float4 *watched_before, \
    __global float4 *states, __global float4 *watched, \
    __global const float4 *stage_values, \
    __global const float4 *motions, \
    uint elapsed_ticks
#define CONSTRAINT_ARGUMENTS \
    controls, steps, overrides, constraints, links, targets, ground, heights, soles, contacts, \
    states_before, watched_before, states, watched, stage_values, motions, elapsed_ticks
// clang-format on

// Gathers what constraint programs read and write.
INLINE ConstraintTables constraint_tables_of(
    CONSTRAINT_PARAMETERS,
    // Members and what they play, for root motion.
    __global const Member *members, __global const Slot *slots, __global const Layer *layers,
    __global const BoundClip *bound_clips, __global const ClipRows *clips,
    __global const float *masks, uint slots_per_member, Machines machines,
    // The clock.
    ulong tick)
{
    ConstraintTables tables;
    tables.controls = controls;
    tables.steps = steps;
    tables.overrides = overrides;
    tables.constraints = constraints;
    tables.links = links;
    tables.targets = targets;
    tables.ground = ground;
    tables.heights = heights;
    tables.soles = soles;
    tables.contacts = contacts;
    tables.states_before = states_before;
    tables.watched_before = watched_before;
    tables.states = states;
    tables.watched = watched;
    tables.stage_values = stage_values;
    tables.motions = motions;
    tables.members = members;
    tables.slots = slots;
    tables.layers = layers;
    tables.bound_clips = bound_clips;
    tables.clips = clips;
    tables.masks = masks;
    tables.slots_per_member = slots_per_member;
    tables.machines = machines;
    tables.tick = tick;
    tables.elapsed_ticks = elapsed_ticks;
    tables.elapsed_secs = (float)elapsed_ticks * TICK_SECS;
    return tables;
}
