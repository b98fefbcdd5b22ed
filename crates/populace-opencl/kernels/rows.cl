// rows.cl - Local transforms of one joint, or of neighbouring ones in lanes, from rows of a clip.
// Twin of populace-native/src/rows.rs, populace-native/src/block_columns.rs,
// populace-native/src/encoding.rs and populace-native/src/sample.rs: same arithmetic, same order of
// operations.
//
// populace-clip/src/storage.rs describes a row. A component is `offset + part * n`, where n is the
// sum of both rows' numbers, each times its weight in ROW_PARTS. Joints that the clip does not
// drive, or that do not move in it, have a part of 0, so the arithmetic is the same for all.

typedef struct {
    __global const BoundClip *bound_clips;
    __global const BoundBlock *bound_blocks;
    __global const ClipRows *clips;
    __global const uint *rows;
    __global const float *poses, *masks;
} ClipTables;

// Numbers of a joint, or of joints in lanes, in a table of poses. The planes of sixteen joints are
// neighbours, so that a compiler knows how far apart they are.
typedef __global const float *Stored;

// Where a row begins: its index among words, or with lanes a pointer, which saves additions.
#if LANES == 1
typedef uint RowStart;
INLINE RowStart row_start(const ClipTables *tables, uint row) { return row; }
#else
typedef __global const uint *RowStart;
INLINE RowStart row_start(const ClipTables *tables, uint row) { return tables->rows + row; }
#endif

// A slot as it plays now. `secs` is the time after the start of the clip; NAN for live clips, without
// weight, and in the staged schedule.
typedef struct {
    SlotSample at;
    uint bound_clip, layer;
    float secs;
    // The weights of both rows; see Rows.
    uint halves;
#if LANES > 1
    // The clip's first block of columns, its planes, and both rows. play_all() sets them.
    __global const BoundBlock *blocks;
    Stored planes;
    RowStart from, to;
#endif
} Playing;

// Properties of a row.
enum { ROTATION, TRANSLATION, SCALE };

// Where the columns of a block of sixteen joints are stored. `lane` is the place of the first joint
// that is sampled within the block. `no_floats` is a constant: true if the clip is known to store
// none.
typedef struct {
    BoundBlock block;
    uint flags, lane;
    bool no_floats;
} Columns;

INLINE Columns columns_of(__global const BoundBlock *blocks, uint joint, bool no_floats)
{
    // Counted in words, since compilers would multiply an index again for each slot.
    __global const uint *words =
        (__global const uint *)blocks + joint / JOINT_BLOCK * (uint)(sizeof(BoundBlock) / 4);
#if LANES == 1
    // GPUs read all four words at once.
    const uint4 all = *(__global const uint4 *)words;
    const BoundBlock block = { all.x, all.y, all.z, all.w };
#else
    const BoundBlock block = *(__global const BoundBlock *)words;
#endif
    const Columns columns = { block, block.lanes_and_flags >> 24, joint % JOINT_BLOCK, no_floats };
    return columns;
}

// The first word of a property's planes in a row, and the words from one plane to the next.
// `floats` tells that each component has a plane of floats.
typedef struct {
    uint first, lanes;
    bool floats;
} Planes;

INLINE Planes planes_of(Columns columns, uint property)
{
    const BoundBlock block = columns.block;
    const Planes planes = {
        property == ROTATION      ? block.rotation_first
        : property == TRANSLATION ? block.translation_first
                                  : block.scale_first,
        block.lanes_and_flags >> 8 * property & 0xff,
        !columns.no_floats && columns.flags & FLOATS << property,
    };
    return planes;
}

// Returns the first word of a plane, after the beginning of its row.
INLINE uint plane_at(Planes planes, uint plane) { return planes.first + plane * planes.lanes; }

#if LANES == 1

INLINE Words words_at(const ClipTables *tables, Columns columns, Planes planes, RowStart row,
                      uint plane)
{
    return tables->rows[row + plane_at(planes, plane) + columns.lane];
}

// Returns words whose lower halves are those of a plane with two lanes in a word.
INLINE Words halves_at(const ClipTables *tables, Columns columns, Planes planes, RowStart row,
                       uint plane)
{
    return tables->rows[row + plane_at(planes, plane) + columns.lane / 2]
           >> 16 * (columns.lane % 2);
}

#else

INLINE Words words_at(const ClipTables *tables, Columns columns, Planes planes, RowStart row,
                      uint plane)
{
    return LOAD(row + plane_at(planes, plane) + columns.lane);
}

INLINE Words halves_at(const ClipTables *tables, Columns columns, Planes planes, RowStart row,
                       uint plane)
{
    __global const ushort *halves = (__global const ushort *)(row + plane_at(planes, plane));
    return CONVERT_WORDS(LOAD(halves + columns.lane));
}

#endif

// Two rows, and their weights. `between` is for floats. `halves` is for 16-bit numbers, in ROW_PARTS:
// the lower half is the weight of `from`, the upper half that of `to`.
typedef struct {
    RowStart from, to;
    float between;
    uint halves;
} Rows;

// Returns the weights of two rows in ROW_PARTS, for 16-bit numbers.
INLINE uint halves_of(float between)
{
    // Places that callers give may lie past the last row.
    const float part = between > 0.0f ? between < 1.0f ? between : 1.0f : 0.0f;
    const uint second = (uint)(part * ROW_PARTS + 0.5f);
    return ((uint)ROW_PARTS - second) | second << 16;
}

INLINE Rows rows_of(const ClipTables *tables, SlotSample at)
{
    const Rows rows = { row_start(tables, at.row0), row_start(tables, at.row1), at.between,
                        halves_of(at.between) };
    return rows;
}

// Returns the rows that a slot plays.
INLINE Rows rows_in(Playing playing)
{
#if LANES == 1
    const Rows rows = { playing.at.row0, playing.at.row1, playing.at.between, playing.halves };
#else
    const Rows rows = { playing.from, playing.to, playing.at.between, playing.halves };
#endif
    return rows;
}

// Words of the two planes of a property in two rows.
typedef struct {
    Words first_from, first_to, second_from, second_to;
} RowWords;

// Returns the words of columns. The second plane of translations and scales becomes lower halves.
INLINE RowWords row_words(const ClipTables *tables, Columns columns, Planes planes, uint property,
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

INLINE Quat float_quats(const ClipTables *tables, Columns columns, Rows at)
{
    const Planes planes = planes_of(columns, ROTATION);
    const Quat floats = { mix_floats(tables, columns, planes, at, 0),
                          mix_floats(tables, columns, planes, at, 1),
                          mix_floats(tables, columns, planes, at, 2),
                          mix_floats(tables, columns, planes, at, 3) };
    return floats;
}

INLINE Vec3 float_vectors(const ClipTables *tables, Columns columns, uint property, Rows at)
{
    const Planes planes = planes_of(columns, property);
    const Vec3 floats = { mix_floats(tables, columns, planes, at, 0),
                          mix_floats(tables, columns, planes, at, 1),
                          mix_floats(tables, columns, planes, at, 2) };
    return floats;
}

// Returns rotations between two rows, in ROW_PARTS of a step.
INLINE Quat rotation_parts(const ClipTables *tables, Columns columns, Rows at)
{
    const Planes planes = planes_of(columns, ROTATION);
    return planes.floats ? float_quats(tables, columns, at)
                         : mix_quats(row_words(tables, columns, planes, ROTATION, at), at);
}

// Returns translations or scales between two rows, in ROW_PARTS of a step.
INLINE Vec3 vector_parts(const ClipTables *tables, Columns columns, uint property, Rows at)
{
    const Planes planes = planes_of(columns, property);
    return planes.floats ? float_vectors(tables, columns, property, at)
                         : mix_vectors(row_words(tables, columns, planes, property, at), at);
}

// Returns the offset of a joint's numbers.
INLINE uint stored_offset(uint planes, uint joint)
{
    return joint / JOINT_BLOCK * JOINT_BLOCK * planes + joint % JOINT_BLOCK;
}

INLINE Stored stored_at(const ClipTables *tables, uint first, uint planes, uint joint)
{
    return tables->poses + (first + stored_offset(planes, joint));
}

INLINE Real stored_real(Stored stored, int plane) { return LOAD(stored + plane * JOINT_BLOCK); }

INLINE Quat stored_quat(Stored stored, int plane)
{
    const Quat q = { stored_real(stored, plane), stored_real(stored, plane + 1),
                     stored_real(stored, plane + 2), stored_real(stored, plane + 3) };
    return q;
}

INLINE Vec3 stored_vec3(Stored stored, int plane)
{
    const Vec3 v = { stored_real(stored, plane), stored_real(stored, plane + 1),
                     stored_real(stored, plane + 2) };
    return v;
}

// Returns the pose whose first plane is `plane`.
INLINE Local stored_pose(Stored stored, int plane)
{
    const Local pose = { stored_vec3(stored, plane + 4), stored_quat(stored, plane),
                         stored_vec3(stored, plane + 7) };
    return pose;
}

// Returns the pose in the first row of a bound clip.
INLINE Local first_pose(const ClipTables *tables, uint bound, uint joint)
{
    const uint planes = tables->bound_clips[bound].plane_first;
    return stored_pose(stored_at(tables, planes, BOUND_PLANES, joint), FIRST_POSE_PLANE);
}

// Returns rotations between two rows, of a block in which they move.
INLINE Quat moving_quat(const ClipTables *tables, Columns columns, Rows at, Stored range)
{
    const Quat n = rotation_parts(tables, columns, at);
    return quat_add(quat_scale(n, stored_real(range, 4)), stored_quat(range, 0));
}

INLINE Quat sample_rotation(const ClipTables *tables, Columns columns, Rows at, Stored range)
{
    if (columns.block.rotation_first == NONE) return stored_quat(range, 0);
    return moving_quat(tables, columns, at, range);
}

// Returns translations or scales between two rows, of a block in which they move. `plane` is the
// first of their offset; after it comes their part.
INLINE Vec3 moving_vector(const ClipTables *tables, Columns columns, uint property, Rows at,
                          Stored range, int plane)
{
    const Vec3 n = vector_parts(tables, columns, property, at);
    return vec3_add(vec3_scale(n, stored_real(range, plane + 3)), stored_vec3(range, plane));
}

INLINE Vec3 sample_vector(const ClipTables *tables, Columns columns, uint property, Rows at,
                          Stored range, int plane)
{
    if (planes_of(columns, property).first == NONE) return stored_vec3(range, plane);
    return moving_vector(tables, columns, property, at, range, plane);
}

// A sample of a clip. Rotations are near length 1, as unit_of() needs. `at_rest` has REST_TRANSLATION
// or REST_SCALE set if that property is at rest.
typedef struct {
    Local trs;
    uint at_rest;
} Sample;

// Returns the factor that brings a sampled rotation to length 1. Rows are near each other, so that
// three terms of a series are enough: halfway between rows that are 60 degrees apart, the length is
// off by 0.0001.
INLINE Real near_unit_of(Quat rotation)
{
    const Real short_by = 1.0f - quat_dot(rotation, rotation);
    return 1.0f + short_by * (0.5f + short_by * 0.375f);
}

// Returns the same factor, negative for a rotation outside the hemisphere of the rest rotation.
INLINE Real unit_of(Quat rotation, Quat rest)
{
    return near_unit_of(rotation) * quat_side(rotation, rest);
}

// Returns the sample with a rotation of length 1 in the hemisphere of the rest rotation.
INLINE Local normalized(Sample sample, Local rest)
{
    sample.trs.r = quat_scale(sample.trs.r, unit_of(sample.trs.r, rest.r));
    return sample.trs;
}

// What a joint reads from the rows of a clip and from its range, for rotations or translations.
typedef struct {
    bool moves, floats;
    RowWords words;
    Real part;
} Reading;

INLINE Reading reading_of(const ClipTables *tables, Columns columns, uint property, Rows rows,
                          Stored range, int part_plane)
{
    const Words zero = 0;
    const RowWords none = { zero, zero, zero, zero };
    const Planes planes = planes_of(columns, property);
    Reading reading = { planes.first != NONE, planes.floats, none, stored_real(range, part_plane) };
    if (reading.moves) reading.words = row_words(tables, columns, planes, property, rows);
    return reading;
}

// Samples a clip between two rows. *trs comes in at rest. Rotations and translations are read
// before either is computed, so that a GPU waits once for both.
INLINE void sample_at_once(const ClipTables *tables, Columns columns, Stored range, Rows rows,
                           Local *trs)
{
    const bool shifts = !(columns.flags & REST_TRANSLATION);
    const Reading turn = reading_of(tables, columns, ROTATION, rows, range, 4);
    const Quat r = stored_quat(range, 0);
    Reading shift;
    Vec3 t = trs->t;
    if (shifts) {
        shift = reading_of(tables, columns, TRANSLATION, rows, range, 8);
        t = stored_vec3(range, 5);
    }
    trs->r = r;
    if (turn.moves) {
        const Quat n =
            turn.floats ? float_quats(tables, columns, rows) : mix_quats(turn.words, rows);
        trs->r = quat_add(quat_scale(n, turn.part), r);
    }
    trs->t = t;
    if (shifts && shift.moves) {
        const Vec3 n = shift.floats ? float_vectors(tables, columns, TRANSLATION, rows)
                                    : mix_vectors(shift.words, rows);
        trs->t = vec3_add(vec3_scale(n, shift.part), t);
    }
    if (!(columns.flags & REST_SCALE))
        trs->s = sample_vector(tables, columns, SCALE, rows, range, 9);
}

// Samples a clip between two rows, one property after the other. *trs comes in at rest.
INLINE void sample_columns(const ClipTables *tables, Columns columns, Stored range, Rows rows,
                           Local *trs)
{
    trs->r = sample_rotation(tables, columns, rows, range);
    if (!(columns.flags & REST_TRANSLATION))
        trs->t = sample_vector(tables, columns, TRANSLATION, rows, range, 5);
    if (!(columns.flags & REST_SCALE))
        trs->s = sample_vector(tables, columns, SCALE, rows, range, 9);
}

// Returns local transforms between two rows. `bound` is an index into bound_clips. `at_once` is a
// constant: true to read rotations and translations before either is computed.
INLINE Sample sample_joint(const ClipTables *tables, uint bound, uint joint, Rows rows, Local rest,
                           bool at_once)
{
    __global const BoundClip *clip = tables->bound_clips + bound;
    const Columns columns = columns_of(tables->bound_blocks + clip->block_first, joint, false);
    const Stored range = stored_at(tables, clip->plane_first, BOUND_PLANES, joint);
    Sample sample = { rest, columns.flags & (REST_TRANSLATION | REST_SCALE) };
    if (at_once) sample_at_once(tables, columns, range, rows, &sample.trs);
    else sample_columns(tables, columns, range, rows, &sample.trs);
    return sample;
}
