//! Benchmark scenes: random skeletons and clips, with animated scales and arbitrary inverse bind
//! matrices, or given characters; with random phases and weights.

use std::fmt;
use std::sync::Arc;

use populace::character::Character;
use populace::{
    ClipId, ClipPlayback, Crowd, Device, Devices, Error, MAX_SLOTS, MemberId, Placement, Schedule,
    Split,
};
use populace_testkit::Rng;

use crate::observer::Observer;
use crate::{constraints, rigs};

/// Joint counts of the four default skeletons.
const JOINT_COUNTS: [usize; 4] = [24, 54, 67, 128];
/// Number of clips of all characters together.
const CLIP_COUNT: usize = 32;
/// Not a whole number of frames, so that no ramp ends exactly at a frame.
pub(crate) const FADE_SECS: f32 = 0.31;

/// The load of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Blended clips only.
    Plain,
    /// Clips come from other skeletons, with the same joint names in another order and additional
    /// joints between them.
    Retargeted,
    /// Each frame, a percentage of the members crossfades to another clip.
    Changing {
        /// Percentage of the members, above 0 and up to 100.
        percent: f32,
    },
    /// Every member looks at a target of its own and plants both feet.
    Constraints,
    /// Constraints and two more layers, one masked and one additive, with a slot in each.
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
    /// Returns whether members have constraints.
    pub(crate) fn is_constrained(self) -> bool {
        matches!(self, Self::Constraints | Self::Full)
    }

    /// Returns the number of slots above layer 0.
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

/// Settings of a scene.
#[derive(Clone, Copy, Debug)]
pub struct SceneSettings {
    /// Joints of the one skeleton, at least 1; several default skeletons if `None`.
    pub joints: Option<u32>,
    /// Slots of each member in layer 0, from 1 to 8.
    pub slots: usize,
    /// Seed of skeletons, clips, phases and weights.
    pub seed: u64,
}

/// A scene, the same on every device.
#[derive(Clone)]
pub struct Scene {
    pub(crate) load: Load,
    pub(crate) characters: Vec<Arc<Character>>,
    pub(crate) member_count: usize,
    pub(crate) slot_count: usize,
    seed: u64,
}

/// A slot of a member at the start.
pub(crate) struct InitialSlot {
    /// Index of one of the character's clips.
    pub(crate) clip: usize,
    pub(crate) phase: f32,
    pub(crate) weight: f32,
    pub(crate) layer: usize,
}

/// A crowd set up for a scene.
pub(crate) struct Staging {
    pub(crate) crowd: Crowd,
    pub(crate) members: Vec<MemberId>,
    /// Clips of each character.
    clips: Vec<Vec<ClipId>>,
}

/// The devices of a crowd, and how several share it.
#[derive(Clone, Debug)]
pub struct DeviceSetup {
    /// The devices; several share the crowd.
    pub devices: Devices,
    /// The shares of several devices.
    pub split: Split,
}

impl DeviceSetup {
    /// Returns whether all devices are native, so that crowds stay in host memory.
    #[must_use]
    pub fn is_native(&self) -> bool {
        self.devices.as_slice().iter().all(|device| matches!(device, Device::Native { .. }))
    }

    /// Returns whether several devices share a crowd.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.devices.as_slice().len() > 1
    }
}

impl Scene {
    /// Creates a scene without members.
    ///
    /// # Errors
    ///
    /// If skeletons or clips cannot be made, for example without joints.
    pub fn new(settings: SceneSettings, load: Load) -> Result<Self, Error> {
        let mut random = Rng::from_state(settings.seed);
        let counts = settings.joints.map_or(JOINT_COUNTS.to_vec(), |n| vec![n as usize]);
        let clips_each = CLIP_COUNT / counts.len();
        let retargeted = load == Load::Retargeted;
        let characters = counts
            .into_iter()
            .map(|count| rigs::character(count, clips_each, retargeted, &mut random).map(Arc::new));
        let characters = characters.collect::<Result<_, _>>()?;
        let slot_count = settings.slots + load.upper_slots();
        Ok(Self { load, characters, member_count: 0, slot_count, seed: settings.seed })
    }

    /// Creates a scene of characters with clips of their own, without members. Loads are
    /// [`Plain`](Load::Plain) and [`Changing`](Load::Changing); the others need the bones of random
    /// skeletons.
    ///
    /// # Errors
    ///
    /// Says which character has no clips, which load was asked for, or that there is no character
    /// or no slot, or more than eight slots.
    pub fn of_characters(
        characters: Vec<Arc<Character>>,
        slots: usize,
        seed: u64,
        load: Load,
    ) -> Result<Self, String> {
        if !matches!(load, Load::Plain | Load::Changing { .. }) {
            return Err(format!("given characters are not measured under load {load}"));
        }
        if characters.is_empty() || !(1..=MAX_SLOTS).contains(&slots) {
            let count = characters.len();
            return Err(format!("{count} characters with {slots} slots cannot be measured"));
        }
        let without = characters.iter().find(|character| character.clips.is_empty());
        if let Some(character) = without {
            let name = &character.name;
            return Err(format!("{name} has no clips of its own; give a file with clips"));
        }
        Ok(Self { load, characters, member_count: 0, slot_count: slots, seed })
    }

    /// Copies the scene with another number of members.
    #[must_use]
    pub fn with_members(&self, members: usize) -> Self {
        Self { member_count: members, ..self.clone() }
    }

    /// Returns the number of members.
    #[must_use]
    pub const fn member_count(&self) -> usize {
        self.member_count
    }

    /// Returns the number of slots of each member, those of layers above 0 included.
    #[must_use]
    pub const fn slot_count(&self) -> usize {
        self.slot_count
    }

    /// Returns the number of members and the names of their characters.
    #[must_use]
    pub fn crowd(&self) -> String {
        let names: Vec<_> = self.characters.iter().map(|one| one.name.as_str()).collect();
        format!("{} members ({})", self.member_count, names.join(", "))
    }

    /// Returns the index of a member's character.
    pub(crate) fn character_index(&self, member: usize) -> usize {
        member % self.characters.len()
    }

    /// Sums a property of characters over all members.
    pub(crate) fn total(&self, of: impl Fn(&Character) -> usize) -> usize {
        let count = self.characters.len();
        let members = |index: usize| (self.member_count + count - 1 - index) / count;
        self.characters
            .iter()
            .enumerate()
            .map(|(index, character)| of(character) * members(index))
            .sum()
    }

    /// Returns the number of joints of all members.
    pub(crate) fn joint_count(&self) -> usize {
        self.total(|character| character.skeleton.joint_count())
    }

    /// Returns the slots of a member at the start.
    pub(crate) fn initial_slots(&self, member: usize) -> impl Iterator<Item = InitialSlot> + use<> {
        let clips = self.characters[self.character_index(member)].clips.len();
        let mut random = Rng::stream(self.seed, member as u64);
        let lower = self.slot_count - self.load.upper_slots();
        (0..self.slot_count).map(move |slot| InitialSlot {
            clip: random.below(clips),
            phase: random.unit(),
            weight: 0.1 + 0.9 * random.unit(),
            layer: (slot + 1).saturating_sub(lower),
        })
    }

    /// Returns a member's look-at target in its model space.
    pub(crate) fn target(&self, member: usize) -> [f32; 3] {
        let mut random = Rng::stream(!self.seed, member as u64);
        [2.0 * random.signed(), 1.2 + random.signed(), 3.0 + random.signed()]
    }

    /// Returns the members that crossfade before a frame, each with its new clip. All members take
    /// turns.
    pub(crate) fn changes(&self, frame: u32) -> impl Iterator<Item = (usize, usize)> + '_ {
        let members = self.member_count;
        let count = match self.load {
            Load::Changing { percent } => changing_count(members, percent),
            _ => 0,
        };
        (0..count).map(move |index| {
            let member = (index * members / count + frame as usize) % members;
            let clips = self.characters[self.character_index(member)].clips.len();
            let mut random = Rng::stream(self.seed ^ (u64::from(frame) + 1), member as u64);
            (member, random.below(clips))
        })
    }

    /// Builds the crowd and uploads it to the device.
    pub(crate) fn set_up(
        &self,
        on: &DeviceSetup,
        schedule: Schedule,
        observer: &mut dyn Observer,
    ) -> Result<Staging, Error> {
        let builder = Crowd::builder()
            .devices(on.devices.clone())
            .split(on.split.clone())
            .schedule(schedule)
            .capacity(self.member_count)
            .slots_per_member(self.slot_count);
        let mut crowd = builder.build()?;
        observer.drivers_started();
        let (mut ids, mut clips) = (Vec::new(), Vec::<Vec<ClipId>>::new());
        for character in &self.characters {
            let id = crowd.add_character(Arc::clone(character))?;
            clips.push(crowd.character(id)?.clips().into_iter().map(|(clip, _)| clip).collect());
            ids.push(id);
        }
        let mut masks = Vec::new();
        for (id, character) in ids.iter().zip(&self.characters).filter(|_| self.load == Load::Full)
        {
            masks.push(
                crowd.character_mut(*id)?.add_mask(&constraints::mask(&character.skeleton)?)?,
            );
        }
        let mut members = Vec::with_capacity(self.member_count);
        for index in 0..self.member_count {
            let kind = self.character_index(index);
            let member = crowd.spawn(ids[kind], Placement::at([0.0; 3]))?;
            for slot in self.initial_slots(index) {
                let play = ClipPlayback::looping()
                    .phase(slot.phase)
                    .weight(slot.weight)
                    .on_layer(slot.layer);
                crowd.member_mut(member)?.blend(clips[kind][slot.clip], play)?;
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

/// Returns a percentage of the members, rounded, but at least one.
fn changing_count(members: usize, percent: f32) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count, not negative"
    )]
    let count = (members as f64 * f64::from(percent) / 100.0).round() as usize;
    count.clamp(members.min(1), members)
}

impl Staging {
    /// Starts the crossfades of a frame.
    pub(crate) fn change(&mut self, scene: &Scene, frame: u32) -> Result<(), Error> {
        for (member, clip) in scene.changes(frame) {
            let clip = self.clips[scene.character_index(member)][clip];
            self.crowd.member_mut(self.members[member])?.crossfade(clip, FADE_SECS)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_take_turns_without_repeats_in_a_frame() {
        let scene = |members, percent| Scene {
            load: Load::Changing { percent },
            characters: vec![Arc::new(
                rigs::character(3, 2, false, &mut Rng::from_state(1)).expect("valid"),
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
                let frame = u32::try_from(frame).expect("few members");
                let changing: Vec<_> = scene.changes(frame).collect();
                assert_eq!(changing.len(), each);
                let mut different: Vec<_> = changing.iter().map(|(member, _)| *member).collect();
                different.sort_unstable();
                different.dedup();
                assert_eq!(different.len(), each, "{members} members, {percent} %, frame {frame}");
                changing.iter().for_each(|(member, _)| turns[*member] += 1);
            }
            assert_eq!(turns, vec![each; members], "every member changes equally often");
        }
        assert_eq!(Scene { load: Load::Plain, ..scene(9, 1.0) }.changes(3).count(), 0);
    }
}
