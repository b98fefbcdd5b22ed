/* stage_tools.cl - what users' stages can call; their texts follow. Twin of StageJoint in populace-device. */

INLINE float stage_phase(const StageJoint *joint, float period_secs)
{
    if (!(period_secs >= 1e-4f && period_secs <= 1e6f)) return 0.0f;
    const ulong period = (ulong)(period_secs * TICKS_PER_SEC);
    return (float)(joint->ticks % period) / (float)period;
}

INLINE float4 stage_to_model(const StageJoint *joint, float4 direction)
{
    const float sine = joint->facing.x, cosine = joint->facing.y;
    return vec(cosine * direction.x - sine * direction.z, direction.y, sine * direction.x + cosine * direction.z);
}

INLINE void stage_turn(StageJoint *joint, float4 quaternion)
{
    const float16 model = (float16)(joint->row0, joint->row1, joint->row2, (float4)(0.0f));
    const float16 turned = affine_turned(model, quaternion);
    joint->row0 = turned.s0123;
    joint->row1 = turned.s4567;
    joint->row2 = turned.s89ab;
}

