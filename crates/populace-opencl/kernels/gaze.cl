/* gaze.cl - look-at: a chain shares a turn, and its last joint faces the targets. Twin of populace-native
 * controls/gaze.rs.
 *
 * A turn of the gaze is a yaw about what is up and a pitch about the left of what faces, so that no head tilts. Both come
 * straight from the directions before and after. Angles are needed for what lies beyond the limits or between targets. */

/* Nearer than this to straight up or down, as the sine of the angle, a target's side counts for less and less: it would
 * turn about wildly there. */
#define STEEP 0.17f

/* Front, left and up of what carries a chain. */
typedef struct { float4 front, left, up; } Frame;

INLINE Frame frame_of(Constraint constraint, float16 parent, bool has_parent)
{
    const float4 front = has_parent ? transform_vector(parent, constraint.front) : constraint.front;
    const float4 up = has_parent ? transform_vector(parent, constraint.up) : constraint.up;
    Frame frame;
    frame.front = unit_or(front, vec(0.0f, 0.0f, 1.0f));
    frame.left = unit_or(vec_cross(up, front), any_across(frame.front));
    frame.up = vec_cross(frame.front, frame.left);
    return frame;
}

/* A direction in a frame: to the left, up and to the front, of length 1, and the length of what is level of it. */
INLINE float4 seen_in(Frame frame, float4 v)
{
    const float x = vec_dot(v, frame.left), y = vec_dot(v, frame.up), z = vec_dot(v, frame.front);
    const float level = x * x + z * z, squared = level + y * y;
    const float k = squared > 1e-20f ? inverse_root(squared) : 0.0f;
    return (float4)(x * k, y * k, z * k, root(level) * k);
}

/* The turn of what faces `start`: by a yaw, of which there are sine and cosine of the half, both times the same; and to a
 * pitch, of which there are cosine and sine. */
INLINE float4 gaze_turn(Frame frame, float4 start, float side, float ahead, float level, float height)
{
    const float rise = start.w * height - start.y * level, on = 1.0f + (start.w * level + start.y * height);
    const float right = -start.z * rise, back = start.x * rise, whole = start.w * on;
    const float x = ahead * right + side * back, y = side * whole, z = ahead * back - side * right;
    const float4 axis = add_scaled(add_scaled(frame.left * x, frame.up, y), frame.front, z);
    return turn_unit((float4)(axis.xyz, ahead * whole));
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

/* The turn towards the mean of all targets, as far as limits let it. */
APART_STEP float4 aim_by_angles(const Steering *s, Constraint constraint, Frame frame, float4 start, float4 from)
{
    const float4 limits = constraint.limits;
    float yaw = 0.0f, pitch = 0.0f, total = 0.0f;
    for (uint t = 0; t < constraint.target_count; t++) {
        float own;
        const float4 place = sight(s, s->of.targets[constraint.target_first + t], from, &own);
        const float4 seen = seen_in(frame, place - from);
        if (own <= 0.0f || vec_dot(seen, seen) <= 0.0f) continue;
        const float steep = seen.w < STEEP ? seen.w * (1.0f / STEEP) : 1.0f;
        const float up = angle_of(seen.y, seen.w), raised = up > limits.y ? limits.y : up;
        yaw += held(angle_of(seen.x, seen.z), limits.x) * steep * own;
        pitch += (raised < -limits.z ? -limits.z : raised) * own;
        total += own;
    }
    const float k = 1.0f / total;
    const float2 half_yaw = sin_cos(0.5f * (yaw * k - angle_of(start.x, start.z))), to = sin_cos(pitch * k);
    return gaze_turn(frame, start, half_yaw.x, half_yaw.y, to.y, to.x);
}

/* The turn from facing `start` to facing what is aimed at from a point, and how much that weighs. */
INLINE float4 aim(const Steering *s, Constraint constraint, Frame frame, float4 start, float4 from, float *weight)
{
    float4 to = vec(0.0f, 0.0f, 0.0f);
    float total = 0.0f;
    uint count = 0;
    for (uint t = 0; t < constraint.target_count; t++) {
        float own;
        const float4 place = sight(s, s->of.targets[constraint.target_first + t], from, &own);
        const float4 seen = seen_in(frame, place - from);
        if (own <= 0.0f || vec_dot(seen, seen) <= 0.0f) continue;
        to = seen;
        total += own;
        count++;
    }
    *weight = total < 1.0f ? total : 1.0f;
    if (count == 0) return IDENTITY_TURN;
    /* The tangents of the limits. With both in front, the short way is the one that passes the front. */
    const float side_most = constraint.axis.w, up_most = constraint.front.w, down_most = constraint.up.w;
    const bool within = to.w >= STEEP && fabs(to.x) <= side_most * to.z && to.y <= up_most * to.w && -to.y <= down_most * to.w;
    if (count > 1 || !within || start.z <= 0.0f) return aim_by_angles(s, constraint, frame, start, from);
    const float side = start.z * to.x - start.x * to.z, ahead = start.w * to.w + (start.x * to.x + start.z * to.z);
    return gaze_turn(frame, start, side, ahead, to.w, to.y);
}

/* Where the end of a chain faces. */
INLINE float4 start_of(Frame frame, float4 facing)
{
    float4 start = seen_in(frame, facing);
    /* Straight up and down there is no side to turn from. */
    if (start.w < 1e-3f) start = (float4)(0.0f, start.y, 1e-3f, 1e-3f);
    return start;
}

APART_STEP float16 gaze(const Steering *s, Hierarchy joints, Step step, float16 own, float16 parent, bool has_parent)
{
    const Constraint constraint = s->of.constraints[step.index];
    const uint last = constraint.link_count - 1;
    const Frame frame = frame_of(constraint, parent, has_parent);
    float4 places[LINKS_MOST];
    const float16 end = walk(s, joints, constraint, own, places);
    const float4 start = start_of(frame, transform_vector(end, constraint.axis));
    float weight, weight_there, shared = 0.0f;
    const float4 whole = aim(s, constraint, frame, start, places[last], &weight);
    float4 so_far = IDENTITY_TURN, place = places[0];
    float16 result = own;
    for (uint at = 0; at < last; at++) {
        const float share = s->of.links[constraint.link_first + at].share * weight;
        if (share > 0.0f) {
            shared += share;
            const float4 now = part_as_told(whole, shared), turn = turn_mul(now, turn_back(so_far));
            so_far = now;
            if (at == 0) result = affine_turned(own, turn);
            else s->turns[step.turn + at - 1] = turn;
        } else if (at > 0) {
            s->turns[step.turn + at - 1] = IDENTITY_TURN;
        }
        place = place + turned(so_far, places[at + 1] - places[at]);
    }
    /* The others have moved the last: it looks from where it is now, and turns by what is left. */
    const float4 there = aim(s, constraint, frame, start, place, &weight_there);
    const float4 left = turn_mul(weight_there < 1.0f ? part_as_told(there, weight_there) : there, turn_back(so_far));
    if (last == 0) return affine_turned(own, left);
    s->turns[step.turn + last - 1] = left;
    return result;
}
