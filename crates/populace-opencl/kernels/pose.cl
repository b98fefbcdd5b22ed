/* pose.cl - Pose: each member's slots, mixed layer by layer, as local transforms (Lister & Day 2012, section 4.1).
 * NDRange  (the joint buffer's places, padded to whole work-groups); 16 places are one block of one member's joints
 * Reads    member, samples, slots, layers, the clips' rows, stored poses, joint maps, masks
 * Writes   translations, rotations, scales: every joint exactly once, padding untouched
 * Oracle   populace-testkit oracle/pose.rs; twin of populace-native pose.rs */

typedef struct {
    __global const BoundClip *bound_clips;
    __global const ClipRows *clips;
    __global const uint *block_offsets, *joint_maps;
    __global const float *rows, *poses, *masks;
} Clips;

/* One joint of a stored pose: ten planes of `padded` floats, rotation, translation, scale. */
float4 stored_rotation(__global const float *joint, uint padded)
{
    return (float4)(joint[0], joint[padded], joint[2 * padded], joint[3 * padded]);
}

float4 stored_translation(__global const float *joint, uint padded)
{
    return (float4)(joint[4 * padded], joint[5 * padded], joint[6 * padded], 0.0f);
}

float4 stored_scale(__global const float *joint, uint padded)
{
    return (float4)(joint[7 * padded], joint[8 * padded], joint[9 * padded], 0.0f);
}

float4 row_at3(__global const float *row)
{
    return (float4)(row[0], row[JOINT_BLOCK], row[2 * JOINT_BLOCK], 0.0f);
}

float4 row_at4(__global const float *row)
{
    return (float4)(row[0], row[JOINT_BLOCK], row[2 * JOINT_BLOCK], row[3 * JOINT_BLOCK]);
}

/* A joint's local transform between two rows, its rotation in the hemisphere of the rest rotation. */
Trs sample_joint(Clips of, BoundClip bound, uint padded, uint joint, SlotSample at, float4 rest_rotation)
{
    const uint map = of.joint_maps[bound.map_first + joint];
    const uint column = map & MAP_COLUMN, lane = column % JOINT_BLOCK;
    __global const uint *offsets = of.block_offsets + of.clips[bound.clip].block_first + column / JOINT_BLOCK * 3;
    __global const float *row0 = of.rows + at.row0 + lane, *row1 = of.rows + at.row1 + lane;
    __global const float *base = of.poses + bound.base_first + joint;
    const float f = at.between;
    Trs trs;
    if (map & MAP_ROTATION)
        trs.r = quat_normalize_or(mix4(row_at4(row0 + offsets[0]), row_at4(row1 + offsets[0]), f), rest_rotation);
    else
        trs.r = stored_rotation(base, padded);
    if (map & MAP_TRANSLATION)
        trs.t = mix4(row_at3(row0 + offsets[1]), row_at3(row1 + offsets[1]), f);
    else
        trs.t = stored_translation(base, padded);
    if (map & MAP_SCALE)
        trs.s = mix4(row_at3(row0 + offsets[2]), row_at3(row1 + offsets[2]), f);
    else
        trs.s = stored_scale(base, padded);
    trs.r = quat_hemisphere(trs.r, rest_rotation);
    return trs;
}

/* What takes `reference` to `value`, less what changes nothing: sums of it do not depend on their order. */
Trs difference(Trs value, Trs reference)
{
    Trs delta;
    delta.r = quat_hemisphere(quat_mul(quat_conjugate(reference.r), value.r), QUAT_IDENTITY);
    delta.r.w -= 1.0f;
    delta.t = value.t - reference.t;
    delta.s = (float4)(reference.s.x == 0.0f ? 1.0f : value.s.x / reference.s.x,
                       reference.s.y == 0.0f ? 1.0f : value.s.y / reference.s.y,
                       reference.s.z == 0.0f ? 1.0f : value.s.z / reference.s.z, 1.0f) - 1.0f;
    return delta;
}

Trs add_layer(Trs beneath, Trs sum, float layer_weight)
{
    Trs trs;
    const float4 delta = quat_normalize_or(QUAT_IDENTITY + sum.r * layer_weight, QUAT_IDENTITY);
    trs.t = beneath.t + sum.t * layer_weight;
    trs.r = quat_mul(beneath.r, delta);
    trs.s = beneath.s * (1.0f + sum.s * layer_weight);
    return trs;
}

Trs mean_of(Trs sum, float total, float4 rest_rotation)
{
    const float k = 1.0f / total;
    Trs mean;
    mean.t = sum.t * k;
    mean.r = quat_normalize_or(sum.r, rest_rotation);
    mean.s = sum.s * k;
    return mean;
}

/* A layer above 0 whose slots weigh less than 1 in all leaves the remainder to what lies beneath. */
Trs mix_layer(Trs beneath, Trs sum, float total, float layer_weight, float4 rest_rotation)
{
    if (total <= 0.0f) return beneath;
    const float f = layer_weight * (total < 1.0f ? total : 1.0f);
    const Trs above = mean_of(sum, total, rest_rotation);
    const float4 from = quat_hemisphere(beneath.r, rest_rotation), to = quat_hemisphere(above.r, rest_rotation);
    Trs trs;
    trs.t = mix4(beneath.t, above.t, f);
    trs.r = quat_normalize_or(mix4(from, to, f), rest_rotation);
    trs.s = mix4(beneath.s, above.s, f);
    return trs;
}

/* The sum over a layer's slots of weight times value, or times difference from the first row; the weights' in *total. */
Trs sum_layer(Clips of, __global const Slot *slots, __global const SlotSample *samples, uint slot_count,
                uint layer_index, bool additive, uint padded, uint joint, float4 rest_rotation, float *total)
{
    Trs sum = { (float4)(0.0f), (float4)(0.0f), (float4)(0.0f) };
    *total = 0.0f;
    for (uint s = 0; s < slot_count; s++) {
        const SlotSample sample = samples[s];
        if (sample.weight <= 0.0f || slot_layer(slots[s]) != layer_index) continue;
        const BoundClip bound = of.bound_clips[slots[s].bound_clip];
        Trs value = sample_joint(of, bound, padded, joint, sample, rest_rotation);
        if (additive) {
            const uint first = of.clips[bound.clip].row_first;
            const SlotSample start = { first, first, 0.0f, 0.0f };
            value = difference(value, sample_joint(of, bound, padded, joint, start, rest_rotation));
        }
        sum.t += value.t * sample.weight;
        sum.r += value.r * sample.weight;
        sum.s += value.s * sample.weight;
        *total += sample.weight;
    }
    return sum;
}

__kernel void pose(__global const Member *members, __global const uint *joint_blocks, __global const Body *bodies,
                   __global const Slot *slots, __global const SlotSample *samples, __global const Layer *layers,
                   __global const BoundClip *bound_clips, __global const ClipRows *clips,
                   __global const uint *block_offsets, __global const uint *joint_maps, __global const float *rows,
                   __global const float *poses, __global const float *masks, uint slots_per_member, uint place_count,
                   __global float4 *translations, __global float4 *rotations, __global float4 *scales)
{
    const uint place = (uint)get_global_id(0);
    if (place >= place_count || joint_blocks[place / JOINT_BLOCK] == NONE) return;
    const uint owner = joint_blocks[place / JOINT_BLOCK];
    const Member member = members[owner];
    const uint joint = place - member.joint_first;
    const uint padded = bodies[member.body].padded_count;
    if (joint >= bodies[member.body].joint_count) return;

    const Clips of = { bound_clips, clips, block_offsets, joint_maps, rows, poses, masks };
    __global const float *rest = poses + bodies[member.body].rest_first + joint;
    const float4 rest_rotation = stored_rotation(rest, padded);
    const uint first_slot = owner * slots_per_member;
    float total;
    Trs sum = sum_layer(of, slots + first_slot, samples + first_slot, slots_per_member, 0, false, padded, joint,
                        rest_rotation, &total), trs;
    /* Layer 0 is always divided by its total, so that nobody sees the rest pose by accident. */
    if (total > 1e-3f) {
        trs = mean_of(sum, total, rest_rotation);
    } else {
        trs.t = stored_translation(rest, padded);
        trs.r = rest_rotation;
        trs.s = stored_scale(rest, padded);
    }
    for (uint l = 1; l < member.layer_count; l++) {
        const Layer layer = layers[owner * LAYERS_PER_MEMBER + l];
        const uint mask = layer.mask_and_mode & LAYER_MASK;
        const float weight = layer.weight * (mask == LAYER_MASK ? 1.0f : masks[mask + joint]);
        if (!(weight > 0.0f)) continue;
        const bool additive = (layer.mask_and_mode & LAYER_ADDITIVE) != 0;
        sum = sum_layer(of, slots + first_slot, samples + first_slot, slots_per_member, l, additive, padded, joint,
                        rest_rotation, &total);
        trs = additive ? add_layer(trs, sum, weight) : mix_layer(trs, sum, total, weight, rest_rotation);
    }
    translations[place] = trs.t;
    rotations[place] = trs.r;
    scales[place] = trs.s;
}
