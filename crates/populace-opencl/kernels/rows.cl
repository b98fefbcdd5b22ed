// rows.cl - Local transforms of one joint, or of sixteen neighbouring ones, from rows of a clip.
// Twin of populace-native/src/rows.rs, populace-native/src/block_columns.rs,
// populace-native/src/encoding.rs and populace-native/src/sample.rs: same arithmetic, same order of
// operations.
//
// populace-clip/src/storage.rs describes a row. A component is `offset + step / ROW_PARTS * n`, where
// n is the sum of both rows' numbers, each times its weight in ROW_PARTS. Joints that the clip does
// not drive, or that do not move in it, have a step of 0, so the arithmetic is the same for all.

typedef struct {
    __global const BoundClip *bound_clips;
    __global const BoundBlock *bound_blocks;
    __global const Source *sources;
    __global const uint *source_lanes;
    __global const ClipRows *clips;
    __global const RowBlock *row_blocks;
    __global const uint *joint_maps, *rows;
    __global const float *poses, *masks;
} ClipTables;

// What a slot plays now, and its time after the start of the clip; NAN for live clips.
typedef struct {
    SlotSample at;
    uint bound_clip, layer;
    float secs;
} Playing;

// Properties of a row.
enum { ROTATION, TRANSLATION, SCALE };

// The first word of a property's planes in a row, and the words from one plane to the next.
typedef struct {
    uint first, lanes;
} Planes;

INLINE Planes planes_of(RowBlock block, uint property)
{
    const Planes rotation = { block.rotation_first, block.rotation_lanes };
    const Planes translation = { block.translation_first, block.translation_lanes };
    const Planes scale = { block.scale_first, block.scale_lanes };
    return property == ROTATION ? rotation : property == TRANSLATION ? translation : scale;
}

INLINE uint plane_at(Planes planes, uint row, uint plane)
{
    return row + planes.first + plane * (planes.lanes & ~ROW_FLOATS);
}

// Returns the column references of the block of sixteen joints that `joint` belongs to.
INLINE __global const BoundBlock *bound_block(const ClipTables *tables, BoundClip bound, uint joint)
{
    return tables->bound_blocks + bound.block_first + joint / JOINT_BLOCK;
}

#if LANES == 1

// Where a joint's column is stored.
typedef struct {
    RowBlock block;
    uint flags, lane;
} Columns;

INLINE Columns columns_of(const ClipTables *tables, BoundClip bound, uint joint)
{
    const uint map = tables->joint_maps[bound.map_first + joint], column = map & MAP_COLUMN;
    Columns columns = { tables->row_blocks[bound.row_block_first + column / JOINT_BLOCK],
                        bound_block(tables, bound, joint)->flags, column % JOINT_BLOCK };
    if (!(map & MAP_ROTATION)) columns.block.rotation_first = NONE;
    if (!(map & MAP_TRANSLATION)) columns.block.translation_first = NONE;
    if (!(map & MAP_SCALE)) columns.block.scale_first = NONE;
    return columns;
}

INLINE Words words_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                      uint plane)
{
    return tables->rows[plane_at(planes, row, plane) + columns.lane];
}

// Returns words whose lower halves are those of a plane with two lanes in a word.
INLINE Words halves_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                       uint plane)
{
    return tables->rows[plane_at(planes, row, plane) + columns.lane / 2] >> 16 * (columns.lane % 2);
}

#else

// Where the columns of sixteen neighbouring joints are stored: in one block, each in its own lane,
// or gathered from several blocks. In the second case `block` only tells which properties move.
typedef struct {
    RowBlock block;
    uint flags, source_first, source_count;
} Columns;

INLINE Columns columns_of(const ClipTables *tables, BoundClip bound, uint joint)
{
    __global const BoundBlock *b = bound_block(tables, bound, joint);
    const Columns columns = { { b->rotation_first, b->rotation_lanes, b->translation_first,
                                b->translation_lanes, b->scale_first, b->scale_lanes },
                              b->flags,
                              b->source_first,
                              b->source_count };
    return columns;
}

INLINE Words words_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                      uint plane)
{
    return vload16(0, tables->rows + plane_at(planes, row, plane));
}

INLINE Words halves_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                       uint plane)
{
    __global const ushort *halves =
        (__global const ushort *)(tables->rows + plane_at(planes, row, plane));
    return convert_uint16(vload16(0, halves));
}

#endif

// Mixes rotations from the words of their planes in two rows.
INLINE Quat mix_quats(Words xy0, Words zw0, Words xy1, Words zw1, float between)
{
    const uint weights = row_weights(between);
    const Quat n = { mix_low(xy0, xy1, weights), mix_high(xy0, xy1, weights),
                     mix_low(zw0, zw1, weights), mix_high(zw0, zw1, weights) };
    return n;
}

// Mixes translations or scales from the words of their planes in two rows.
INLINE Vec3 mix_vectors(Words xy0, Words z0, Words xy1, Words z1, float between)
{
    const uint weights = row_weights(between);
    const Vec3 n = { mix_low(xy0, xy1, weights), mix_high(xy0, xy1, weights),
                     mix_low(z0, z1, weights) };
    return n;
}

// Returns a component of floats between two rows.
INLINE Real mix_floats(const ClipTables *tables, Columns columns, Planes planes, SlotSample at,
                       uint component)
{
    return mix_real(AS_REAL(words_at(tables, columns, planes, at.row0, component)),
                    AS_REAL(words_at(tables, columns, planes, at.row1, component)), at.between)
           * ROW_PARTS;
}

// Returns rotations between two rows, in ROW_PARTS of a step, for columns of one block.
INLINE Quat block_rotation(const ClipTables *tables, Columns columns, Planes planes, SlotSample at)
{
    if (planes.lanes & ROW_FLOATS) {
        const Quat floats = { mix_floats(tables, columns, planes, at, 0),
                              mix_floats(tables, columns, planes, at, 1),
                              mix_floats(tables, columns, planes, at, 2),
                              mix_floats(tables, columns, planes, at, 3) };
        return floats;
    }
    const Words xy0 = words_at(tables, columns, planes, at.row0, 0),
                zw0 = words_at(tables, columns, planes, at.row0, 1);
    const Words xy1 = words_at(tables, columns, planes, at.row1, 0),
                zw1 = words_at(tables, columns, planes, at.row1, 1);
    return mix_quats(xy0, zw0, xy1, zw1, at.between);
}

// Returns translations or scales between two rows, in ROW_PARTS of a step, for columns of one block.
INLINE Vec3 block_vector(const ClipTables *tables, Columns columns, Planes planes, SlotSample at)
{
    if (planes.lanes & ROW_FLOATS) {
        const Vec3 floats = { mix_floats(tables, columns, planes, at, 0),
                              mix_floats(tables, columns, planes, at, 1),
                              mix_floats(tables, columns, planes, at, 2) };
        return floats;
    }
    const Words xy0 = words_at(tables, columns, planes, at.row0, 0),
                xy1 = words_at(tables, columns, planes, at.row1, 0);
    const Words z0 = halves_at(tables, columns, planes, at.row0, 1),
                z1 = halves_at(tables, columns, planes, at.row1, 1);
    return mix_vectors(xy0, z0, xy1, z1, at.between);
}

#if LANES > 1

// A block of columns that joints follow, and the lane of each joint's column in it, or NONE.
typedef struct {
    Planes planes;
    Words lanes;
} Gathering;

INLINE Gathering gathering_of(const ClipTables *tables, Columns columns, uint nth, uint property)
{
    const Source source = tables->sources[columns.source_first + nth];
    const Gathering gathering = { planes_of(tables->row_blocks[source.block], property),
                                  vload16(0, tables->source_lanes + source.lanes_first) };
    return gathering;
}

// Replaces the lanes of joints that follow the block.
INLINE Words gather(Words to, Words from, Words lanes)
{
    return lanes == (Words)(NONE) ? to : permute(from, lanes);
}

INLINE Real gather_reals(Real to, Real from, Words lanes)
{
    return AS_REAL(gather(AS_WORDS(to), AS_WORDS(from), lanes));
}

// Returns whether any of the blocks that joints follow has floats.
INLINE bool gathers_floats(const ClipTables *tables, Columns columns, uint property)
{
    uint lanes = 0;
    for (uint s = 0; s < columns.source_count; s++) {
        const Source source = tables->sources[columns.source_first + s];
        lanes |= planes_of(tables->row_blocks[source.block], property).lanes;
    }
    return lanes & ROW_FLOATS;
}

// The same for columns gathered from several blocks: words, or what was mixed of each if there are
// floats among them.
APART Quat gathered_rotation(const ClipTables *tables, Columns columns, SlotSample at)
{
    const bool floats = gathers_floats(tables, columns, ROTATION);
    Quat n = { 0.0f, 0.0f, 0.0f, 0.0f };
    Words xy0 = 0, zw0 = 0, xy1 = 0, zw1 = 0;
    for (uint s = 0; s < columns.source_count; s++) {
        const Gathering from = gathering_of(tables, columns, s, ROTATION);
        if (from.planes.first == NONE) continue;
        if (floats) {
            const Quat found = block_rotation(tables, columns, from.planes, at);
            n.x = gather_reals(n.x, found.x, from.lanes);
            n.y = gather_reals(n.y, found.y, from.lanes);
            n.z = gather_reals(n.z, found.z, from.lanes);
            n.w = gather_reals(n.w, found.w, from.lanes);
            continue;
        }
        xy0 = gather(xy0, words_at(tables, columns, from.planes, at.row0, 0), from.lanes);
        zw0 = gather(zw0, words_at(tables, columns, from.planes, at.row0, 1), from.lanes);
        xy1 = gather(xy1, words_at(tables, columns, from.planes, at.row1, 0), from.lanes);
        zw1 = gather(zw1, words_at(tables, columns, from.planes, at.row1, 1), from.lanes);
    }
    return floats ? n : mix_quats(xy0, zw0, xy1, zw1, at.between);
}

APART Vec3 gathered_vector(const ClipTables *tables, Columns columns, uint property, SlotSample at)
{
    const bool floats = gathers_floats(tables, columns, property);
    Vec3 n = { 0.0f, 0.0f, 0.0f };
    Words xy0 = 0, z0 = 0, xy1 = 0, z1 = 0;
    for (uint s = 0; s < columns.source_count; s++) {
        const Gathering from = gathering_of(tables, columns, s, property);
        if (from.planes.first == NONE) continue;
        if (floats) {
            const Vec3 found = block_vector(tables, columns, from.planes, at);
            n.x = gather_reals(n.x, found.x, from.lanes);
            n.y = gather_reals(n.y, found.y, from.lanes);
            n.z = gather_reals(n.z, found.z, from.lanes);
            continue;
        }
        xy0 = gather(xy0, words_at(tables, columns, from.planes, at.row0, 0), from.lanes);
        xy1 = gather(xy1, words_at(tables, columns, from.planes, at.row1, 0), from.lanes);
        z0 = gather(z0, halves_at(tables, columns, from.planes, at.row0, 1), from.lanes);
        z1 = gather(z1, halves_at(tables, columns, from.planes, at.row1, 1), from.lanes);
    }
    return floats ? n : mix_vectors(xy0, z0, xy1, z1, at.between);
}

#endif

// Returns rotations between two rows, in ROW_PARTS of a step.
INLINE Quat rotation_parts(const ClipTables *tables, Columns columns, SlotSample at)
{
#if LANES > 1
    if (!(columns.flags & BLOCK_STRAIGHT)) return gathered_rotation(tables, columns, at);
#endif
    return block_rotation(tables, columns, planes_of(columns.block, ROTATION), at);
}

// Returns translations or scales between two rows, in ROW_PARTS of a step.
INLINE Vec3 vector_parts(const ClipTables *tables, Columns columns, uint property, SlotSample at)
{
#if LANES > 1
    if (!(columns.flags & BLOCK_STRAIGHT)) return gathered_vector(tables, columns, property, at);
#endif
    return block_vector(tables, columns, planes_of(columns.block, property), at);
}

// Planes of a joint, or of sixteen, in a table of poses. Offsets are 32 bits wide, since GPUs hold one
// of 64 bits in two registers.
typedef struct {
    __global const float *poses;
    uint first, padded;
} Stored;

INLINE Stored stored_at(const ClipTables *tables, uint first, Body body)
{
    const Stored stored = { tables->poses, first, body.padded_count };
    return stored;
}

INLINE Real stored_real(Stored stored, uint plane)
{
    return LOAD(stored.poses + (stored.first + plane * stored.padded));
}

// Returns the step in a plane, divided by ROW_PARTS.
INLINE Real stored_part(Stored stored, uint plane)
{
    return stored_real(stored, plane) * (1.0f / ROW_PARTS);
}

INLINE Quat stored_quat(Stored stored, uint plane)
{
    const Quat q = { stored_real(stored, plane), stored_real(stored, plane + 1),
                     stored_real(stored, plane + 2), stored_real(stored, plane + 3) };
    return q;
}

INLINE Vec3 stored_vec3(Stored stored, uint plane)
{
    const Vec3 v = { stored_real(stored, plane), stored_real(stored, plane + 1),
                     stored_real(stored, plane + 2) };
    return v;
}

// Returns translations or scales between two rows. `plane` is the first of their offset; after it
// comes their step.
INLINE Vec3 sample_vector(const ClipTables *tables, Columns columns, uint property, SlotSample at,
                          Stored range, uint plane)
{
    const Vec3 still = stored_vec3(range, plane);
    if (planes_of(columns.block, property).first == NONE) return still;
    const Vec3 n = vector_parts(tables, columns, property, at);
    return vec3_add(vec3_scale(n, stored_part(range, plane + 3)), still);
}

// A sample of a clip. Rotations are near length 1, as unit_of() needs. `at_rest` has REST_TRANSLATION
// or REST_SCALE set if that property is at rest.
typedef struct {
    Local trs;
    uint at_rest;
} Sample;

// Returns the factor that brings a sampled rotation to length 1, in the hemisphere of the rest
// rotation. Rows are near each other, so that three terms of a series are enough: halfway between
// rows that are 60 degrees apart, the length is off by 0.0001.
INLINE Real unit_of(Quat rotation, Quat rest)
{
    const Real short_by = 1.0f - quat_dot(rotation, rotation);
    return (1.0f + short_by * (0.5f + short_by * 0.375f)) * quat_side(rotation, rest);
}

// Returns the sample with a rotation of length 1 in the hemisphere of the rest rotation.
INLINE Local normalized(Sample sample, Local rest)
{
    sample.trs.r = quat_scale(sample.trs.r, unit_of(sample.trs.r, rest.r));
    return sample.trs;
}

// Applies retarget corrections; see corrections.cl.
APART void correct(const ClipTables *tables, BoundClip bound, Body body, uint joint, SlotSample at,
                   Local *posed);

// Samples a clip between two rows. *trs comes in at rest.
INLINE void sample_columns(const ClipTables *tables, Columns columns, BoundClip bound, Body body,
                           uint joint, SlotSample at, Local *trs)
{
    const Stored range = stored_at(tables, bound.range_first + joint, body);
    trs->r = stored_quat(range, 0);
    if (columns.block.rotation_first != NONE)
        trs->r = quat_add(quat_scale(rotation_parts(tables, columns, at), stored_part(range, 4)),
                          trs->r);
    if (!(columns.flags & REST_TRANSLATION))
        trs->t = sample_vector(tables, columns, TRANSLATION, at, range, 5);
    if (!(columns.flags & REST_SCALE)) trs->s = sample_vector(tables, columns, SCALE, at, range, 9);
    if (columns.flags & BLOCK_CORRECTED) {
        Local turned = *trs;
        correct(tables, bound, body, joint, at, &turned);
        *trs = turned;
    }
}

#if LANES > 1

// Returns whether all columns are stored as halves, each joint's in its own lane, and need no
// correction, as nearly all are.
INLINE bool are_common(Columns columns)
{
    const uint lanes =
        columns.block.rotation_lanes | columns.block.translation_lanes | columns.block.scale_lanes;
    return (columns.flags & (BLOCK_STRAIGHT | BLOCK_CORRECTED)) == BLOCK_STRAIGHT
           && !(lanes & ROW_FLOATS);
}

// Tells the compiler that columns are common.
INLINE Columns as_common(Columns columns)
{
    columns.flags = (columns.flags & (REST_TRANSLATION | REST_SCALE)) | BLOCK_STRAIGHT;
    columns.block.rotation_lanes &= ~ROW_FLOATS;
    columns.block.translation_lanes &= ~ROW_FLOATS;
    columns.block.scale_lanes &= ~ROW_FLOATS;
    return columns;
}

// Samples any columns. The slow path.
APART void sample_any(const ClipTables *tables, Columns columns, BoundClip bound, Body body,
                      uint joint, SlotSample at, Local *trs)
{
    sample_columns(tables, columns, bound, body, joint, at, trs);
}

#endif

// Returns local transforms between two rows.
INLINE Sample sample_joint(const ClipTables *tables, BoundClip bound, Body body, uint joint,
                           SlotSample at, Local rest)
{
    const Columns columns = columns_of(tables, bound, joint);
    Sample sample = { rest, columns.flags & (REST_TRANSLATION | REST_SCALE) };
#if LANES > 1
    // The slow path has a copy, so that the pointer to it does not keep the sample in memory.
    if (!are_common(columns)) {
        Local any = rest;
        sample_any(tables, columns, bound, body, joint, at, &any);
        sample.trs = any;
        return sample;
    }
    sample_columns(tables, as_common(columns), bound, body, joint, at, &sample.trs);
#else
    sample_columns(tables, columns, bound, body, joint, at, &sample.trs);
#endif
    return sample;
}
