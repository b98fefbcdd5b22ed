/* stage.cl - what a user's stage gets of a joint, and what is taken of what it leaves. Users' texts come after all kernels,
 * so that nothing that they define changes anything here; without them none of this is there. Twin of populace-native
 * stages.rs. */

#ifdef USER_STAGES

/* Past this a number is no place, turn or scale any longer, and what hangs on it would come to be not finite. */
#define STAGE_BOUND 1e9f

/* Runs the stage of a number. */
static void run_user_stage(uint stage, StageJoint *joint);

/* What stages of all members read. */
typedef struct { __global const Step *steps; __global const float4 *values; ulong tick; float elapsed_secs; } StageTables;

INLINE StageJoint stage_joint(StageTables of, Step step, Control control)
{
    StageJoint joint;
    joint.translation = joint.scale = (float4)(0.0f);
    joint.rotation = (float4)(0.0f, 0.0f, 0.0f, 1.0f);
    joint.row0 = joint.row1 = joint.row2 = (float4)(0.0f);
    joint.place = control.place;
    joint.facing = control.facing;
    joint.values = of.values[step.turn];
    for (uint i = 0; i < STAGE_PARAMETERS / 4; i++)
        vstore4(of.values[step.index * (STAGE_PARAMETERS / 4) + i], i, joint.parameters);
    joint.ticks = of.tick > FIRST_TICK ? of.tick - FIRST_TICK : 0;
    joint.elapsed_secs = of.elapsed_secs;
    joint.joint = step.joint;
    joint.member = control.member;
    return joint;
}

INLINE bool stage_bounded(float4 v)
{
    return fabs(v.x) <= STAGE_BOUND && fabs(v.y) <= STAGE_BOUND && fabs(v.z) <= STAGE_BOUND && fabs(v.w) <= STAGE_BOUND;
}

/* What a stage makes of a model transform. */
APART_STEP float16 stage_model(StageTables of, Step step, Control control, float16 own)
{
    StageJoint joint = stage_joint(of, step, control);
    joint.row0 = own.s0123;
    joint.row1 = own.s4567;
    joint.row2 = own.s89ab;
    run_user_stage(step.index, &joint);
    if (!stage_bounded(joint.row0) || !stage_bounded(joint.row1) || !stage_bounded(joint.row2)) return own;
    return (float16)(joint.row0, joint.row1, joint.row2, (float4)(0.0f));
}

/* One lane. */
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

/* What a stage makes of the local transform in one lane. */
APART_STEP Trs stage_local(StageTables of, Step step, Control control, uint lane, Trs trs)
{
    StageJoint joint = stage_joint(of, step, control);
    joint.translation = (float4)(lane_of(trs.t.x, lane), lane_of(trs.t.y, lane), lane_of(trs.t.z, lane), 0.0f);
    joint.rotation = (float4)(lane_of(trs.r.x, lane), lane_of(trs.r.y, lane), lane_of(trs.r.z, lane), lane_of(trs.r.w, lane));
    joint.scale = (float4)(lane_of(trs.s.x, lane), lane_of(trs.s.y, lane), lane_of(trs.s.z, lane), 0.0f);
    run_user_stage(step.index, &joint);
    const float4 t = joint.translation, r = joint.rotation, s = joint.scale;
    if (!stage_bounded((float4)(t.xyz, 0.0f)) || !stage_bounded(r) || !stage_bounded((float4)(s.xyz, 0.0f))) return trs;
    const Trs left = { { t.x, t.y, t.z }, { r.x, r.y, r.z, r.w }, { s.x, s.y, s.z } };
    const Choice only = ONLY(lane);
    trs.t = vec3_choose(only, left.t, trs.t);
    trs.r = quat_choose(only, quat_normalize_or(left.r, trs.r), trs.r);
    trs.s = vec3_choose(only, left.s, trs.s);
    return trs;
}

/* What a member's stages make of its local transforms from `joint` on; their steps stand by joint. */
INLINE Trs stage_locals(StageTables of, Control control, uint joint, Trs trs)
{
    for (uint i = 0; i < control.pose_step_count; i++) {
        const Step step = of.steps[control.step_first + control.step_count + i];
        if (step.joint >= joint + LANES) break;
        if (step.joint >= joint) trs = stage_local(of, step, control, step.joint - joint, trs);
    }
    return trs;
}

#define STAGE_TABLES(tick, elapsed_ticks) , { steps, stage_values, tick, (float)(elapsed_ticks) * TICK_SECS }

#else

#define STAGE_TABLES(tick, elapsed_ticks)

#endif
