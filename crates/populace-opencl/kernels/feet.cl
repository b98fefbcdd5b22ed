// feet.cl - Foot IK: feet follow the ground and stay where they are planted, and the pelvis sinks
// so that they reach it.
//
// Reads    local transforms of the legs; the ground; each foot's state after the previous frame
// Writes   the model transform of the pelvis or hip; step_rotations of hip, knee and ankle;
//          the state of each foot after this frame
//
// Twin of populace-native/src/constraints/feet.rs: same arithmetic, same order of operations.

// Returns the index of the last grid sample at or before `at` that has a successor. *between is the
// fraction of the way to that successor.
INLINE uint grid_sample(float at, uint count, float *between)
{
    const float last = (float)(count - 1), inside = at > 0.0f ? (at < last ? at : last) : 0.0f;
    const uint whole = min((uint)inside, count - 2);
    *between = inside - (float)whole;
    return whole;
}

// Returns the ground's unit normal in x, y, z and its height in w, at a point of the world.
INLINE float4 ground_at(const ConstraintTables *tables, float x, float z)
{
    const Ground ground = *tables->ground;
    float height = ground.offset + ground.slope_x * x + ground.slope_z * z;
    float slope_x = ground.slope_x, slope_z = ground.slope_z;
    if (ground.per_metre > 0.0f) {
        float fraction_x, fraction_z;
        const uint column =
            grid_sample((x - ground.grid_x) * ground.per_metre, ground.count_x, &fraction_x);
        const uint row =
            grid_sample((z - ground.grid_z) * ground.per_metre, ground.count_z, &fraction_z);
        __global const float *at = tables->heights + row * ground.count_x + column;
        const float h00 = at[0], h10 = at[1], h01 = at[ground.count_x],
                    h11 = at[ground.count_x + 1];
        const float near = h00 + (h10 - h00) * fraction_x, far = h01 + (h11 - h01) * fraction_x;
        height += near + (far - near) * fraction_z;
        slope_x += ((h10 - h00) + ((h11 - h01) - (h10 - h00)) * fraction_z) * ground.per_metre;
        slope_z += (far - near) * ground.per_metre;
    }
    const float4 normal = unit_or(vec(-slope_x, 1.0f, -slope_z), vec(0.0f, 1.0f, 0.0f));
    return (float4)(normal.xyz, height);
}

// Returns where the ankle goes, in model space. *follows holds the ground's normal there and, in w,
// how much the foot follows it. `left` is the foot's state after the previous frame: where it is
// planted, or its offset from the clip.
INLINE float4 foot_goal(const Solver *s, uint foot, __global const Constraint *constraint,
                      float4 ankle, float4 left, float4 *follows)
{
    const float rest = constraint->up.x, planted_below = constraint->up.y,
                lifted_above = constraint->up.z;
    const float size = s->control.place.w, held_most = constraint->up.w * size;
    const float4 clip = to_world(s->control, ankle);
    const uint bits = as_uint(left.w);
    const bool ours = bits >> 1 == s->control.epoch, was_planted = ours && (bits & 1u);
    const float4 kept = ours ? vec(left.x, left.y, left.z) : vec(0.0f, 0.0f, 0.0f);
    float4 behind = was_planted
                        ? kept - clip
                        : kept
                              * (1.0f
                                 / (1.0f
                                    + s->tables->elapsed_secs * (1.0f / FOOT_RELEASE_SECS)));
    behind.y = 0.0f;
    bool stays = was_planted;
    const float far2 = vec_dot(behind, behind), held2 = held_most * held_most;
    if (far2 > 4.0f * held2) { // the member was teleported
        behind = vec(0.0f, 0.0f, 0.0f);
        stays = false;
    } else if (far2 > held2) {
        behind = behind * (held_most * inverse_root(far2));
        stays = false;
    }
    float lift = ankle.y - rest;
    const bool planted = lift <= planted_below;
    const float4 place = planted && stays ? kept : clip + behind;
    const float4 keep = planted ? place : behind;
    s->tables->states[s->index * STATES_PER_CONTROL + foot] =
        (float4)(keep.xyz, as_float(s->control.epoch << 1 | (planted ? 1u : 0u)));

    const float4 ground = ground_at(s->tables, place.x, place.z);
    const float between = (lift - planted_below) / (lifted_above - planted_below);
    float slope = 0.0f;
    if (planted) {
        lift = 0.0f;
        slope = 1.0f;
    } else if (lift < lifted_above) {
        lift = between * lifted_above;
        slope = 1.0f - between;
    }
    const float4 normal = direction_to_model(s->control, ground);
    *follows = (float4)(normal.xyz, slope);
    return to_model(s->control, vec(place.x, ground.w + (rest / ground.y + lift) * size, place.z));
}

// Legs in lanes: the limbs, in `follows` the ground's normal and how much the foot follows it, and
// the settings of their constraints.
typedef struct {
    Limb limb;
    Quat follows;
    Real soft, weight;
} Legs;

#define MAX_LEGS ((BATCH * MAX_FEET + LANES - 1) / LANES)

// A leg as its clips pose it, in model space.
typedef struct {
    float4 hip, knee, ankle, bend;
} Leg;

// Walks a leg's chain from link `start`, whose joint has the model transform `from`.
INLINE Leg walk_leg(const Solver *s, Hierarchy joints, __global const Constraint *constraint,
                    uint start, float16 from)
{
    Leg leg;
    leg.hip = leg.knee = leg.bend = vec(0.0f, 0.0f, 0.0f);
    for (uint at = start; at < constraint->link_count; at++) {
        if (at > start)
            from = affine_mul(
                from, local_of(joints, s->tables->links[constraint->link_first + at].joint));
        if (at == constraint->upper) {
            leg.hip = origin_of(from);
            leg.bend = transform_vector(from, constraint->axis);
        }
        if (at == constraint->middle) leg.knee = origin_of(from);
    }
    leg.ankle = origin_of(from);
    return leg;
}

// Fills unused lanes with an identity.
INLINE void clear_legs(Legs *legs)
{
    legs->limb = no_limb();
    legs->follows = quat_identity();
    legs->soft = legs->weight = 0.0f;
}

// Puts a leg into a lane. Its ankle goes to `goes_to`.
INLINE void put_leg(Legs *legs, uint lane, Leg leg, __global const Constraint *constraint,
                    float4 goes_to, float4 follows)
{
    put_limb(&legs->limb, lane, leg.knee - leg.hip, leg.ankle - leg.knee, leg.bend,
             goes_to - leg.hip);
    PUT(legs->follows.x, lane, follows.x);
    PUT(legs->follows.y, lane, follows.y);
    PUT(legs->follows.z, lane, follows.z);
    PUT(legs->follows.w, lane, follows.w);
    PUT(legs->soft, lane, constraint->limits.x);
    PUT(legs->weight, lane, constraint->limits.y);
}

// Returns how far the pelvis has to sink for each leg to reach its goal.
INLINE Real sinks(Limb limb, Real soft)
{
    const Real length = square_root(vec3_dot(limb.upper, limb.upper))
                        + square_root(vec3_dot(limb.lower, limb.lower));
    const Real reach = length * (1.0f - soft), most = length * MAX_PELVIS_SINK;
    const Vec3 to = limb.to;
    const Real needed = -to.y - square_root(reach * reach - to.x * to.x - to.z * to.z);
    return needed > most ? most : needed;
}

// Rotations of hips, knees and ankles.
typedef struct {
    Quat hip, knee, ankle;
} LegRotations;

INLINE LegRotations leg_rotations(const Legs *legs)
{
    const Vec3 no_pole = { 0.0f, 0.0f, 0.0f };
    LegRotations rotations;
    limb_rotations(legs->limb, no_pole, 0, legs->soft, &rotations.hip, &rotations.knee);
    const Choice partly = legs->weight < (Real)(1.0f);
    rotations.hip = quat_choose(partly, quat_part(rotations.hip, legs->weight), rotations.hip);
    rotations.knee = quat_choose(partly, quat_part(rotations.knee, legs->weight), rotations.knee);
    // The ankle keeps the rotation of its clips and follows the slope: the rotation from straight
    // up to the normal.
    const Quat follows = legs->follows, tilt = { follows.z, 0.0f, -follows.x, 1.0f + follows.y };
    const Quat slope = quat_normalize_or(tilt, quat_identity());
    const Quat part = quat_part_as_told(slope, follows.w * legs->weight);
    rotations.ankle = quat_mul(part, quat_conjugate(quat_mul(rotations.knee, rotations.hip)));
    return rotations;
}

INLINE void hand_down(const YieldPoint *at, uint foot, LegRotations rotations, uint lane)
{
    STEP_ROTATIONS float4 *to = at->s->step_rotations + at->step.operand + 3 * foot;
    to[0] = quat_in(rotations.hip, lane);
    to[1] = quat_in(rotations.knee, lane);
    to[2] = quat_in(rotations.ankle, lane);
}

// Finds where a member's feet go and puts its legs into lanes from `next` on. Returns the next free
// lane. The goals are also handed down, for legs that another step moves after the pelvis.
INLINE uint put_feet(Legs *legs, uint next, const YieldPoint *at, uint feet, const float4 *left)
{
    for (uint foot = 0; foot < feet; foot++, next++) {
        __global const Constraint *constraint = at->s->tables->constraints + at->step.index + foot;
        const Leg leg = walk_leg(at->s, at->joints, constraint, 0, at->own);
        float4 follows;
        const float4 goes_to = foot_goal(at->s, foot, constraint, leg.ankle, left[foot], &follows);
        put_leg(&legs[next / LANES], next % LANES, leg, constraint, goes_to, follows);
        STEP_ROTATIONS float4 *step_rotations = at->s->step_rotations + at->step.operand + 3 * foot;
        step_rotations[0] = goes_to;
        step_rotations[1] = follows;
    }
    return next;
}

// Lowers a member's pelvis for its legs, the first of which is in lane `next`. Returns the lane
// after them.
INLINE uint sink(Legs *legs, const Real *needed, uint next, YieldPoint *at,
                 __global const Constraint *first)
{
    float drop = 0.0f;
    for (uint leg = next; leg < next + first->target_count; leg++)
        drop = max(drop, LANE(needed[leg / LANES], leg % LANES));
    drop *= first->limits.y;
    at->own.s7 -= drop;
    for (uint foot = 0; foot < first->target_count; foot++, next++)
        PUT(legs[next / LANES].limb.to.y, next % LANES,
            LANE(legs[next / LANES].limb.to.y, next % LANES) + drop);
    return next;
}

APART_STEP void pelvis(YieldPoint *at, uint count)
{
    Legs legs[MAX_LEGS];
    Real needed[MAX_LEGS];
    LegRotations rotations[MAX_LEGS];
    uint all = 0, next = 0;
    for (uint i = 0; i < MAX_LEGS; i++) clear_legs(&legs[i]);
    // Load the previous state of all feet first, so that the cache misses overlap.
    float4 left[BATCH][MAX_FEET];
    for (uint m = 0; m < count; m++)
        for (uint foot = 0; foot < MAX_FEET; foot++)
            left[m][foot] =
                at[m].s->tables->states_before[at[m].s->index * STATES_PER_CONTROL + foot];
    for (uint m = 0; m < count; m++)
        all = put_feet(legs, all, at + m, constraint_of(at + m)->target_count, left[m]);
    for (uint i = 0; i * LANES < all; i++) needed[i] = sinks(legs[i].limb, legs[i].soft);
    for (uint m = 0; m < count; m++) next = sink(legs, needed, next, at + m, constraint_of(at + m));
    for (uint i = 0; i * LANES < all; i++) rotations[i] = leg_rotations(&legs[i]);
    next = 0;
    for (uint m = 0; m < count; m++) {
        __global const Constraint *first = constraint_of(at + m);
        for (uint foot = 0; foot < first->target_count; foot++, next++)
            if (first->at_once) hand_down(at + m, foot, rotations[next / LANES], next % LANES);
    }
}

// Solves legs that another step moved after the pelvis. They go where the pelvis step found.
APART_STEP void foot(YieldPoint *at, uint count)
{
    Legs legs;
    clear_legs(&legs);
    for (uint m = 0; m < count; m++) {
        __global const Constraint *constraint = constraint_of(at + m);
        const Leg leg = walk_leg(at[m].s, at[m].joints, constraint, constraint->upper, at[m].own);
        STEP_ROTATIONS float4 *step_rotations = at[m].s->step_rotations + at[m].step.operand;
        put_leg(&legs, m, leg, constraint, step_rotations[0], step_rotations[1]);
    }
    const LegRotations rotations = leg_rotations(&legs);
    for (uint m = 0; m < count; m++) {
        hand_down(at + m, 0, rotations, m);
        at[m].own = affine_rotated(at[m].own, quat_in(rotations.hip, m));
    }
}
