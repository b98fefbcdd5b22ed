// foot_state.cl - States of feet in lanes: what a frame leaves for the next.
//
// Reads    states after the previous frame
// Writes   states after this frame
//
// Twin of populace-native/src/constraints/foot_state.rs: same arithmetic, same order of operations.

// A foot's state, in world space. If planted: the horizontal position of the pivot and its index, the
// direction from heel to toes along X and Z, and the height of the pivot above the true ground. Else
// the offset from the clip, and the tangent of half the angle by which the foot is turned from it.
// Then the height of the ground that the foot is shown on, and the speed at which it rises to it; and
// whether the lock was let go within a contact that has not ended, and whether the member had a state
// in the previous frame.
typedef struct {
    Real x, z, along_x, along_z, height, above, climb, pivot;
    Choice planted, released, known;
} FootState;

// Places and strides of members, in lanes.
typedef struct {
    Vec3 place, stride;
    Real scale, sine, cosine;
} Stance;

// Stored states of members' feet, sixteen numbers for two feet, and the members' epochs.
typedef struct {
    Numbers pairs[MAX_FEET / 2];
    Words epochs;
} FootStates;

// Returns the states of the first `feet` feet of each member.
INLINE FootStates foot_states(const Stop *at, uint feet)
{
    FootStates all;
    all.epochs = 0;
    for (uint lane = 0; lane < at->count; lane++)
        PUT_WORD(all.epochs, lane, at->members[lane].control.epoch);
    for (uint pair = 0; 2 * pair < feet; pair++) {
        Numbers *numbers = all.pairs + pair;
        *numbers = no_numbers();
        for (uint lane = 0; lane < at->count; lane++) {
            const Solver *s = at->members + lane;
            const uint first = s->index * STATES_PER_CONTROL + FOOT_STATE + 4 * pair;
            put_numbers(numbers, lane, (__global const float *)(s->tables->states_before + first));
        }
        turn_numbers(numbers);
    }
    return all;
}

INLINE FootState foot_state(const FootStates *all, uint foot)
{
    const Real *place = all->pairs[foot / 2].n + 8 * (foot % 2), *turn = place + 4, none = 0.0f;
    const Words bits = AS_WORDS(place[3]);
    const Choice known = bits >> FOOT_STATE_BITS == all->epochs;
    const FootState state = { known ? place[0] : none,
                              known ? place[2] : none,
                              known ? turn[0] : none,
                              known ? turn[1] : none,
                              place[1],
                              turn[2],
                              turn[3],
                              CONVERT_REAL(AS_INTS(bits >> 1 & 15u)),
                              known & ((bits & 1u) != 0u),
                              known & ((bits & 32u) != 0u),
                              known };
    return state;
}

INLINE void put_foot_state(FootStates *all, uint foot, const FootState *state)
{
    Real *place = all->pairs[foot / 2].n + 8 * (foot % 2), *turn = place + 4;
    const Words none = 0, flags = (state->released ? (Words)(32u) : none)
                                  | (state->planted ? (Words)(1u) : none);
    const Words bits =
        all->epochs << FOOT_STATE_BITS | flags | CONVERT_WORDS(state->pivot) << 1;
    place[0] = state->x;
    place[1] = state->height;
    place[2] = state->z;
    place[3] = AS_REAL(bits);
    turn[0] = state->along_x;
    turn[1] = state->along_z;
    turn[2] = state->above;
    turn[3] = state->climb;
}

// Writes the states of the first feet of members.
INLINE void keep_foot_states(const Stop *at, FootStates *all, uint feet)
{
    for (uint pair = 0; 2 * pair < feet; pair++) {
        Numbers *numbers = all->pairs + pair;
        const uint count = min(feet - 2 * pair, 2u);
        turn_numbers(numbers);
        for (uint lane = 0; lane < at->count; lane++) {
            const Solver *s = at->members + lane;
            const uint first = s->index * STATES_PER_CONTROL + FOOT_STATE + 4 * pair;
            for (uint i = 0; i < 2 * count; i++)
                s->tables->states[first + i] = numbers_in(numbers, lane, 4 * i);
        }
    }
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
