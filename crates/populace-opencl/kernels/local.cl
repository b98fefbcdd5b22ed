// local.cl - Algebra of local transforms, of one joint or of joints in lanes. Twin of
// populace-native/src/local.rs: same arithmetic, same order of operations.

// Translation, rotation and scale, relative to the parent joint.
typedef struct {
    Vec3 t;
    Quat r;
    Vec3 s;
} Local;

// Sums, differences and multiples, component by component.

INLINE Local local_add(Local a, Local b)
{
    const Local sum = { vec3_add(a.t, b.t), quat_add(a.r, b.r), vec3_add(a.s, b.s) };
    return sum;
}

INLINE Local local_scale(Local a, Real k)
{
    const Local scaled = { vec3_scale(a.t, k), quat_scale(a.r, k), vec3_scale(a.s, k) };
    return scaled;
}

INLINE Local local_less(Local a, Local b) { return local_add(a, local_scale(b, -1.0f)); }

// Returns the ratio of two scales; 1 if the reference is 0 or no number.
INLINE Real scale_ratio(Real value, Real reference)
{
    const Choice divides = (reference < (Real)(0.0f)) | (reference > (Real)(0.0f));
    return divides ? value / reference : (Real)(1.0f);
}

INLINE Vec3 scale_ratios(Vec3 value, Vec3 reference)
{
    const Vec3 ratios = { scale_ratio(value.x, reference.x), scale_ratio(value.y, reference.y),
                          scale_ratio(value.z, reference.z) };
    return ratios;
}

// Returns the difference that takes `reference` to `value`, with the rotation in the hemisphere of
// `side`. Scales that are at rest in both are not divided.
INLINE Local quotient(Local value, Local reference, Quat side, uint at_rest)
{
    Local trs = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f, 0.0f }, { 1.0f, 1.0f, 1.0f } };
    trs.r = quat_hemisphere(quat_mul(quat_conjugate(reference.r), value.r), side);
    trs.t = vec3_add(value.t, vec3_scale(reference.t, -1.0f));
    if (!(at_rest & REST_SCALE)) trs.s = scale_ratios(value.s, reference.s);
    return trs;
}

// Subtracts the identity from a difference, so that weighted sums do not depend on the order of
// their terms.
INLINE Local change(Local trs)
{
    trs.r.w -= 1.0f;
    trs.s.x -= 1.0f;
    trs.s.y -= 1.0f;
    trs.s.z -= 1.0f;
    return trs;
}

// Applies weighted sums of changes of rotations and scales to those of the pose beneath.

INLINE Quat add_layer_rotation(Quat beneath, Quat sum, Real layer_weight)
{
    const Quat changed = quat_add(quat_identity(), quat_scale(sum, layer_weight));
    return quat_mul(beneath, quat_normalize_or(changed, quat_identity()));
}

INLINE Vec3 add_layer_scale(Vec3 beneath, Vec3 sum, Real layer_weight)
{
    const Vec3 s = { beneath.x * (1.0f + sum.x * layer_weight),
                     beneath.y * (1.0f + sum.y * layer_weight),
                     beneath.z * (1.0f + sum.z * layer_weight) };
    return s;
}

// Applies a weighted sum of changes to the pose beneath.
INLINE Local add_layer(Local beneath, Local sum, Real layer_weight)
{
    const Local trs = { vec3_add(beneath.t, vec3_scale(sum.t, layer_weight)),
                        add_layer_rotation(beneath.r, sum.r, layer_weight),
                        add_layer_scale(beneath.s, sum.s, layer_weight) };
    return trs;
}

// Combines two differences: first one, then the other.
INLINE Local after(Local first, Local then)
{
    const Local both = { vec3_add(first.t, then.t),
                         quat_mul(first.r, then.r),
                         { first.s.x * then.s.x, first.s.y * then.s.y, first.s.z * then.s.z } };
    return both;
}
