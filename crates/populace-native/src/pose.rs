//! Pose: each member's slots, mixed layer by layer, as local transforms; the twin of `kernels/pose.cl`.

use populace_core::layout::{
    Body, BoundClip, Float4, JOINT_BLOCK, MAP_COLUMN, MAP_ROTATION, MAP_SCALE, MAP_TRANSLATION, Member,
    SlotSample,
};
use populace_core::math::{quat, scalar};
use populace_core::{Tables, Trs};

use crate::{JointBuffer, Playback, split};

pub(crate) fn run(tables: &Tables, samples: &[SlotSample], joints: &mut JointBuffer) {
    let arrays = [&mut joints.translations[..], &mut joints.rotations[..], &mut joints.scales[..]];
    split::for_each_member(
        tables.joint_blocks().as_slice(),
        arrays,
        &|place, _, [translations, rotations, scales]| {
            let member = &tables.members().as_slice()[place as usize];
            let body = &tables.bodies().as_slice()[member.body as usize];
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
    let at = JointAt { tables, padded: body.padded_count as usize, joint };
    let rest = at.stored(body.rest_first);
    let rest_rotation = rest.rotation();
    let sum = sum_layer(&at, playback, 0, rest_rotation, false);
    // Layer 0 is always divided by its total, so that nobody sees the rest pose by accident.
    let mut pose = if sum.weight > 1e-3 {
        sum.mean(rest_rotation)
    } else {
        Trs { translation: rest.translation(), rotation: rest_rotation, scale: rest.scale() }
    };
    for layer_index in 1..member.layer_count {
        let layer = &playback.layers[layer_index as usize];
        let of_joint = |first| tables.masks().as_slice()[(first + joint) as usize];
        let weight = layer.weight * layer.mask().map_or(1.0, of_joint);
        if weight > 0.0 {
            let additive = layer.is_additive();
            let sum = sum_layer(&at, playback, layer_index, rest_rotation, additive);
            pose = if additive {
                add_layer(&pose, &sum, weight)
            } else {
                mix_layer(&pose, &sum, weight, rest_rotation)
            };
        }
    }
    pose
}

/// One joint of a body, and where its data is.
struct JointAt<'a> {
    tables: &'a Tables,
    padded: usize,
    joint: u32,
}

impl<'a> JointAt<'a> {
    fn stored(&self, pose_first: u32) -> StoredJoint<'a> {
        let planes = &self.tables.poses().as_slice()[(pose_first + self.joint) as usize..];
        StoredJoint { planes, padded: self.padded }
    }
}

/// One joint of a stored pose: ten planes of `padded` floats, rotation, translation, scale.
struct StoredJoint<'a> {
    planes: &'a [f32],
    padded: usize,
}

impl StoredJoint<'_> {
    fn plane(&self, plane: usize) -> f32 {
        self.planes[plane * self.padded]
    }

    fn rotation(&self) -> [f32; 4] {
        [self.plane(0), self.plane(1), self.plane(2), self.plane(3)]
    }

    fn translation(&self) -> [f32; 3] {
        [self.plane(4), self.plane(5), self.plane(6)]
    }

    fn scale(&self) -> [f32; 3] {
        [self.plane(7), self.plane(8), self.plane(9)]
    }
}

/// The sum over a layer's slots of weight times value, or times difference from the first row.
fn sum_layer(
    at: &JointAt,
    playback: &Playback,
    layer_index: u32,
    rest_rotation: [f32; 4],
    additive: bool,
) -> Sum {
    let mut sum = Sum::ZERO;
    for (slot, sample) in playback.slots.iter().zip(playback.samples) {
        if slot.layer() != layer_index || sample.weight <= 0.0 {
            continue;
        }
        let bound = &at.tables.bound_clips().as_slice()[slot.bound_clip as usize];
        let value = sample_joint(at, bound, sample, rest_rotation);
        if additive {
            let first = at.tables.clips().as_slice()[bound.clip as usize].row_first;
            let first = SlotSample { row0: first, row1: first, between: 0.0, weight: 0.0 };
            let reference = sample_joint(at, bound, &first, rest_rotation);
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

/// A layer above 0 whose slots weigh less than 1 in all leaves the remainder to what lies beneath.
fn mix_layer(beneath: &Trs, sum: &Sum, layer_weight: f32, rest_rotation: [f32; 4]) -> Trs {
    if sum.weight <= 0.0 {
        return *beneath;
    }
    let f = layer_weight * if sum.weight < 1.0 { sum.weight } else { 1.0 };
    let above = sum.mean(rest_rotation);
    let from = quat::hemisphere(beneath.rotation, rest_rotation);
    let to = quat::hemisphere(above.rotation, rest_rotation);
    Trs {
        translation: std::array::from_fn(|i| scalar::mix(beneath.translation[i], above.translation[i], f)),
        rotation: quat::normalize_or(quat::mix(from, to, f), rest_rotation),
        scale: std::array::from_fn(|i| scalar::mix(beneath.scale[i], above.scale[i], f)),
    }
}

/// A joint's local transform between two rows, its rotation in the hemisphere of the rest rotation.
fn sample_joint(at: &JointAt, bound: &BoundClip, sample: &SlotSample, rest_rotation: [f32; 4]) -> Trs {
    let tables = at.tables;
    let map = tables.joint_maps().as_slice()[(bound.map_first + at.joint) as usize];
    let base = at.stored(bound.base_first);
    let clip = &tables.clips().as_slice()[bound.clip as usize];
    let column = map & MAP_COLUMN;
    let block = (clip.block_first + column / JOINT_BLOCK * 3) as usize;
    let lane = column % JOINT_BLOCK;
    let rows = tables.rows().as_slice();
    let between = |place: usize, component: u32| {
        let offset = tables.block_offsets().as_slice()[block + place] + component * JOINT_BLOCK + lane;
        let (a, b) = (rows[(sample.row0 + offset) as usize], rows[(sample.row1 + offset) as usize]);
        scalar::mix(a, b, sample.between)
    };
    let rotation = if map & MAP_ROTATION == 0 {
        base.rotation()
    } else {
        let mixed = [between(0, 0), between(0, 1), between(0, 2), between(0, 3)];
        quat::normalize_or(mixed, rest_rotation)
    };
    let vector = |flag: u32, place: usize, base: [f32; 3]| {
        if map & flag == 0 { base } else { [between(place, 0), between(place, 1), between(place, 2)] }
    };
    Trs {
        translation: vector(MAP_TRANSLATION, 1, base.translation()),
        rotation: quat::hemisphere(rotation, rest_rotation),
        scale: vector(MAP_SCALE, 2, base.scale()),
    }
}
