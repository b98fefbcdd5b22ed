/* rows.cl - local transforms of one joint, or of sixteen neighbouring ones, from a clip's rows; see populace-core
 * clip/storage.rs for what a row holds. A component is `offset + step * n`: a joint that the clip does not drive, or that
 * stands still, has a step of 0, so the arithmetic is the same for all. */

typedef struct {
    __global const BoundClip *bound_clips;
    __global const BoundBlock *bound_blocks;
    __global const Source *sources;
    __global const uint *source_lanes;
    __global const ClipRows *clips;
    __global const RowBlock *row_blocks;
    __global const uint *joint_maps, *rows;
    __global const float *poses, *masks;
} Clips;

/* A slot as it plays now. */
typedef struct { SlotSample at; uint bound_clip, layer; } Playing;

/* Properties of a row. */
enum { ROTATION, TRANSLATION, SCALE };

/* Where a property's planes stand in a row, and the words from one plane to the next. */
typedef struct { uint first, lanes; } Planes;

Planes planes_of(RowBlock block, uint property)
{
    const Planes rotation = { block.rotation_first, block.rotation_lanes };
    const Planes translation = { block.translation_first, block.translation_lanes };
    const Planes scale = { block.scale_first, block.scale_lanes };
    return property == ROTATION ? rotation : property == TRANSLATION ? translation : scale;
}

uint plane_at(Planes planes, uint row, uint plane) { return row + planes.first + plane * (planes.lanes & ~ROW_FLOATS); }

/* A component's steps from the word that holds it: all of a float, or the lower or upper half. */
Real steps_in(Words words, Planes planes, uint component)
{
    if (planes.lanes & ROW_FLOATS) return AS_REAL(words);
    return CONVERT_REAL(AS_INTS(component % 2 == 0 ? words & 0xffffu : words >> 16));
}

/* The plane that holds a component. */
uint plane_of(Planes planes, uint component) { return planes.lanes & ROW_FLOATS ? component : component / 2; }

/* Whether a plane holds a half for each lane, two in a word: the third component of translations and scales. */
bool is_packed(Planes planes, uint property, uint component)
{
    return !(planes.lanes & ROW_FLOATS) && property != ROTATION && component == 2;
}

#if LANES == 1

/* Where a joint's column stands. */
typedef struct { RowBlock block; uint lane; } Columns;

Columns columns_of(Clips of, BoundClip bound, uint joint)
{
    const uint map = of.joint_maps[bound.map_first + joint], column = map & MAP_COLUMN;
    Columns columns = { of.row_blocks[of.clips[bound.clip].block_first + column / JOINT_BLOCK], column % JOINT_BLOCK };
    if (!(map & MAP_ROTATION)) columns.block.rotation_first = NONE;
    if (!(map & MAP_TRANSLATION)) columns.block.translation_first = NONE;
    if (!(map & MAP_SCALE)) columns.block.scale_first = NONE;
    return columns;
}

/* A component of a row, in steps. */
Real steps(Clips of, Columns columns, uint property, uint row, uint component)
{
    const Planes planes = planes_of(columns.block, property);
    __global const uint *plane = of.rows + plane_at(planes, row, plane_of(planes, component));
    if (is_packed(planes, property, component))
        return steps_in(plane[columns.lane / 2] >> 16 * (columns.lane % 2), planes, component);
    return steps_in(plane[columns.lane], planes, component);
}

#else

/* Where the columns of sixteen neighbouring joints stand: in one block, each in its own lane, or here and there in
 * several; `block` then tells no more than what moves. */
typedef struct { RowBlock block; BoundBlock bound; } Columns;

/* What moves in either block; where it stands is that of one. */
RowBlock moving_of(RowBlock a, RowBlock b)
{
    if (b.rotation_first != NONE) a.rotation_first = b.rotation_first;
    if (b.translation_first != NONE) a.translation_first = b.translation_first;
    if (b.scale_first != NONE) a.scale_first = b.scale_first;
    return a;
}

Columns columns_of(Clips of, BoundClip bound, uint joint)
{
    Columns columns = { { NONE, 0, NONE, 0, NONE, 0 }, of.bound_blocks[bound.block_first + joint / JOINT_BLOCK] };
    for (uint s = 0; s < columns.bound.source_count; s++) {
        const RowBlock source = of.row_blocks[of.sources[columns.bound.source_first + s].block];
        columns.block = columns.bound.straight ? source : moving_of(columns.block, source);
    }
    return columns;
}

/* A component of a row, in steps, of the columns of one block. */
Real block_steps(Clips of, Planes planes, uint property, uint row, uint component)
{
    __global const uint *plane = of.rows + plane_at(planes, row, plane_of(planes, component));
    if (is_packed(planes, property, component))
        return CONVERT_REAL(convert_int16(vload16(0, (__global const ushort *)plane)));
    return steps_in(vload16(0, plane), planes, component);
}

/* A component of a row, in steps, of each lane's column in the block that it follows. */
Real gathered_steps(Clips of, BoundBlock bound, uint property, uint row, uint component)
{
    Words found = 0;
    for (uint s = 0; s < bound.source_count; s++) {
        const Source source = of.sources[bound.source_first + s];
        const Planes planes = planes_of(of.row_blocks[source.block], property);
        if (planes.first == NONE) continue;
        const Words lanes = vload16(0, of.source_lanes + source.lanes_first);
        const Words here = AS_WORDS(block_steps(of, planes, property, row, component));
        found = lanes == (Words)(NONE) ? found : permute(here, lanes);
    }
    return AS_REAL(found);
}

/* A component of a row, in steps. */
Real steps(Clips of, Columns columns, uint property, uint row, uint component)
{
    if (!columns.bound.straight) return gathered_steps(of, columns.bound, property, row, component);
    return block_steps(of, planes_of(columns.block, property), property, row, component);
}

#endif

/* A component between two rows, in steps. */
Real steps_between(Clips of, Columns columns, uint property, SlotSample at, uint component)
{
    return mix_real(steps(of, columns, property, at.row0, component), steps(of, columns, property, at.row1, component),
                    at.between);
}

Quat load_quat(__global const float *planes, uint padded)
{
    const Quat q = { LOAD(planes), LOAD(planes + padded), LOAD(planes + 2 * padded), LOAD(planes + 3 * padded) };
    return q;
}

Vec3 load_vec3(__global const float *planes, uint padded)
{
    const Vec3 v = { LOAD(planes), LOAD(planes + padded), LOAD(planes + 2 * padded) };
    return v;
}

/* Translations or scales between two rows; `offset` and `step` are planes. */
Vec3 sample_vector(Clips of, Columns columns, uint property, SlotSample at, __global const float *offset,
                   __global const float *step, uint padded)
{
    const Vec3 still = load_vec3(offset, padded);
    if (planes_of(columns.block, property).first == NONE) return still;
    const Vec3 n = { steps_between(of, columns, property, at, 0), steps_between(of, columns, property, at, 1),
                     steps_between(of, columns, property, at, 2) };
    return vec3_add(vec3_scale(n, LOAD(step)), still);
}

/* Local transforms between two rows, rotations in the hemisphere of the rest rotation. */
Trs sample_joint(Clips of, BoundClip bound, Body body, uint joint, SlotSample at, Quat rest_rotation)
{
    const Columns columns = columns_of(of, bound, joint);
    const uint padded = body.padded_count;
    __global const float *range = of.poses + bound.range_first + joint;
    __global const float *translation = range + 5 * padded, *scale = range + 9 * padded;
#if LANES > 1
    /* The same values, more likely to be near: the body's rest serves all of its clips. */
    __global const float *rest = of.poses + body.rest_first + joint;
    if (columns.bound.flags & REST_TRANSLATION) translation = rest + 4 * padded;
    if (columns.bound.flags & REST_SCALE) scale = rest + 7 * padded;
#endif
    Trs trs;
    trs.r = load_quat(range, padded);
    if (columns.block.rotation_first != NONE) {
        const Quat n = { steps_between(of, columns, ROTATION, at, 0), steps_between(of, columns, ROTATION, at, 1),
                         steps_between(of, columns, ROTATION, at, 2), steps_between(of, columns, ROTATION, at, 3) };
        trs.r = quat_add(quat_scale(n, LOAD(range + 4 * padded)), trs.r);
    }
    trs.r = quat_hemisphere(quat_normalize_or(trs.r, rest_rotation), rest_rotation);
    trs.t = sample_vector(of, columns, TRANSLATION, at, translation, range + 8 * padded, padded);
    trs.s = sample_vector(of, columns, SCALE, at, scale, range + 12 * padded, padded);
    return trs;
}
