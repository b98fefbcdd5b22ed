/* turns.cl - what a retargeted clip's poses go through; see TURN_PLANES in populace-device layout.rs. Twin of populace-native
 * turns.rs. */

/* The rows that a turn has for two of its clip's. */
INLINE SlotSample own_rows(const Clips *of, BoundClip bound, SlotSample at)
{
    const ClipRows clip = of->clips[bound.clip];
    at.row0 = bound.row_first + (at.row0 - clip.row_first) / clip.row_stride * bound.row_stride;
    at.row1 = bound.row_first + (at.row1 - clip.row_first) / clip.row_stride * bound.row_stride;
    return at;
}

/* A translation and a rotation, not of length 1, through all turns of a clip. Apart: most clips have none. */
APART void turn(const Clips *of, BoundClip bound, Body body, uint joint, SlotSample at, Trs *posed)
{
    Trs trs = *posed;
    const uint padded = body.padded_count;
    while (bound_block(of, bound, joint)->flags & BLOCK_TURNED) {
        bound = of->bound_clips[bound.next];
        if (bound.row_stride != 0) at = own_rows(of, bound, at);
        const Columns columns = columns_of(of, bound, joint);
        __global const float *planes = of->poses + bound.range_first + joint;
        if (!(columns.flags & REST_TRANSLATION)) {
            const Vec3 arm = sample_vector(of, columns, TRANSLATION, at, planes + 6 * padded, planes + 9 * padded, padded);
            const Quat unit = quat_scale(trs.r, inverse_sqrt(quat_dot(trs.r, trs.r)));
            trs.t = vec3_add(trs.t, quat_turned(unit, arm));
        }
        Quat q = load_quat(planes, padded);
        if (columns.block.rotation_first != NONE) {
            const Quat n = rotation_steps(of, columns, at);
            const Real step = LOAD(planes + 4 * padded), step_w = LOAD(planes + 5 * padded);
            const Quat scaled = { n.x * step, n.y * step, n.z * step, n.w * step_w };
            q = quat_add(scaled, q);
        }
        trs.r = quat_mul(quat_mul(trs.r, q), load_quat(planes + 10 * padded, padded));
    }
    *posed = trs;
}
