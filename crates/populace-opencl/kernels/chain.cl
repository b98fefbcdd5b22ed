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

// Computes the origins of the joints of the chain of the member in a lane.
INLINE void walk_in(const Stop *at, uint lane, __global const Constraint *constraint, float16 from,
                    float4 *places)
{
    places[0] = origin_of(from);
    for (uint link = 1; link < constraint->link_count; link++) {
        const uint joint = at->members->tables->links[constraint->link_first + link].joint;
        from = affine_mul(from, local_in(at->joints, joint, lane));
        places[link] = origin_of(from);
    }
}

// Bends the chain of the member in a lane, and returns the first joint's model transform.
APART_STEP float16 chain(const Stop *at, uint lane, float16 own)
{
    const Solver *s = at->members + lane;
    __global const Constraint *constraint = constraint_in(at, lane);
    const uint operand = at->step.operand;
    const uint last = constraint->link_count - 1;
    float4 places[MAX_LINKS], points[MAX_LINKS];
    float lengths[MAX_LINKS], total = 0.0f, weight;
    walk_in(at, lane, constraint, own, places);
    for (uint link = 0; link < last; link++) {
        lengths[link] = vec_length(places[link + 1] - places[link]);
        total += lengths[link];
    }
    const float4 target = goal(s, constraint, places[0], &weight), to = target - places[0];
    const float distance = vec_length(to);
    for (uint link = 0; link <= last; link++) points[link] = places[link];
    if (weight > 0.0f && total > 1e-6f && distance > 1e-6f) {
        const Real softened = soft_distance(distance, total, 0.0f, constraint->limits.x);
        const float far = LANE(softened, 0);
        const float4 reached = add_scaled(places[0], to, far / distance);
        for (uint pass = 0; pass < CHAIN_PASSES; pass++) {
            points[last] = reached;
            for (uint link = last; link-- > 0;)
                points[link] = drawn(points[link + 1], points[link], lengths[link]);
            points[0] = places[0];
            for (uint link = 0; link < last; link++)
                points[link + 1] = drawn(points[link], points[link + 1], lengths[link]);
        }
    }
    float4 rotated_by = IDENTITY_ROTATION;
    float16 result = own;
    for (uint link = 0; link < last; link++) {
        const float4 was =
            unit_or(rotated(rotated_by, places[link + 1] - places[link]), vec(0.0f, 0.0f, 0.0f));
        const float4 is = unit_or(points[link + 1] - points[link], was);
        const float4 rotation = part_of(rotation_between(was, is, any_across(is)), weight);
        if (link == 0) result = affine_rotated(own, rotation);
        else hand_rotation_in(at->rotations, operand + link - 1, lane, rotation);
        rotated_by = rotation_mul(rotation, rotated_by);
    }
    hand_rotation_in(at->rotations, operand + last - 1, lane, IDENTITY_ROTATION);
    return result;
}
