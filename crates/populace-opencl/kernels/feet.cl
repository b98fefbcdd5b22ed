// feet.cl - Foot IK: planted feet stay where they stand, and the pelvis sinks so that they reach
// it.
//
// Reads    local transforms of the legs; the goals of the feet
// Writes   the model transform of the pelvis or hip; step_rotations of hip, knee and ankle; the
//          states of feet and pelvis after this frame
//
// Twin of populace-native/src/constraints/feet.rs: same arithmetic, same order of operations.

// Legs and their goals: the limbs, in `follows` the ground's normal and how much the foot follows it,
// the turn of the foot, and the settings of their constraints.
typedef struct {
    Limb limb;
    BoneLengths lengths;
    Quat follows;
    Real turn, soft, weight;
} Legs;

// Walks down the chains of legs from link `start`, which is the joint of the step. `axis` is the
// direction in the hip that the knee bends to.
INLINE void walk_leg(const Stop *at, __global const Constraint *foot, uint start, Vec3 axis,
                     Leg *leg)
{
    const uint ankle = ankle_link(foot);
    const Vec3 none = { 0.0f, 0.0f, 0.0f };
    leg->hip = leg->knee = leg->bend = none;
    leg->toes = leg->ankle = own_models(at);
    for (uint link = start; link < foot->link_count; link++) {
        if (link > start) walk(at, foot, link, &leg->toes);
        if (link == foot->upper) {
            leg->hip = matrix_origin(&leg->toes);
            leg->bend = matrix_transform_vector(&leg->toes, axis);
        }
        if (link == foot->middle) leg->knee = matrix_origin(&leg->toes);
        if (link == ankle) leg->ankle = leg->toes;
    }
}

// Puts legs and their goals together.
INLINE Legs bend_leg(const Leg *leg, const FootGoals *goals, Real soft, Real weight)
{
    const Limb limb = { vec3_add_scaled(leg->knee, leg->hip, -1.0f),
                        vec3_add_scaled(matrix_origin(&leg->ankle), leg->knee, -1.0f), leg->bend,
                        vec3_add_scaled(goals->ankle, leg->hip, -1.0f) };
    const Legs legs = { limb,
                        bone_lengths(limb),
                        { goals->normal.x, goals->normal.y, goals->normal.z, goals->near },
                        goals->turn,
                        soft,
                        weight };
    return legs;
}

// Returns how far the pelvis has to sink for each leg to reach its goal, times the leg's weight.
INLINE Real sinks(const Legs *legs)
{
    const Real length = legs->lengths.upper + legs->lengths.lower;
    const Real reach = length * (1.0f - legs->soft), most = length * MAX_PELVIS_SINK;
    const Vec3 to = legs->limb.to;
    const Real needed = -to.y - square_root(reach * reach - to.x * to.x - to.z * to.z);
    return (needed > most ? most : needed) * legs->weight;
}

// Rotations of hips, knees and ankles.
typedef struct {
    Quat hip, knee, ankle;
} LegRotations;

INLINE LegRotations leg_rotations(const Legs *legs)
{
    const Vec3 no_pole = { 0.0f, 0.0f, 0.0f };
    const Real weight = legs->weight;
    Quat hip, knee;
    limb_rotations(legs->limb, legs->lengths, no_pole, 0, legs->soft, &hip, &knee);
    hip = weighted(hip, weight);
    knee = weighted(knee, weight);
    // The ankle keeps the rotation of its clips and follows the slope: the rotation from straight
    // up to the normal.
    const Quat about = { 0.0f, legs->turn * weight, 0.0f, 1.0f };
    Quat ankle = quat_normalize_or(about, quat_identity());
    const Quat follows = legs->follows;
    const Choice leans = (follows.x != (Real)(0.0f)) | (follows.z != (Real)(0.0f));
    if (ANY(leans)) {
        const Quat tilt = { follows.z, 0.0f, -follows.x, 1.0f + follows.y };
        const Quat slope = quat_normalize_or(tilt, quat_identity());
        const Quat sloped = quat_mul(quat_part_as_told(slope, follows.w * weight), ankle);
        ankle = quat_choose(leans, sloped, ankle);
    }
    const LegRotations rotations = { hip, knee,
                                     quat_mul(ankle, quat_conjugate(quat_mul(knee, hip))) };
    return rotations;
}

INLINE void hand_down_leg(Stop *at, uint foot, const Legs *legs)
{
    const LegRotations rotations = leg_rotations(legs);
    hand_down(at, 3 * foot, rotations.hip);
    hand_down(at, 3 * foot + 1, rotations.knee);
    hand_down(at, 3 * foot + 2, rotations.ankle);
}

// Hands down goals, for legs that are solved later.
INLINE void hand_down_goals(Stop *at, uint foot, const FootGoals *goals)
{
    const Quat ankle = { goals->ankle.x, goals->ankle.y, goals->ankle.z, goals->turn };
    const Quat follows = { goals->normal.x, goals->normal.y, goals->normal.z, goals->near };
    hand_down(at, 3 * foot, ankle);
    hand_down(at, 3 * foot + 1, follows);
}

// Returns legs from link `start` on, which is the joint of the step, to goals that were handed down.
INLINE Legs legs_to_goals(const Stop *at, uint foot, uint start)
{
    const Numbers settings = settings_of(at, foot);
    const Quat ankle = handed_down(at, 3 * foot), follows = handed_down(at, 3 * foot + 1);
    const FootGoals goals = {
        { ankle.x, ankle.y, ankle.z }, { follows.x, follows.y, follows.z }, ankle.w, follows.w, 0
    };
    Leg leg;
    walk_leg(at, constraint_in(at, 0) + foot, start, vec3_of(&settings, 0), &leg);
    return bend_leg(&leg, &goals, settings.n[12], settings.n[13]);
}

// Returns the seconds for which all feet will have stood if none lets go, at most FOOT_SETTLE_SECS.
INLINE Real stood_after(const Stop *at)
{
    const Real most = FOOT_SETTLE_SECS;
    Real before = 0.0f;
    for (uint lane = 0; lane < at->count; lane++) {
        const Solver *s = at->members + lane;
        const float4 left = s->tables->states_before[s->index * STATES_PER_CONTROL + PELVIS_STATE];
        PUT(before, lane, as_uint(left.w) == s->control->epoch ? left.y : 0.0f);
    }
    const Real after = before + at->members->tables->elapsed_secs;
    return after < most ? after : most;
}

// Returns how far pelvises are lowered, in metres, and keeps it with the seconds for which all feet
// have stood. Pelvises sink at once, so that feet reach the ground, and take their time to rise.
INLINE Real eased_drop(const Stop *at, Real wanted, Real stood_secs)
{
    const float elapsed_secs = at->members->tables->elapsed_secs,
                part = elapsed_secs / (elapsed_secs + PELVIS_RISE_SECS);
    Real before = 0.0f, known = 0.0f;
    for (uint lane = 0; lane < at->count; lane++) {
        const Solver *s = at->members + lane;
        const float4 left = s->tables->states_before[s->index * STATES_PER_CONTROL + PELVIS_STATE];
        PUT(before, lane, left.x);
        PUT(known, lane, as_uint(left.w) == s->control->epoch ? 1.0f : 0.0f);
    }
    const Choice rises = (wanted < before) & (known > (Real)(0.5f));
    const Real drop = rises ? before + (wanted - before) * part : wanted;
    for (uint lane = 0; lane < at->count; lane++) {
        const Solver *s = at->members + lane;
        s->tables->states[s->index * STATES_PER_CONTROL + PELVIS_STATE] =
            (float4)(LANE(drop, lane), LANE(stood_secs, lane), 0.0f, as_float(s->control->epoch));
    }
    return drop;
}

// Finds the goals of all feet, and lowers pelvises until the legs can reach them. Solves the legs
// too, unless another step moves them after the pelvis.
SELDOM void pelvis(Stop *at)
{
    __global const Constraint *feet = constraint_in(at, 0);
    const uint count = feet->target_count;
    const Stance stance = stance_of(at);
    const Real none = 0.0f;
    Real needed = 0.0f, stood_secs = stood_after(at);
#if LANES > 1
    Legs legs[MAX_FEET];
#endif
    for (uint first = 0; first < count; first += FEET_AT_ONCE) {
        FootStates states = foot_states(at, first);
        Real within_secs[FEET_AT_ONCE];
        const uint here = FEET_AT_ONCE == 1 ? 1 : min(count - first, FEET_AT_ONCE);
        put_contacts(at, feet + first, here, within_secs);
        for (uint nth = 0; nth < here; nth++) {
            const uint foot = first + nth;
            const Numbers settings = settings_of(at, foot);
            Leg leg;
            walk_leg(at, feet + foot, 0, vec3_of(&settings, 0), &leg);
            const FootInputs inputs = { at,   at->members->tables, feet + foot, &settings, &stance,
                                        &leg, within_secs[nth], stood_secs };
            const FootGoals goals = foot_goal(&inputs, &states, nth);
            stood_secs = goals.planted ? stood_secs : none;
            if (LANES == 1 || !feet->at_once) hand_down_goals(at, foot, &goals);
#if LANES == 1
            const Legs bent = legs_to_goals(at, foot, 0);
#else
            const Legs bent = bend_leg(&leg, &goals, settings.n[12], settings.n[13]);
            legs[foot] = bent;
#endif
            const Real own = sinks(&bent);
            needed = needed < own ? own : needed;
        }
        keep_foot_states(at, &states, first, here);
    }
    const Real drop = eased_drop(at, needed, stood_secs);
    for (uint foot = 0; foot < count && feet->at_once; foot++) {
#if LANES > 1
        Legs bent = legs[foot];
#else
        // Walks once more, since an array that a variable indexes would take a GPU's stack.
        Legs bent = legs_to_goals(at, foot, 0);
#endif
        bent.limb.to.y += drop;
        hand_down_leg(at, foot, &bent);
    }
    Matrix own = own_models(at);
    own.m[7] -= drop;
    keep_models(at->joints, at->step.joint, &own);
}

// Solves legs that another step moved after the pelvis. They go where the pelvis step found.
SELDOM void foot(Stop *at)
{
    __global const Constraint *constraint = constraint_in(at, 0);
    const Legs legs = legs_to_goals(at, 0, constraint->upper);
    hand_down_leg(at, 0, &legs);
    rotate_own(at, handed_down(at, 0));
}
