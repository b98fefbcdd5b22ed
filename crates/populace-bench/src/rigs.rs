//! Benchmark characters: random skeletons, clips that rotate all joints and scale some, and
//! arbitrary inverse bind matrices; and source skeletons for retargeted clips.

use std::f32::consts::TAU;
use std::sync::Arc;

use populace::Error;
use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::model::{
    Affine, ClipSource, Interpolation, JointSource, Property, Skeleton, Track, Trs,
};
use populace_model::convert::single;
use populace_testkit::Rng;

const KEYS_PER_SEC: f32 = 30.0;
/// Depth of the skeletons, about that of fingers on a long spine.
const MAX_DEPTH: usize = 14;
/// In a source skeleton, one of this many joints has an additional parent that the character lacks.
const JOINTS_PER_EXTRA: usize = 3;

/// Creates a character. If `retargeted`, its clips belong to a source skeleton, with the same joint
/// names in another order and additional joints between them. The motion is the same.
pub(crate) fn character(
    joint_count: usize,
    clip_count: usize,
    retargeted: bool,
    random: &mut Rng,
) -> Result<Character, Error> {
    let joints = joints(joint_count, random);
    let skeleton = Skeleton::new(&joints)?;
    let sources: Vec<_> = (0..clip_count).map(|index| clip(index, &skeleton, random)).collect();
    let palette = skeleton
        .joints()
        .map(|joint| PaletteEntry { joint, joint_from_bind: bind(random) })
        .collect();
    let clips: Result<Vec<_>, _> = if retargeted {
        let (source_joints, extras) =
            source_joints(&joints, &mut Rng::from_state(joint_count as u64));
        let source_skeleton = Skeleton::new(&source_joints)?;
        let clip = |source| Clip::new(with_extras(source, &extras), &source_skeleton);
        sources.into_iter().map(clip).collect()
    } else {
        sources.into_iter().map(|source| Clip::new(source, &skeleton)).collect()
    };
    Ok(Character::new(CharacterSource {
        name: format!("{joint_count} joints"),
        skeleton,
        palette,
        parts: Vec::new(),
        materials: Vec::new(),
        images: Vec::new(),
        skins: Vec::new(),
        clips: clips?.into_iter().map(Arc::new).collect(),
    })?)
}

/// The first joints of all skeletons, as parent index and bone vector in metres: a trunk with a
/// head, and two legs. Smaller skeletons have only the first of them.
const CORE: [(usize, [f32; 3]); 11] = [
    (0, [0.0, 0.0, 0.0]), // the pelvis, which is the root
    (0, [0.0, 0.12, -0.01]),
    (1, [0.0, 0.18, -0.01]),
    (2, [0.0, 0.22, 0.01]),
    (HEAD - 1, [0.0, 0.10, 0.03]),
    (0, [0.1, -0.05, 0.0]),
    (5, [0.01, -0.40, 0.02]),
    (6, [0.0, -0.38, -0.03]),
    (0, [-0.1, -0.05, 0.0]),
    (8, [-0.01, -0.40, 0.02]),
    (9, [0.0, -0.38, -0.03]),
];
/// Core joints of the trunk, from the first joint above the pelvis to the head.
pub(crate) const TRUNK: [usize; 4] = [1, 2, 3, HEAD];
const HEAD: usize = 4;
/// Core joints of each leg: hip, knee and ankle.
pub(crate) const LEGS: [[usize; 3]; 2] = [[5, 6, 7], [8, 9, 10]];
/// Height of the root in all clips.
const PELVIS_M: f32 = 0.9;

fn joints(joint_count: usize, random: &mut Rng) -> Vec<JointSource> {
    let mut joints: Vec<JointSource> = Vec::with_capacity(joint_count);
    let mut depths: Vec<usize> = Vec::with_capacity(joint_count);
    for (index, &(parent, bone)) in CORE.iter().enumerate().take(joint_count) {
        let parent = (index > 0).then_some(parent);
        depths.push(parent.map_or(0, |p| depths[p] + 1));
        let bone = if index == 0 { [0.0, PELVIS_M, 0.0] } else { bone };
        let rest = Trs { translation: bone, ..Trs::IDENTITY };
        joints.push(JointSource { name: format!("joint {index}"), parent, rest });
    }
    for index in joints.len()..joint_count {
        let parent = index - 1 - random.below(index.min(6));
        let parent = Some(if depths[parent] + 1 < MAX_DEPTH { parent } else { parent / 2 });
        depths.push(parent.map_or(0, |p| depths[p] + 1));
        let bone = [random.signed() * 0.1, 0.15 * random.unit(), random.signed() * 0.1];
        joints.push(JointSource {
            name: format!("joint {index}"),
            parent,
            rest: Trs {
                translation: bone,
                rotation: quat_from_axis_angle(random_axis(random), random.signed() * 0.8),
                scale: [1.0; 3],
            },
        });
    }
    joints
}

/// Returns shuffled joints with the same names and rest transforms, with additional joints between
/// them and their parents, and the names of the additional joints.
fn source_joints(joints: &[JointSource], random: &mut Rng) -> (Vec<JointSource>, Vec<String>) {
    let (mut shuffled, mut extras): (Vec<JointSource>, Vec<String>) = (Vec::new(), Vec::new());
    let mut new_indices = vec![None; joints.len()];
    let mut remaining: Vec<usize> = (0..joints.len()).collect();
    while !remaining.is_empty() {
        let at = random.below(remaining.len());
        let joint = &joints[remaining[at]];
        let mut parent = match joint.parent {
            Some(parent) if new_indices[parent].is_none() => continue,
            Some(parent) => new_indices[parent],
            None => None,
        };
        if remaining[at] % JOINTS_PER_EXTRA == 1 {
            let name = format!("between {} and its parent", joint.name);
            extras.push(name.clone());
            shuffled.push(JointSource { name, parent, rest: Trs::IDENTITY });
            parent = Some(shuffled.len() - 1);
        }
        new_indices[remaining.swap_remove(at)] = Some(shuffled.len());
        shuffled.push(JointSource { parent, ..joint.clone() });
    }
    (shuffled, extras)
}

/// Adds rotation tracks for the additional joints, as for twist joints.
fn with_extras(mut source: ClipSource, extras: &[String]) -> ClipSource {
    let moving = source.tracks.iter().filter(|track| track.property == Property::Rotation);
    let added: Vec<_> = extras
        .iter()
        .zip(moving.cycle())
        .map(|(name, track)| Track { joint: name.clone(), ..track.clone() })
        .collect();
    source.tracks.extend(added);
    source
}

/// Creates a clip in which all joints rotate in slow waves, the root moves, and every eighth joint
/// scales.
fn clip(index: usize, skeleton: &Skeleton, random: &mut Rng) -> ClipSource {
    let duration_secs = 1.0 + random.unit() * 2.0;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most three seconds of keys"
    )]
    let key_count = (duration_secs * KEYS_PER_SEC) as usize + 1;
    let times: Vec<f32> = (0..key_count).map(|key| key as f32 / KEYS_PER_SEC).collect();
    let angle = |key: usize| TAU * key as f32 / (key_count - 1) as f32;
    let mut tracks = Vec::new();
    for joint in skeleton.joints() {
        let name = skeleton.name(joint);
        let mut add = |property, values| {
            let (joint, interpolation, times) =
                (name.to_owned(), Interpolation::Linear, times.clone());
            tracks.push(Track { joint, property, interpolation, times, values });
        };
        let (axis, swing, shift) =
            (random_axis(random), 0.2 + 0.4 * random.unit(), random.unit() * TAU);
        let wave = |key: usize| f64::from(angle(key) + shift).sin();
        add(
            Property::Rotation,
            (0..key_count)
                .flat_map(|k| quat_from_axis_angle(axis, swing * single(wave(k))))
                .collect(),
        );
        if skeleton.parent(joint).is_none() {
            let sway = |k: usize| {
                [single(wave(k)) * 0.1, PELVIS_M, single(f64::from(angle(k)).cos()) * 0.1]
            };
            add(Property::Translation, (0..key_count).flat_map(sway).collect());
        }
        if joint.index() % 8 == 3 {
            let swell = |k: usize| [1.0 + single(wave(k)) * 0.1, 1.0, 1.0 - single(wave(k)) * 0.05];
            add(Property::Scale, (0..key_count).flat_map(swell).collect());
        }
    }
    ClipSource { name: format!("clip {index}"), tracks }
}

fn bind(random: &mut Rng) -> Affine {
    let translation = [random.signed(), random.signed(), random.signed()];
    let scale = [0.5 + random.unit(), 0.5 + random.unit(), 0.5 + random.unit()];
    Affine::from_trs(&Trs {
        translation,
        rotation: quat_from_axis_angle(random_axis(random), random.signed() * 3.0),
        scale,
    })
}

fn random_axis(random: &mut Rng) -> [f32; 3] {
    let [x, y, z] = [random.signed(), random.signed(), random.signed() + 1e-3];
    let length = x.hypot(y).hypot(z);
    [x / length, y / length, z / length]
}

fn quat_from_axis_angle([x, y, z]: [f32; 3], angle_rad: f32) -> [f32; 4] {
    let (sin, cos) = f64::from(angle_rad / 2.0).sin_cos();
    let sin = single(sin);
    [x * sin, y * sin, z * sin, single(cos)]
}
