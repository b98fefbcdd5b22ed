// foot.cl - Where a foot of a member goes: with its clips and its stride, locked to the ground while
// it stands.
//
// Reads    the leg's transforms; soles; the ground; the foot's state after the previous frame
// Writes   the foot's state after this frame
//
// Twin of populace-native/src/constraints/foot.rs, populace-native/src/constraints/foothold.rs and,
// for the ground, populace-device/src/tables/controls/ground.rs: same arithmetic, same order of
// operations.

// Returns the index of the last grid sample at or before `at` that has a successor. *between is the
// fraction of the way to that successor.
INLINE uint grid_sample(float at, uint count, float *between)
{
    const float last = (float)(count - 1), inside = at > 0.0f ? (at < last ? at : last) : 0.0f;
    const uint whole = min((uint)inside, count - 2);
    *between = inside - (float)whole;
    return whole;
}

// Returns the ground's unit normal in x, y, z and its height in w, at a point of the world.
INLINE float4 ground_at(const ConstraintTables *tables, float x, float z)
{
    const Ground ground = *tables->ground;
    float height = ground.offset + ground.slope_x * x + ground.slope_z * z;
    float slope_x = ground.slope_x, slope_z = ground.slope_z;
    if (ground.per_metre > 0.0f) {
        float fraction_x, fraction_z;
        const uint column =
            grid_sample((x - ground.grid_x) * ground.per_metre, ground.count_x, &fraction_x);
        const uint row =
            grid_sample((z - ground.grid_z) * ground.per_metre, ground.count_z, &fraction_z);
        __global const float *at = tables->heights + row * ground.count_x + column;
        const float h00 = at[0], h10 = at[1], h01 = at[ground.count_x],
                    h11 = at[ground.count_x + 1];
        const float near = h00 + (h10 - h00) * fraction_x, far = h01 + (h11 - h01) * fraction_x;
        height += near + (far - near) * fraction_z;
        slope_x += ((h10 - h00) + ((h11 - h01) - (h10 - h00)) * fraction_z) * ground.per_metre;
        slope_z += (far - near) * ground.per_metre;
    }
    const float4 normal = unit_or(vec(-slope_x, 1.0f, -slope_z), vec(0.0f, 1.0f, 0.0f));
    return (float4)(normal.xyz, height);
}

// A foot's state after the previous frame, in world space. If planted: the horizontal position of the
// pivot and its index, the direction from heel to toes along X and Z, and the height of the pivot
// above the true ground. Else the offset from the clip, and the tangent of half the angle by which the
// foot is turned from it. Then the height of the ground that the foot is shown on, and the speed at
// which it rises to it. A lock may have been let go within a contact that has not ended.
typedef struct {
    float4 vector;
    float2 direction;
    float height, above, climb;
    uint pivot;
    bool planted, released, known;
} FootState;

INLINE FootState foot_state(const Solver *s, float4 left, float4 turned)
{
    const uint bits = as_uint(left.w);
    const bool known = bits >> FOOT_STATE_BITS == s->control.epoch;
    const FootState state = { known ? vec(left.x, 0.0f, left.z) : vec(0.0f, 0.0f, 0.0f),
                              known ? turned.xy : (float2)(0.0f),
                              left.y,
                              turned.z,
                              turned.w,
                              bits >> 1 & 15u,
                              known && (bits & 1u),
                              known && (bits & 32u),
                              known };
    return state;
}

INLINE void keep_foot_state(const Solver *s, uint foot, FootState state)
{
    const uint flags = (state.released ? 32u : 0u) | (state.planted ? 1u : 0u);
    const uint bits = s->control.epoch << FOOT_STATE_BITS | flags | state.pivot << 1;
    __global float4 *states = s->tables->states + s->index * STATES_PER_CONTROL + foot;
    states[0] = (float4)(state.vector.x, state.height, state.vector.z, as_float(bits));
    states[FOOT_TURN_STATE] = (float4)(state.direction, state.above, state.climb);
}

// Returns the tangent of half the angle by which a foot is turned from where the clip has it. `own`
// is the direction from heel to toes in the clip, in world space.
INLINE float turn_lag(FootState state, float2 own, float decay)
{
    float lag = state.direction.x * decay;
    if (state.planted) {
        const float x = state.direction.x, z = state.direction.y;
        const float cross = own.y * x - own.x * z, dot = own.x * x + own.y * z;
        lag = dot > 0.0f ? cross / (1.0f + dot) : 0.0f;
    }
    return lag > FOOT_MAX_TURN ? FOOT_MAX_TURN : lag < -FOOT_MAX_TURN ? -FOOT_MAX_TURN : lag;
}

// Returns the unit direction in world space of a vector of model space, along X and Z.
INLINE float2 level_direction(const Solver *s, float4 v)
{
    const float sine = s->control.facing.x, cosine = s->control.facing.y;
    const float4 along = unit_or(vec(cosine * v.x + sine * v.z, 0.0f, cosine * v.z - sine * v.x),
                                 vec(0.0f, 0.0f, 1.0f));
    return (float2)(along.x, along.z);
}

// A leg as its clips pose it, in model space: with the transforms of the ankle and of the joint that
// carries the front of the sole.
typedef struct {
    float4 hip, knee, bend;
    float16 ankle, toes;
} Leg;

// A rotation about +Y, by the tangent of half its angle.
typedef struct {
    float half_tan, sine, cosine;
} Turn;

INLINE Turn turn_of(float half_tan)
{
    const float inverse = 1.0f / (1.0f + half_tan * half_tan);
    const Turn turn = { half_tan, (half_tan + half_tan) * inverse, 2.0f * inverse - 1.0f };
    return turn;
}

// Returns the turn by the sum of two angles, which is less than half a turn.
INLINE Turn turn_and(Turn turn, float half_tan)
{
    return turn_of((turn.half_tan + half_tan) / (1.0f - turn.half_tan * half_tan));
}

INLINE float4 turned(Turn turn, float4 v)
{
    return vec(turn.cosine * v.x + turn.sine * v.z, v.y, turn.cosine * v.z - turn.sine * v.x);
}

// A foot as its clips and the member's stride pose it, in model space, in `along` from heel to ball as
// the clips have it, and the lowest point of the sole with its height.
typedef struct {
    float4 ankle, along;
    Turn turn;
    float clearance;
    uint lowest;
} Stepped;

// Finds the lowest of the points that a joint carries, the first of which has the index `first`.
INLINE void lower(Stepped *stepped, float16 joint, __global const float4 *points, uint count,
                  uint first)
{
    for (uint i = 0; i < count; i++) {
        const float4 at = points[i];
        const float height = joint.s4 * at.x + joint.s5 * at.y + joint.s6 * at.z + joint.s7;
        if (height < stepped->clearance) {
            stepped->lowest = first + i;
            stepped->clearance = height;
        }
    }
}

// Returns a point of the sole as the clips pose it; beneath the ankle if none is known.
INLINE float4 sole_point(const Leg *leg, __global const Constraint *foot,
                         __global const float4 *soles, uint point)
{
    if (point < foot->sole_count)
        return transform_point(leg->ankle, soles[foot->sole_first + point]);
    if (point - foot->sole_count < foot->toe_count)
        return transform_point(leg->toes, soles[foot->toe_first + (point - foot->sole_count)]);
    return vec(leg->ankle.s3, leg->ankle.s7 - foot->limits.w, leg->ankle.sb);
}

// Applies the member's stride: distances that the clip steps along +Z, from the ankle's position at
// rest, are scaled and turned, and the foot turns by them about the origin.
INLINE Stepped step_foot(const Leg *leg, __global const Constraint *foot,
                         __global const float4 *soles, float4 with)
{
    Stepped stepped;
    const float4 ankle = origin_of(leg->ankle);
    const float rest_z = foot->limits.z, stride = ankle.z - rest_z;
    stepped.turn = turn_of(with.z * stride);
    stepped.ankle = turned(stepped.turn, vec(ankle.x + stride * with.x, ankle.y,
                                             rest_z + stride * with.y));
    __global const float4 *of_ankle = soles + foot->sole_first;
    stepped.along = vec(0.0f, 0.0f, 0.0f);
    if (foot->sole_count > 1)
        stepped.along =
            transform_vector(leg->ankle, of_ankle[foot->sole_count - 1] - of_ankle[0]);
    stepped.lowest = 0;
    stepped.clearance = FLT_MAX;
    lower(&stepped, leg->ankle, of_ankle, foot->sole_count, 0);
    lower(&stepped, leg->toes, soles + foot->toe_first, foot->toe_count, foot->sole_count);
    if (foot->sole_count + foot->toe_count == 0) stepped.clearance = ankle.y - foot->limits.w;
    return stepped;
}

// Returns a part of the way from 0 to 1 that begins and ends without speed.
INLINE float eased(float part)
{
    part = part > 0.0f ? (part < 1.0f ? part : 1.0f) : 0.0f;
    return part * part * (3.0f - 2.0f * part);
}

// Returns a height on the way from that of the frame before, at a limited speed, whose gain and loss
// are limited. It comes to rest at the height. *climb is the speed of the frame before, then that of
// the way.
INLINE float climbs(const Solver *s, float before, float *climb, float wanted)
{
    const float secs = s->tables->elapsed_secs;
    const float way = wanted - before, far = way < 0.0f ? -way : way;
    if (far * 1.5f <= FOOT_CLIMB_M_PER_SEC * secs) { // a slope, along which feet do not lag
        *climb = secs > 0.0f ? way / secs : *climb;
        return wanted;
    }
    const float stopping = root(2.0f * FOOT_CLIMB_GAIN * far);
    float most = stopping < FOOT_CLIMB_M_PER_SEC ? stopping : FOOT_CLIMB_M_PER_SEC;
    most = most * secs > far ? far / secs : most;
    const float gain = FOOT_CLIMB_GAIN * secs, low = *climb - gain, high = *climb + gain;
    const float aim = way < 0.0f ? -most : most;
    *climb = aim > high ? high : aim < low ? low : aim;
    return before + *climb * secs;
}

// Returns the ground beneath a lifted foot: its true height or that a little ahead, whichever is
// higher. The nearer the foot is to standing (`near` is 1), the less it looks ahead. The foot rises
// to the ground at the speed *climb.
INLINE float ground_beneath(const Solver *s, FootState state, float4 at, float height, float most,
                            float near, float *climb)
{
    *climb = 0.0f;
    if (!state.known) return height;
    *climb = state.climb;
    float wanted = height;
    if (s->tables->ground->per_metre > 0.0f) {
        const float4 stride = s->control.stride, facing = s->control.facing;
        const float ahead = FOOT_AHEAD * most;
        const float x = at.x + (facing.y * stride.x + facing.x * stride.y) * ahead,
                    z = at.z + (facing.y * stride.y - facing.x * stride.x) * ahead;
        const float next = ground_at(s->tables, x, z).w - height;
        const float rise = 0.0f > next ? 0.0f : next;
        wanted = height + rise * (1.0f - near);
    }
    return climbs(s, state.height, climb, wanted);
}

// Returns the height that a planted foot is shown at. It rises at the speed *climb.
INLINE float height_planted(const Solver *s, FootState state, float ground, bool on_edge,
                            float *climb)
{
    *climb = 0.0f;
    if (!state.known) return ground;
    *climb = state.climb;
    if (state.planted && !on_edge) return ground + climbs(s, state.above, climb, 0.0f);
    return climbs(s, state.height, climb, ground);
}

// The ground under a sole of which the pivot stands. On an edge the ground under a point of the sole
// is far off the plane through the pivot, and the sole is level.
typedef struct {
    float4 pivot;
    float height, level, tilted, fall_x, fall_z, edge;
    bool on_edge;
} Under;

// Takes a point of the sole into account. The sole is so high that the point is not in the ground.
INLINE void stand_on(const Solver *s, Under *under, float4 at)
{
    const float x = at.x - under->pivot.x, z = at.z - under->pivot.z;
    const float ground = ground_at(s->tables, at.x, at.z).w;
    const float above = at.y - under->pivot.y, fall = under->fall_x * x + under->fall_z * z;
    const float level = ground - above, tilted = ground + fall - above;
    under->level = level > under->level ? level : under->level;
    under->tilted = tilted > under->tilted ? tilted : under->tilted;
    const float off = ground + fall - under->height;
    under->on_edge = under->on_edge || off * off > under->edge * under->edge;
}

// Returns whether an offset takes an ankle too far from its hip, horizontally.
INLINE bool overstretches(const Solver *s, const Leg *leg, Stepped stepped, float4 offset,
                          float most)
{
    const float4 own = to_world(s->control, stepped.ankle) - to_world(s->control, leg->hip);
    const float x = own.x + offset.x, z = own.z + offset.z;
    const float of_clip = own.x * own.x + own.z * own.z, with_offset = x * x + z * z;
    return with_offset > of_clip && with_offset > FOOT_REACH * FOOT_REACH * most * most;
}

// Returns where a point of the sole of a turned foot is, relative to the ankle.
INLINE float4 sole_arm(const Leg *leg, __global const Constraint *foot,
                       __global const float4 *soles, uint point, Turn turn)
{
    return turned(turn, sole_point(leg, foot, soles, point) - origin_of(leg->ankle));
}

// Returns where the ankle goes, in model space, and in w the turn of the foot. *follows holds the
// ground's normal there and, in w, how much the foot follows it. `left` is the foot's state after the
// previous frame; `within_secs` is the time within its contact, NAN if that is not known.
INLINE float4 foot_goal(const Solver *s, uint foot, __global const Constraint *constraint,
                        const Leg *leg, float within_secs, const float4 *left, float4 *follows)
{
    const float rest = constraint->up.x, planted_below = constraint->up.y,
                lifted_above = constraint->up.z, held_most = constraint->up.w;
    const float size = s->control.place.w, most = held_most * size;
    __global const float4 *soles = s->tables->soles;
    const Stepped stepped = step_foot(leg, constraint, soles, s->control.stride);
    const float lift = stepped.ankle.y - rest;
    const bool unknown = isnan(within_secs);
    const float above_planted = (lift - planted_below) / (lifted_above - planted_below);
    const bool stands = unknown ? lift <= planted_below : within_secs >= 0.0f;
    const float near = eased(unknown ? 1.0f - above_planted
                                     : 1.0f + within_secs * (1.0f / FOOT_NEAR_SECS));
    FootState state = foot_state(s, left[0], left[1]);
    const float decay = 1.0f / (1.0f + s->tables->elapsed_secs * (1.0f / FOOT_RELEASE_SECS));
    const uint points = constraint->sole_count + constraint->toe_count;
    const float2 own = level_direction(s, turned(stepped.turn, stepped.along));
    const float lag = constraint->sole_count > 1 ? turn_lag(state, own, decay) : 0.0f;
    const Turn turn = turn_and(stepped.turn, lag);
    const float4 kept_arm = state.planted ? sole_arm(leg, constraint, soles, state.pivot, turn)
                                          : vec(0.0f, 0.0f, 0.0f);
    float4 behind = state.planted
                        ? state.vector - to_world(s->control, stepped.ankle + kept_arm)
                        : state.vector * decay;
    behind.y = 0.0f;
    const float far2 = vec_dot(behind, behind);
    const bool moved_elsewhere = far2 > 4.0f * most * most;
    if (moved_elsewhere)
        behind = vec(0.0f, 0.0f, 0.0f);
    else if (far2 > most * most)
        behind = behind * (most * inverse_root(far2));
    const float relock = FOOT_RELOCK * most;
    const bool is_behind = state.released && vec_dot(behind, behind) > relock * relock;
    const bool released = stands && (is_behind || overstretches(s, leg, stepped, behind, most));
    const bool planted = stands && !released;
    const float slack = FOOT_PIVOT_SLACK * held_most;
    const bool keeps =
        state.planted && stepped.ankle.y + kept_arm.y <= stepped.clearance + slack;
    const uint pivot = keeps ? state.pivot : stepped.lowest;
    const float4 arm = keeps ? kept_arm : sole_arm(leg, constraint, soles, pivot, turn);
    const float4 place = to_world(s->control, stepped.ankle + arm) + behind;
    bool on_edge = false;
    float4 ground = ground_at(s->tables, place.x, place.z);
    if (s->tables->ground->per_metre > 0.0f && points > 0) {
        Under under = { place,    ground.w,
                        ground.w, ground.w,
                        ground.x / ground.y, ground.z / ground.y,
                        FOOT_EDGE * most, false };
        for (uint point = 0; point < points; point++) {
            const float4 of_point = sole_arm(leg, constraint, soles, point, turn);
            stand_on(s, &under, to_world(s->control, stepped.ankle + of_point) + behind);
        }
        on_edge = under.on_edge;
        if (on_edge)
            ground = (float4)(0.0f, 1.0f, 0.0f, under.level);
        else
            ground.w = under.tilted;
    }
    if (moved_elsewhere) state.known = false;
    float climb;
    const float height = planted ? height_planted(s, state, ground.w, on_edge, &climb)
                                 : ground_beneath(s, state, place, ground.w, most, near, &climb);
    const float4 direction = turned(turn_of(lag), vec(own.x, 0.0f, own.y));
    const FootState next = { planted ? place : behind,
                             planted ? (float2)(direction.x, direction.z) : (float2)(lag, 0.0f),
                             height,
                             planted ? height - ground.w : 0.0f,
                             climb,
                             pivot,
                             planted,
                             released,
                             true };
    keep_foot_state(s, foot, next);

    const float clearance = stepped.clearance > 0.0f ? stepped.clearance * (1.0f - near) : 0.0f;
    const float above = clearance + (stepped.ankle.y + arm.y - stepped.clearance);
    const float y = height + above * size;
    const float4 normal = direction_to_model(s->control, ground);
    float4 tilted = arm;
    if (normal.x != 0.0f || normal.z != 0.0f) {
        const float4 tilt =
            rotation_unit((float4)(normal.z, 0.0f, -normal.x, 1.0f + normal.y));
        tilted = rotated(part_of(tilt, near), arm);
    }
    *follows = (float4)(normal.xyz, near);
    const float4 goes_to = to_model(s->control, vec(place.x, y, place.z)) - tilted;
    return (float4)(goes_to.xyz, turn.half_tan);
}
