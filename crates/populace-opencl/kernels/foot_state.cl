// foot_state.cl - States of feet in lanes: what a frame leaves for the next.
//
// Reads    states after the previous frame
// Writes   states after this frame
//
// Twin of populace-native/src/constraints/foot_state.rs: same arithmetic, same order of operations.

// A foot's state, in world space. If planted: the horizontal position of the pivot and its index, and
// the direction from heel to toes along X and Z. Else the offset from the clip, and the tangent of
// half the angle by which the foot is turned from it. Then whether the lock was let go within a
// contact that has not ended, and whether the member had a state in the previous frame.
typedef struct {
    Real x, z, along_x, along_z, pivot;
    Choice planted, released, known;
} FootState;

// The height of the ground that a foot is shown on, the height of a planted foot's pivot above the
// true ground, and the speed at which the first rises.
typedef struct {
    Real shown, above, climb;
} FootHeights;

// Places and strides of members, in lanes.
typedef struct {
    Vec3 place, stride;
    Real scale, sine, cosine;
} Stance;

// Feet whose stored states are sixteen numbers, which turn into lanes at once. A GPU takes one foot
// after another, which needs no arrays.
#if LANES == 1
#define FEET_AT_ONCE 1u
#else
#define FEET_AT_ONCE 2u
#endif

INLINE uint stored_foot(const Solver *s, uint foot)
{
    return s->index * STATES_PER_CONTROL + FOOT_STATE + 2 * foot;
}

#if LANES == 1

// The member, and the first element of a foot's state, which is eight numbers.
typedef struct {
    const Solver *member;
    uint first;
} FootStates;

INLINE FootStates foot_states(const Stop *at, uint foot)
{
    const FootStates states = { at->members, stored_foot(at->members, foot) };
    return states;
}

INLINE uint epochs_of(const FootStates *all) { return all->member->control->epoch; }

INLINE float foot_number(const FootStates *all, uint nth, uint i)
{
    return ((__global const float *)(all->member->tables->states_before + all->first))[i];
}

INLINE void put_foot_number(FootStates *all, uint nth, uint i, float number)
{
    ((__global float *)(all->member->tables->states + all->first))[i] = number;
}

INLINE void keep_foot_states(const Stop *at, FootStates *all, uint first, uint count) {}

#else

// Stored states of FEET_AT_ONCE feet, and the members' epochs.
typedef struct {
    Numbers feet;
    Words epochs;
} FootStates;

INLINE FootStates foot_states(const Stop *at, uint first)
{
    FootStates all;
    all.feet = no_numbers();
    all.epochs = 0;
    for (uint lane = 0; lane < at->count; lane++) {
        const Solver *s = at->members + lane;
        PUT_WORD(all.epochs, lane, s->control->epoch);
        put_numbers(&all.feet, lane,
                    (__global const float *)(s->tables->states_before + stored_foot(s, first)));
    }
    turn_numbers(&all.feet);
    return all;
}

INLINE Words epochs_of(const FootStates *all) { return all->epochs; }

INLINE Real foot_number(const FootStates *all, uint nth, uint i)
{
    return all->feet.n[8 * nth + i];
}

INLINE void put_foot_number(FootStates *all, uint nth, uint i, Real number)
{
    all->feet.n[8 * nth + i] = number;
}

// Writes the states of `count` feet of members, from `first` on.
INLINE void keep_foot_states(const Stop *at, FootStates *all, uint first, uint count)
{
    turn_numbers(&all->feet);
    for (uint lane = 0; lane < at->count; lane++) {
        const Solver *s = at->members + lane;
        for (uint i = 0; i < 2 * count; i++)
            s->tables->states[stored_foot(s, first) + i] = numbers_in(&all->feet, lane, 4 * i);
    }
}

#endif

// Numbers of a foot's state.
enum { FOOT_X, FOOT_SHOWN, FOOT_Z, FOOT_BITS, FOOT_ALONG_X, FOOT_ALONG_Z, FOOT_ABOVE, FOOT_CLIMB };

INLINE FootState foot_state(const FootStates *all, uint nth)
{
    const Real none = 0.0f;
    const Words bits = AS_WORDS(foot_number(all, nth, FOOT_BITS));
    const Choice known = bits >> FOOT_STATE_BITS == epochs_of(all);
    const FootState state = { known ? foot_number(all, nth, FOOT_X) : none,
                              known ? foot_number(all, nth, FOOT_Z) : none,
                              known ? foot_number(all, nth, FOOT_ALONG_X) : none,
                              known ? foot_number(all, nth, FOOT_ALONG_Z) : none,
                              CONVERT_REAL(AS_INTS(bits >> 1 & 15u)),
                              known & ((bits & 1u) != 0u),
                              known & ((bits & 32u) != 0u),
                              known };
    return state;
}

INLINE FootHeights foot_heights(const FootStates *all, uint nth)
{
    const FootHeights heights = { foot_number(all, nth, FOOT_SHOWN),
                                  foot_number(all, nth, FOOT_ABOVE),
                                  foot_number(all, nth, FOOT_CLIMB) };
    return heights;
}

INLINE void put_foot_state(FootStates *all, uint nth, FootState state)
{
    const Words none = 0, flags = (state.released ? (Words)(32u) : none)
                                  | (state.planted ? (Words)(1u) : none);
    const Words bits = epochs_of(all) << FOOT_STATE_BITS | flags | CONVERT_WORDS(state.pivot) << 1;
    put_foot_number(all, nth, FOOT_X, state.x);
    put_foot_number(all, nth, FOOT_Z, state.z);
    put_foot_number(all, nth, FOOT_BITS, AS_REAL(bits));
    put_foot_number(all, nth, FOOT_ALONG_X, state.along_x);
    put_foot_number(all, nth, FOOT_ALONG_Z, state.along_z);
}

INLINE void put_foot_heights(FootStates *all, uint nth, FootHeights heights)
{
    put_foot_number(all, nth, FOOT_SHOWN, heights.shown);
    put_foot_number(all, nth, FOOT_ABOVE, heights.above);
    put_foot_number(all, nth, FOOT_CLIMB, heights.climb);
}

INLINE Stance stance_of(const Stop *at)
{
    Numbers all = no_numbers();
    for (uint lane = 0; lane < at->count; lane++) {
        const Solver *s = at->members + lane;
        put_numbers(&all, lane, (__global const float *)(s->tables->controls + s->index));
    }
    turn_numbers(&all);
    const Stance stance = { vec3_of(&all, 0), vec3_of(&all, 4), all.n[3], all.n[8], all.n[9] };
    return stance;
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
