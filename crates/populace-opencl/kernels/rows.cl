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
// or gathered from several blocks. In the second case `block` only tells which properties move, and
// whether any block has floats.
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

// Two rows, and their weights. `between` is for floats. `halves` is for 16-bit numbers, in ROW_PARTS:
// the lower half is the weight of `from`, the upper half that of `to`.
typedef struct {
    uint from, to;
    float between;
    uint halves;
} Rows;

INLINE Rows rows_of(SlotSample at)
{
    // Places that callers give may lie past the last row.
    const uint second = min(convert_uint_sat(at.between * ROW_PARTS + 0.5f), (uint)ROW_PARTS);
    const Rows rows = { at.row0, at.row1, at.between, ((uint)ROW_PARTS - second) | second << 16 };
    return rows;
}

// Words of the two planes of a property in two rows.
typedef struct {
    Words first_from, first_to, second_from, second_to;
} RowWords;

// Returns the words of columns of one block. The second plane of translations and scales becomes
// lower halves.
INLINE RowWords block_words(const ClipTables *tables, Columns columns, Planes planes, uint property,
                            Rows at)
{
    const bool packed = property != ROTATION;
    const RowWords words = { words_at(tables, columns, planes, at.from, 0),
                             words_at(tables, columns, planes, at.to, 0),
                             packed ? halves_at(tables, columns, planes, at.from, 1)
                                    : words_at(tables, columns, planes, at.from, 1),
                             packed ? halves_at(tables, columns, planes, at.to, 1)
                                    : words_at(tables, columns, planes, at.to, 1) };
    return words;
}

INLINE Quat mix_quats(RowWords words, Rows at)
{
    const Quat n = { mix_low(words.first_from, words.first_to, at.halves),
                     mix_high(words.first_from, words.first_to, at.halves),
                     mix_low(words.second_from, words.second_to, at.halves),
                     mix_high(words.second_from, words.second_to, at.halves) };
    return n;
}

INLINE Vec3 mix_vectors(RowWords words, Rows at)
{
    const Vec3 n = { mix_low(words.first_from, words.first_to, at.halves),
                     mix_high(words.first_from, words.first_to, at.halves),
                     mix_low(words.second_from, words.second_to, at.halves) };
    return n;
}

// Returns a component of floats between two rows.
INLINE Real mix_floats(const ClipTables *tables, Columns columns, Planes planes, Rows at,
                       uint component)
{
    return mix_real(AS_REAL(words_at(tables, columns, planes, at.from, component)),
                    AS_REAL(words_at(tables, columns, planes, at.to, component)), at.between)
           * ROW_PARTS;
}

// Returns rotations between two rows, in ROW_PARTS of a step, for columns of one block.
INLINE Quat block_rotation(const ClipTables *tables, Columns columns, Planes planes, Rows at)
{
    if (planes.lanes & ROW_FLOATS) {
        const Quat floats = { mix_floats(tables, columns, planes, at, 0),
                              mix_floats(tables, columns, planes, at, 1),
                              mix_floats(tables, columns, planes, at, 2),
                              mix_floats(tables, columns, planes, at, 3) };
        return floats;
    }
    return mix_quats(block_words(tables, columns, planes, ROTATION, at), at);
}

// Returns translations or scales between two rows, in ROW_PARTS of a step, for columns of one block.
INLINE Vec3 block_vector(const ClipTables *tables, Columns columns, Planes planes, uint property,
                         Rows at)
{
    if (planes.lanes & ROW_FLOATS) {
        const Vec3 floats = { mix_floats(tables, columns, planes, at, 0),
                              mix_floats(tables, columns, planes, at, 1),
                              mix_floats(tables, columns, planes, at, 2) };
        return floats;
    }
    return mix_vectors(block_words(tables, columns, planes, property, at), at);
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

// Gathers words from several blocks without floats.
APART RowWords gathered_words(const ClipTables *tables, Columns columns, uint property, Rows at)
{
    RowWords words = { 0, 0, 0, 0 };
    for (uint s = 0; s < columns.source_count; s++) {
        const Gathering from = gathering_of(tables, columns, s, property);
        if (from.planes.first == NONE) continue;
        const RowWords found = block_words(tables, columns, from.planes, property, at);
        words.first_from = gather(words.first_from, found.first_from, from.lanes);
        words.first_to = gather(words.first_to, found.first_to, from.lanes);
        words.second_from = gather(words.second_from, found.second_from, from.lanes);
        words.second_to = gather(words.second_to, found.second_to, from.lanes);
    }
    return words;
}

// Gathers components from several blocks, some of them with floats. `w` is 0 for vectors.
APART Quat gathered_components(const ClipTables *tables, Columns columns, uint property, Rows at)
{
    Quat n = { 0.0f, 0.0f, 0.0f, 0.0f };
    for (uint s = 0; s < columns.source_count; s++) {
        const Gathering from = gathering_of(tables, columns, s, property);
        if (from.planes.first == NONE) continue;
        Quat found = { 0.0f, 0.0f, 0.0f, 0.0f };
        if (property == ROTATION) {
            found = block_rotation(tables, columns, from.planes, at);
        } else {
            const Vec3 v = block_vector(tables, columns, from.planes, property, at);
            found.x = v.x;
            found.y = v.y;
            found.z = v.z;
        }
        n.x = gather_reals(n.x, found.x, from.lanes);
        n.y = gather_reals(n.y, found.y, from.lanes);
        n.z = gather_reals(n.z, found.z, from.lanes);
        n.w = gather_reals(n.w, found.w, from.lanes);
    }
    return n;
}

#endif

// Returns rotations between two rows, in ROW_PARTS of a step.
INLINE Quat rotation_parts(const ClipTables *tables, Columns columns, Rows at)
{
    const Planes planes = planes_of(columns.block, ROTATION);
#if LANES > 1
    if (!(columns.flags & BLOCK_STRAIGHT)) {
        if (planes.lanes & ROW_FLOATS) return gathered_components(tables, columns, ROTATION, at);
        return mix_quats(gathered_words(tables, columns, ROTATION, at), at);
    }
#endif
    return block_rotation(tables, columns, planes, at);
}

// Returns translations or scales between two rows, in ROW_PARTS of a step.
INLINE Vec3 vector_parts(const ClipTables *tables, Columns columns, uint property, Rows at)
{
    const Planes planes = planes_of(columns.block, property);
#if LANES > 1
    if (!(columns.flags & BLOCK_STRAIGHT)) {
        if (planes.lanes & ROW_FLOATS) {
            const Quat n = gathered_components(tables, columns, property, at);
            const Vec3 v = { n.x, n.y, n.z };
            return v;
        }
        return mix_vectors(gathered_words(tables, columns, property, at), at);
    }
#endif
    return block_vector(tables, columns, planes, property, at);
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
INLINE Vec3 sample_vector(const ClipTables *tables, Columns columns, uint property, Rows at,
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
    const Rows rows = rows_of(at);
    trs->r = stored_quat(range, 0);
    if (columns.block.rotation_first != NONE)
        trs->r = quat_add(quat_scale(rotation_parts(tables, columns, rows), stored_part(range, 4)),
                          trs->r);
    if (!(columns.flags & REST_TRANSLATION))
        trs->t = sample_vector(tables, columns, TRANSLATION, rows, range, 5);
    if (!(columns.flags & REST_SCALE))
        trs->s = sample_vector(tables, columns, SCALE, rows, range, 9);
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
