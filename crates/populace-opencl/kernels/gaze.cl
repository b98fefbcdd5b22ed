/* gaze.cl - look-at: a chain shares a turn, and its last joint faces the targets. Twin of populace-native
 * controls/gaze.rs. */

/* Front, left and up of what carries a chain. */
typedef struct { float4 front, left, up; } Frame;

/* Yaw towards the left and pitch upwards, in radians; `level` is the part of the unit vector that is level. */
typedef struct { float yaw, pitch, level; } Angles;

INLINE Angles angles_of(Frame frame, float4 v)
{
    const float x = vec_dot(v, frame.left), y = vec_dot(v, frame.up), z = vec_dot(v, frame.front);
    Angles angles;
    angles.level = root(x * x + z * z);
    angles.yaw = angle_of(x, z);
    angles.pitch = angle_of(y, angles.level);
    return angles;
}

/* The turn by some angles of what faces `yaw`: up about its own left, then about what is up here. */
INLINE float4 frame_turn(Frame frame, float yaw, float by_yaw, float by_pitch)
{
    const float2 facing = sin_cos(yaw);
    const float4 right = add_scaled(frame.front * facing.x, frame.left, -facing.y);
    return turn_mul(turn_about(frame.up, by_yaw), turn_about(right, by_pitch));
}

/* A yaw within a limit; what passes behind lets the gaze come back to the front. */
INLINE float held(float yaw, float limit)
{
    const float size = fabs(yaw);
    if (size <= limit) return yaw;
    const float behind = 0.5f * (limit + HALF_TURN);
    const float kept = size <= behind ? limit : limit * (HALF_TURN - size) / (HALF_TURN - behind);
    return yaw < 0.0f ? -kept : kept;
}

/* The angles to face from a point, and how much they weigh. */
INLINE Angles wished(Steering s, Constraint constraint, Frame frame, float4 from, float *weight)
{
    Angles wish = { 0.0f, 0.0f, 0.0f };
    const float4 limits = constraint.limits;
    float total = 0.0f;
    for (uint t = 0; t < constraint.target_count; t++) {
        float own;
        const float4 place = sight(s, s.of.targets[constraint.target_first + t], from, &own);
        const float4 to = unit_or(vec(place.x - from.x, place.y - from.y, place.z - from.z), vec(0.0f, 0.0f, 0.0f));
        if (own <= 0.0f || vec_dot(to, to) <= 0.0f) continue;
        const Angles seen = angles_of(frame, to);
        const float steep = seen.level < 0.17f ? seen.level * (1.0f / 0.17f) : 1.0f;
        const float raised = seen.pitch > limits.y ? limits.y : seen.pitch;
        wish.yaw += held(seen.yaw, limits.x) * steep * own;
        wish.pitch += (raised < -limits.z ? -limits.z : raised) * own;
        total += own;
    }
    *weight = total <= 0.0f ? 0.0f : total < 1.0f ? total : 1.0f;
    if (total <= 0.0f) return wish;
    const float k = 1.0f / total;
    wish.yaw *= k;
    wish.pitch *= k;
    return wish;
}

APART_STEP float16 gaze(Steering s, Hierarchy joints, Step step, float16 own, float16 parent, bool has_parent)
{
    const Constraint constraint = s.of.constraints[step.index];
    const uint last = constraint.link_count - 1;
    Frame frame;
    const float4 front = constraint.front, up = constraint.up;
    frame.front = unit_or(has_parent ? transform_vector(parent, front) : front, vec(0.0f, 0.0f, 1.0f));
    frame.up = unit_or(across(has_parent ? transform_vector(parent, up) : up, frame.front), any_across(frame.front));
    frame.left = vec_cross(frame.up, frame.front);
    float4 places[LINKS_MOST];
    const float16 end = walk(s, joints, constraint, 0, own, places);
    const float4 facing = unit_or(transform_vector(end, constraint.axis), frame.front);
    const Angles start = angles_of(frame, facing);
    float weight;
    const Angles wish = wished(s, constraint, frame, places[last], &weight);
    const float whole_yaw = (wish.yaw - start.yaw) * weight, whole_pitch = (wish.pitch - start.pitch) * weight;
    float now_yaw = start.yaw, now_pitch = start.pitch;
    float4 turned_by = IDENTITY_TURN, place = places[0];
    float16 result = own;
    for (uint at = 0; at <= last; at++) {
        const float share = s.of.links[constraint.link_first + at].share;
        float by_yaw = whole_yaw * share, by_pitch = whole_pitch * share;
        if (at == last) {
            /* The others have moved it: it looks from where it is now. */
            float weight_there;
            const Angles there = wished(s, constraint, frame, place, &weight_there);
            by_yaw = start.yaw + (there.yaw - start.yaw) * weight_there - now_yaw;
            by_pitch = start.pitch + (there.pitch - start.pitch) * weight_there - now_pitch;
        }
        const float4 turn = weight > 0.0f ? frame_turn(frame, now_yaw, by_yaw, by_pitch) : IDENTITY_TURN;
        now_yaw += by_yaw;
        now_pitch += by_pitch;
        if (at == 0) result = affine_turned(own, turn);
        else s.turns[step.turn + at - 1] = turn;
        turned_by = turn_mul(turn, turned_by);
        if (at < last) {
            const float4 on = places[at + 1] - places[at];
            place = place + turned(turned_by, vec(on.x, on.y, on.z));
        }
    }
    return result;
}
