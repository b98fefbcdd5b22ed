// rows.cl - Local transforms of one joint, or of sixteen neighbouring ones, from rows of a clip.
// Twin of populace-native/src/rows.rs and sample.rs: same arithmetic, same order of operations.
//
// populace-clip/src/storage.rs describes a row. A component is `offset + step * n`. The step
// is 0 for a constant component or a joint that the clip does not drive, so the arithmetic is the
// same for all joints.

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

// Returns a component in steps from its word: the whole word if it is a float, else its lower or
// upper half.
INLINE Real steps_in(Words words, Planes planes, uint component)
{
    if (planes.lanes & ROW_FLOATS) return AS_REAL(words);
    return CONVERT_REAL(AS_INTS(component % 2 == 0 ? words & 0xffffu : words >> 16));
}

// Returns the plane that holds a component.
INLINE uint plane_of(Planes planes, uint component)
{
    return planes.lanes & ROW_FLOATS ? component : component / 2;
}

// Returns whether a plane holds one half for each lane, two in a word: the third component of
// translations and scales.
INLINE bool is_packed(Planes planes, uint property, uint component)
{
    return !(planes.lanes & ROW_FLOATS) && property != ROTATION && component == 2;
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

// Returns whether a property is stored as halves, as nearly all are.
INLINE bool is_plain(Columns columns, Planes planes) { return !(planes.lanes & ROW_FLOATS); }

INLINE Words words_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                      uint plane)
{
    return tables->rows[plane_at(planes, row, plane) + columns.lane];
}

INLINE Real halves_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                      uint plane)
{
    const uint word = tables->rows[plane_at(planes, row, plane) + columns.lane / 2];
    return convert_float((int)(word >> 16 * (columns.lane % 2) & 0xffffu));
}

// Returns a component of a row, in steps.
INLINE Real steps(const ClipTables *tables, Columns columns, uint property, uint row,
                  uint component)
{
    const Planes planes = planes_of(columns.block, property);
    if (is_packed(planes, property, component)) return halves_at(tables, columns, planes, row, 1);
    return steps_in(words_at(tables, columns, planes, row, plane_of(planes, component)), planes,
                    component);
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

// Returns whether a property is stored as halves, each joint's in its own lane, as nearly all are.
INLINE bool is_plain(Columns columns, Planes planes)
{
    return (columns.flags & BLOCK_STRAIGHT) && !(planes.lanes & ROW_FLOATS);
}

INLINE Words words_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                      uint plane)
{
    return vload16(0, tables->rows + plane_at(planes, row, plane));
}

INLINE Real halves_at(const ClipTables *tables, Columns columns, Planes planes, uint row,
                      uint plane)
{
    __global const ushort *halves =
        (__global const ushort *)(tables->rows + plane_at(planes, row, plane));
    return convert_float16(convert_int16(vload16(0, halves)));
}

// Returns a component of a row, in steps, for columns of one block.
INLINE Real block_steps(const ClipTables *tables, Columns columns, Planes planes, uint property,
                        uint row, uint component)
{
    if (is_packed(planes, property, component)) return halves_at(tables, columns, planes, row, 1);
    return steps_in(words_at(tables, columns, planes, row, plane_of(planes, component)), planes,
                    component);
}

// Returns a component of a row, in steps, gathered for each lane from its column's block.
INLINE Real gathered_steps(const ClipTables *tables, Columns columns, uint property, uint row,
                           uint component)
{
    Words found = 0;
    for (uint s = 0; s < columns.source_count; s++) {
        const Source source = tables->sources[columns.source_first + s];
        const Planes planes = planes_of(tables->row_blocks[source.block], property);
        if (planes.first == NONE) continue;
        const Words lanes = vload16(0, tables->source_lanes + source.lanes_first);
        const Words here = AS_WORDS(block_steps(tables, columns, planes, property, row, component));
        found = lanes == (Words)(NONE) ? found : permute(here, lanes);
    }
    return AS_REAL(found);
}

// Returns a component of a row, in steps.
INLINE Real steps(const ClipTables *tables, Columns columns, uint property, uint row,
                  uint component)
{
    if (!(columns.flags & BLOCK_STRAIGHT))
        return gathered_steps(tables, columns, property, row, component);
    return block_steps(tables, columns, planes_of(columns.block, property), property, row,
                       component);
}

#endif

// Returns a rotation between two rows, in steps, for any storage. The slow path.
APART Quat any_rotation_steps(const ClipTables *tables, Columns columns, SlotSample at)
{
    const Quat from = { steps(tables, columns, ROTATION, at.row0, 0),
                        steps(tables, columns, ROTATION, at.row0, 1),
                        steps(tables, columns, ROTATION, at.row0, 2),
                        steps(tables, columns, ROTATION, at.row0, 3) };
    const Quat to = { steps(tables, columns, ROTATION, at.row1, 0),
                      steps(tables, columns, ROTATION, at.row1, 1),
                      steps(tables, columns, ROTATION, at.row1, 2),
                      steps(tables, columns, ROTATION, at.row1, 3) };
    return quat_mix(from, to, at.between);
}

APART Vec3 any_vector_steps(const ClipTables *tables, Columns columns, uint property, SlotSample at)
{
    const Vec3 from = { steps(tables, columns, property, at.row0, 0),
                        steps(tables, columns, property, at.row0, 1),
                        steps(tables, columns, property, at.row0, 2) };
    const Vec3 to = { steps(tables, columns, property, at.row1, 0),
                      steps(tables, columns, property, at.row1, 1),
                      steps(tables, columns, property, at.row1, 2) };
    return vec3_mix(from, to, at.between);
}

INLINE Real low_half(Words words) { return CONVERT_REAL(AS_INTS(words & 0xffffu)); }

INLINE Real high_half(Words words) { return CONVERT_REAL(AS_INTS(words >> 16)); }

#if LANES > 1

// The same for columns gathered from several blocks without floats. Gathers whole words, not
// components.
APART Quat gathered_rotation_steps(const ClipTables *tables, Columns columns, SlotSample at)
{
    Words xy0 = 0, zw0 = 0, xy1 = 0, zw1 = 0;
    for (uint s = 0; s < columns.source_count; s++) {
        const Source source = tables->sources[columns.source_first + s];
        const Planes planes = planes_of(tables->row_blocks[source.block], ROTATION);
        if (planes.first == NONE) continue;
        const Words lanes = vload16(0, tables->source_lanes + source.lanes_first);
        const Choice elsewhere = lanes == (Words)(NONE);
        xy0 = elsewhere ? xy0 : permute(words_at(tables, columns, planes, at.row0, 0), lanes);
        zw0 = elsewhere ? zw0 : permute(words_at(tables, columns, planes, at.row0, 1), lanes);
        xy1 = elsewhere ? xy1 : permute(words_at(tables, columns, planes, at.row1, 0), lanes);
        zw1 = elsewhere ? zw1 : permute(words_at(tables, columns, planes, at.row1, 1), lanes);
    }
    const Quat n = { mix_real(low_half(xy0), low_half(xy1), at.between),
                     mix_real(high_half(xy0), high_half(xy1), at.between),
                     mix_real(low_half(zw0), low_half(zw1), at.between),
                     mix_real(high_half(zw0), high_half(zw1), at.between) };
    return n;
}

#endif

// Returns rotations between two rows, in steps.
INLINE Quat rotation_steps(const ClipTables *tables, Columns columns, SlotSample at)
{
    const Planes planes = planes_of(columns.block, ROTATION);
#if LANES > 1
    if (!is_plain(columns, planes) && !(planes.lanes & ROW_FLOATS))
        return gathered_rotation_steps(tables, columns, at);
#endif
    if (!is_plain(columns, planes)) return any_rotation_steps(tables, columns, at);
    const Words xy0 = words_at(tables, columns, planes, at.row0, 0),
                zw0 = words_at(tables, columns, planes, at.row0, 1);
    const Words xy1 = words_at(tables, columns, planes, at.row1, 0),
                zw1 = words_at(tables, columns, planes, at.row1, 1);
    const Quat n = { mix_real(low_half(xy0), low_half(xy1), at.between),
                     mix_real(high_half(xy0), high_half(xy1), at.between),
                     mix_real(low_half(zw0), low_half(zw1), at.between),
                     mix_real(high_half(zw0), high_half(zw1), at.between) };
    return n;
}

#if LANES > 1

APART Vec3 gathered_vector_steps(const ClipTables *tables, Columns columns, uint property,
                                 SlotSample at)
{
    Words xy0 = 0, z0 = 0, xy1 = 0, z1 = 0;
    for (uint s = 0; s < columns.source_count; s++) {
        const Source source = tables->sources[columns.source_first + s];
        const Planes planes = planes_of(tables->row_blocks[source.block], property);
        if (planes.first == NONE) continue;
        const Words lanes = vload16(0, tables->source_lanes + source.lanes_first);
        const Choice elsewhere = lanes == (Words)(NONE);
        xy0 = elsewhere ? xy0 : permute(words_at(tables, columns, planes, at.row0, 0), lanes);
        z0 = elsewhere ? z0
                       : permute(AS_WORDS(halves_at(tables, columns, planes, at.row0, 1)), lanes);
        xy1 = elsewhere ? xy1 : permute(words_at(tables, columns, planes, at.row1, 0), lanes);
        z1 = elsewhere ? z1
                       : permute(AS_WORDS(halves_at(tables, columns, planes, at.row1, 1)), lanes);
    }
    const Vec3 n = { mix_real(low_half(xy0), low_half(xy1), at.between),
                     mix_real(high_half(xy0), high_half(xy1), at.between),
                     mix_real(AS_REAL(z0), AS_REAL(z1), at.between) };
    return n;
}

#endif

// Returns translations or scales between two rows, in steps.
INLINE Vec3 vector_steps(const ClipTables *tables, Columns columns, uint property, SlotSample at)
{
    const Planes planes = planes_of(columns.block, property);
#if LANES > 1
    if (!is_plain(columns, planes) && !(planes.lanes & ROW_FLOATS))
        return gathered_vector_steps(tables, columns, property, at);
#endif
    if (!is_plain(columns, planes)) return any_vector_steps(tables, columns, property, at);
    const Words xy0 = words_at(tables, columns, planes, at.row0, 0),
                xy1 = words_at(tables, columns, planes, at.row1, 0);
    const Real z0 = halves_at(tables, columns, planes, at.row0, 1),
               z1 = halves_at(tables, columns, planes, at.row1, 1);
    const Vec3 n = { mix_real(low_half(xy0), low_half(xy1), at.between),
                     mix_real(high_half(xy0), high_half(xy1), at.between),
                     mix_real(z0, z1, at.between) };
    return n;
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
    const Vec3 n = vector_steps(tables, columns, property, at);
    return vec3_add(vec3_scale(n, stored_real(range, plane + 3)), still);
}

// A sample of a clip. `unit` scales the rotation to length 1 in the hemisphere of the rest
// rotation, or to 0 if it has no length. `at_rest` has REST_TRANSLATION or REST_SCALE set if that
// property is at rest.
typedef struct {
    Local trs;
    Real unit;
    uint at_rest;
} Sample;

// Returns the sample with a rotation of length 1.
INLINE Local normalized(Sample sample)
{
    sample.trs.r = quat_scale(sample.trs.r, sample.unit);
    return sample.trs;
}

// Applies retarget corrections; see corrections.cl.
APART void correct(const ClipTables *tables, BoundClip bound, Body body, uint joint, SlotSample at,
                   Local *posed);

// Returns local transforms between two rows.
INLINE Sample sample_joint(const ClipTables *tables, BoundClip bound, Body body, uint joint,
                           SlotSample at, Local rest)
{
    const Columns columns = columns_of(tables, bound, joint);
    const Stored range = stored_at(tables, bound.range_first + joint, body);
    Sample sample = { { rest.t, stored_quat(range, 0), rest.s },
                      0.0f,
                      columns.flags & (REST_TRANSLATION | REST_SCALE) };
    Local *trs = &sample.trs;
    if (columns.block.rotation_first != NONE)
        trs->r = quat_add(quat_scale(rotation_steps(tables, columns, at), stored_real(range, 4)),
                          trs->r);
    if (!(sample.at_rest & REST_TRANSLATION))
        trs->t = sample_vector(tables, columns, TRANSLATION, at, range, 5);
    if (!(sample.at_rest & REST_SCALE))
        trs->s = sample_vector(tables, columns, SCALE, at, range, 9);
    if (columns.flags & BLOCK_CORRECTED) {
        Local turned = *trs;
        correct(tables, bound, body, joint, at, &turned);
        *trs = turned;
    }
    sample.unit = inverse_sqrt(quat_dot(trs->r, trs->r)) * quat_side(trs->r, rest.r);
    return sample;
}
