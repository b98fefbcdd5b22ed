// corrections.cl - Retarget corrections of sampled poses; CORRECTION_PLANES in
// populace-device/src/layout.rs describes their planes.
//
// Twin of populace-native/src/corrections.rs: same arithmetic, same order of operations.

// Returns the correction's own rows for two rows of its clip.
INLINE SlotSample own_rows(const ClipTables *tables, BoundClip bound, SlotSample at)
{
    const ClipRows clip = tables->clips[bound.clip];
    at.row0 = bound.row_first + (at.row0 - clip.row_first) / clip.row_stride * bound.row_stride;
    at.row1 = bound.row_first + (at.row1 - clip.row_first) / clip.row_stride * bound.row_stride;
    return at;
}

// Applies all corrections of a clip to a translation and a rotation, which need not have length 1.
// Not inlined on CPUs, because most clips have no correction.
APART void correct(const ClipTables *tables, BoundClip bound, Body body, uint joint, SlotSample at,
                   Local *posed)
{
    Local trs = *posed;
    while (bound_block(tables, bound, joint)->flags & BLOCK_CORRECTED) {
        bound = tables->bound_clips[bound.next];
        if (bound.row_stride != 0) at = own_rows(tables, bound, at);
        const Columns columns = columns_of(tables, bound, joint);
        const Rows rows = rows_of(at);
        const Stored planes = stored_at(tables, bound.range_first + joint, body);
        if (!(columns.flags & REST_TRANSLATION)) {
            const Vec3 arm = sample_vector(tables, columns, TRANSLATION, rows, planes, 6);
            const Quat unit = quat_scale(trs.r, inverse_sqrt(quat_dot(trs.r, trs.r)));
            trs.t = vec3_add(trs.t, quat_rotated(unit, arm));
        }
        Quat q = stored_quat(planes, 0);
        if (columns.block.rotation_first != NONE) {
            const Quat n = rotation_parts(tables, columns, rows);
            const Real step = stored_part(planes, 4), step_w = stored_part(planes, 5);
            const Quat scaled = { n.x * step, n.y * step, n.z * step, n.w * step_w };
            q = quat_add(scaled, q);
        }
        trs.r = quat_mul(quat_mul(trs.r, q), stored_quat(planes, 10));
    }
    *posed = trs;
}
