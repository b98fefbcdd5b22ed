//! A crowd that is never one clip in one phase: several skeletons, 32 clips, random phases and weights, moving scales,
//! arbitrary inverse binds.

use std::f32::consts::TAU;
use std::sync::Arc;

use populace::core::{
    Affine, Character, CharacterSource, Clip, ClipSource, Interpolation, JointSource, PaletteEntry, Property,
    Skeleton, Track, Trs,
};
use populace::{Crowd, Devices, Error, Member, Placement, Play, Schedule, Split};

use crate::placement::Random;

/// Joints of the four skeletons, unless one number is asked for.
const JOINT_COUNTS: [usize; 4] = [24, 54, 67, 128];
const CLIP_COUNT: usize = 32;
const KEYS_PER_SEC: f32 = 30.0;
/// No deeper than a hand's fingers on a long spine.
const MAX_DEPTH: usize = 14;

/// What to build on each device alike.
pub(crate) struct Scene {
    pub(crate) characters: Vec<Arc<Character>>,
    member_count: usize,
    slot_count: usize,
    seed: u64,
}

/// One playing clip, as the oracle needs to know it.
pub(crate) struct PlayedSlot {
    /// Index among the character's clips.
    pub(crate) clip: usize,
    pub(crate) phase: f32,
    pub(crate) weight: f32,
}

/// A crowd on a device, and what its members play.
pub(crate) struct Staging {
    pub(crate) crowd: Crowd,
    pub(crate) members: Vec<(Member, usize, Vec<PlayedSlot>)>,
}

impl Scene {
    pub(crate) fn new(members: u32, joints: Option<u32>, slots: u32, seed: u64) -> Result<Self, Error> {
        let mut random = Random::new(seed);
        let counts = joints.map_or(JOINT_COUNTS.to_vec(), |n| vec![n as usize]);
        let clips_each = CLIP_COUNT / counts.len();
        let characters: Result<Vec<_>, _> =
            counts.into_iter().map(|count| character(count, clips_each, &mut random).map(Arc::new)).collect();
        Ok(Self { characters: characters?, member_count: members as usize, slot_count: slots as usize, seed })
    }

    pub(crate) fn member_count(&self) -> usize {
        self.member_count
    }

    pub(crate) fn slot_count(&self) -> usize {
        self.slot_count
    }

    /// Joints of all members.
    pub(crate) fn joint_count(&self) -> usize {
        let kinds = self.characters.len();
        let of_kind = |kind: usize| (self.member_count + kinds - 1 - kind) / kinds;
        let joints =
            self.characters.iter().enumerate().map(|(kind, c)| c.skeleton.joint_count() * of_kind(kind));
        joints.sum()
    }

    pub(crate) fn stage(
        &self,
        devices: &Devices,
        split: &Split,
        schedule: Schedule,
    ) -> Result<Staging, Error> {
        let builder = Crowd::builder()
            .devices(devices.clone())
            .split(split.clone())
            .schedule(schedule)
            .capacity(self.member_count)
            .slots_per_member(self.slot_count);
        let mut crowd = builder.build()?;
        let mut ids = Vec::new();
        for character in &self.characters {
            let id = crowd.add_character(Arc::clone(character))?;
            let clips: Vec<_> = crowd.clips(id)?.into_iter().map(|(clip, _)| clip).collect();
            ids.push((id, clips));
        }
        let mut random = Random::new(self.seed ^ 0x5eed);
        let mut members = Vec::with_capacity(self.member_count);
        for index in 0..self.member_count {
            let (id, clips) = &ids[index % ids.len()];
            let member = crowd.spawn(*id, Placement::at([0.0; 3]))?;
            let mut played = Vec::with_capacity(self.slot_count);
            for _ in 0..self.slot_count {
                let slot = PlayedSlot {
                    clip: random.below(clips.len()),
                    phase: random.unit(),
                    weight: 0.1 + 0.9 * random.unit(),
                };
                crowd.blend(
                    member,
                    clips[slot.clip],
                    Play::looping().phase(slot.phase).weight(slot.weight),
                )?;
                played.push(slot);
            }
            members.push((member, index % ids.len(), played));
        }
        Ok(Staging { crowd, members })
    }
}

fn character(joint_count: usize, clip_count: usize, random: &mut Random) -> Result<Character, Error> {
    let skeleton = skeleton(joint_count, random)?;
    let clips: Result<Vec<_>, _> = (0..clip_count)
        .map(|index| Clip::new(clip(index, &skeleton, random), &skeleton).map(Arc::new))
        .collect();
    let palette =
        skeleton.joints().map(|joint| PaletteEntry { joint, joint_from_bind: bind(random) }).collect();
    Ok(Character::new(CharacterSource {
        name: format!("{joint_count} joints"),
        skeleton,
        palette,
        parts: Vec::new(),
        materials: Vec::new(),
        images: Vec::new(),
        skins: Vec::new(),
        clips: clips?,
    })?)
}

fn skeleton(joint_count: usize, random: &mut Random) -> Result<Skeleton, Error> {
    let mut joints: Vec<JointSource> = Vec::with_capacity(joint_count);
    let mut depths: Vec<usize> = Vec::with_capacity(joint_count);
    for index in 0..joint_count {
        let parent = (index > 0).then(|| index - 1 - random.below(index.min(6)));
        let parent = parent.map(|p| if depths[p] + 1 < MAX_DEPTH { p } else { p / 2 });
        depths.push(parent.map_or(0, |p| depths[p] + 1));
        let bone = [random.signed() * 0.1, 0.15 * random.unit(), random.signed() * 0.1];
        joints.push(JointSource {
            name: format!("joint {index}"),
            parent,
            rest: Trs {
                translation: bone,
                rotation: turn(random_axis(random), random.signed() * 0.8),
                scale: [1.0; 3],
            },
        });
    }
    Ok(Skeleton::new(&joints)?)
}

/// All joints turn by their own slow waves; the root also moves, and every eighth joint swells.
fn clip(index: usize, skeleton: &Skeleton, random: &mut Random) -> ClipSource {
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
            let (joint, interpolation, times) = (name.to_owned(), Interpolation::Linear, times.clone());
            tracks.push(Track { joint, property, interpolation, times, values });
        };
        let (axis, swing, shift) = (random_axis(random), 0.2 + 0.4 * random.unit(), random.unit() * TAU);
        let wave = |key: usize| f64::from(angle(key) + shift).sin();
        add(Property::Rotation, (0..key_count).flat_map(|k| turn(axis, swing * narrow(wave(k)))).collect());
        if skeleton.parent(joint).is_none() {
            let sway = |k: usize| [narrow(wave(k)) * 0.1, 0.9, narrow(f64::from(angle(k)).cos()) * 0.1];
            add(Property::Translation, (0..key_count).flat_map(sway).collect());
        }
        if joint.index() % 8 == 3 {
            let swell = |k: usize| [1.0 + narrow(wave(k)) * 0.1, 1.0, 1.0 - narrow(wave(k)) * 0.05];
            add(Property::Scale, (0..key_count).flat_map(swell).collect());
        }
    }
    ClipSource { name: format!("clip {index}"), tracks }
}

fn bind(random: &mut Random) -> Affine {
    let translation = [random.signed(), random.signed(), random.signed()];
    let scale = [0.5 + random.unit(), 0.5 + random.unit(), 0.5 + random.unit()];
    Affine::from_trs(&Trs { translation, rotation: turn(random_axis(random), random.signed() * 3.0), scale })
}

fn random_axis(random: &mut Random) -> [f32; 3] {
    let [x, y, z] = [random.signed(), random.signed(), random.signed() + 1e-3];
    let length = x.hypot(y).hypot(z);
    [x / length, y / length, z / length]
}

fn turn([x, y, z]: [f32; 3], angle_rad: f32) -> [f32; 4] {
    let (sin, cos) = f64::from(angle_rad / 2.0).sin_cos();
    let sin = narrow(sin);
    [x * sin, y * sin, z * sin, narrow(cos)]
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is what is wanted")]
fn narrow(x: f64) -> f32 {
    x as f32
}
