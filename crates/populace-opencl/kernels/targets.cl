// targets.cl - Inputs of a member's constraint program, and the targets of its constraints.
//
// Twin of populace-native/src/constraints/targets.rs: same arithmetic, same order of operations.

// Tables and clock that all constraint programs read.
typedef struct {
    __global const Control *controls;
    __global const Step *steps;
    __global const Override *overrides;
    __global const Constraint *constraints;
    __global const Link *links;
    __global const Target *targets;
    __global const Ground *ground;
    __global const float *heights;
    __global const float4 *soles;
    __global const Contact *contacts;
    __global const float4 *states_before, *watched_before; // as the previous frame left them
    __global float4 *states, *watched;                     // as this frame leaves them
    __global const float4 *stage_values, *motions;
    // What members play, for root motion and contacts of feet.
    __global const Member *members;
    __global const Slot *slots;
    __global const Layer *layers;
    __global const BoundClip *bound_clips;
    __global const ClipRows *clips;
    __global const float *masks;
    uint slots_per_member;
    Machines machines;
    ulong tick;
    uint elapsed_ticks;
    float elapsed_secs;
} ConstraintTables;

// A member's constraint program.
typedef struct {
    const ConstraintTables *tables;
    __global const Control *control;
    uint index;
} Solver;

INLINE Solver solver_of(const ConstraintTables *tables, uint control)
{
    const Solver solver = { tables, tables->controls + control, control };
    return solver;
}

// Rotates a direction of the world into model space.
INLINE float4 direction_to_model(__global const Control *control, float4 d)
{
    const float sine = control->sine, cosine = control->cosine;
    return vec(cosine * d.x - sine * d.z, d.y, sine * d.x + cosine * d.z);
}

INLINE float4 to_model(__global const Control *control, float4 point)
{
    const float4 d =
        vec(point.x - control->place.x, point.y - control->place.y, point.z - control->place.z);
    return direction_to_model(control, d) * (1.0f / control->place.w);
}

// Returns a target's weight now, eased at both ends of its ramp, and 0 below LEAST_WEIGHT.
INLINE float target_weight(Target target, ulong tick)
{
    const ulong elapsed = tick > target.weight_tick ? tick - target.weight_tick : 0;
    const float w = ramp(elapsed, target.start_weight, target.weight_rate, target.end_weight);
    const float eased = w * w * (3.0f - 2.0f * w);
    return eased > LEAST_WEIGHT ? eased : 0.0f;
}

// Returns a target's position in model space, seen from a point there. A watched joint without a
// position has weight 0.
INLINE float4 sight(const Solver *s, Target target, float4 from, float *weight)
{
    *weight = target_weight(target, s->tables->tick);
    const float4 point = vec(target.point.x, target.point.y, target.point.z);
    if (target.kind == TARGET_WORLD) return to_model(s->control, point);
    if (target.kind == TARGET_DIRECTION)
        return add_scaled(from, direction_to_model(s->control, point), TARGET_FAR_M);
    if (target.kind == TARGET_WATCHED) {
        __global const float4 *rows = s->tables->watched_before + target.watched * WATCHED_ELEMENTS;
        const float4 a = rows[0];
        const float4 place = vec(a.w + point.x, rows[1].w + point.y, rows[2].w + point.z);
        // Positions that are not finite fail this test and count as never seen.
        if (a.x * a.x + a.y * a.y + a.z * a.z > 0.0f && vec_dot(place, place) < 1e30f)
            return to_model(s->control, place);
        *weight = 0.0f;
        return from;
    }
    return point;
}

// Returns a target of one of the member's constraints.
INLINE Target target_of(const Solver *s, __global const Constraint *constraint, uint nth)
{
    return s->tables->targets[s->control->target_first + constraint->target_first + nth];
}

// Returns the weighted mean of all targets, and their total weight, at most 1.
INLINE float4 goal(const Solver *s, __global const Constraint *constraint, float4 from,
                   float *weight)
{
    float4 sum = vec(0.0f, 0.0f, 0.0f);
    float total = 0.0f;
    for (uint t = 0; t < constraint->target_count; t++) {
        float own;
        const float4 place = sight(s, target_of(s, constraint, t), from, &own);
        if (own <= 0.0f) continue;
        sum = add_scaled(sum, place, own);
        total += own;
    }
    *weight = total < 1.0f ? total : 1.0f;
    if (total > 0.0f) return sum * (1.0f / total);
    *weight = 0.0f;
    return from;
}
