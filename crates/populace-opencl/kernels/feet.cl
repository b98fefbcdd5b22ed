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
INLINE float4 ground_at(Controls of, float x, float z)
{
    const Ground ground = *of.ground;
    float height = ground.offset + ground.slope_x * x + ground.slope_z * z;
    float slope_x = ground.slope_x, slope_z = ground.slope_z;
    if (ground.per_metre > 0.0f) {
        float fraction_x, fraction_z;
        const uint column = grid_sample((x - ground.grid_x) * ground.per_metre, ground.count_x, &fraction_x);
        const uint row = grid_sample((z - ground.grid_z) * ground.per_metre, ground.count_z, &fraction_z);
        __global const float *at = of.heights + row * ground.count_x + column;
        const float h00 = at[0], h10 = at[1], h01 = at[ground.count_x], h11 = at[ground.count_x + 1];
        const float near = h00 + (h10 - h00) * fraction_x, far = h01 + (h11 - h01) * fraction_x;
        height += near + (far - near) * fraction_z;
        slope_x += ((h10 - h00) + ((h11 - h01) - (h10 - h00)) * fraction_z) * ground.per_metre;
        slope_z += (far - near) * ground.per_metre;
    }
    const float4 normal = unit_or(vec(-slope_x, 1.0f, -slope_z), vec(0.0f, 1.0f, 0.0f));
    return (float4)(normal.xyz, height);
}

/* Where a foot's ankle goes, in model space; *follows is the ground's normal there and how much the foot follows it. */
INLINE float4 footing(const Steering *s, uint foot, Constraint constraint, float4 ankle, float4 *follows)
{
    const float rest = constraint.up.x, planted_below = constraint.up.y, lifted_above = constraint.up.z;
    const float size = s->control.place.w, held_most = constraint.up.w * size;
    const float4 clip = to_world(s->control, ankle);
    /* What the foot left behind: where it is planted, or how far it is behind where the clip has it. */
    const uint element = s->index * STATES_PER_CONTROL + foot;
    const float4 left = s->of.states_before[element];
    const uint bits = as_uint(left.w);
    const bool ours = bits >> 1 == s->control.epoch, was_planted = ours && (bits & 1u);
    const float4 kept = ours ? vec(left.x, left.y, left.z) : vec(0.0f, 0.0f, 0.0f);
    float4 behind = was_planted ? kept - clip : kept * (1.0f / (1.0f + s->of.elapsed_secs * (1.0f / 0.06f)));
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
    s->of.states[element] = (float4)(keep.xyz, as_float(s->control.epoch << 1 | (planted ? 1u : 0u)));

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

/* As many legs as there are lanes: where each goes, and the ground's normal there with how much its foot follows it. */
typedef struct { Limb limb; Quat follows; } Legs;

#define LEGS_MOST ((FEET_MOST + LANES - 1) / LANES)

/* A leg as the clips have it, in model space. */
typedef struct { float4 hip, knee, ankle, bend; } Leg;

/* Down a leg's chain from link `start`, whose joint's model transform is `from`. */
INLINE Leg walk_leg(const Steering *s, Hierarchy joints, Constraint constraint, uint start, float16 from)
{
    Leg leg;
    leg.hip = leg.knee = leg.bend = vec(0.0f, 0.0f, 0.0f);
    for (uint at = start; at < constraint.link_count; at++) {
        if (at > start) from = affine_mul(from, local_of(joints, s->of.links[constraint.link_first + at].joint));
        if (at == constraint.upper) {
            leg.hip = origin_of(from);
            leg.bend = transform_vector(from, constraint.axis);
        }
        if (at == constraint.middle) leg.knee = origin_of(from);
    }
    leg.ankle = origin_of(from);
    return leg;
}

INLINE Legs no_legs(void)
{
    const Legs legs = { { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } },
                        { 0.0f, 0.0f, 0.0f, 0.0f } };
    return legs;
}

/* With a leg put into a lane: its ankle is to come to `goes_to`. */
INLINE Legs with_leg(Legs legs, uint lane, Leg leg, float4 goes_to, float4 follows)
{
    const Quat own = { follows.x, follows.y, follows.z, follows.w };
    legs.limb = with_limb(legs.limb, lane, leg.knee - leg.hip, leg.ankle - leg.knee, leg.bend, goes_to - leg.hip);
    legs.follows = quat_choose(ONLY(lane), own, legs.follows);
    return legs;
}

/* How far the pelvis has to sink so that each leg gets where it goes. */
INLINE Real sinks(Limb limb, float soft)
{
    const Real length = square_root(vec3_dot(limb.upper, limb.upper)) + square_root(vec3_dot(limb.lower, limb.lower));
    const Real reach = length * (1.0f - soft), most = length * 0.5f;
    const Vec3 to = limb.to;
    const Real needed = -to.y - square_root(reach * reach - to.x * to.x - to.z * to.z);
    return needed > most ? most : needed;
}

/* Solves legs, and writes the turns of hips, knees and ankles, three for each leg, for what stands in the first lanes. */
INLINE void step_with(const Steering *s, Legs legs, Constraint constraint, uint turn, uint count)
{
    const float weight = constraint.limits.y;
    Quat hip, knee;
    limb_turns(legs.limb, vec(0.0f, 0.0f, 0.0f), constraint.limits.x, &hip, &knee);
    if (weight < 1.0f) {
        hip = quat_part(hip, weight);
        knee = quat_part(knee, weight);
    }
    /* The ankle keeps the rotation that the clips give it, and follows the slope: the turn from upwards to the normal. */
    const Quat follows = legs.follows, tilt = { follows.z, 0.0f, -follows.x, 1.0f + follows.y };
    const Quat slope = quat_normalize_or(tilt, quat_identity()), part = quat_mix(quat_identity(), slope, follows.w * weight);
    const Quat ankle = quat_mul(quat_normalize_or(part, quat_identity()), quat_conjugate(quat_mul(knee, hip)));
    for (uint lane = 0; lane < count; lane++, turn += 3) {
        s->turns[turn] = turn_in(hip, lane);
        s->turns[turn + 1] = turn_in(knee, lane);
        s->turns[turn + 2] = turn_in(ankle, lane);
    }
}

APART_STEP float16 pelvis(const Steering *s, Hierarchy joints, Step step, float16 own)
{
    const Constraint first = s->of.constraints[step.index];
    Legs legs[LEGS_MOST];
    for (uint i = 0; i < LEGS_MOST; i++) legs[i] = no_legs();
    float drop = 0.0f;
    for (uint foot = 0; foot < first.target_count; foot++) {
        const Constraint constraint = s->of.constraints[step.index + foot];
        const Leg leg = walk_leg(s, joints, constraint, 0, own);
        float4 follows;
        const float4 goes_to = footing(s, foot, constraint, leg.ankle, &follows);
        legs[foot / LANES] = with_leg(legs[foot / LANES], foot % LANES, leg, goes_to, follows);
        s->turns[step.turn + 3 * foot] = goes_to;
        s->turns[step.turn + 3 * foot + 1] = follows;
    }
    for (uint i = 0; i < LEGS_MOST; i++) {
        const Real needed = sinks(legs[i].limb, first.limits.x);
        for (uint foot = i * LANES; foot < min((i + 1) * LANES, first.target_count); foot++)
            drop = LANE(needed, foot % LANES) > drop ? LANE(needed, foot % LANES) : drop;
    }
    drop *= first.limits.y;
    own.s7 -= drop;
    for (uint i = 0; i < LEGS_MOST && first.at_once; i++) {
        legs[i].limb.to.y += drop;
        const uint begin = i * LANES, end = min(begin + LANES, first.target_count);
        if (begin < end) step_with(s, legs[i], first, step.turn + 3 * begin, end - begin);
    }
    return own;
}

/* A leg that something else moves after the pelvis: it goes where the pelvis found. */
APART_STEP float16 foot(const Steering *s, Hierarchy joints, Step step, float16 own)
{
    const Constraint constraint = s->of.constraints[step.index];
    const Leg leg = walk_leg(s, joints, constraint, constraint.upper, own);
    const Legs legs = with_leg(no_legs(), 0, leg, s->turns[step.turn], s->turns[step.turn + 1]);
    step_with(s, legs, constraint, step.turn, 1);
    return affine_turned(own, s->turns[step.turn]);
}
