// chain.cl - Inverse kinematics of chains of any length, by FABRIK (Aristidou & Lasenby 2011).
//
// Reads    local transforms of the chain; targets
// Writes   the model transform of the first joint; one of step_rotations for each further joint
//
// Twin of populace-native/src/constraints/chain.rs: same arithmetic, same order of operations.

// Moves `from` along the line through `to` until it is `length` away from `to`.
INLINE float4 drawn(float4 to, float4 from, float length)
{
    return add_scaled(to, unit_or(from - to, vec(0.0f, 1.0f, 0.0f)), length);
}

APART_STEP float16 chain(const Solver *s, Hierarchy joints, Step step, float16 own)
{
    __global const Constraint *constraint = s->tables->constraints + step.index;
    const uint last = constraint->link_count - 1;
    float4 places[MAX_LINKS], points[MAX_LINKS];
    float lengths[MAX_LINKS], total = 0.0f, weight;
    walk(s, joints, constraint, own, places);
    for (uint at = 0; at < last; at++) {
        lengths[at] = vec_length(places[at + 1] - places[at]);
        total += lengths[at];
    }
    const float4 target = goal(s, constraint, places[0], &weight), to = target - places[0];
    const float distance = vec_length(to);
    for (uint at = 0; at <= last; at++) points[at] = places[at];
    if (weight > 0.0f && total > 1e-6f && distance > 1e-6f) {
        const Real softened = soft_distance(distance, total, 0.0f, constraint->limits.x);
        const float far = LANE(softened, 0);
        const float4 reached = add_scaled(places[0], to, far / distance);
        for (uint pass = 0; pass < CHAIN_PASSES; pass++) {
            points[last] = reached;
            for (uint at = last; at-- > 0;)
                points[at] = drawn(points[at + 1], points[at], lengths[at]);
            points[0] = places[0];
            for (uint at = 0; at < last; at++)
                points[at + 1] = drawn(points[at], points[at + 1], lengths[at]);
        }
    }
    float4 rotated_by = IDENTITY_ROTATION;
    float16 result = own;
    for (uint at = 0; at < last; at++) {
        const float4 was =
            unit_or(rotated(rotated_by, places[at + 1] - places[at]), vec(0.0f, 0.0f, 0.0f));
        const float4 is = unit_or(points[at + 1] - points[at], was);
        const float4 rotation = part_of(rotation_between(was, is, any_across(is)), weight);
        if (at == 0) result = affine_rotated(own, rotation);
        else s->step_rotations[step.operand + at - 1] = rotation;
        rotated_by = rotation_mul(rotation, rotated_by);
    }
    s->step_rotations[step.operand + last - 1] = IDENTITY_ROTATION;
    return result;
}
