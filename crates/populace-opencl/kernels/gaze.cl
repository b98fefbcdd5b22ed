/* gaze.cl - look-at: a chain shares a turn, and its last joint faces the targets. Twin of populace-native
 * controls/gaze.rs.
 *
 * A turn of the gaze is a yaw about what is up and a pitch about the left of what faces, so that no head tilts. Both come
 * straight from the directions before and after. Angles are needed for what lies beyond the limits or between targets. */

/* Nearer than this to straight up or down, as the sine of the angle, a target's side counts for less and less: it would
 * turn about wildly there. */
#define STEEP 0.17f

/* Front, left and up of what carries a chain. */
typedef struct { Vec3 front, left, up; } Frame;

/* A direction of length 1 in a frame, and the length of what is level of it. Nothing where it has no length. */
typedef struct { Real left, up, front, level; } Sight;

/* Gazes of members side by side. */
typedef struct {
    const Stop *at;
    uint count, links_most, targets_most;
    Frame frame;
    Vec3 places[LINKS_MOST]; /* of the chain's joints, as the clips have them, its last one's again to the longest's end */
    Real shares[LINKS_MOST]; /* of the whole turn, 0 from the last joint on */
    Sight start;             /* where the end of the chain faces */
    Vec3 tangents, limits;   /* to either side, up and down, limits in radians */
} Gazes;

INLINE Frame frame_of(Vec3 front, Vec3 up)
{
    const Vec3 ahead = { 0.0f, 0.0f, 1.0f };
    Frame frame;
    frame.front = vec3_unit_or(front, ahead);
    frame.left = vec3_unit_or(vec3_cross(up, front), vec3_any_across(frame.front));
    frame.up = vec3_cross(frame.front, frame.left);
    return frame;
}

INLINE Sight seen_in(Frame frame, Vec3 v)
{
    const Real x = vec3_dot(v, frame.left), y = vec3_dot(v, frame.up), z = vec3_dot(v, frame.front);
    const Real level = x * x + z * z, squared = level + y * y;
    const Real k = squared > (Real)(1e-20f) ? inverse_sqrt(squared) : (Real)(0.0f);
    const Sight sight = { x * k, y * k, z * k, square_root(level) * k };
    return sight;
}

/* The turn of what faces the start: by a yaw, of which there are sine and cosine of the half, both times the same; and to a
 * pitch, of which there are cosine and sine. */
INLINE Quat gaze_turn(Frame frame, Sight start, Real side, Real ahead, Real level, Real height)
{
    const Real rise = start.level * height - start.up * level, on = 1.0f + (start.level * level + start.up * height);
    const Real right = -start.front * rise, back = start.left * rise, whole = start.level * on;
    const Real x = ahead * right + side * back, y = side * whole, z = ahead * back - side * right;
    const Vec3 axis = vec3_add_scaled(vec3_add_scaled(vec3_scale(frame.left, x), frame.up, y), frame.front, z);
    const Quat turn = { axis.x, axis.y, axis.z, ahead * whole };
    return quat_normalize_or(turn, quat_identity());
}

/* A yaw within a limit; what passes behind lets the gaze come back to the front. */
INLINE Real held(Real yaw, Real limit)
{
    const Real size = fabs(yaw), behind = 0.5f * (limit + HALF_TURN);
    const Real kept = size <= behind ? limit : limit * (HALF_TURN - size) / (HALF_TURN - behind);
    return size <= limit ? yaw : yaw < (Real)(0.0f) ? -kept : kept;
}

/* Each member's target of that number as it is seen from a place, what it weighs, and whether there is one that does. */
INLINE Sight see_target(const Gazes *g, uint t, Vec3 from, Real *weight, Choice *counts)
{
    Vec3 place = from;
    *weight = 0.0f;
    for (uint m = 0; m < g->count; m++) {
        const Steering *s = g->at[m].s;
        __global const Constraint *constraint = constraint_of(g->at + m);
        if (t >= constraint->target_count) continue;
        float own;
        put_vec3(&place, m, sight(s, s->of->targets[constraint->target_first + t], vec3_in(from, m), &own));
        PUT(*weight, m, own);
    }
    const Sight seen = seen_in(g->frame, vec3_add_scaled(place, from, -1.0f));
    const Real length = seen.left * seen.left + seen.up * seen.up + seen.front * seen.front;
    *counts = (*weight > (Real)(0.0f)) & (length > (Real)(0.0f));
    return seen;
}

/* The turn towards the mean of all targets, as far as limits let it. */
APART_STEP Quat aim_by_angles(const Gazes *g, Vec3 from)
{
    const Real none = 0.0f, side = g->limits.x, most = g->limits.y, least = -g->limits.z;
    Real yaw = 0.0f, pitch = 0.0f, total = 0.0f, half_side, half_ahead, height, level;
    for (uint t = 0; t < g->targets_most; t++) {
        Real own;
        Choice counts;
        const Sight seen = see_target(g, t, from, &own, &counts);
        const Real steep = seen.level < (Real)(STEEP) ? seen.level * (1.0f / STEEP) : (Real)(1.0f);
        const Real up = angle_of(seen.up, seen.level), raised = up > most ? most : up;
        const Real to_side = held(angle_of(seen.left, seen.front), side) * steep * own;
        yaw += counts ? to_side : none;
        pitch += counts ? (raised < least ? least : raised) * own : none;
        total += counts ? own : none;
    }
    const Real k = 1.0f / total;
    sin_cos(0.5f * (yaw * k - angle_of(g->start.left, g->start.front)), &half_side, &half_ahead);
    sin_cos(pitch * k, &height, &level);
    return gaze_turn(g->frame, g->start, half_side, half_ahead, level, height);
}

/* The turn from facing the start to facing what is aimed at from a place, and how much that weighs. */
INLINE Quat aim(const Gazes *g, Vec3 from, Real *weight)
{
    const Sight start = g->start;
    Sight to = { 0.0f, 0.0f, 0.0f, 0.0f };
    Real total = 0.0f, seen_count = 0.0f;
    for (uint t = 0; t < g->targets_most; t++) {
        Real own;
        Choice counts;
        const Sight seen = see_target(g, t, from, &own, &counts);
        to.left = counts ? seen.left : to.left;
        to.up = counts ? seen.up : to.up;
        to.front = counts ? seen.front : to.front;
        to.level = counts ? seen.level : to.level;
        total += counts ? own : (Real)(0.0f);
        seen_count += counts ? (Real)(1.0f) : (Real)(0.0f);
    }
    *weight = total < (Real)(1.0f) ? total : (Real)(1.0f);
    /* By the tangents of the limits. With both in front, the short way is the one that passes the front. */
    const Choice within = (to.level >= (Real)(STEEP)) & (fabs(to.left) <= g->tangents.x * to.front)
                          & (to.up <= g->tangents.y * to.level) & (-to.up <= g->tangents.z * to.level);
    const Choice some = seen_count > (Real)(0.0f), one = seen_count == (Real)(1.0f);
    const Choice straight = one & within & (start.front > (Real)(0.0f)), by_angles = some & !straight;
    const Real side = start.front * to.left - start.left * to.front;
    const Real ahead = start.level * to.level + (start.left * to.left + start.front * to.front);
    Quat turn = quat_choose(straight, gaze_turn(g->frame, start, side, ahead, to.level, to.up), quat_identity());
    if (ANY(by_angles)) turn = quat_choose(by_angles, aim_by_angles(g, from), turn);
    return turn;
}

/* A member's gaze put into a lane; `front` and `up` of what carries it, and what its end faces. */
INLINE void put_gaze(Gazes *g, uint m, Vec3 *front, Vec3 *up, Vec3 *facing)
{
    const Stop *at = g->at + m;
    __global const Constraint *constraint = constraint_of(at);
    const float4 ahead = constraint->front, above = constraint->up;
    float4 places[LINKS_MOST];
    const float16 end = walk(at->s, at->joints, constraint, at->own, places);
    put_vec3(front, m, at->has_parent ? transform_vector(at->parent, ahead) : ahead);
    put_vec3(up, m, at->has_parent ? transform_vector(at->parent, above) : above);
    put_vec3(facing, m, transform_vector(end, constraint->axis));
    put_vec3(&g->tangents, m, vec(constraint->axis.w, ahead.w, above.w));
    put_vec3(&g->limits, m, constraint->limits);
    const uint last = constraint->link_count - 1;
    for (uint link = 0; link < g->links_most; link++) put_vec3(&g->places[link], m, places[min(link, last)]);
    for (uint link = 0; link < last; link++) PUT(g->shares[link], m, at->s->of->links[constraint->link_first + link].share);
}

/* The sizes of the largest, and nothing in lanes that have no more links or no member. */
INLINE void clear_gazes(Gazes *g, const Stop *at, uint count)
{
    g->at = at;
    g->count = count;
    g->links_most = g->targets_most = 0;
    for (uint m = 0; m < count; m++) {
        __global const Constraint *constraint = constraint_of(at + m);
        g->links_most = max(g->links_most, constraint->link_count);
        g->targets_most = max(g->targets_most, constraint->target_count);
    }
    const Vec3 none = { 0.0f, 0.0f, 0.0f };
    for (uint link = 0; link < g->links_most; link++) g->places[link] = none;
    for (uint link = 0; link < g->links_most; link++) g->shares[link] = 0.0f;
    g->tangents = g->limits = none;
}

/* Hands a member's turns down its chain, the first to its own joint. */
INLINE void turn_gaze(Stop *at, uint m, const Quat *turns, Quat left)
{
    const uint last = constraint_of(at)->link_count - 1, first = at->step.turn;
    const float4 own = quat_in(last == 0 ? left : turns[0], m);
    for (uint link = 1; link < last; link++) at->s->turns[first + link - 1] = quat_in(turns[link], m);
    if (last > 0) at->s->turns[first + last - 1] = quat_in(left, m);
    at->own = affine_turned(at->own, own);
}

APART_STEP void gazes(Stop *at, uint count)
{
    Gazes g;
    clear_gazes(&g, at, count);
    Vec3 front = g.limits, up = g.limits, facing = g.limits;
    for (uint m = 0; m < count; m++) put_gaze(&g, m, &front, &up, &facing);
    g.frame = frame_of(front, up);
    g.start = seen_in(g.frame, facing);
    /* Straight up and down there is no side to turn from. */
    const Choice upright = g.start.level < (Real)(1e-3f);
    g.start.left = upright ? (Real)(0.0f) : g.start.left;
    g.start.front = upright ? (Real)(1e-3f) : g.start.front;
    g.start.level = upright ? (Real)(1e-3f) : g.start.level;

    Real weight, weight_there, shared = 0.0f;
    Quat turns[LINKS_MOST], so_far = quat_identity();
    const Quat whole = aim(&g, g.places[g.links_most - 1], &weight);
    Vec3 place = g.places[0];
    for (uint link = 0; link + 1 < g.links_most; link++) {
        const Real share = g.shares[link] * weight;
        const Choice turns_on = share > (Real)(0.0f);
        shared += turns_on ? share : (Real)(0.0f);
        const Quat now = quat_choose(turns_on, quat_part_as_told(whole, shared), so_far);
        turns[link] = quat_choose(turns_on, quat_mul(now, quat_conjugate(so_far)), quat_identity());
        so_far = now;
        const Vec3 on = vec3_add_scaled(g.places[link + 1], g.places[link], -1.0f);
        place = vec3_add(place, quat_turned(so_far, on));
    }
    /* The others have moved the last: it looks from where it is now, and turns by what is left. */
    const Quat there = aim(&g, place, &weight_there);
    const Choice partly = weight_there < (Real)(1.0f);
    const Quat held_back = quat_choose(partly, quat_part_as_told(there, weight_there), there);
    const Quat left = quat_mul(held_back, quat_conjugate(so_far));
    for (uint m = 0; m < count; m++) turn_gaze(at + m, m, turns, left);
}
