// foot.cl - Where feet in lanes go: with their clips and the members' strides, locked to the ground
// while they stand.
//
// Reads    the legs' transforms; soles; the ground; the feet's states after the previous frame
// Writes   the feet's states after this frame, into lanes
//
// Twin of populace-native/src/constraints/foot.rs: same arithmetic, same order of operations.

// The most points of a sole: those of the ankle and those of the toes.
#define SOLE_POINTS (2 * MAX_SOLE_POINTS)

// Legs as their clips pose them, in model space: with the transforms of the ankles and of the joints
// that carry the front of the sole.
typedef struct {
    Vec3 hip, knee, bend;
    Matrix ankle, toes;
} Leg;

// Rotations about +Y, by the tangents of half their angles.
typedef struct {
    Real half_tan, sine, cosine;
} Turn;

INLINE Turn turn_of(Real half_tan)
{
    const Real inverse = 1.0f / (1.0f + half_tan * half_tan);
    const Turn turn = { half_tan, (half_tan + half_tan) * inverse, 2.0f * inverse - 1.0f };
    return turn;
}

// Returns the turn by the sum of two angles, which is less than half a turn.
INLINE Turn turn_and(Turn turn, Real half_tan)
{
    return turn_of((turn.half_tan + half_tan) / (1.0f - turn.half_tan * half_tan));
}

INLINE Vec3 turned(Turn turn, Vec3 v)
{
    const Vec3 t = { turn.cosine * v.x + turn.sine * v.z, v.y,
                     turn.cosine * v.z - turn.sine * v.x };
    return t;
}

// Feet as their clips and the members' strides pose them, in model space. `along` leads from heel to
// ball, as the clips have it. Then the count of the sole's points; the index of the lowest one, that
// point relative to the ankle, and its height in model space; and the point that stood before.
typedef struct {
    Vec3 ankle, along, lowest_point, stood;
    Turn turn;
#if LANES > 1
    Vec3 sole[SOLE_POINTS]; // relative to the ankle
#endif
    uint points;
    Real lowest, clearance;
} Stepped;

// Feet and all that they go by.
typedef struct {
    const Stop *at;
    const ConstraintTables *tables;
    __global const Constraint *foot; // of the first member
    const Numbers *settings;
    const Stance *stance;
    const Leg *leg;
    Real within_secs; // seconds within a contact, NAN if they are not known
    Real stood_secs;  // for which all feet have stood, as of the feet before this one
} FootInputs;

// Where feet in lanes go, in model space: the ankles, the turns of the feet, the ground's unit
// normals, how much the feet follow them, and whether they are planted.
typedef struct {
    Vec3 ankle, normal;
    Real turn, near;
    Choice planted;
} FootGoals;

INLINE Vec3 same_in_lanes(float4 v)
{
    const Vec3 all = { v.x, v.y, v.z };
    return all;
}

// Returns a point of the soles in the joint that carries it: those of the ankle come first, then those
// of the toes.
INLINE Vec3 sole_point(const FootInputs *in, uint nth)
{
    __global const Constraint *foot = in->foot;
    const uint of_ankle = foot->sole_count;
    return same_in_lanes(in->tables->soles[nth < of_ankle ? foot->sole_first + nth
                                                          : foot->toe_first + nth - of_ankle]);
}

// Finds the lowest point of the soles, and the one that stood before, whose index is `pivot`. The
// point on the ground beneath the ankle stands in for a sole without points.
INLINE void put_points(const FootInputs *in, Real pivot, Stepped *stepped)
{
    const Vec3 ankle = matrix_origin(&in->leg->ankle);
    const Vec3 beneath = { ankle.x, ankle.y - in->settings->n[15], ankle.z };
    stepped->points = in->foot->sole_count + in->foot->toe_count;
    stepped->lowest = 0.0f;
    stepped->lowest_point = stepped->stood = vec3_add_scaled(beneath, ankle, -1.0f);
    stepped->clearance = stepped->points == 0 ? beneath.y : (Real)(FLT_MAX);
    for (uint nth = 0; nth < stepped->points; nth++) {
        const Matrix *joint = nth < in->foot->sole_count ? &in->leg->ankle : &in->leg->toes;
        const Vec3 at = matrix_transform_point(joint, sole_point(in, nth)),
                   point = vec3_add_scaled(at, ankle, -1.0f);
        const Choice is_lower = at.y < stepped->clearance;
        stepped->clearance = is_lower ? at.y : stepped->clearance;
        stepped->lowest = is_lower ? (Real)((float)nth) : stepped->lowest;
        stepped->lowest_point = vec3_choose(is_lower, point, stepped->lowest_point);
        const Choice was_before = pivot < (Real)((float)nth - 0.5f);
        stepped->stood = vec3_choose(was_before, stepped->stood, point);
#if LANES > 1
        stepped->sole[nth] = point;
#endif
    }
}

// Applies the members' strides: distances that the clips step along +Z, from the ankle's position at
// rest, are scaled and turned, and the foot turns by them about the origin.
INLINE void step_foot(const FootInputs *in, Real pivot, Stepped *stepped)
{
    __global const Constraint *foot = in->foot;
    __global const float4 *of_ankle = in->tables->soles + foot->sole_first;
    const Vec3 at = matrix_origin(&in->leg->ankle), with = in->stance->stride;
    const Real rest_z = in->settings->n[14], stride = at.z - rest_z;
    const Vec3 strided = { at.x + stride * with.x, at.y, rest_z + stride * with.y };
    const Vec3 none = { 0.0f, 0.0f, 0.0f };
    stepped->turn = turn_of(with.z * stride);
    stepped->ankle = turned(stepped->turn, strided);
    stepped->along = none;
    if (foot->sole_count > 1)
        stepped->along = matrix_transform_vector(
            &in->leg->ankle, same_in_lanes(of_ankle[foot->sole_count - 1] - of_ankle[0]));
    put_points(in, pivot, stepped);
}

// Returns a part of the way from 0 to 1 that begins and ends without speed.
INLINE Real eased(Real part)
{
    const Real zero = 0.0f, one = 1.0f;
    part = part > zero ? (part < one ? part : one) : zero;
    return part * part * (3.0f - 2.0f * part);
}

// Returns which feet stand, and in *near how near they are to that: 1 while they stand, 0 in the air.
INLINE Choice stands(const FootInputs *in, Real ankle_height, Real *near)
{
    const Real *up = in->settings->n + 8, within_secs = in->within_secs;
    const Real lift = ankle_height - up[0], above = (lift - up[1]) / (up[2] - up[1]);
    const Choice known = within_secs == within_secs;
    *near = eased(known ? 1.0f + within_secs * (1.0f / FOOT_NEAR_SECS) : 1.0f - above);
    return (known & (within_secs >= (Real)(0.0f))) | (!known & (lift <= up[1]));
}

// Returns the horizontal offsets of feet from their positions in the clip, at most `most` metres.
// *elsewhere tells which members were moved elsewhere, which ends the offset. `pivot` is where the
// clip has the point that stands.
INLINE Vec3 offset(const FootState *state, Vec3 pivot, Real decay, Real most, Choice *elsewhere)
{
    const Choice stood = state->planted;
    const Vec3 none = { 0.0f, 0.0f, 0.0f };
    const Vec3 vector = { stood ? state->x - pivot.x : state->x * decay, 0.0f,
                          stood ? state->z - pivot.z : state->z * decay };
    const Real far = vec3_dot(vector, vector);
    const Vec3 shorter = vec3_scale(vector, most * inverse_sqrt(far));
    const Vec3 near = vec3_choose(far > most * most, shorter, vector);
    *elsewhere = far > 4.0f * most * most;
    return vec3_choose(*elsewhere, none, near);
}

// Returns the tangents of half the angles by which feet are turned from where the clip has them.
// `own` is the direction from heel to toes in the clip, in world space.
INLINE Real turn_lag(const FootState *state, Vec3 own, Real decay)
{
    const Real x = state->along_x, z = state->along_z, none = 0.0f;
    const Real cross = own.z * x - own.x * z, dot = own.x * x + own.z * z;
    const Real kept = dot > none ? cross / (1.0f + dot) : none;
    return within(state->planted ? kept : x * decay, -FOOT_MAX_TURN, FOOT_MAX_TURN);
}

// Returns the unit directions in world space of vectors of model space, along X and Z.
INLINE Vec3 level_direction(const Stance *stance, Vec3 v)
{
    const Real sine = stance->sine, cosine = stance->cosine;
    const Vec3 along = { cosine * v.x + sine * v.z, 0.0f, cosine * v.z - sine * v.x };
    const Vec3 front = { 0.0f, 0.0f, 1.0f };
    return vec3_unit_or(along, front);
}

// Returns which offsets take an ankle too far from its hip: horizontally, or so that the pelvis would
// have to sink for it.
INLINE Choice overstretches(const FootInputs *in, Vec3 ankle, Vec3 offset, Real most)
{
    const Vec3 to = vec3_to_world(in->stance, ankle);
    const Vec3 from = vec3_to_world(in->stance, in->leg->hip);
    const Real own_x = to.x - from.x, own_z = to.z - from.z;
    const Real x = own_x + offset.x, z = own_z + offset.z;
    const Real of_clip = own_x * own_x + own_z * own_z, with_offset = x * x + z * z;
    const Real leg = FOOT_LEG * FOOT_LEG * most * most, straight = square_root(leg - of_clip);
    const Real down = from.y - to.y, none = 0.0f;
    const Real known = FOOT_SINK, unknown = FOOT_SINK_UNKNOWN,
               sink = in->within_secs == in->within_secs ? known : unknown,
               sunk = (straight < down ? straight : down) - sink * most,
               above = sunk > none ? sunk : none;
    const Choice is_far =
        (with_offset > FOOT_REACH * FOOT_REACH * most * most) | (with_offset > leg - above * above);
    return (with_offset > of_clip) & is_far;
}

// Returns which feet that stand for long leave an offset, to stand below the body.
INLINE Choice settles(const FootInputs *in, Vec3 offset, Real most)
{
    const Real far = FOOT_SETTLE * most;
    return (in->stood_secs >= (Real)(FOOT_SETTLE_SECS)) & (vec3_dot(offset, offset) > far * far);
}

// A foot that is locked to the ground, or let go: its offset from the clip in world space, whether
// the member was moved elsewhere, and the point of the sole that stands, relative to the ankle.
typedef struct {
    Vec3 vector, arm;
    Choice moved_elsewhere, planted, released;
    Real pivot;
} Lock;

// Locks feet that stand, unless the lock holds them too far back.
INLINE Lock lock(const FootInputs *in, const FootState *state, const Stepped *stepped,
                 Choice stands, Turn turn, Real decay, Real most)
{
    Lock lock;
    const Vec3 none = { 0.0f, 0.0f, 0.0f };
    const Vec3 kept_arm = vec3_choose(state->planted, turned(turn, stepped->stood), none);
    const Vec3 pivot = vec3_to_world(in->stance, vec3_add(stepped->ankle, kept_arm));
    lock.vector = offset(state, pivot, decay, most, &lock.moved_elsewhere);
    const Real relock = FOOT_RELOCK * most;
    const Choice is_behind =
        state->released & (vec3_dot(lock.vector, lock.vector) > relock * relock);
    const Choice lets_go = is_behind | overstretches(in, stepped->ankle, lock.vector, most)
                           | settles(in, lock.vector, most);
    lock.released = stands & lets_go;
    lock.planted = stands & !lets_go;
    const Real slack = FOOT_PIVOT_SLACK * in->settings->n[11];
    const Choice keeps =
        state->planted & (stepped->ankle.y + kept_arm.y <= stepped->clearance + slack);
    lock.pivot = keeps ? state->pivot : stepped->lowest;
    lock.arm = vec3_choose(keeps, kept_arm, turned(turn, stepped->lowest_point));
    return lock;
}

// Returns the ankles' positions in model space above the places of their pivots. A lifted foot is as
// far above the ground as the clip has it. `arm` leads from the ankle to the pivot.
INLINE Vec3 ankle_over(const Stance *stance, const Stepped *stepped, Vec3 place, Vec3 arm,
                       Vec3 normal, Real near)
{
    const Real none = 0.0f, clearance = stepped->clearance;
    const Real kept = clearance > none ? clearance * (1.0f - near) : none;
    const Real above = kept + (stepped->ankle.y + arm.y - clearance);
    const Vec3 over = { place.x, place.y + above * stance->scale, place.z };
    const Choice leans = (normal.x != none) | (normal.z != none);
    Vec3 tilted = arm;
    if (ANY(leans)) {
        const Quat tilt = { normal.z, 0.0f, -normal.x, 1.0f + normal.y };
        const Quat slope = quat_part(quat_normalize_or(tilt, quat_identity()), near);
        tilted = vec3_choose(leans, quat_rotated(slope, arm), arm);
    }
    return vec3_add_scaled(vec3_to_model(stance, over), tilted, -1.0f);
}

// Where the points of soles go: as the clips have them, turned, and moved by the offset of the lock.
typedef struct {
    Turn turn;
    Vec3 offset;
    Real edge; // see stand_on()
} SolesTo;

INLINE void stand_on_point(const FootInputs *in, const Stepped *stepped, const SolesTo *to,
                           Vec3 point, Under *under)
{
    const Vec3 at = vec3_to_world(in->stance, vec3_add(stepped->ankle, turned(to->turn, point)));
    stand_on(in->tables, under, vec3_add(at, to->offset), to->edge);
}

// Raises the ground under soles until none of their points is in it.
INLINE void stand_on_points(const FootInputs *in, const Stepped *stepped, const SolesTo *to,
                            Under *under)
{
#if LANES == 1
    // Walks once more, since an array that a variable indexes would take a GPU's stack.
    __global const Constraint *foot = in->foot;
    const uint ankle_at = ankle_link(foot);
    Matrix joint = own_models(in->at);
    Vec3 ankle = matrix_origin(&joint);
    for (uint link = 0, nth = 0; link < foot->link_count; link++) {
        if (link > 0) walk(in->at, foot, link, &joint);
        if (link == ankle_at) ankle = matrix_origin(&joint);
        const uint of_ankle = link < ankle_at ? 0 : foot->sole_count,
                   end = link + 1 < foot->link_count ? of_ankle : stepped->points;
        for (; nth < end; nth++) {
            const Vec3 at = matrix_transform_point(&joint, sole_point(in, nth));
            stand_on_point(in, stepped, to, vec3_add_scaled(at, ankle, -1.0f), under);
        }
    }
#else
    for (uint nth = 0; nth < stepped->points; nth++)
        stand_on_point(in, stepped, to, stepped->sole[nth], under);
#endif
    settle(under);
}

// Returns where the nth feet of `states` go, and puts their states after this frame there.
INLINE FootGoals foot_goal(const FootInputs *in, FootStates *states, uint nth)
{
    const ConstraintTables *tables = in->tables;
    const Stance *stance = in->stance;
    const FootState state = foot_state(states, nth);
    const Real none = 0.0f, most = in->settings->n[11] * stance->scale;
    Stepped stepped;
    FootGoals goals;
    step_foot(in, state.pivot, &stepped);
    const Choice standing = stands(in, stepped.ankle.y, &goals.near);
    const float decay = 1.0f / (1.0f + tables->elapsed_secs * (1.0f / FOOT_RELEASE_SECS));
    const Vec3 own = level_direction(stance, turned(stepped.turn, stepped.along));
    const Real lag = in->foot->sole_count > 1 ? turn_lag(&state, own, decay) : none;
    const Turn turn = turn_and(stepped.turn, lag);
    const Lock to = lock(in, &state, &stepped, standing, turn, decay, most);
    const Vec3 place = vec3_add(vec3_to_world(stance, vec3_add(stepped.ankle, to.arm)), to.vector);
    const Vec3 direction = turned(turn_of(lag), own);
    const Choice known = state.known & !to.moved_elsewhere;
    const FootState next = { to.planted ? place.x : to.vector.x,
                             to.planted ? place.z : to.vector.z,
                             to.planted ? direction.x : lag,
                             to.planted ? direction.z : none,
                             to.pivot,
                             to.planted,
                             to.released,
                             known };
    put_foot_state(states, nth, next);
    Under under = ground_under(tables, place);
    const SolesTo soles_to = { turn, to.vector, FOOT_EDGE * most };
    if (tables->ground->per_metre > 0.0f) stand_on_points(in, &stepped, &soles_to, &under);
    const Real lift = FOOT_LIFT * square_root(vec3_dot(to.vector, to.vector));
    const Real ahead = ground_ahead(tables, stance, place, under.ground, most, goals.near)
                       + (to.released & (in->within_secs == in->within_secs) ? lift : none);
    const FootHeights heights = next_heights(tables, foot_heights(states, nth), known,
                                             state.planted, to.planted, &under, ahead);
    put_foot_heights(states, nth, heights);
    const Vec3 over = { place.x, heights.shown, place.z };
    goals.normal = vec3_direction_to_model(stance, under.normal);
    goals.ankle = ankle_over(stance, &stepped, over, to.arm, goals.normal, goals.near);
    goals.turn = turn.half_tan;
    goals.planted = to.planted;
    return goals;
}
