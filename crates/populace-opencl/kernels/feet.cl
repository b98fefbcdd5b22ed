/* feet.cl - feet that keep to the ground, and the pelvis that sinks for them. Twin of populace-native controls/feet.rs. */

/* The last sample at or before a place on a grid that has one after it; *between is how far it is to that. */
INLINE uint grid_sample(float at, uint count, float *between)
{
    const float last = (float)(count - 1), inside = at > 0.0f ? (at < last ? at : last) : 0.0f;
    const uint whole = min((uint)inside, count - 2);
    *between = inside - (float)whole;
    return whole;
}

/* The ground's upward normal and, as w, its height at a place in the world. */
INLINE float4 ground_at(const Controls *of, float x, float z)
{
    const Ground ground = *of->ground;
    float height = ground.offset + ground.slope_x * x + ground.slope_z * z;
    float slope_x = ground.slope_x, slope_z = ground.slope_z;
    if (ground.per_metre > 0.0f) {
        float fraction_x, fraction_z;
        const uint column = grid_sample((x - ground.grid_x) * ground.per_metre, ground.count_x, &fraction_x);
        const uint row = grid_sample((z - ground.grid_z) * ground.per_metre, ground.count_z, &fraction_z);
        __global const float *at = of->heights + row * ground.count_x + column;
        const float h00 = at[0], h10 = at[1], h01 = at[ground.count_x], h11 = at[ground.count_x + 1];
        const float near = h00 + (h10 - h00) * fraction_x, far = h01 + (h11 - h01) * fraction_x;
        height += near + (far - near) * fraction_z;
        slope_x += ((h10 - h00) + ((h11 - h01) - (h10 - h00)) * fraction_z) * ground.per_metre;
        slope_z += (far - near) * ground.per_metre;
    }
    const float4 normal = unit_or(vec(-slope_x, 1.0f, -slope_z), vec(0.0f, 1.0f, 0.0f));
    return (float4)(normal.xyz, height);
}

/* Where a foot's ankle goes, in model space; *follows is the ground's normal there and how much the foot follows it. `left`
 * is what the foot left behind: where it is planted, or how far it is behind where the clip has it. */
INLINE float4 footing(const Steering *s, uint foot, __global const Constraint *constraint, float4 ankle, float4 left,
                      float4 *follows)
{
    const float rest = constraint->up.x, planted_below = constraint->up.y, lifted_above = constraint->up.z;
    const float size = s->control.place.w, held_most = constraint->up.w * size;
    const float4 clip = to_world(s->control, ankle);
    const uint bits = as_uint(left.w);
    const bool ours = bits >> 1 == s->control.epoch, was_planted = ours && (bits & 1u);
    const float4 kept = ours ? vec(left.x, left.y, left.z) : vec(0.0f, 0.0f, 0.0f);
    float4 behind = was_planted ? kept - clip : kept * (1.0f / (1.0f + s->of->elapsed_secs * (1.0f / 0.06f)));
    behind.y = 0.0f;
    bool stays = was_planted;
    const float far2 = vec_dot(behind, behind), held2 = held_most * held_most;
    if (far2 > 4.0f * held2) { /* the member was put elsewhere */
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
    s->of->states[s->index * STATES_PER_CONTROL + foot] = (float4)(keep.xyz, as_float(s->control.epoch << 1 | (planted ? 1u : 0u)));

    const float4 ground = ground_at(s->of, place.x, place.z);
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

/* As many legs as there are lanes: where each goes, the ground's normal there with how much its foot follows it, and what
 * its constraint says. */
typedef struct { Limb limb; Quat follows; Real soft, weight; } Legs;

#define LEGS_MOST ((BATCH * FEET_MOST + LANES - 1) / LANES)

/* A leg as the clips have it, in model space. */
typedef struct { float4 hip, knee, ankle, bend; } Leg;

/* Down a leg's chain from link `start`, whose joint's model transform is `from`. */
INLINE Leg walk_leg(const Steering *s, Hierarchy joints, __global const Constraint *constraint, uint start, float16 from)
{
    Leg leg;
    leg.hip = leg.knee = leg.bend = vec(0.0f, 0.0f, 0.0f);
    for (uint at = start; at < constraint->link_count; at++) {
        if (at > start) from = affine_mul(from, local_of(joints, s->of->links[constraint->link_first + at].joint));
        if (at == constraint->upper) {
            leg.hip = origin_of(from);
            leg.bend = transform_vector(from, constraint->axis);
        }
        if (at == constraint->middle) leg.knee = origin_of(from);
    }
    leg.ankle = origin_of(from);
    return leg;
}

/* Nothing in lanes where no leg stands. */
INLINE void clear_legs(Legs *legs)
{
    legs->limb = no_limb();
    legs->follows = quat_identity();
    legs->soft = legs->weight = 0.0f;
}

/* A leg put into a lane: its ankle is to come to `goes_to`. */
INLINE void put_leg(Legs *legs, uint lane, Leg leg, __global const Constraint *constraint, float4 goes_to, float4 follows)
{
    put_limb(&legs->limb, lane, leg.knee - leg.hip, leg.ankle - leg.knee, leg.bend, goes_to - leg.hip);
    PUT(legs->follows.x, lane, follows.x);
    PUT(legs->follows.y, lane, follows.y);
    PUT(legs->follows.z, lane, follows.z);
    PUT(legs->follows.w, lane, follows.w);
    PUT(legs->soft, lane, constraint->limits.x);
    PUT(legs->weight, lane, constraint->limits.y);
}

/* How far the pelvis has to sink so that each leg gets where it goes. */
INLINE Real sinks(Limb limb, Real soft)
{
    const Real length = square_root(vec3_dot(limb.upper, limb.upper)) + square_root(vec3_dot(limb.lower, limb.lower));
    const Real reach = length * (1.0f - soft), most = length * 0.5f;
    const Vec3 to = limb.to;
    const Real needed = -to.y - square_root(reach * reach - to.x * to.x - to.z * to.z);
    return needed > most ? most : needed;
}

/* The turns of hips, knees and ankles. */
typedef struct { Quat hip, knee, ankle; } LegTurns;

INLINE LegTurns leg_turns(const Legs *legs)
{
    const Vec3 no_pole = { 0.0f, 0.0f, 0.0f };
    LegTurns turns;
    limb_turns(legs->limb, no_pole, 0, legs->soft, &turns.hip, &turns.knee);
    const Choice partly = legs->weight < (Real)(1.0f);
    turns.hip = quat_choose(partly, quat_part(turns.hip, legs->weight), turns.hip);
    turns.knee = quat_choose(partly, quat_part(turns.knee, legs->weight), turns.knee);
    /* The ankle keeps the rotation that the clips give it, and follows the slope: the turn from upwards to the normal. */
    const Quat follows = legs->follows, tilt = { follows.z, 0.0f, -follows.x, 1.0f + follows.y };
    const Quat slope = quat_normalize_or(tilt, quat_identity());
    const Quat part = quat_part_as_told(slope, follows.w * legs->weight);
    turns.ankle = quat_mul(part, quat_conjugate(quat_mul(turns.knee, turns.hip)));
    return turns;
}

INLINE void hand_down(const Stop *at, uint foot, LegTurns turns, uint lane)
{
    TURNS float4 *to = at->s->turns + at->step.turn + 3 * foot;
    to[0] = quat_in(turns.hip, lane);
    to[1] = quat_in(turns.knee, lane);
    to[2] = quat_in(turns.ankle, lane);
}

/* Finds where a member's feet go, and puts its legs into lanes from `next` on; returns the lane after them. Where the feet
 * go is handed down, for legs that something else moves after the pelvis. */
INLINE uint put_feet(Legs *legs, uint next, const Stop *at, uint feet, const float4 *left)
{
    for (uint foot = 0; foot < feet; foot++, next++) {
        __global const Constraint *constraint = at->s->of->constraints + at->step.index + foot;
        const Leg leg = walk_leg(at->s, at->joints, constraint, 0, at->own);
        float4 follows;
        const float4 goes_to = footing(at->s, foot, constraint, leg.ankle, left[foot], &follows);
        put_leg(&legs[next / LANES], next % LANES, leg, constraint, goes_to, follows);
        TURNS float4 *turns = at->s->turns + at->step.turn + 3 * foot;
        turns[0] = goes_to;
        turns[1] = follows;
    }
    return next;
}

/* Lets a member's pelvis sink for its legs, of which the first stands in lane `next`; returns the lane after them. */
INLINE uint sink(Legs *legs, const Real *needed, uint next, Stop *at, __global const Constraint *first)
{
    float drop = 0.0f;
    for (uint leg = next; leg < next + first->target_count; leg++)
        drop = max(drop, LANE(needed[leg / LANES], leg % LANES));
    drop *= first->limits.y;
    at->own.s7 -= drop;
    for (uint foot = 0; foot < first->target_count; foot++, next++)
        PUT(legs[next / LANES].limb.to.y, next % LANES, LANE(legs[next / LANES].limb.to.y, next % LANES) + drop);
    return next;
}

APART_STEP void pelvises(Stop *at, uint count)
{
    Legs legs[LEGS_MOST];
    Real needed[LEGS_MOST];
    LegTurns turns[LEGS_MOST];
    uint all = 0, next = 0;
    for (uint i = 0; i < LEGS_MOST; i++) clear_legs(&legs[i]);
    /* What all feet left behind comes from far: asked for at once it is waited for once. */
    float4 left[BATCH][FEET_MOST];
    for (uint m = 0; m < count; m++)
        for (uint foot = 0; foot < FEET_MOST; foot++)
            left[m][foot] = at[m].s->of->states_before[at[m].s->index * STATES_PER_CONTROL + foot];
    for (uint m = 0; m < count; m++) all = put_feet(legs, all, at + m, constraint_of(at + m)->target_count, left[m]);
    for (uint i = 0; i * LANES < all; i++) needed[i] = sinks(legs[i].limb, legs[i].soft);
    for (uint m = 0; m < count; m++) next = sink(legs, needed, next, at + m, constraint_of(at + m));
    for (uint i = 0; i * LANES < all; i++) turns[i] = leg_turns(&legs[i]);
    next = 0;
    for (uint m = 0; m < count; m++) {
        __global const Constraint *first = constraint_of(at + m);
        for (uint foot = 0; foot < first->target_count; foot++, next++)
            if (first->at_once) hand_down(at + m, foot, turns[next / LANES], next % LANES);
    }
}

/* Legs that something else moves after the pelvis: they go where the pelvis found. */
APART_STEP void legs_alone(Stop *at, uint count)
{
    Legs legs;
    clear_legs(&legs);
    for (uint m = 0; m < count; m++) {
        __global const Constraint *constraint = constraint_of(at + m);
        const Leg leg = walk_leg(at[m].s, at[m].joints, constraint, constraint->upper, at[m].own);
        TURNS float4 *turns = at[m].s->turns + at[m].step.turn;
        put_leg(&legs, m, leg, constraint, turns[0], turns[1]);
    }
    const LegTurns turns = leg_turns(&legs);
    for (uint m = 0; m < count; m++) {
        hand_down(at + m, 0, turns, m);
        at[m].own = affine_turned(at[m].own, quat_in(turns.hip, m));
    }
}
