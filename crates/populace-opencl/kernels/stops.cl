/* stops.cl - members that stand at a step of their hierarchies, and are solved side by side, each in lanes of its own. With
 * one lane there is one. */

/* A member at a step: its joint's model transform, which the step changes, and the one's of the joint above. */
typedef struct { const Steering *s; Hierarchy joints; Step step; float16 own, parent; bool has_parent; } Stop;

INLINE __global const Constraint *constraint_of(const Stop *at) { return at->s->of->constraints + at->step.index; }

INLINE void put_vec3(Vec3 *all, uint lane, float4 one)
{
    PUT(all->x, lane, one.x);
    PUT(all->y, lane, one.y);
    PUT(all->z, lane, one.z);
}

INLINE float4 vec3_in(Vec3 all, uint lane) { return vec(LANE(all.x, lane), LANE(all.y, lane), LANE(all.z, lane)); }

INLINE float4 quat_in(Quat all, uint lane)
{
    return (float4)(LANE(all.x, lane), LANE(all.y, lane), LANE(all.z, lane), LANE(all.w, lane));
}
