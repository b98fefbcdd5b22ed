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
INLINE float4 footing(Steering s, uint foot, Constraint constraint, float4 ankle, float4 *follows)
{
    const float rest = constraint.up.x, planted_below = constraint.up.y, lifted_above = constraint.up.z;
    const float size = s.control.place.w, held_most = constraint.up.w * size;
    const float4 clip = to_world(s.control, ankle);
    /* What the foot left behind: where it is planted, or how far it is behind where the clip has it. */
    const uint element = s.index * STATES_PER_CONTROL + foot;
    const float4 left = s.of.states_before[element];
    const uint bits = as_uint(left.w);
    const bool ours = bits >> 1 == s.control.epoch, was_planted = ours && (bits & 1u);
    const float4 kept = ours ? vec(left.x, left.y, left.z) : vec(0.0f, 0.0f, 0.0f);
    float4 behind = was_planted ? kept - clip : kept * (1.0f / (1.0f + s.of.elapsed_secs * (1.0f / 0.06f)));
    behind.y = 0.0f;
    bool stays = was_planted;
    const float far = vec_length(behind);
    if (far > 2.0f * held_most) { /* the member was put elsewhere */
        behind = vec(0.0f, 0.0f, 0.0f);
        stays = false;
    } else if (far > held_most) {
        behind = behind * (held_most / far);
        stays = false;
    }
    float lift = ankle.y - rest;
    const bool planted = lift <= planted_below;
    const float4 place = planted && stays ? kept : clip + behind;
    const float4 keep = planted ? place : behind;
    s.of.states[element] = (float4)(keep.xyz, as_float(s.control.epoch << 1 | (planted ? 1u : 0u)));

    const float4 ground = ground_at(s.of, place.x, place.z);
    const float between = (lift - planted_below) / (lifted_above - planted_below);
    float slope = 0.0f;
    if (planted) {
        lift = 0.0f;
        slope = 1.0f;
    } else if (lift < lifted_above) {
        lift = between * lifted_above;
        slope = 1.0f - between;
    }
    const float4 normal = direction_to_model(s.control, ground);
    *follows = (float4)(normal.xyz, slope);
    return to_model(s.control, vec(place.x, ground.w + (rest / ground.y + lift) * size, place.z));
}

APART_STEP float16 pelvis(Steering s, Hierarchy joints, Step step, float16 own)
{
    const Constraint first = s.of.constraints[step.index];
    float drop = 0.0f;
    for (uint foot = 0; foot < first.target_count; foot++) {
        const Constraint constraint = s.of.constraints[step.index + foot];
        float4 places[LINKS_MOST], follows;
        walk(s, joints, constraint, 0, own, places);
        const float4 hip = places[constraint.upper], knee = places[constraint.middle], ankle = places[constraint.link_count - 1];
        const float4 place = footing(s, foot, constraint, ankle, &follows);
        const float length = vec_length(knee - hip) + vec_length(ankle - knee);
        const float reach = length * (1.0f - constraint.limits.x);
        const float4 d = hip - place;
        float needed = d.y - root(reach * reach - d.x * d.x - d.z * d.z);
        needed = needed > 0.5f * length ? 0.5f * length : needed;
        drop = needed > drop ? needed : drop;
        s.turns[step.turn + 2 * foot] = vec(place.x, place.y, place.z);
        s.turns[step.turn + 2 * foot + 1] = follows;
    }
    own.s7 -= drop * first.limits.y;
    return own;
}

APART_STEP float16 foot(Steering s, Hierarchy joints, Step step, float16 own)
{
    const Constraint constraint = s.of.constraints[step.index];
    float4 places[LINKS_MOST], first_turn, second_turn;
    walk(s, joints, constraint, constraint.upper, own, places);
    const float4 follows = s.turns[step.turn + 1];
    limb_turns(places[constraint.upper], places[constraint.middle], places[constraint.link_count - 1], s.turns[step.turn],
               transform_vector(own, constraint.axis), vec(0.0f, 0.0f, 0.0f), constraint.limits.x, &first_turn, &second_turn);
    const float weight = constraint.limits.y;
    first_turn = part_of(first_turn, weight);
    second_turn = part_of(second_turn, weight);
    const float4 slope = turn_between(vec(0.0f, 1.0f, 0.0f), vec(follows.x, follows.y, follows.z), vec(1.0f, 0.0f, 0.0f));
    s.turns[step.turn] = second_turn;
    s.turns[step.turn + 1] = turn_mul(part_of(slope, follows.w * weight), turn_back(turn_mul(second_turn, first_turn)));
    return affine_turned(own, first_turn);
}
