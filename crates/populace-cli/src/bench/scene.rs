//! A crowd that is never one clip in one phase: several skeletons, 32 clips, random phases and
//! weights, moving scales, arbitrary inverse binds.

use std::fmt;
use std::sync::Arc;

use populace::character::Character;
use populace::{ClipId, Crowd, Device, Devices, Error, Member, Placement, Play, Schedule, Split};

use super::{constraints, rigs};
use crate::cli::BenchArgs;
use crate::placement::Random;

/// Joints of the four skeletons, unless one number is asked for.
const JOINT_COUNTS: [usize; 4] = [24, 54, 67, 128];
const CLIP_COUNT: usize = 32;
/// No whole number of frames, so that no weight is at its end just when it is looked at.
pub(crate) const FADE_SECS: f32 = 0.31;

/// What makes a crowd harder than the plain one; all else is equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Load {
    Plain,
    /// Clips come from other skeletons: joints of the same names in another order, and more between
    /// them.
    Retargeted,
    /// Each frame so many of a hundred members change over to another clip.
    Changing {
        percent: f32,
    },
    /// Every member looks at something of its own, and keeps both feet to the ground.
    Constraints,
    /// The same, with two layers above the first: one through a mask and one additive, a slot in
    /// each.
    Full,
}

impl fmt::Display for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plain => f.write_str("plain"),
            Self::Retargeted => f.write_str("retargeted"),
            Self::Changing { percent } => write!(f, "changing {percent} %"),
            Self::Constraints => f.write_str("constraints"),
            Self::Full => f.write_str("full"),
        }
    }
}

impl Load {
    /// Whether constraints move members.
    pub(crate) fn is_constrained(self) -> bool {
        matches!(self, Self::Constraints | Self::Full)
    }

    /// Slots above layer 0.
    pub(crate) fn upper_slots(self) -> usize {
        if self == Self::Full { 2 } else { 0 }
    }
}

impl std::str::FromStr for Load {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let known = [Self::Plain, Self::Constraints, Self::Full];
        let load = known.into_iter().find(|load| load.to_string() == name);
        load.ok_or_else(|| "write plain, constraints or full".into())
    }
}

/// What to build on each device alike.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) load: Load,
    pub(crate) characters: Vec<Arc<Character>>,
    pub(crate) member_count: usize,
    pub(crate) slot_count: usize,
    seed: u64,
}

/// What a member plays from the start on.
pub(crate) struct PlayedSlot {
    /// Index among the character's clips.
    pub(crate) clip: usize,
    pub(crate) phase: f32,
    pub(crate) weight: f32,
    pub(crate) layer: usize,
}

/// A crowd on a device.
pub(crate) struct Staging {
    pub(crate) crowd: Crowd,
    pub(crate) members: Vec<Member>,
    /// Of each character.
    clips: Vec<Vec<ClipId>>,
}

/// A device to measure on, or several that share each crowd.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) devices: Devices,
    pub(crate) split: Split,
}

impl Setup {
    /// Whether crowds stay in the host's own tables.
    pub(crate) fn is_native(&self) -> bool {
        self.devices.as_slice().iter().all(|device| matches!(device, Device::Native { .. }))
    }

    pub(crate) fn is_shared(&self) -> bool {
        self.devices.as_slice().len() > 1
    }
}

impl Scene {
    /// A scene without members yet.
    pub(crate) fn new(args: &BenchArgs, load: Load) -> Result<Self, Error> {
        let mut random = Random::new(args.seed);
        let counts = args.joints.map_or(JOINT_COUNTS.to_vec(), |n| vec![n as usize]);
        let clips_each = CLIP_COUNT / counts.len();
        let retargeted = load == Load::Retargeted;
        let characters = counts
            .into_iter()
            .map(|count| rigs::character(count, clips_each, retargeted, &mut random).map(Arc::new));
        let characters = characters.collect::<Result<_, _>>()?;
        let slot_count = args.slots as usize + load.upper_slots();
        Ok(Self { load, characters, member_count: 0, slot_count, seed: args.seed })
    }

    /// The same with so many members.
    pub(crate) fn with_members(&self, members: usize) -> Self {
        Self { member_count: members, ..self.clone() }
    }

    /// Which character a member is.
    pub(crate) fn kind(&self, member: usize) -> usize {
        member % self.characters.len()
    }

    /// The sum over all members of something that their characters have.
    pub(crate) fn total(&self, of: impl Fn(&Character) -> usize) -> usize {
        let kinds = self.characters.len();
        let members = |kind: usize| (self.member_count + kinds - 1 - kind) / kinds;
        self.characters
            .iter()
            .enumerate()
            .map(|(kind, character)| of(character) * members(kind))
            .sum()
    }

    /// Joints of all members.
    pub(crate) fn joint_count(&self) -> usize {
        self.total(|character| character.skeleton.joint_count())
    }

    /// What a member plays before anything changes.
    pub(crate) fn played(&self, member: usize) -> impl Iterator<Item = PlayedSlot> + use<> {
        let clips = self.characters[self.kind(member)].clips.len();
        let mut random = Random::one_of(self.seed, member);
        let lower = self.slot_count - self.load.upper_slots();
        (0..self.slot_count).map(move |slot| PlayedSlot {
            clip: random.below(clips),
            phase: random.unit(),
            weight: 0.1 + 0.9 * random.unit(),
            layer: (slot + 1).saturating_sub(lower),
        })
    }

    /// What a member looks at, in its model space.
    pub(crate) fn target(&self, member: usize) -> [f32; 3] {
        let mut random = Random::one_of(!self.seed, member);
        [2.0 * random.signed(), 1.2 + random.signed(), 3.0 + random.signed()]
    }

    /// Members that change over to another clip before a frame, and to which; each member in its
    /// turn.
    pub(crate) fn changes(&self, frame: u32) -> impl Iterator<Item = (usize, usize)> + '_ {
        let members = self.member_count;
        let count = match self.load {
            Load::Changing { percent } => share(members, percent),
            _ => 0,
        };
        (0..count).map(move |index| {
            let member = (index * members / count + frame as usize) % members;
            let clips = self.characters[self.kind(member)].clips.len();
            let mut random = Random::one_of(self.seed ^ (u64::from(frame) + 1), member);
            (member, random.below(clips))
        })
    }

    /// Builds the crowd and lets the device take it over.
    pub(crate) fn stage(&self, on: &Setup, schedule: Schedule) -> Result<Staging, Error> {
        let builder = Crowd::builder()
            .devices(on.devices.clone())
            .split(on.split.clone())
            .schedule(schedule)
            .capacity(self.member_count)
            .slots_per_member(self.slot_count);
        let mut crowd = builder.build()?;
        #[cfg(unix)]
        crate::aborts::end_with_a_code();
        let (mut ids, mut clips) = (Vec::new(), Vec::<Vec<ClipId>>::new());
        for character in &self.characters {
            let id = crowd.add_character(Arc::clone(character))?;
            clips.push(crowd.clips(id)?.into_iter().map(|(clip, _)| clip).collect());
            ids.push(id);
        }
        let mut masks = Vec::new();
        for (id, character) in ids.iter().zip(&self.characters).filter(|_| self.load == Load::Full)
        {
            masks.push(crowd.add_mask(*id, &constraints::mask(&character.skeleton)?)?);
        }
        let mut members = Vec::with_capacity(self.member_count);
        for index in 0..self.member_count {
            let kind = self.kind(index);
            let member = crowd.spawn(ids[kind], Placement::at([0.0; 3]))?;
            for slot in self.played(index) {
                let play =
                    Play::looping().phase(slot.phase).weight(slot.weight).on_layer(slot.layer);
                crowd.blend(member, clips[kind][slot.clip], play)?;
            }
            if self.load == Load::Full {
                constraints::set_layers(&mut crowd, member, masks[kind])?;
            }
            if self.load.is_constrained() {
                constraints::constrain(
                    &mut crowd,
                    member,
                    &self.characters[kind].skeleton,
                    self.target(index),
                )?;
            }
            members.push(member);
        }
        crowd.update(0.0)?;
        crowd.finish()?;
        Ok(Staging { crowd, members, clips })
    }
}

/// That many of a hundred, at least one of any.
fn share(members: usize, percent: f32) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count, not negative"
    )]
    let count = (members as f64 * f64::from(percent) / 100.0).round() as usize;
    count.clamp(members.min(1), members)
}

impl Staging {
    /// Lets members change over to other clips, as the scene has it for a frame.
    pub(crate) fn change(&mut self, scene: &Scene, frame: u32) -> Result<(), Error> {
        for (member, clip) in scene.changes(frame) {
            let clip = self.clips[scene.kind(member)][clip];
            self.crowd.crossfade(self.members[member], clip, FADE_SECS)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_member_changes_in_its_turn_and_none_twice_in_a_frame() {
        let scene = |members, percent| Scene {
            load: Load::Changing { percent },
            characters: vec![Arc::new(
                rigs::character(3, 2, false, &mut Random::new(1)).expect("sound"),
            )],
            member_count: members,
            slot_count: 2,
            seed: 0,
        };
        for (members, percent, each) in
            [(1000, 1.0, 10), (997, 10.0, 100), (7, 100.0, 7), (3, 0.1, 1)]
        {
            let scene = scene(members, percent);
            let mut turns = vec![0; members];
            for frame in 0..members {
                let frame = u32::try_from(frame).expect("few");
                let changing: Vec<_> = scene.changes(frame).collect();
                assert_eq!(changing.len(), each);
                let mut different: Vec<_> = changing.iter().map(|(member, _)| *member).collect();
                different.sort_unstable();
                different.dedup();
                assert_eq!(different.len(), each, "{members} members, {percent} %, frame {frame}");
                changing.iter().for_each(|(member, _)| turns[*member] += 1);
            }
            assert_eq!(turns, vec![each; members], "over as many frames all had as many turns");
        }
        assert_eq!(Scene { load: Load::Plain, ..scene(9, 1.0) }.changes(3).count(), 0);
    }
}
