// stages.cl - Users' stages: the joint that a stage gets, the result that is taken from it, and the
// functions that it can call.
//
// Users' texts follow after all kernels, so that their definitions change nothing here. Without
// users' stages, only an empty STAGE_TABLES remains.
//
// Twin of populace-native/src/stages.rs: same arithmetic, same order of operations. The functions
// for users are twins of StageJoint in populace-device/src/stage.rs.

#ifdef USER_STAGES

// Runs the stage with the given index.
static void run_user_stage(uint stage, StageJoint *joint);

// Inputs that stages of all members share.
typedef struct {
    __global const Step *steps;
    __global const float4 *values;
    ulong tick;
    float elapsed_secs;
} StageTables;

INLINE StageJoint stage_joint(StageTables tables, Step step, __global const Control *control)
{
    StageJoint joint;
    joint.translation = joint.scale = (float4)(0.0f);
    joint.rotation = (float4)(0.0f, 0.0f, 0.0f, 1.0f);
    joint.row0 = joint.row1 = joint.row2 = (float4)(0.0f);
    joint.place = control->place;
    joint.facing = (float4)(control->sine, control->cosine, 0.0f, 0.0f);
    joint.values = tables.values[step.operand];
    for (uint i = 0; i < STAGE_PARAMETERS / 4; i++)
        vstore4(tables.values[step.index * (STAGE_PARAMETERS / 4) + i], i, joint.parameters);
    joint.ticks = tables.tick > FIRST_TICK ? tables.tick - FIRST_TICK : 0;
    joint.elapsed_secs = tables.elapsed_secs;
    joint.joint = step.joint;
    joint.member = control->member;
    return joint;
}

INLINE bool stage_bounded(float4 v)
{
    return fabs(v.x) <= STAGE_LARGEST && fabs(v.y) <= STAGE_LARGEST && fabs(v.z) <= STAGE_LARGEST
           && fabs(v.w) <= STAGE_LARGEST;
}

// Runs a stage on a model transform. A result out of bounds is dropped.
SELDOM float16 stage_model(StageTables tables, Step step, __global const Control *control,
                           float16 own)
{
    StageJoint joint = stage_joint(tables, step, control);
    joint.row0 = own.s0123;
    joint.row1 = own.s4567;
    joint.row2 = own.s89ab;
    run_user_stage(step.index, &joint);
    if (!stage_bounded(joint.row0) || !stage_bounded(joint.row1) || !stage_bounded(joint.row2))
        return own;
    return (float16)(joint.row0, joint.row1, joint.row2, (float4)(0.0f));
}

// Returns one lane.
INLINE float lane_of(Real all, uint lane)
{
#if LANES == 1
    return all;
#else
    float numbers[LANES];
    STORE(all, numbers);
    return numbers[lane];
#endif
}

// Runs a stage on the local transform in one lane. A result out of bounds is dropped.
SELDOM Local stage_local(StageTables tables, Step step, __global const Control *control, uint lane,
                         Local trs)
{
    StageJoint joint = stage_joint(tables, step, control);
    joint.translation =
        (float4)(lane_of(trs.t.x, lane), lane_of(trs.t.y, lane), lane_of(trs.t.z, lane), 0.0f);
    joint.rotation = (float4)(lane_of(trs.r.x, lane), lane_of(trs.r.y, lane),
                              lane_of(trs.r.z, lane), lane_of(trs.r.w, lane));
    joint.scale =
        (float4)(lane_of(trs.s.x, lane), lane_of(trs.s.y, lane), lane_of(trs.s.z, lane), 0.0f);
    run_user_stage(step.index, &joint);
    const float4 t = joint.translation, r = joint.rotation, s = joint.scale;
    if (!stage_bounded((float4)(t.xyz, 0.0f)) || !stage_bounded(r)
        || !stage_bounded((float4)(s.xyz, 0.0f)))
        return trs;
    const Local left = { { t.x, t.y, t.z }, { r.x, r.y, r.z, r.w }, { s.x, s.y, s.z } };
    const Choice only = ONLY(lane);
    trs.t = vec3_choose(only, left.t, trs.t);
    trs.r = quat_choose(only, quat_normalize_or(left.r, trs.r), trs.r);
    trs.s = vec3_choose(only, left.s, trs.s);
    return trs;
}

// Runs a member's stages on its local transforms from `joint` on. Their steps are sorted by joint.
INLINE Local stage_locals(StageTables tables, __global const Control *control, uint joint,
                          Local trs)
{
    for (uint i = 0; i < control->pose_step_count; i++) {
        const Step step = tables.steps[control->step_first + control->step_count + i];
        if (step.joint >= joint + LANES) break;
        if (step.joint >= joint) trs = stage_local(tables, step, control, step.joint - joint, trs);
    }
    return trs;
}

// Functions for users' stages.

INLINE float stage_phase(const StageJoint *joint, float period_secs)
{
    if (!(period_secs >= 1e-4f && period_secs <= 1e6f)) return 0.0f;
    const ulong period = (ulong)(period_secs * TICKS_PER_SEC);
    return (float)(joint->ticks % period) / (float)period;
}

INLINE float4 stage_to_model(const StageJoint *joint, float4 direction)
{
    const float sine = joint->facing.x, cosine = joint->facing.y;
    return vec(cosine * direction.x - sine * direction.z, direction.y,
               sine * direction.x + cosine * direction.z);
}

INLINE void stage_rotate(StageJoint *joint, float4 quaternion)
{
    const float16 model = (float16)(joint->row0, joint->row1, joint->row2, (float4)(0.0f));
    const float16 rotated = affine_rotated(model, quaternion);
    joint->row0 = rotated.s0123;
    joint->row1 = rotated.s4567;
    joint->row2 = rotated.s89ab;
    joint->rotation = rotation_mul(quaternion, joint->rotation);
}

// Initializes StageTables as the last field of a list, after a comma.
#define STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)                                     \
    , { steps, stage_values, tick, (float)(elapsed_ticks) * TICK_SECS }

#else

#define STAGE_TABLES(steps, stage_values, tick, elapsed_ticks)

#endif
