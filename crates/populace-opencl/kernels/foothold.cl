// foothold.cl - Heights at which feet stand or swing over the ground.
//
// Reads    the ground; the feet's states after the previous frame
//
// Twin of populace-native/src/constraints/foothold.rs and, for the ground,
// populace-device/src/tables/controls/ground.rs: same arithmetic, same order of operations.

// Returns the index of the last grid sample at or before `at` that has a successor. *between is the
// fraction of the way to that successor.
INLINE uint grid_sample(float at, uint count, float *between)
{
    const float last = (float)(count - 1), inside = at > 0.0f ? (at < last ? at : last) : 0.0f;
    const uint whole = min((uint)inside, count - 2);
    *between = inside - (float)whole;
    return whole;
}

// Returns the ground's unit normal in x, y, z and its height in w, at a point of the world.
INLINE float4 ground_at(const ConstraintTables *tables, float x, float z)
{
    const Ground ground = *tables->ground;
    float height = ground.offset + ground.slope_x * x + ground.slope_z * z;
    float slope_x = ground.slope_x, slope_z = ground.slope_z;
    if (ground.per_metre > 0.0f) {
        float fraction_x, fraction_z;
        const uint column =
            grid_sample((x - ground.grid_x) * ground.per_metre, ground.count_x, &fraction_x);
        const uint row =
            grid_sample((z - ground.grid_z) * ground.per_metre, ground.count_z, &fraction_z);
        __global const float *at = tables->heights + row * ground.count_x + column;
        const float h00 = at[0], h10 = at[1], h01 = at[ground.count_x],
                    h11 = at[ground.count_x + 1];
        const float near = h00 + (h10 - h00) * fraction_x, far = h01 + (h11 - h01) * fraction_x;
        height += near + (far - near) * fraction_z;
        slope_x += ((h10 - h00) + ((h11 - h01) - (h10 - h00)) * fraction_z) * ground.per_metre;
        slope_z += (far - near) * ground.per_metre;
    }
    const float4 normal = unit_or(vec(-slope_x, 1.0f, -slope_z), vec(0.0f, 1.0f, 0.0f));
    return (float4)(normal.xyz, height);
}

// Returns the ground's height at points of the world. *normal is its upward unit normal.
INLINE Real grounds_at(const ConstraintTables *tables, Real x, Real z, Vec3 *normal)
{
#if LANES > 1
    if (tables->ground->per_metre <= 0.0f) {
        const Ground ground = *tables->ground;
        const float4 own = ground_at(tables, 0.0f, 0.0f);
        normal->x = own.x, normal->y = own.y, normal->z = own.z;
        return ground.offset + ground.slope_x * x + ground.slope_z * z;
    }
#endif
    Real heights;
    for (uint lane = 0; lane < LANES; lane++) {
        const float4 own = ground_at(tables, LANE(x, lane), LANE(z, lane));
        put_vec3(normal, lane, own);
        PUT(heights, lane, own.w);
    }
    return heights;
}

INLINE Real larger(Real a, Real b) { return a < b ? b : a; }

// Returns the nearest number of a range.
INLINE Real within(Real value, Real least, Real most)
{
    return value > most ? most : value < least ? least : value;
}

// Returns a height on the way from that of the frame before, at a limited speed, whose gain and loss
// are limited. It comes to rest at the height. *climb is the speed of the frame before, then that of
// the way.
INLINE Real climbs(Real before, Real *climb, Real wanted, float secs)
{
    const Real way = wanted - before;
    const Choice down = way < (Real)(0.0f);
    const Real far = down ? -way : way;
    const Real stopping = square_root(2.0f * FOOT_CLIMB_GAIN * far);
    const Real fastest = FOOT_CLIMB_M_PER_SEC;
    const Real at_most = stopping < fastest ? stopping : fastest;
    const Real most = at_most * secs > far ? far / secs : at_most;
    const Real gain = FOOT_CLIMB_GAIN * secs;
    const Real speed = within(down ? -most : most, *climb - gain, *climb + gain);
    const Choice slope = far * 1.5f <= fastest * secs; // along which feet do not lag
    const Real at_once = secs > 0.0f ? way / secs : *climb;
    *climb = slope ? at_once : speed;
    return slope ? wanted : before + speed * secs;
}

// The ground under a sole of which the pivot stands: its height and upward unit normal there, and the
// heights at which no point of the sole is in it, if the sole is level or lies on the plane through
// the pivot. On an edge the ground under a point of the sole is far off that plane.
typedef struct {
    Vec3 pivot, normal;
    Real ground, level, tilted;
    Choice on_edge;
} Under;

INLINE Under ground_under(const ConstraintTables *tables, Vec3 pivot)
{
    Under under;
    under.pivot = pivot;
    under.ground = under.level = under.tilted = grounds_at(tables, pivot.x, pivot.z, &under.normal);
    under.on_edge = 0;
    return under;
}

// Takes a point of the sole into account.
INLINE void stand_on(const ConstraintTables *tables, Under *under, Vec3 at, Real edge)
{
    Vec3 unused;
    const Vec3 normal = under->normal;
    const Real fall_x = normal.x / normal.y, fall_z = normal.z / normal.y;
    const Real x = at.x - under->pivot.x, z = at.z - under->pivot.z;
    const Real ground = grounds_at(tables, at.x, at.z, &unused);
    const Real above = at.y - under->pivot.y, fall = fall_x * x + fall_z * z;
    under->level = larger(under->level, ground - above);
    under->tilted = larger(under->tilted, ground + fall - above);
    const Real off = ground + fall - under->ground;
    under->on_edge = under->on_edge | (off * off > edge * edge);
}

// Raises the ground until no point of the sole is in it. On an edge the sole is level.
INLINE void settle(Under *under)
{
    const Vec3 up = { 0.0f, 1.0f, 0.0f };
    under->ground = under->on_edge ? under->level : under->tilted;
    under->normal = vec3_choose(under->on_edge, up, under->normal);
}

// Returns the height that a lifted foot rises to: that of the ground, or of the ground a little
// ahead, whichever is higher. The nearer the foot is to standing (`near` is 1), the less it looks
// ahead.
INLINE Real ground_ahead(const ConstraintTables *tables, const Stance *stance, Vec3 at, Real ground,
                         Real most, Real near)
{
    if (tables->ground->per_metre <= 0.0f) return ground;
    Vec3 unused;
    const Real ahead = FOOT_AHEAD * most, sine = stance->sine, cosine = stance->cosine;
    const Real x = at.x + (cosine * stance->stride.x + sine * stance->stride.y) * ahead,
               z = at.z + (cosine * stance->stride.y - sine * stance->stride.x) * ahead;
    const Real rise = larger(grounds_at(tables, x, z, &unused) - ground, 0.0f);
    return ground + rise * (1.0f - near);
}

// Returns heights of feet after this frame. The shown ground rises at a limited speed: under planted
// feet to the ground, under lifted ones to the height `ahead`. `stood` tells which were planted in
// the previous frame, and `known` which had a state there.
INLINE FootHeights next_heights(const ConstraintTables *tables, FootHeights last, Choice known,
                                Choice stood, Choice planted, const Under *under, Real ahead)
{
    const Real none = 0.0f;
    // A foot that stays planted loses its height above or below the ground.
    const Choice stays = planted & stood & !under->on_edge;
    const Real before = stays ? last.above : last.shown;
    const Real ground = planted ? under->ground : ahead;
    Real climb = last.climb;
    Real height = climbs(before, &climb, stays ? none : ground, tables->elapsed_secs);
    height = stays ? under->ground + height : height;
    height = known ? height : under->ground;
    const FootHeights next = { height, planted ? height - under->ground : none,
                               known ? climb : none };
    return next;
}
