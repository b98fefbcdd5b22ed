// yield_points.cl - Steps that a batch of members solves side by side, each member in lanes of its
// own. With one lane, a batch is one member.

// A member at such a step: the joint's model transform, which the step changes, and that of its
// parent.
typedef struct {
    const Solver *s;
    Hierarchy joints;
    Step step;
    float16 own, parent;
    bool has_parent;
} YieldPoint;

INLINE __global const Constraint *constraint_of(const YieldPoint *at)
{
    return at->s->tables->constraints + at->step.index;
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

INLINE float4 quat_in(Quat all, uint lane)
{
    return (float4)(LANE(all.x, lane), LANE(all.y, lane), LANE(all.z, lane), LANE(all.w, lane));
}
