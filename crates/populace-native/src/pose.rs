//! Pose: each member's slots, mixed layer by layer, as local transforms; the twin of `kernels/pose.cl`.

use populace_core::layout::{
    Body, BoundClip, Float4, JOINT_BLOCK, LAYER_ADDITIVE, Layer, MAP_COLUMN, MAP_ROTATION, MAP_SCALE,
    MAP_TRANSLATION, Member, NONE, SlotSample,
};
use populace_core::math::{quat, scalar};
use populace_core::{Tables, Trs};

use crate::{JointBuffer, Playback, split};

pub(crate) fn run(tables: &Tables, samples: &[SlotSample], joints: &mut JointBuffer) {
    let arrays = [&mut joints.translations[..], &mut joints.rotations[..], &mut joints.scales[..]];
    split::for_each_member(
        tables.joint_blocks.as_slice(),
        arrays,
        &|place, _, [translations, rotations, scales]| {
            let member = &tables.members.as_slice()[place as usize];
            let body = &tables.bodies.as_slice()[member.body as usize];
            let playback = Playback::of(tables, samples, place);
            for joint in 0..body.joint_count {
                let local = pose_joint(tables, member, body, &playback, joint);
                let at = joint as usize;
                translations[at] = Float4::from_xyz(local.translation);
                rotations[at] = Float4(local.rotation);
                scales[at] = Float4::from_xyz(local.scale);
            }
        },
    );
}

/// A weighted sum of local transforms; for an additive layer, of differences.
struct Sum {
    translation: [f32; 3],
    rotation: [f32; 4],
    scale: [f32; 3],
    weight: f32,
}

impl Sum {
    const ZERO: Self = Self { translation: [0.0; 3], rotation: [0.0; 4], scale: [0.0; 3], weight: 0.0 };

    fn add(&mut self, value: &Trs, weight: f32) {
        for i in 0..3 {
            self.translation[i] += value.translation[i] * weight;
            self.scale[i] += value.scale[i] * weight;
        }
        self.rotation = quat::add(self.rotation, quat::scale(value.rotation, weight));
        self.weight += weight;
    }

    fn mean(&self, rest_rotation: [f32; 4]) -> Trs {
        let k = 1.0 / self.weight;
        Trs {
            translation: self.translation.map(|v| v * k),
            rotation: quat::normalize_or(self.rotation, rest_rotation),
            scale: self.scale.map(|v| v * k),
        }
    }
}

fn pose_joint(tables: &Tables, member: &Member, body: &Body, playback: &Playback, joint: u32) -> Trs {
    let rest = stored_pose(tables, body.rest_first, body.padded_count, joint);
    let mut pose = rest;
    for layer_index in 0..member.layer_count {
        let layer = &playback.layers[layer_index as usize];
        let layer_weight = layer_weight(tables, layer, layer_index, joint);
        if layer_weight > 0.0 {
            let additive = layer_index > 0 && layer.mode == LAYER_ADDITIVE;
            let sum = sum_layer(tables, body, playback, layer_index, joint, &rest, additive);
            pose = if additive {
                add_layer(&pose, &sum, layer_weight)
            } else {
                mix_layer(&pose, &sum, layer_index, layer_weight, &rest)
            };
        }
    }
    pose
}

/// Layer weight times mask; layer 0 lies over the rest pose whole.
fn layer_weight(tables: &Tables, layer: &Layer, layer_index: u32, joint: u32) -> f32 {
    if layer_index == 0 {
        return 1.0;
    }
    let mask = if layer.mask == NONE { 1.0 } else { tables.masks.as_slice()[(layer.mask + joint) as usize] };
    layer.weight * mask
}

fn sum_layer(
    tables: &Tables,
    body: &Body,
    playback: &Playback,
    layer_index: u32,
    joint: u32,
    rest: &Trs,
    additive: bool,
) -> Sum {
    let mut sum = Sum::ZERO;
    for (slot, sample) in playback.slots.iter().zip(playback.samples) {
        if slot.layer != layer_index || sample.weight <= 0.0 {
            continue;
        }
        let bound = &tables.bound_clips.as_slice()[slot.bound_clip as usize];
        let value = sample_joint(tables, bound, body.padded_count, joint, sample, rest);
        if additive {
            let first = tables.clips.as_slice()[bound.clip as usize].row_first;
            let first = SlotSample { row0: first, row1: first, between: 0.0, weight: 0.0 };
            let reference = sample_joint(tables, bound, body.padded_count, joint, &first, rest);
            sum.add(&difference(&value, &reference), sample.weight);
        } else {
            sum.add(&value, sample.weight);
        }
    }
    sum
}

/// What takes `reference` to `value`, less what changes nothing: sums of it do not depend on their order.
fn difference(value: &Trs, reference: &Trs) -> Trs {
    let delta = quat::mul(quat::conjugate(reference.rotation), value.rotation);
    let delta = quat::hemisphere(delta, quat::IDENTITY);
    let ratio = |i: usize| {
        if reference.scale[i] == 0.0 { 1.0 } else { value.scale[i] / reference.scale[i] }
    };
    Trs {
        translation: std::array::from_fn(|i| value.translation[i] - reference.translation[i]),
        rotation: [delta[0], delta[1], delta[2], delta[3] - 1.0],
        scale: std::array::from_fn(|i| ratio(i) - 1.0),
    }
}

fn add_layer(beneath: &Trs, sum: &Sum, layer_weight: f32) -> Trs {
    let delta = quat::add(quat::IDENTITY, quat::scale(sum.rotation, layer_weight));
    let delta = quat::normalize_or(delta, quat::IDENTITY);
    Trs {
        translation: std::array::from_fn(|i| beneath.translation[i] + sum.translation[i] * layer_weight),
        rotation: quat::mul(beneath.rotation, delta),
        scale: std::array::from_fn(|i| beneath.scale[i] * (1.0 + sum.scale[i] * layer_weight)),
    }
}

/// Layer 0 is always divided by its total, so that nobody sees the rest pose by accident; a layer above it whose slots
/// weigh less than 1 in all leaves the remainder to what lies beneath.
fn mix_layer(beneath: &Trs, sum: &Sum, layer_index: u32, layer_weight: f32, rest: &Trs) -> Trs {
    if layer_index == 0 {
        return if sum.weight > 1e-3 { sum.mean(rest.rotation) } else { *beneath };
    }
    if sum.weight <= 0.0 {
        return *beneath;
    }
    let f = layer_weight * if sum.weight < 1.0 { sum.weight } else { 1.0 };
    let above = sum.mean(rest.rotation);
    let from = quat::hemisphere(beneath.rotation, rest.rotation);
    let to = quat::hemisphere(above.rotation, rest.rotation);
    Trs {
        translation: std::array::from_fn(|i| scalar::mix(beneath.translation[i], above.translation[i], f)),
        rotation: quat::normalize_or(quat::mix(from, to, f), rest.rotation),
        scale: std::array::from_fn(|i| scalar::mix(beneath.scale[i], above.scale[i], f)),
    }
}

/// A joint's local transform between two rows, its rotation in the hemisphere of the rest rotation.
fn sample_joint(
    tables: &Tables,
    bound: &BoundClip,
    padded: u32,
    joint: u32,
    at: &SlotSample,
    rest: &Trs,
) -> Trs {
    let map = tables.joint_maps.as_slice()[(bound.map_first + joint) as usize];
    let mut pose = stored_pose(tables, bound.base_first, padded, joint);
    let clip = &tables.clips.as_slice()[bound.clip as usize];
    let column = map & MAP_COLUMN;
    let block = (clip.block_first + column / JOINT_BLOCK * 3) as usize;
    let lane = column % JOINT_BLOCK;
    let rows = tables.rows.as_slice();
    let between = |place: usize, component: u32| {
        let offset = tables.block_offsets.as_slice()[block + place] + component * JOINT_BLOCK + lane;
        scalar::mix(rows[(at.row0 + offset) as usize], rows[(at.row1 + offset) as usize], at.between)
    };
    if map & MAP_ROTATION != 0 {
        let mixed = [between(0, 0), between(0, 1), between(0, 2), between(0, 3)];
        pose.rotation = quat::normalize_or(mixed, rest.rotation);
    }
    if map & MAP_TRANSLATION != 0 {
        pose.translation = [between(1, 0), between(1, 1), between(1, 2)];
    }
    if map & MAP_SCALE != 0 {
        pose.scale = [between(2, 0), between(2, 1), between(2, 2)];
    }
    pose.rotation = quat::hemisphere(pose.rotation, rest.rotation);
    pose
}

/// Reads one joint of a stored pose: ten planes of `padded` floats.
fn stored_pose(tables: &Tables, first: u32, padded: u32, joint: u32) -> Trs {
    let planes = &tables.poses.as_slice()[(first + joint) as usize..];
    let plane = |p: usize| planes[p * padded as usize];
    Trs {
        rotation: [plane(0), plane(1), plane(2), plane(3)],
        translation: [plane(4), plane(5), plane(6)],
        scale: [plane(7), plane(8), plane(9)],
    }
}
