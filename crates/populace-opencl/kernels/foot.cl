// foot.cl - Where feet in lanes go: with their clips and the members' strides, locked to the ground
// while they stand.
//
// Reads    the legs' transforms; soles; the ground; the feet's states after the previous frame
// Writes   the feet's states after this frame, into lanes
//
// Twin of populace-native/src/constraints/foot.rs: same arithmetic, same order of operations.

// A leg as its clips pose it, in model space: with the transforms of the ankle and of the joint that
// carries the front of the sole.
typedef struct {
    float4 hip, knee, bend;
    float16 ankle, toes;
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

// Feet in lanes as their clips pose them, and their other inputs. In model space: the hip and the
// ankle; relative to the ankle, the point of the sole that was planted, 0 if none was, and the lowest
// one, with its index and its height; the direction from heel to ball, 0 if it is not known. Settings
// of the constraint: height of the ankle at rest, heights above it of planted and lifted feet, the
// longest offset, and z of the ankle at rest. Seconds within a contact, NAN if they are not known.
typedef struct {
    Vec3 hip, ankle, kept, low, along;
    Real lowest, clearance, has_sole;
    Real rest, planted_below, lifted_above, longest, rest_z;
    Real within_secs;
    Stance stance;
    FootState state;
    Leg legs[LANES];
    __global const Constraint *constraints[LANES]; // 0 in unused lanes
    uint points_most;
} FootInputs;

// Fills unused lanes.
INLINE void clear_feet(FootInputs *all)
{
    const Vec3 none = { 0.0f, 0.0f, 0.0f };
    const Stance stance = { none, none, 1.0f, 0.0f, 1.0f };
    const FootState state = { 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f };
    all->hip = all->ankle = all->kept = all->low = all->along = none;
    all->lowest = all->clearance = all->has_sole = 0.0f;
    all->rest = all->planted_below = all->longest = all->rest_z = all->within_secs = 0.0f;
    all->lifted_above = 1.0f;
    all->stance = stance;
    all->state = state;
    for (uint lane = 0; lane < LANES; lane++) all->constraints[lane] = 0;
    all->points_most = 0;
}

// Where feet in lanes go, in model space: the ankles, the turns of the feet, the ground's unit
// normals, and how much the feet follow them.
typedef struct {
    Vec3 ankle, normal;
    Real turn, near;
} FootGoals;

// Returns the number of points of a sole.
INLINE uint point_count(__global const Constraint *foot)
{
    return foot->sole_count + foot->toe_count;
}

// Returns a point of a sole as the clips pose it, relative to the ankle; on the ground beneath the
// ankle if none is known.
INLINE float4 arm(const Leg *leg, __global const Constraint *foot, __global const float4 *soles,
                  uint point)
{
    float4 at = vec(leg->ankle.s3, leg->ankle.s7 - foot->limits.w, leg->ankle.sb);
    if (point < foot->sole_count)
        at = transform_point(leg->ankle, soles[foot->sole_first + point]);
    else if (point - foot->sole_count < foot->toe_count)
        at = transform_point(leg->toes, soles[foot->toe_first + (point - foot->sole_count)]);
    return at - origin_of(leg->ankle);
}

// Finds the lowest of the points that a joint carries, the first of which has the index `first`.
INLINE void lower(float16 joint, __global const float4 *points, uint count, uint first,
                  uint *lowest, float *clearance)
{
    for (uint i = 0; i < count; i++) {
        const float4 at = points[i];
        const float height = joint.s4 * at.x + joint.s5 * at.y + joint.s6 * at.z + joint.s7;
        if (height < *clearance) {
            *lowest = first + i;
            *clearance = height;
        }
    }
}

// Puts a member's foot into a lane. `left` is its state after the previous frame.
INLINE void put_foot(FootInputs *all, uint lane, const Solver *s,
                     __global const Constraint *foot, const Leg *leg, float within_secs,
                     const float4 *left)
{
    __global const float4 *soles = s->tables->soles, *of_ankle = soles + foot->sole_first;
    const float4 ankle = origin_of(leg->ankle);
    uint lowest = 0;
    float clearance = FLT_MAX;
    lower(leg->ankle, of_ankle, foot->sole_count, 0, &lowest, &clearance);
    lower(leg->toes, soles + foot->toe_first, foot->toe_count, foot->sole_count, &lowest,
          &clearance);
    if (point_count(foot) == 0) clearance = ankle.y - foot->limits.w;
    const bool has_sole = foot->sole_count > 1;
    const uint pivot = foot_states(&all->state, lane, s, left[0], left[1]);
    put_stance(&all->stance, lane, &s->control);
    put_vec3(&all->hip, lane, leg->hip);
    put_vec3(&all->ankle, lane, ankle);
    put_vec3(&all->kept, lane,
             pivot == NONE ? vec(0.0f, 0.0f, 0.0f) : arm(leg, foot, soles, pivot));
    put_vec3(&all->low, lane, arm(leg, foot, soles, lowest));
    put_vec3(&all->along, lane,
             has_sole ? transform_vector(leg->ankle, of_ankle[foot->sole_count - 1] - of_ankle[0])
                      : vec(0.0f, 0.0f, 0.0f));
    PUT(all->lowest, lane, (float)lowest);
    PUT(all->clearance, lane, clearance);
    PUT(all->has_sole, lane, has_sole ? 1.0f : 0.0f);
    PUT(all->rest, lane, foot->up.x);
    PUT(all->planted_below, lane, foot->up.y);
    PUT(all->lifted_above, lane, foot->up.z);
    PUT(all->longest, lane, foot->up.w);
    PUT(all->rest_z, lane, foot->limits.z);
    PUT(all->within_secs, lane, within_secs);
    all->legs[lane] = *leg;
    all->constraints[lane] = foot;
    all->points_most = max(all->points_most, point_count(foot));
}

// Returns point `point` of each sole relative to its ankle. *has_it tells which soles have it.
INLINE Vec3 sole_points(const FootInputs *all, __global const float4 *soles, uint point,
                        Choice *has_it)
{
    Vec3 points = { 0.0f, 0.0f, 0.0f };
    Real there = 0.0f;
    for (uint lane = 0; lane < LANES; lane++) {
        __global const Constraint *foot = all->constraints[lane];
        if (!foot || point >= point_count(foot)) continue;
        put_vec3(&points, lane, arm(&all->legs[lane], foot, soles, point));
        PUT(there, lane, 1.0f);
    }
    *has_it = there > (Real)(0.5f);
    return points;
}

// Returns a part of the way from 0 to 1 that begins and ends without speed.
INLINE Real eased(Real part)
{
    const Real zero = 0.0f, one = 1.0f;
    part = part > zero ? (part < one ? part : one) : zero;
    return part * part * (3.0f - 2.0f * part);
}

// Returns which feet stand, and in *near how near they are to that: 1 while they stand, 0 in the air.
INLINE Choice stands(const FootInputs *all, Real ankle_height, Real *near)
{
    const Real within_secs = all->within_secs, lift = ankle_height - all->rest;
    const Real above = (lift - all->planted_below) / (all->lifted_above - all->planted_below);
    const Choice known = within_secs == within_secs;
    *near = eased(known ? 1.0f + within_secs * (1.0f / FOOT_NEAR_SECS) : 1.0f - above);
    return (known & (within_secs >= (Real)(0.0f))) | (!known & (lift <= all->planted_below));
}

// Returns the horizontal offsets of feet from their positions in the clip, at most `most` metres.
// *elsewhere tells which members were moved elsewhere, which ends the offset. `pivot` is where the
// clip has the point that stands.
INLINE Vec3 offset(const FootState *state, Choice stood, Vec3 pivot, Real decay, Real most,
                   Choice *elsewhere)
{
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
INLINE Real turn_lag(const FootState *state, Choice stood, Vec3 own, Real decay)
{
    const Real x = state->along_x, z = state->along_z, none = 0.0f;
    const Real cross = own.z * x - own.x * z, dot = own.x * x + own.z * z;
    const Real kept = dot > none ? cross / (1.0f + dot) : none;
    return within(stood ? kept : x * decay, -FOOT_MAX_TURN, FOOT_MAX_TURN);
}

// Returns the unit directions in world space of vectors of model space, along X and Z.
INLINE Vec3 level_direction(const Stance *stance, Vec3 v)
{
    const Real sine = stance->sine, cosine = stance->cosine;
    const Vec3 along = { cosine * v.x + sine * v.z, 0.0f, cosine * v.z - sine * v.x };
    const Vec3 front = { 0.0f, 0.0f, 1.0f };
    return vec3_unit_or(along, front);
}

// Returns which offsets take an ankle too far from its hip, horizontally.
INLINE Choice overstretches(const FootInputs *all, Vec3 ankle, Vec3 offset, Real most)
{
    const Vec3 to = vec3_to_world(&all->stance, ankle);
    const Vec3 from = vec3_to_world(&all->stance, all->hip);
    const Real own_x = to.x - from.x, own_z = to.z - from.z;
    const Real x = own_x + offset.x, z = own_z + offset.z;
    const Real of_clip = own_x * own_x + own_z * own_z, with_offset = x * x + z * z;
    return (with_offset > of_clip) & (with_offset > FOOT_REACH * FOOT_REACH * most * most);
}

// A foot that is locked to the ground, or let go: its offset from the clip in world space, whether
// the member was moved elsewhere, and the point of the sole that stands, relative to the ankle.
typedef struct {
    Vec3 vector, arm;
    Choice moved_elsewhere, planted, released;
    Real pivot;
} Lock;

// Locks feet that stand, unless the lock holds them too far back.
INLINE Lock lock(const FootInputs *all, Vec3 ankle, Choice stands, Turn turn, Real decay, Real most)
{
    Lock lock;
    const Choice stood = all->state.planted > (Real)(0.5f);
    const Vec3 kept_arm = turned(turn, all->kept), low_arm = turned(turn, all->low);
    const Vec3 pivot = vec3_to_world(&all->stance, vec3_add(ankle, kept_arm));
    lock.vector = offset(&all->state, stood, pivot, decay, most, &lock.moved_elsewhere);
    const Real relock = FOOT_RELOCK * most;
    const Choice is_behind = (all->state.released > (Real)(0.5f))
                             & (vec3_dot(lock.vector, lock.vector) > relock * relock);
    const Choice lets_go = is_behind | overstretches(all, ankle, lock.vector, most);
    lock.released = stands & lets_go;
    lock.planted = stands & !lets_go;
    const Real slack = FOOT_PIVOT_SLACK * all->longest;
    const Choice keeps = stood & (ankle.y + kept_arm.y <= all->clearance + slack);
    lock.pivot = keeps ? all->state.pivot : all->lowest;
    lock.arm = vec3_choose(keeps, kept_arm, low_arm);
    return lock;
}

// Returns the ankles' positions in model space above the places of their pivots. A lifted foot is as
// far above the ground as the clip has it. `arm` leads from the ankle to the pivot.
INLINE Vec3 ankle_over(const FootInputs *all, Vec3 ankle, Vec3 place, Vec3 arm, Vec3 normal,
                       Real near)
{
    const Real none = 0.0f, clearance = all->clearance;
    const Real kept = clearance > none ? clearance * (1.0f - near) : none;
    const Real above = kept + (ankle.y + arm.y - clearance);
    const Vec3 over = { place.x, place.y + above * all->stance.scale, place.z };
    const Choice leans = (normal.x != none) | (normal.z != none);
    Vec3 tilted = arm;
    if (ANY(leans)) {
        const Quat tilt = { normal.z, 0.0f, -normal.x, 1.0f + normal.y };
        const Quat slope = quat_part(quat_normalize_or(tilt, quat_identity()), near);
        tilted = vec3_choose(leans, quat_rotated(slope, arm), arm);
    }
    return vec3_add_scaled(vec3_to_model(&all->stance, over), tilted, -1.0f);
}

// Returns where feet go. The states in `all` become those after this frame.
INLINE FootGoals foot_goal(const ConstraintTables *tables, FootInputs *all)
{
    const Real none = 0.0f, one = 1.0f, most = all->longest * all->stance.scale;
    // The stride: distances that the clip steps along +Z, from the ankle's position at rest, are
    // scaled and turned, and the foot turns by them about the origin.
    const Vec3 with = all->stance.stride;
    const Real stride = all->ankle.z - all->rest_z;
    const Turn step = turn_of(with.z * stride);
    const Vec3 stepped = { all->ankle.x + stride * with.x, all->ankle.y,
                           all->rest_z + stride * with.y };
    const Vec3 ankle = turned(step, stepped);
    FootGoals goals;
    const Choice standing = stands(all, ankle.y, &goals.near);
    const float decay = 1.0f / (1.0f + tables->elapsed_secs * (1.0f / FOOT_RELEASE_SECS));
    const Vec3 own = level_direction(&all->stance, turned(step, all->along));
    const Real turns = turn_lag(&all->state, all->state.planted > (Real)(0.5f), own, decay);
    const Real lag = all->has_sole > (Real)(0.5f) ? turns : none;
    const Turn turn = turn_and(step, lag);
    const Lock to = lock(all, ankle, standing, turn, decay, most);
    const Vec3 place =
        vec3_add(vec3_to_world(&all->stance, vec3_add(ankle, to.arm)), to.vector);
    Under under = ground_under(tables, place);
    if (tables->ground->per_metre > 0.0f) {
        for (uint point = 0; point < all->points_most; point++) {
            Choice has_it;
            const Vec3 arm = turned(turn, sole_points(all, tables->soles, point, &has_it));
            const Vec3 at = vec3_to_world(&all->stance, vec3_add(ankle, arm));
            stand_on(tables, &under, vec3_add(at, to.vector), has_it, FOOT_EDGE * most);
        }
        settle(&under);
    }
    all->state.known = to.moved_elsewhere ? none : all->state.known;
    const Real ahead =
        ground_ahead(tables, &all->stance, place, under.ground, most, goals.near);
    Real climb;
    const Real height = shown_height(tables, &all->state, to.planted, &under, ahead, &climb);
    const Vec3 direction = turned(turn_of(lag), own);
    const FootState next = { to.planted ? place.x : to.vector.x,
                             to.planted ? place.z : to.vector.z,
                             to.planted ? direction.x : lag,
                             to.planted ? direction.z : none,
                             height,
                             to.planted ? height - under.ground : none,
                             climb,
                             to.pivot,
                             to.planted ? one : none,
                             to.released ? one : none,
                             one };
    all->state = next;
    const Vec3 over = { place.x, height, place.z };
    goals.normal = vec3_direction_to_model(&all->stance, under.normal);
    goals.ankle = ankle_over(all, ankle, over, to.arm, goals.normal, goals.near);
    goals.turn = turn.half_tan;
    return goals;
}
