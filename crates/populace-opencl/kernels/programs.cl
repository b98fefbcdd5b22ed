// programs.cl - Constraint programs of members side by side, each in a lane of its own. With one
// lane there is one member.
//
// Members stand side by side if their programs have one shape: the kinds and joints of steps, and
// the chains, soles and rotations of constraints. The other settings may differ.
//
// Twin of populace-native/src/constraints/programs.rs.

// Members at a step of their programs. In lanes without a member, inputs are 0 and results unused.
typedef struct {
    const Solver *members;
    uint count;
    bool share_rows; // all have equal programs, and so the same rows
#if LANES > 1
    const Playback *plays; // what each plays
#endif
    uint nth;  // index of the step in each program
    Step step; // of the first member; kind, joint and operand are those of all
    Hierarchy joints;
    Rotations rotations;
    uint parent; // of the step's joint, or NONE
} Stop;

// Returns the model transforms of the step's joint, which the step changes.
INLINE Matrix own_models(const Stop *at)
{
    Matrix own;
    models_of(at->joints, at->step.joint, &own);
    return own;
}

INLINE void rotate_own(Stop *at, Quat rotations)
{
    Matrix own = own_models(at);
    matrix_rotated(&own, rotations);
    keep_models(at->joints, at->step.joint, &own);
}

INLINE Step step_in(const Stop *at, uint lane)
{
    const Solver *s = at->members + lane;
    return s->tables->steps[s->control->step_first + at->nth];
}

// Returns the constraint of a member. That of the first has the chain, the soles and the number of
// feet of all.
INLINE __global const Constraint *constraint_in(const Stop *at, uint lane)
{
    return at->members->tables->constraints + step_in(at, lane).index;
}

INLINE void hand_down(Stop *at, uint index, Quat rotations)
{
    hand_rotations(at->rotations, at->step.operand + index, rotations);
}

INLINE Quat handed_down(const Stop *at, uint index)
{
    return handed_rotations(at->rotations, at->step.operand + index);
}

// Returns whether members have equal programs.
INLINE bool share_rows(const Solver *members, uint count)
{
    bool share = true;
    for (uint lane = 1; lane < count; lane++)
        share = share & (members[lane].control->step_first == members->control->step_first);
    return share;
}

// Returns axis, front, up and limits of the `nth` constraints after those of the step. Equal programs
// share them.
INLINE Numbers settings_of(const Stop *at, uint nth)
{
    Numbers settings = no_numbers();
    if (at->share_rows) {
        __global const float *row = (__global const float *)(constraint_in(at, 0) + nth);
        for (uint i = 0; i < 16; i++) settings.n[i] = row[i];
        return settings;
    }
    for (uint lane = 0; lane < at->count; lane++)
        put_numbers(&settings, lane, (__global const float *)(constraint_in(at, lane) + nth));
    turn_numbers(&settings);
    return settings;
}

INLINE Vec3 vec3_of(const Numbers *numbers, uint first)
{
    const Vec3 v = { numbers->n[first], numbers->n[first + 1], numbers->n[first + 2] };
    return v;
}

INLINE void put_vec3(Vec3 *all, uint lane, float4 one)
{
    PUT(all->x, lane, one.x);
    PUT(all->y, lane, one.y);
    PUT(all->z, lane, one.z);
}

INLINE float4 vec3_in(Vec3 all, uint lane)
{
    return vec(LANE(all.x, lane), LANE(all.y, lane), LANE(all.z, lane));
}

// Takes model transforms of a chain's joint to its next link, as the clips pose it.
INLINE void walk(const Stop *at, __global const Constraint *constraint, uint link, Matrix *models)
{
    Matrix locals;
    locals_of(at->joints, at->members->tables->links[constraint->link_first + link].joint, &locals);
    matrix_product(models, &locals, models);
}
