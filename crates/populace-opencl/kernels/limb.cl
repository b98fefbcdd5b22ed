// limb.cl - Two-bone inverse kinematics, for a limb in each lane.
//
// Reads    local transforms of the limb; targets
// Writes   the model transform of the first joint; step_rotations of middle joint and end
//
// Twin of populace-native/src/constraints/limb.rs: same arithmetic, same order of operations.

// A limb as its clips pose it, in model space: both bones, the direction of the bend if the limb is
// straight, and the vector from the first joint to the goal.
typedef struct {
    Vec3 upper, lower, bend, to;
} Limb;

// Lengths of a limb's bones, in metres, and the inverse of the upper one's.
typedef struct {
    Real upper, lower, shrinks;
} BoneLengths;

INLINE BoneLengths bone_lengths(Limb limb)
{
    const Real square = vec3_dot(limb.upper, limb.upper);
    const BoneLengths lengths = { square_root(square),
                                  square_root(vec3_dot(limb.lower, limb.lower)),
                                  inverse_sqrt(square) };
    return lengths;
}

// Returns how far from the root the end of a chain goes for a target at `distance`. It eases
// towards full and least extension.
INLINE Real soft_distance(Real distance, Real length, Real least, Real soft)
{
    const Real far = length - length * soft, near = least + (length - least) * soft;
    const Choice beyond = distance > far;
    const Real over = beyond ? distance - far : near - distance,
               room = beyond ? length * soft : near - least;
    const Real eased = room * over / (room + over);
    return beyond ? far + eased : distance < near ? near - eased : distance;
}

// Returns the axis, of any length, about which the middle joint bends: across the limb's own bend,
// blended slightly towards the preferred bend. `shrinks` is 1 / length of the upper bone.
INLINE Vec3 hinge(Limb limb, Real shrinks)
{
    const Vec3 none = { 0.0f, 0.0f, 0.0f }, x = { 1.0f, 0.0f, 0.0f }, y = { 0.0f, 1.0f, 0.0f };
    const Vec3 upper = vec3_scale(limb.upper, shrinks),
               chain = vec3_add(upper, vec3_scale(limb.lower, shrinks));
    const Vec3 hinge =
        vec3_cross(vec3_add_scaled(upper, vec3_unit_or(limb.bend, none), LIMB_OWN_BEND), chain);
    const Choice stands = vec3_dot(hinge, hinge) > (Real)(1e-10f);
    return vec3_choose(stands, hinge,
                       vec3_cross(upper, vec3_choose(upper.x * upper.x < (Real)(0.5f), x, y)));
}

// Returns the shortest rotation from one vector to another. `lengths` is the product of their
// lengths. If they are opposite, it rotates about `about`, which is perpendicular to them.
INLINE Quat swing_between(Vec3 from, Vec3 to, Real lengths, Vec3 about)
{
    const Vec3 axis = vec3_cross(from, to);
    const Real w = lengths + vec3_dot(from, to);
    const Quat rotation = { axis.x, axis.y, axis.z, w }, over = { about.x, about.y, about.z, 0.0f };
    return quat_normalize_or(quat_choose(w > lengths * 1e-6f, rotation, over), quat_identity());
}

// Returns the rotation about the line to the goal that brings the middle joint nearest to a pole.
INLINE Quat pole_rotation(Limb limb, Quat first, Vec3 hinge, Vec3 pole)
{
    const Vec3 x = { 1.0f, 0.0f, 0.0f }, ahead = vec3_unit_or(limb.to, x),
               upper = quat_rotated(first, limb.upper);
    const Vec3 bend = vec3_cross(ahead, quat_rotated(first, hinge));
    const Vec3 out = vec3_unit_or(vec3_across(upper, ahead), bend);
    const Vec3 drawn = vec3_unit_or(vec3_across(pole, ahead), out);
    return swing_between(out, drawn, 1.0f, ahead);
}

// Computes the rotation of the first joint and, after it, of the middle joint that bring the end to
// its goal. Both are the identity for a limb without length. `pole` is a direction; it counts if
// `has_pole`.
INLINE void limb_rotations(Limb limb, BoneLengths lengths, Vec3 pole, Choice has_pole, Real soft,
                           Quat *first_rotation, Quat *second_rotation)
{
    const Vec3 upper = limb.upper, lower = limb.lower;
    const Real aa = vec3_dot(upper, upper), bb = vec3_dot(lower, lower);
    const Real a = lengths.upper, b = lengths.lower,
               distance = square_root(vec3_dot(limb.to, limb.to));
    const Real shorter = a < b ? a : b, longer = a < b ? b : a;
    const Real reach = soft_distance(distance, a + b, longer - shorter, soft);
    // Rotate the lower bone about the hinge until both bones together are `reach` long. The part
    // along the hinge stays; the product of both bones is a cosine of the angle. Scaled by nn, the
    // squared length of the hinge, nothing waits for that length.
    const Vec3 hinge_axis = hinge(limb, lengths.shrinks), side = vec3_cross(hinge_axis, lower);
    const Real nn = vec3_dot(hinge_axis, hinge_axis), length = square_root(nn),
               unit = inverse_sqrt(nn), unit2 = unit * unit;
    const Real along = vec3_dot(hinge_axis, lower), still = vec3_dot(hinge_axis, upper) * along;
    const Real p = vec3_dot(upper, lower) * nn - still, q = vec3_dot(upper, side);
    const Real most = p * p + q * q * nn, k = inverse_sqrt(most);
    const Real wanted = ((reach * reach - aa - bb) * 0.5f * nn - still) * k;
    const Real below = wanted < (Real)(1.0f) ? wanted : (Real)(1.0f),
               c = below > (Real)(-1.0f) ? below : (Real)(-1.0f);
    const Real s = square_root((1.0f - c) * (1.0f + c)), p1 = p * k, q1 = q * length * k;
    const Real cosine = p1 * c - q1 * s, sine = q1 * c + p1 * s;
    // Half the angle, from the larger of its sine and cosine.
    const Choice back = cosine < (Real)(0.0f);
    const Real x = back ? 1.0f - cosine : sine, w = back ? sine : 1.0f + cosine,
               half_unit = inverse_sqrt(x * x + w * w);
    // Then the whole limb, now of the right length, swings to its goal.
    const Vec3 rest = vec3_scale(hinge_axis, along * unit2),
               level = vec3_add_scaled(lower, rest, -1.0f);
    const Vec3 rotated_lower =
        vec3_add_scaled(vec3_add_scaled(rest, level, cosine), side, sine * unit);
    const Real reached = square_root(aa + bb + (still + most * k * c) * unit2 * 2.0f);
    const Vec3 axis = vec3_scale(hinge_axis, unit);
    Quat first = swing_between(vec3_add(upper, rotated_lower), limb.to, reached * distance, axis);
    if (ANY(has_pole))
        first =
            quat_choose(has_pole, quat_mul(pole_rotation(limb, first, axis, pole), first), first);
    const Vec3 bend = vec3_scale(quat_rotated(first, axis), x * half_unit);
    const Quat second = { bend.x, bend.y, bend.z, w * half_unit };
    const Real size = shorter < distance ? shorter : distance;
    const Choice stands =
        (most < (Real)(LIMB_LARGEST_SQUARE) ? size : (Real)(0.0f)) > (Real)(1e-6f);
    *first_rotation = quat_choose(stands, first, quat_identity());
    *second_rotation = quat_choose(stands, second, quat_identity());
}

// Scales rotations by weights below 1. If all weights are 1, it returns the rotations at once.
INLINE Quat weighted(Quat rotation, Real weight)
{
    const Choice partly = weight < (Real)(1.0f);
    if (!ANY(partly)) return rotation;
    return quat_choose(partly, quat_part(rotation, weight), rotation);
}

SELDOM void reach(Stop *at)
{
    __global const Constraint *constraint = constraint_in(at, 0);
    const Numbers settings = settings_of(at, 0);
    const Matrix own = own_models(at);
    Matrix end = own;
    const Vec3 start = matrix_origin(&end);
    Vec3 middle = start, target = { 0.0f, 0.0f, 0.0f };
    Real weight = 0.0f, keeps_end = 0.0f;
    for (uint link = 1; link < constraint->link_count; link++) {
        walk(at, constraint, link, &end);
        if (link == constraint->middle) middle = matrix_origin(&end);
    }
    for (uint lane = 0; lane < at->count; lane++) {
        __global const Constraint *reach = constraint_in(at, lane);
        float own_weight;
        put_vec3(&target, lane, goal(at->members + lane, reach, vec3_in(start, lane), &own_weight));
        PUT(weight, lane, own_weight);
        PUT(keeps_end, lane, reach->keeps_end ? 1.0f : 0.0f);
    }
    const Limb limb = { vec3_add_scaled(middle, start, -1.0f),
                        vec3_add_scaled(matrix_origin(&end), middle, -1.0f),
                        matrix_transform_vector(&own, vec3_of(&settings, 0)),
                        vec3_add_scaled(target, start, -1.0f) };
    Quat first, second;
    limb_rotations(limb, bone_lengths(limb), vec3_of(&settings, 4), settings.n[7] > (Real)(0.0f),
                   settings.n[12], &first, &second);
    const Choice aims = weight > (Real)(0.0f);
    first = weighted(quat_choose(aims, first, quat_identity()), weight);
    second = weighted(quat_choose(aims, second, quat_identity()), weight);
    const Quat undone = quat_conjugate(quat_mul(second, first));
    hand_down(at, 0, second);
    hand_down(at, 1, quat_choose(keeps_end > (Real)(0.0f), undone, quat_identity()));
    rotate_own(at, first);
}
