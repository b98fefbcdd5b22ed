// constraints.cl - Runs a member's constraint program on the way down its hierarchy: constraints,
// overrides in model space, users' stages, watched joints, attachments and root motion.
//
// Constraints rotate joints in model space, each about its own origin, once the joint's parent has
// its final transform. A constraint is solved at the first joint of its chain, from the chain's
// local transforms, and hands rotations down to the other joints.
//
// Twin of populace-native/src/constraints.rs: same arithmetic, same order of operations.

// Returns a column of a transform: the image of an axis.
INLINE float4 column_of(float16 m, uint column)
{
    return column == 0   ? vec(m.s0, m.s4, m.s8)
           : column == 1 ? vec(m.s1, m.s5, m.s9)
                         : vec(m.s2, m.s6, m.sa);
}

// Interpolates two affine transforms: the origin in a straight line, the axes by the shorter
// rotation, and their lengths in proportion.
SELDOM float16 part_of_the_way(float16 from, float16 to, float k)
{
    const float4 from_x = unit_or(column_of(from, 0), vec(1.0f, 0.0f, 0.0f)),
                 to_x = unit_or(column_of(to, 0), vec(1.0f, 0.0f, 0.0f));
    const float4 from_y = unit_or(across(column_of(from, 1), from_x), any_across(from_x));
    const float4 to_y = unit_or(across(column_of(to, 1), to_x), any_across(to_x));
    const float4 first = rotation_between(from_x, to_x, from_y);
    const float4 second = rotation_between(rotated(first, from_y), to_y, to_x);
    float16 m = affine_rotated(from, part_of(rotation_mul(second, first), k));
    float factors[3];
    for (uint c = 0; c < 3; c++) {
        const float old = vec_length(column_of(from, c)), new = vec_length(column_of(to, c));
        factors[c] = old > 1e-10f ? 1.0f + (new / old - 1.0f) * k : 1.0f;
    }
    m *= (float16)((float4)(factors[0], factors[1], factors[2], 1.0f),
                   (float4)(factors[0], factors[1], factors[2], 1.0f),
                   (float4)(factors[0], factors[1], factors[2], 1.0f), (float4)(1.0f));
    m.s3 = from.s3 + (to.s3 - from.s3) * k;
    m.s7 = from.s7 + (to.s7 - from.s7) * k;
    m.sb = from.sb + (to.sb - from.sb) * k;
    return m;
}

// Returns the matrix of a transform given by the host.
INLINE float16 given_transform(Override given)
{
    const float4 q = given.rotation, t = given.translation_and_weight, s = given.scale;
    const float x = q.x, y = q.y, z = q.z, w = q.w;
    const float4 row0 =
        (float4)((1.0f - 2.0f * (y * y + z * z)) * s.x, (2.0f * (x * y - w * z)) * s.y,
                 (2.0f * (x * z + w * y)) * s.z, t.x);
    const float4 row1 =
        (float4)((2.0f * (x * y + w * z)) * s.x, (1.0f - 2.0f * (x * x + z * z)) * s.y,
                 (2.0f * (y * z - w * x)) * s.z, t.y);
    const float4 row2 = (float4)((2.0f * (x * z - w * y)) * s.x, (2.0f * (y * z + w * x)) * s.y,
                                 (1.0f - 2.0f * (x * x + y * y)) * s.z, t.z);
    return (float16)(row0, row1, row2, (float4)(0.0f));
}

INLINE float16 override_model(Override given, float16 own)
{
    const float16 to = given_transform(given);
    const float weight = given.translation_and_weight.w;
    return weight >= 1.0f ? to : part_of_the_way(own, to, weight);
}

// Returns the member's placement in the world.
INLINE float16 world_from_model(const Solver *s)
{
    const float4 place = s->control->place;
    const float sine = s->control->sine * place.w, cosine = s->control->cosine * place.w;
    const float4 row0 = (float4)(cosine, 0.0f, sine, place.x);
    const float4 row1 = (float4)(0.0f, place.w, 0.0f, place.y);
    const float4 row2 = (float4)(-sine, 0.0f, cosine, place.z);
    return (float16)(row0, row1, row2, (float4)(0.0f));
}

// Publishes a joint's transform for other members.
INLINE void keep_watched(const Solver *s, uint watched, float16 joint)
{
    __global float4 *rows = s->tables->watched + watched * WATCHED_ELEMENTS;
    rows[0] = joint.s0123;
    rows[1] = joint.s4567;
    rows[2] = joint.s89ab;
}

// Attaches a root to its parent member's joint, which an earlier phase of this frame published.
SELDOM float16 attach(const Solver *s, Step step, float16 own)
{
    __global const float4 *rows = s->tables->watched + step.index * WATCHED_ELEMENTS;
    const float16 parent = (float16)(rows[0], rows[1], rows[2], (float4)(0.0f));
    return affine_mul(affine_mul(parent, given_transform(s->tables->overrides[step.operand])), own);
}

// Runs the step of the member in a lane, and returns the joint's new model transform.
INLINE float16 take_step(const Stop *at, uint lane, float16 own)
{
    const Solver *s = at->members + lane;
    const Step step = step_in(at, lane);
    switch (step.kind) {
    case STEP_CHAIN: return chain(at, lane, own);
    case STEP_OVERRIDE: return override_model(s->tables->overrides[step.index], own);
#ifdef USER_STAGES
    case STEP_STAGE: {
        const StageTables tables = { s->tables->steps, s->tables->stage_values, s->tables->tick,
                                     s->tables->elapsed_secs };
        return stage_model(tables, step, s->control, own);
    }
#endif
    case STEP_MOTION: return moves(s, step.joint, own);
    case STEP_WATCH: keep_watched(s, step.index, affine_mul(world_from_model(s), own)); return own;
    case STEP_CARRY: keep_watched(s, step.index, own); return own;
    case STEP_ATTACH: return attach(s, step, own);
    default: return own;
    }
}

// Runs the step of all members.
INLINE void take_steps(Stop *at)
{
    switch (at->step.kind) {
    case STEP_ROTATION: rotate_own(at, handed_down(at, 0)); return;
    case STEP_GAZE: gaze(at); return;
    case STEP_PELVIS: pelvis(at); return;
    case STEP_REACH: reach(at); return;
    case STEP_FOOT: foot(at); return;
    default: break;
    }
    Matrix own = own_models(at);
    for (uint lane = 0; lane < at->count; lane++)
        put_matrix(&own, lane, take_step(at, lane, matrix_in(&own, lane)));
    keep_models(at->joints, at->step.joint, &own);
}

#if LANES == 1

// Runs all steps of one joint, for schedules that compute the joints of a level side by side.
INLINE void solve_joint(const Solver *s, Hierarchy joints, Rotations rotations, uint joint,
                        uint parent)
{
    Stop at;
    at.members = s;
    at.count = 1;
    at.share_rows = true;
    at.joints = joints;
    at.rotations = rotations;
    at.parent = parent;
    for (at.nth = 0; at.nth < s->control->step_count; at.nth++) {
        at.step = step_in(&at, 0);
        if (at.step.joint == joint) take_steps(&at);
    }
}

#endif
