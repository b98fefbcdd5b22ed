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

// A chain of the member in a lane. Until its rotations are known, step_rotations hold the points of
// the further joints, and in w the lengths of the bones that lead to them: arrays that a variable
// indexes would take a GPU's stack.
typedef struct {
    const Stop *at;
    uint lane;
    __global const Constraint *constraint;
} Chain;

// Takes the model transform of a joint of the chain to its next link, as the clips pose it.
INLINE float16 walk_in(Chain c, uint link, float16 from)
{
    const uint joint = c.at->members->tables->links[c.constraint->link_first + link].joint;
    return affine_mul(from, local_in(c.at->joints, joint, c.lane));
}

// Returns the point of a link after the first, and the length of the bone that leads to it.
INLINE float4 point_of(Chain c, uint link, float *length)
{
    const float4 kept = handed_rotation_in(c.at->rotations, c.at->step.operand + link - 1, c.lane);
    *length = kept.w;
    return vec(kept.x, kept.y, kept.z);
}

INLINE void keep_rotation(Chain c, uint link, float4 rotation)
{
    hand_rotation_in(c.at->rotations, c.at->step.operand + link - 1, c.lane, rotation);
}

INLINE void keep_point(Chain c, uint link, float4 point, float length)
{
    keep_rotation(c, link, (float4)(point.xyz, length));
}

// Keeps the chain's points as the clips pose them, and returns its length.
INLINE float keep_points(Chain c, uint last, float16 from)
{
    float total = 0.0f;
    float4 before = origin_of(from);
    for (uint link = 1; link <= last; link++) {
        from = walk_in(c, link, from);
        const float4 place = origin_of(from);
        const float length = vec_length(place - before);
        keep_point(c, link, place, length);
        total += length;
        before = place;
    }
    return total;
}

// Moves the points until the chain reaches from its start to an end.
INLINE void stretch_chain(Chain c, uint last, float4 start, float4 reached)
{
    for (uint pass = 0; pass < CHAIN_PASSES; pass++) {
        float length, own_length;
        float4 point = reached;
        point_of(c, last, &length);
        keep_point(c, last, point, length);
        for (uint link = last; --link > 0;) {
            const float4 own = point_of(c, link, &own_length);
            point = drawn(point, own, length);
            keep_point(c, link, point, own_length);
            length = own_length;
        }
        point = start;
        for (uint link = 1; link <= last; link++) {
            const float4 own = point_of(c, link, &length);
            point = drawn(point, own, length);
            keep_point(c, link, point, length);
        }
    }
}

// Bends the chain of the member in a lane, and returns the first joint's model transform.
SELDOM float16 chain(const Stop *at, uint lane, float16 own)
{
    const Chain c = { at, lane, constraint_in(at, lane) };
    const uint last = c.constraint->link_count - 1;
    const float4 start = origin_of(own);
    const float total = keep_points(c, last, own);
    float weight, length;
    const float4 to = goal(at->members + lane, c.constraint, start, &weight) - start;
    const float distance = vec_length(to);
    if (weight > 0.0f && total > 1e-6f && distance > 1e-6f) {
        const Real softened = soft_distance(distance, total, 0.0f, c.constraint->limits.x);
        stretch_chain(c, last, start, add_scaled(start, to, LANE(softened, 0) / distance));
    }
    float4 rotated_by = IDENTITY_ROTATION, posed = start, point = start;
    float16 from = own, result = own;
    for (uint link = 0; link < last; link++) {
        from = walk_in(c, link + 1, from);
        const float4 next_posed = origin_of(from), next = point_of(c, link + 1, &length);
        const float4 was = unit_or(rotated(rotated_by, next_posed - posed), vec(0.0f, 0.0f, 0.0f));
        const float4 is = unit_or(next - point, was);
        const float4 rotation = part_of(rotation_between(was, is, any_across(is)), weight);
        if (link == 0) result = affine_rotated(own, rotation);
        else keep_rotation(c, link, rotation);
        rotated_by = rotation_mul(rotation, rotated_by);
        posed = next_posed;
        point = next;
    }
    keep_rotation(c, last, IDENTITY_ROTATION);
    return result;
}
