// gaze.cl - Aim constraint: the joints of a chain share a rotation, and its last joint faces the
// targets.
//
// Reads    local transforms of the chain; the model transform of its parent; targets
// Writes   the model transform of the first joint; one of step_rotations for each further joint
//
// The rotation is a yaw about the frame's up and a pitch about its left, so that heads never tilt.
// Both follow directly from the directions before and after. Angles are computed only beyond the
// limits or between several targets.
//
// Twin of populace-native/src/constraints/gaze.rs: same arithmetic, same order of operations.

// Front, left and up of the chain's parent.
typedef struct {
    Vec3 front, left, up;
} Frame;

// A unit direction in a frame, and the length of its level part. All 0 if the direction has no
// length.
typedef struct {
    Real left, up, front, level;
} Sight;

// Aim constraints of members, one in each lane.
typedef struct {
    const Stop *at;
    uint targets_most;
    Frame frame;
    Vec3 end;              // origin of the chain's last joint as the clips pose it
    Sight start;           // direction that the end of the chain faces
    Vec3 tangents, limits; // of the limits: to either side, up, down (radians)
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
    const Real k = squared > (Real)(LEAST_SQUARE) ? inverse_sqrt(squared) : (Real)(0.0f);
    const Sight sight = { x * k, y * k, z * k, square_root(level) * k };
    return sight;
}

// Returns the rotation from `start` by a yaw, given by sine and cosine of half its angle times one
// common factor, to a pitch, given by cosine and sine.
INLINE Quat gaze_rotation(Frame frame, Sight start, Real side, Real ahead, Real level, Real height)
{
    const Real rise = start.level * height - start.up * level,
               on = 1.0f + (start.level * level + start.up * height);
    const Real right = -start.front * rise, back = start.left * rise, whole = start.level * on;
    const Real x = ahead * right + side * back, y = side * whole, z = ahead * back - side * right;
    const Vec3 axis =
        vec3_add_scaled(vec3_add_scaled(vec3_scale(frame.left, x), frame.up, y), frame.front, z);
    const Quat rotation = { axis.x, axis.y, axis.z, ahead * whole };
    return quat_normalize_or(rotation, quat_identity());
}

// Clamps a yaw to a limit. Targets that pass behind bring the gaze back to the front.
INLINE Real held(Real yaw, Real limit)
{
    const Real size = fabs(yaw), behind = 0.5f * (limit + HALF_TURN);
    const Real kept = size <= behind ? limit : limit * (HALF_TURN - size) / (HALF_TURN - behind);
    return size <= limit ? yaw : yaw < (Real)(0.0f) ? -kept : kept;
}

// Returns target `t` of each member as seen from `from`, its weight, and whether it counts.
INLINE Sight see_target(const Gazes *g, uint t, Vec3 from, Real *weight, Choice *counts)
{
    Vec3 place = from;
    *weight = 0.0f;
    for (uint lane = 0; lane < g->at->count; lane++) {
        const Solver *s = g->at->members + lane;
        __global const Constraint *constraint = constraint_in(g->at, lane);
        if (t >= constraint->target_count) continue;
        const Target target = target_of(s, constraint, t);
        float own;
        put_vec3(&place, lane, sight(s, target, vec3_in(from, lane), &own));
        PUT(*weight, lane, own);
    }
    const Sight seen = seen_in(g->frame, vec3_add_scaled(place, from, -1.0f));
    const Real length = seen.left * seen.left + seen.up * seen.up + seen.front * seen.front;
    *counts = (*weight > (Real)(0.0f)) & (length > (Real)(0.0f));
    return seen;
}

// Returns the rotation towards the weighted mean of all targets within the limits.
SELDOM Quat aim_by_angles(const Gazes *g, Vec3 from)
{
    const Real none = 0.0f, side = g->limits.x, most = g->limits.y, least = -g->limits.z;
    Real yaw = 0.0f, pitch = 0.0f, total = 0.0f, half_side, half_ahead, height, level;
    for (uint t = 0; t < g->targets_most; t++) {
        Real own;
        Choice counts;
        const Sight seen = see_target(g, t, from, &own, &counts);
        const Real steep =
            seen.level < (Real)(GAZE_STEEP) ? seen.level * (1.0f / GAZE_STEEP) : (Real)(1.0f);
        const Real up = angle_of(seen.up, seen.level), raised = up > most ? most : up;
        const Real to_side = held(angle_of(seen.left, seen.front), side) * steep * own;
        yaw += counts ? to_side : none;
        pitch += counts ? (raised < least ? least : raised) * own : none;
        total += counts ? own : none;
    }
    const Real k = 1.0f / total;
    sin_cos(0.5f * (yaw * k - angle_of(g->start.left, g->start.front)), &half_side, &half_ahead);
    sin_cos(pitch * k, &height, &level);
    return gaze_rotation(g->frame, g->start, half_side, half_ahead, level, height);
}

// Returns the rotation from `start` to the aim as seen from `from`, and its weight.
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
    // Limits are compared by their tangents. If start and target are both in front, the short
    // rotation is the one through the front.
    const Choice within =
        (to.level >= (Real)(GAZE_STEEP)) & (fabs(to.left) <= g->tangents.x * to.front)
        & (to.up <= g->tangents.y * to.level) & (-to.up <= g->tangents.z * to.level);
    const Choice some = seen_count > (Real)(0.0f), one = seen_count == (Real)(1.0f);
    const Choice straight = one & within & (start.front > (Real)(0.0f)),
                 by_angles = some & !straight;
    const Real side = start.front * to.left - start.left * to.front;
    const Real ahead = start.level * to.level + (start.left * to.left + start.front * to.front);
    Quat rotation = quat_choose(
        straight, gaze_rotation(g->frame, start, side, ahead, to.level, to.up), quat_identity());
    if (ANY(by_angles)) rotation = quat_choose(by_angles, aim_by_angles(g, from), rotation);
    return rotation;
}

// Returns the largest number of targets.
INLINE uint targets_most(const Stop *at)
{
    uint most = 0;
    for (uint lane = 0; lane < at->count; lane++)
        most = max(most, constraint_in(at, lane)->target_count);
    return most;
}

// Returns the share of the whole rotation that a link of each chain takes. The last takes the rest.
INLINE Real shares_of(const Stop *at, uint link)
{
    Real shares = 0.0f;
    for (uint lane = 0; lane < at->count; lane++) {
        __global const Constraint *constraint = constraint_in(at, lane);
        PUT(shares, lane, at->members->tables->links[constraint->link_first + link].share);
    }
    return shares;
}

// Finds the frames of the chains' parents, and what the ends of the chains face. Until their
// rotations are known, step_rotations hold the origins and shares of the further joints: arrays that
// a variable indexes would take a GPU's stack.
INLINE void gaze_of(Gazes *g, Stop *at, __global const Constraint *constraint)
{
    const Numbers settings = settings_of(at, 0);
    const Vec3 ahead = vec3_of(&settings, 4), above = vec3_of(&settings, 8);
    const Vec3 tangents = { settings.n[3], settings.n[7], settings.n[11] };
    Matrix end = own_models(at), parent;
    for (uint link = 1; link < constraint->link_count; link++) {
        walk(at, constraint, link, &end);
        const Vec3 origin = matrix_origin(&end);
        const Quat further = { origin.x, origin.y, origin.z, shares_of(at, link) };
        hand_down(at, link - 1, further);
    }
    g->at = at;
    g->targets_most = targets_most(at);
    g->end = matrix_origin(&end);
    g->tangents = tangents;
    g->limits = vec3_of(&settings, 12);
    if (at->parent == NONE) {
        g->frame = frame_of(ahead, above);
    } else {
        models_of(at->joints, at->parent, &parent);
        g->frame = frame_of(matrix_transform_vector(&parent, ahead),
                            matrix_transform_vector(&parent, above));
    }
    g->start = seen_in(g->frame, matrix_transform_vector(&end, vec3_of(&settings, 0)));
    // Straight up or down there is no side to turn from.
    const Choice upright = g->start.level < (Real)(GAZE_UPRIGHT);
    g->start.left = upright ? (Real)(0.0f) : g->start.left;
    g->start.front = upright ? (Real)(GAZE_UPRIGHT) : g->start.front;
    g->start.level = upright ? (Real)(GAZE_UPRIGHT) : g->start.level;
}

SELDOM void gaze(Stop *at)
{
    __global const Constraint *constraint = constraint_in(at, 0);
    const uint last = constraint->link_count - 1;
    Gazes g;
    gaze_of(&g, at, constraint);

    Real weight, weight_there, shared = 0.0f, link_share = shares_of(at, 0);
    Quat so_far = quat_identity(), first = quat_identity();
    const Quat whole = aim(&g, g.end, &weight);
    const Matrix own = own_models(at);
    Vec3 posed = matrix_origin(&own), place = posed;
    for (uint link = 0; link < last; link++) {
        const Quat further = handed_down(at, link);
        const Real share = link_share * weight;
        const Choice takes_part = share > (Real)(0.0f);
        shared += takes_part ? share : (Real)(0.0f);
        const Quat now = quat_choose(takes_part, quat_part_as_told(whole, shared), so_far);
        const Quat part =
            quat_choose(takes_part, quat_mul(now, quat_conjugate(so_far)), quat_identity());
        if (link == 0) first = part;
        else hand_down(at, link - 1, part);
        so_far = now;
        const Vec3 next = { further.x, further.y, further.z };
        place = vec3_add(place, quat_rotated(so_far, vec3_add_scaled(next, posed, -1.0f)));
        posed = next;
        link_share = further.w;
    }
    // The other joints have moved the last one. It looks from its new origin and turns by the rest.
    const Quat there = aim(&g, place, &weight_there);
    const Choice partly = weight_there < (Real)(1.0f);
    const Quat held_back = quat_choose(partly, quat_part_as_told(there, weight_there), there);
    const Quat left = quat_mul(held_back, quat_conjugate(so_far));
    if (last == 0) first = left;
    else hand_down(at, last - 1, left);
    rotate_own(at, first);
}
