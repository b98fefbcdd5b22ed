/* limb.cl - two-bone inverse kinematics. Twin of populace-native controls/limb.rs. */

/* How far away the end of a chain goes for a target at `distance`. */
INLINE float soft_distance(float distance, float length, float least, float soft)
{
    const float far = length - soft * length, near = least + soft * (length - least);
    if (distance > far) {
        const float x = (distance - far) / (soft * length);
        return far + soft * length * (x / (1.0f + x));
    }
    if (distance < near) {
        const float x = (near - distance) / (near - least);
        return near - (near - least) * (x / (1.0f + x));
    }
    return distance;
}

/* The turns of the first joint and, as of after that, of the middle one, which bring the end to a target; none for a limb of
 * no length. `bend` is where the middle joint bends to when the limb is straight; a pole counts where its w is above 0. */
INLINE void limb_turns(float4 first, float4 middle, float4 end, float4 target, float4 bend, float4 pole, float soft,
                       float4 *first_turn, float4 *second_turn)
{
    *first_turn = *second_turn = IDENTITY_TURN;
    const float4 upper = middle - first, lower = end - middle, to = target - first;
    const float a = vec_length(upper), b = vec_length(lower), distance = vec_length(to);
    if (a < 1e-6f || b < 1e-6f || distance < 1e-6f) return;
    const float least = a < b ? b - a : a - b;
    const float reach = soft_distance(distance, a + b, least, soft);
    const float4 ahead = to * (1.0f / distance);
    /* The limb as a whole swings to where the target is. */
    const float4 along = unit_or(end - first, upper * (1.0f / a));
    const float4 bent_to = unit_or(bend, any_across(along));
    const float4 swing = turn_between(along, ahead, bent_to);
    /* Where the middle joint stands out then; little of a bend of its own gives way to where it is to bend. */
    const float4 own = across(turned(swing, upper), ahead);
    const float4 wish = unit_or(across(turned(swing, bent_to), ahead), any_across(ahead));
    float4 out = unit_or(add_scaled(own, wish, 0.05f * a), wish);
    float4 turn = swing;
    if (pole.w > 0.0f) {
        const float4 drawn = unit_or(across(vec(pole.x, pole.y, pole.z), ahead), out);
        turn = turn_mul(turn_between(out, drawn, ahead), swing);
        out = drawn;
    }
    /* The triangle of both bones and the reach. */
    const float x = (reach * reach + a * a - b * b) * (0.5f / reach);
    const float y = root(a * a - x * x);
    const float4 bent = add_scaled(ahead * x, out, y);
    const float4 upper_now = turned(turn, upper) * (1.0f / a);
    *first_turn = turn_mul(turn_between(upper_now, bent * (1.0f / a), out), turn);
    const float4 lower_now = turned(*first_turn, lower) * (1.0f / b);
    const float4 lower_then = unit_or(ahead * reach - bent, lower_now);
    *second_turn = turn_between(lower_now, lower_then, vec_cross(ahead, out));
}

APART_STEP float16 reach(Steering s, Hierarchy joints, Step step, float16 own)
{
    const Constraint constraint = s.of.constraints[step.index];
    float4 places[LINKS_MOST], first_turn, second_turn;
    walk(s, joints, constraint, 0, own, places);
    float weight;
    const float4 target = goal_of(s, constraint, places[0], &weight);
    limb_turns(places[0], places[constraint.middle], places[constraint.link_count - 1], target,
               transform_vector(own, constraint.axis), constraint.front, constraint.limits.x, &first_turn, &second_turn);
    first_turn = part_of(weight > 0.0f ? first_turn : IDENTITY_TURN, weight);
    second_turn = part_of(weight > 0.0f ? second_turn : IDENTITY_TURN, weight);
    s.turns[step.turn] = second_turn;
    s.turns[step.turn + 1] = constraint.keeps_end ? turn_back(turn_mul(second_turn, first_turn)) : IDENTITY_TURN;
    return affine_turned(own, first_turn);
}
