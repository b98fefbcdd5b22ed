// feet.cl - Foot IK: planted feet stay where they stand, and the pelvis sinks so that they reach
// it.
//
// Reads    local transforms of the legs; the goals of the feet
// Writes   the model transform of the pelvis or hip; step_rotations of hip, knee and ankle; the
//          states of feet and pelvis after this frame
//
// Twin of populace-native/src/constraints/feet.rs: same arithmetic, same order of operations.

// Legs in lanes: the limbs, in `follows` the ground's normal and how much the foot follows it, the
// turn of the foot, and the settings of their constraints.
typedef struct {
    Limb limb;
    Quat follows;
    Real turn, soft, weight;
} Legs;

#define MAX_LEGS ((BATCH * MAX_FEET + LANES - 1) / LANES)

// Walks a leg's chain from link `start`, whose joint has the model transform `from`.
INLINE Leg walk_leg(const Solver *s, Hierarchy joints, __global const Constraint *constraint,
                    uint start, float16 from)
{
    Leg leg;
    const uint ankle = ankle_link(constraint);
    leg.hip = leg.knee = leg.bend = vec(0.0f, 0.0f, 0.0f);
    leg.ankle = from;
    for (uint at = start; at < constraint->link_count; at++) {
        if (at > start)
            from = affine_mul(
                from, local_of(joints, s->tables->links[constraint->link_first + at].joint));
        if (at == constraint->upper) {
            leg.hip = origin_of(from);
            leg.bend = transform_vector(from, constraint->axis);
        }
        if (at == constraint->middle) leg.knee = origin_of(from);
        if (at == ankle) leg.ankle = from;
    }
    leg.toes = from;
    return leg;
}

// Fills unused lanes with an identity.
INLINE void clear_legs(Legs *legs)
{
    legs->limb = no_limb();
    legs->follows = quat_identity();
    legs->turn = legs->soft = legs->weight = 0.0f;
}

// Puts a leg into a lane, without its goal.
INLINE void put_leg(Legs *legs, uint lane, const Leg *leg, __global const Constraint *constraint)
{
    put_limb(&legs->limb, lane, leg->knee - leg->hip, origin_of(leg->ankle) - leg->knee, leg->bend,
             vec(0.0f, 0.0f, 0.0f));
    PUT(legs->soft, lane, constraint->limits.x);
    PUT(legs->weight, lane, constraint->limits.y);
}

// Gives legs their goals. `hip` are the places of their hips.
INLINE void bend_leg(Legs *legs, const FootGoals *goals, Vec3 hip)
{
    const Quat follows = { goals->normal.x, goals->normal.y, goals->normal.z, goals->near };
    legs->limb.to = vec3_add_scaled(goals->ankle, hip, -1.0f);
    legs->follows = follows;
    legs->turn = goals->turn;
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
    const Quat about = { 0.0f, legs->turn * legs->weight, 0.0f, 1.0f };
    const Quat turn = quat_normalize_or(about, quat_identity());
    rotations.ankle = quat_mul(quat_mul(part, turn),
                               quat_conjugate(quat_mul(rotations.knee, rotations.hip)));
    return rotations;
}

INLINE void hand_down(const YieldPoint *at, uint foot, LegRotations rotations, uint lane)
{
    STEP_ROTATIONS float4 *to = at->s->step_rotations + at->step.operand + 3 * foot;
    to[0] = quat_in(rotations.hip, lane);
    to[1] = quat_in(rotations.knee, lane);
    to[2] = quat_in(rotations.ankle, lane);
}

// Puts a member's legs and feet into lanes from `next` on. Returns the next free lane. `left` is the
// state of each foot after the previous frame.
INLINE uint put_feet(Legs *legs, FootInputs *inputs, uint next, const YieldPoint *at, uint feet,
                     const float4 (*left)[2])
{
    __global const Constraint *constraints = at->s->tables->constraints + at->step.index;
    uint ankles[MAX_FEET];
    float within_secs[MAX_FEET];
    for (uint foot = 0; foot < feet; foot++)
        ankles[foot] =
            at->s->tables->links[constraints[foot].link_first + ankle_link(constraints + foot)]
                .joint;
    contacts_of(at->s, ankles, feet, within_secs);
    for (uint foot = 0; foot < feet; foot++, next++) {
        __global const Constraint *constraint = constraints + foot;
        const Leg leg = walk_leg(at->s, at->joints, constraint, 0, at->own);
        const uint group = next / LANES, lane = next % LANES;
        put_leg(&legs[group], lane, &leg, constraint);
        put_foot(&inputs[group], lane, at->s, constraint, &leg, within_secs[foot], left[foot]);
    }
    return next;
}

// Keeps the states of a member's feet, the first of which is in lane `next`. Hands their goals down
// for legs that another step moves after the pelvis. Returns the lane after them.
INLINE uint keep_feet(const FootInputs *inputs, const FootGoals *goals, uint next,
                      const YieldPoint *at, __global const Constraint *first)
{
    for (uint foot = 0; foot < first->target_count; foot++, next++) {
        const uint group = next / LANES, lane = next % LANES;
        keep_foot_states(&inputs[group].state, lane, at->s, foot);
        if (first->at_once) continue;
        const FootGoals *goal = goals + group;
        STEP_ROTATIONS float4 *step_rotations = at->s->step_rotations + at->step.operand + 3 * foot;
        const float4 ankle = vec3_in(goal->ankle, lane), normal = vec3_in(goal->normal, lane);
        step_rotations[0] = (float4)(ankle.xyz, LANE(goal->turn, lane));
        step_rotations[1] = (float4)(normal.xyz, LANE(goal->near, lane));
    }
    return next;
}

// Returns how far the pelvis is lowered, in metres, and keeps it. It sinks at once, so that feet
// reach the ground, and takes its time to rise.
INLINE float eased_drop(const Solver *s, float wanted)
{
    const uint state = s->index * STATES_PER_CONTROL + PELVIS_STATE;
    const float4 left = s->tables->states_before[state];
    const float elapsed_secs = s->tables->elapsed_secs;
    const bool rises = wanted < left.x && as_uint(left.w) == s->control.epoch;
    const float drop =
        rises ? left.x + (wanted - left.x) * (elapsed_secs / (elapsed_secs + PELVIS_RISE_SECS))
              : wanted;
    s->tables->states[state] = (float4)(drop, 0.0f, 0.0f, as_float(s->control.epoch));
    return drop;
}

// Lowers a member's pelvis for its legs, the first of which is in lane `next`. Returns the lane
// after them.
INLINE uint sink(Legs *legs, const Real *needed, uint next, YieldPoint *at,
                 __global const Constraint *first)
{
    float drop = 0.0f;
    for (uint leg = next; leg < next + first->target_count; leg++)
        drop = max(drop, LANE(needed[leg / LANES], leg % LANES));
    drop = eased_drop(at->s, drop * first->limits.y);
    at->own.s7 -= drop;
    for (uint foot = 0; foot < first->target_count; foot++, next++)
        PUT(legs[next / LANES].limb.to.y, next % LANES,
            LANE(legs[next / LANES].limb.to.y, next % LANES) + drop);
    return next;
}

APART_STEP void pelvis(YieldPoint *at, uint count)
{
    Legs legs[MAX_LEGS];
    FootInputs inputs[MAX_LEGS];
    FootGoals goals[MAX_LEGS];
    Real needed[MAX_LEGS];
    LegRotations rotations[MAX_LEGS];
    uint all = 0, next = 0;
    for (uint i = 0; i < MAX_LEGS; i++) {
        clear_legs(&legs[i]);
        clear_feet(&inputs[i]);
    }
    // Load the previous state of all feet first, so that the cache misses overlap.
    float4 left[BATCH][MAX_FEET][2];
    for (uint m = 0; m < count; m++) {
        __global const float4 *before =
            at[m].s->tables->states_before + at[m].s->index * STATES_PER_CONTROL;
        for (uint foot = 0; foot < constraint_of(at + m)->target_count; foot++) {
            left[m][foot][0] = before[foot];
            left[m][foot][1] = before[FOOT_TURN_STATE + foot];
        }
    }
    for (uint m = 0; m < count; m++)
        all = put_feet(legs, inputs, all, at + m, constraint_of(at + m)->target_count, left[m]);
    for (uint i = 0; i * LANES < all; i++) {
        goals[i] = foot_goal(at->s->tables, &inputs[i]);
        bend_leg(&legs[i], &goals[i], inputs[i].hip);
        needed[i] = sinks(legs[i].limb, legs[i].soft);
    }
    for (uint m = 0; m < count; m++)
        next = keep_feet(inputs, goals, next, at + m, constraint_of(at + m));
    next = 0;
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
    FootGoals goals;
    const Vec3 none = { 0.0f, 0.0f, 0.0f };
    Vec3 hips = none;
    clear_legs(&legs);
    goals.ankle = goals.normal = none;
    goals.turn = goals.near = 0.0f;
    for (uint m = 0; m < count; m++) {
        __global const Constraint *constraint = constraint_of(at + m);
        const Leg leg = walk_leg(at[m].s, at[m].joints, constraint, constraint->upper, at[m].own);
        STEP_ROTATIONS float4 *step_rotations = at[m].s->step_rotations + at[m].step.operand;
        put_leg(&legs, m, &leg, constraint);
        put_vec3(&hips, m, leg.hip);
        put_vec3(&goals.ankle, m, step_rotations[0]);
        put_vec3(&goals.normal, m, step_rotations[1]);
        PUT(goals.turn, m, step_rotations[0].w);
        PUT(goals.near, m, step_rotations[1].w);
    }
    bend_leg(&legs, &goals, hips);
    const LegRotations rotations = leg_rotations(&legs);
    for (uint m = 0; m < count; m++) {
        hand_down(at + m, 0, rotations, m);
        at[m].own = affine_rotated(at[m].own, quat_in(rotations.hip, m));
    }
}
