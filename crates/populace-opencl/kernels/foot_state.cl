// foot_state.cl - States of feet in lanes: what a frame leaves for the next.
//
// Reads    states after the previous frame
// Writes   states after this frame
//
// Twin of populace-native/src/constraints/foot_state.rs: same arithmetic, same order of operations.

// A foot's state, in world space. If planted: the horizontal position of the pivot and its index, the
// direction from heel to toes along X and Z, and the height of the pivot above the true ground. Else
// the offset from the clip, and the tangent of half the angle by which the foot is turned from it.
// Then the height of the ground that the foot is shown on, and the speed at which it rises to it.
// Flags are 1 for true: the lock was let go within a contact that has not ended; the member had a
// state in the previous frame.
typedef struct {
    Real x, z, along_x, along_z, height, above, climb, pivot;
    Real planted, released, known;
} FootState;

// Puts the state of a member's foot into a lane. Returns the index of the point of the sole that
// stands, NONE if the foot is not planted.
INLINE uint foot_states(FootState *all, uint lane, const Solver *s, float4 left, float4 turned)
{
    const uint bits = as_uint(left.w), pivot = bits >> 1 & 15u;
    const bool known = bits >> FOOT_STATE_BITS == s->control.epoch, planted = known && (bits & 1u);
    PUT(all->x, lane, known ? left.x : 0.0f);
    PUT(all->z, lane, known ? left.z : 0.0f);
    PUT(all->along_x, lane, known ? turned.x : 0.0f);
    PUT(all->along_z, lane, known ? turned.y : 0.0f);
    PUT(all->height, lane, left.y);
    PUT(all->above, lane, turned.z);
    PUT(all->climb, lane, turned.w);
    PUT(all->pivot, lane, (float)pivot);
    PUT(all->planted, lane, planted ? 1.0f : 0.0f);
    PUT(all->released, lane, known && (bits & 32u) ? 1.0f : 0.0f);
    PUT(all->known, lane, known ? 1.0f : 0.0f);
    return planted ? pivot : NONE;
}

// Writes the state in a lane as that of a member's foot.
INLINE void keep_foot_states(const FootState *all, uint lane, const Solver *s, uint foot)
{
    const uint flags =
        (LANE(all->released, lane) > 0.5f ? 32u : 0u) | (LANE(all->planted, lane) > 0.5f ? 1u : 0u);
    const uint bits =
        s->control.epoch << FOOT_STATE_BITS | flags | (uint)LANE(all->pivot, lane) << 1;
    __global float4 *states = s->tables->states + s->index * STATES_PER_CONTROL + foot;
    states[0] = (float4)(LANE(all->x, lane), LANE(all->height, lane), LANE(all->z, lane),
                         as_float(bits));
    states[FOOT_TURN_STATE] = (float4)(LANE(all->along_x, lane), LANE(all->along_z, lane),
                                       LANE(all->above, lane), LANE(all->climb, lane));
}

// Places and strides of members, in lanes.
typedef struct {
    Vec3 place, stride;
    Real scale, sine, cosine;
} Stance;

INLINE void put_stance(Stance *all, uint lane, const Control *control)
{
    put_vec3(&all->place, lane, control->place);
    put_vec3(&all->stride, lane, control->stride);
    PUT(all->scale, lane, control->place.w);
    PUT(all->sine, lane, control->facing.x);
    PUT(all->cosine, lane, control->facing.y);
}

// Takes directions from world to model space.
INLINE Vec3 vec3_direction_to_model(const Stance *stance, Vec3 d)
{
    const Real sine = stance->sine, cosine = stance->cosine;
    const Vec3 v = { cosine * d.x - sine * d.z, d.y, sine * d.x + cosine * d.z };
    return v;
}

INLINE Vec3 vec3_to_model(const Stance *stance, Vec3 point)
{
    const Vec3 d = { point.x - stance->place.x, point.y - stance->place.y,
                     point.z - stance->place.z };
    return vec3_scale(vec3_direction_to_model(stance, d), 1.0f / stance->scale);
}

INLINE Vec3 vec3_to_world(const Stance *stance, Vec3 p)
{
    const Vec3 place = stance->place;
    const Real sine = stance->sine, cosine = stance->cosine, scale = stance->scale;
    const Vec3 v = { (cosine * p.x + sine * p.z) * scale + place.x, p.y * scale + place.y,
                     (cosine * p.z - sine * p.x) * scale + place.z };
    return v;
}
