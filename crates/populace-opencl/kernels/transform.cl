// transform.cl - Transform stage (Lister & Day 2012, section 3, fig. 1): composes one level of
// local transforms with their parents, and runs constraint programs.
//
// NDRange  joints of the widest level at this depth, for each member of a run, padded to whole
//          work-groups; one enqueue for each phase, level and run; members of other phases are
//          skipped. All levels use one size of group: some drivers compile a kernel once per size
// Reads    translations, rotations, scales; rows of the level above; controls and the tables that
//          they index; watched joints that earlier phases wrote
// Writes   row0, row1, row2 of model_from_joint (a rotated child under non-uniform scale shears, so
//          translation, rotation and scale would not do); step_rotations for the levels below; states
//          and watched joints
// Oracle   populace-testkit/src/oracle/transform.rs
// Twin of populace-native/src/transform.rs: same arithmetic, same order of operations.

__kernel void transform(
    // Members and their bodies.
    __global const Member *members, __global const Body *bodies, __global const uint *parents,
    __global const uint *levels,
    // Level, range and phase.
    uint level, uint level_width, uint member_first, uint member_end, uint phase,
    // Local transforms.
    __global const float4 *translations, __global const float4 *rotations,
    __global const float4 *scales,
    // What members play, for root motion.
    __global const Slot *slots, __global const MachineState *machine_states,
    __global const Running *running, __global const Layer *layers,
    __global const BoundClip *bound_clips, __global const ClipRows *clips,
    __global const float *masks, uint slots_per_member,
    // The clock.
    ulong tick,
    // Constraint programs.
    CONSTRAINT_PARAMETERS,
    // Rotations handed down.
    __global float4 *step_rotations,
    // Output.
    __global float4 *row0, __global float4 *row1, __global float4 *row2)
{
    const uint item = (uint)get_global_id(0), owner = member_first + item / level_width;
    if (owner >= member_end || members[owner].body == NONE) return;
    const Member member = members[owner];
    if (member_phase(member) != phase) return;
    const Body body = bodies[member.posed];
    if (level >= body.level_count) return;
    const uint joint = levels[body.level_first + level] + item % level_width;
    if (joint >= levels[body.level_first + level + 1]) return;

    const uint first = member.joint_first, parent = parents[body.joint_first + joint];
    const Hierarchy joints = { translations + first, rotations + first, scales + first,
                               row0 + first,         row1 + first,      row2 + first };
    float16 model = local_in(joints, joint, 0);
    if (parent != NONE) model = affine_mul(model_of(joints, parent), model);
    keep_model(joints, joint, model.s0123, model.s4567, model.s89ab);
    if (member.control == NONE) return;
    const Machines machines = { machine_states, running };
    const ConstraintTables constraint_tables =
        constraint_tables_of(CONSTRAINT_ARGUMENTS, members, slots, layers, bound_clips, clips,
                             masks, slots_per_member, machines, tick);
    const Solver s = solver_of(&constraint_tables, member.control);
    solve_joint(&s, joints, step_rotations + member.control * MAX_STEP_ROTATIONS, joint, parent);
}
