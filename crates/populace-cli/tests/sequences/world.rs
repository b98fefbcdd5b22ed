//! A crowd with all handles that its user holds, and the outcomes of calls.

use std::sync::Arc;

use populace::{
    BlendSpaceId, CharacterId, ClipId, Crowd, Error, JointIndex, MachineId, MaskId, MemberId,
    PlaybackId, StageId, Watch,
};
use populace_physics::{RagdollPlan, Ragdolls};

use crate::draw::Draw;
use crate::fixture::{Setup, characters};

/// Largest number of members of a short sequence, and of handles of each kind.
pub(crate) const MAX_MEMBERS: usize = 24;
/// The bodies that soaks watch, by their index in [`characters`].
pub(crate) const ARM: usize = 0;
pub(crate) const PERSON: usize = 2;
/// Largest number of handles kept after their members were despawned.
const MAX_STALE: usize = 8;

/// A character and the assets added to it.
pub(crate) struct Body {
    pub(crate) id: CharacterId,
    pub(crate) joints: usize,
    pub(crate) clips: Vec<ClipId>,
    pub(crate) masks: Vec<MaskId>,
    pub(crate) plan: Arc<RagdollPlan>,
}

/// A crowd, and the handles that its user holds.
pub(crate) struct World {
    pub(crate) crowd: Crowd,
    pub(crate) ragdolls: Ragdolls,
    pub(crate) setup: Setup,
    /// Index of the current devices in the set-up.
    pub(crate) device: usize,
    pub(crate) bodies: Vec<Body>,
    pub(crate) members: Vec<(MemberId, usize)>,
    pub(crate) stale: Vec<(MemberId, usize)>,
    pub(crate) plays: Vec<PlaybackId>,
    pub(crate) live: Vec<(ClipId, usize, f64)>,
    pub(crate) spaces: Vec<BlendSpaceId>,
    pub(crate) machines: Vec<MachineId>,
    pub(crate) stages: Vec<StageId>,
    pub(crate) watches: Vec<Watch>,
    /// The two user stages, if they are added.
    pub(crate) staged: [Option<StageId>; 2],
}

/// The outcome of a call, on which two crowds must agree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Outcome {
    Done,
    Refused(String),
    /// The bits of the numbers read.
    Read(Vec<u32>),
}

impl Outcome {
    pub(crate) fn of<T>(result: Result<T, Error>) -> Self {
        match result {
            Ok(_) => Self::Done,
            Err(error) => Self::Refused(error.to_string()),
        }
    }

    pub(crate) fn read<I: IntoIterator<Item = f32>>(result: Result<I, Error>) -> Self {
        match result {
            Ok(numbers) => Self::Read(numbers.into_iter().map(f32::to_bits).collect()),
            Err(error) => Self::Refused(error.to_string()),
        }
    }
}

impl World {
    /// Builds a crowd of at most `capacity` members.
    pub(crate) fn new(setup: &Setup, slots: usize, capacity: usize) -> Result<Self, Error> {
        let builder = Crowd::builder().devices(setup.devices[0].clone()).schedule(setup.schedule);
        let mut crowd = builder.capacity(capacity).slots_per_member(slots).build()?;
        let mut bodies = Vec::new();
        for character in characters() {
            let id = crowd.add_character(Arc::clone(character))?;
            let clips = crowd.character(id)?.clips().into_iter().map(|(clip, _)| clip).collect();
            let plan = Arc::new(RagdollPlan::from_skeleton(&character.skeleton));
            let joints = character.skeleton.joint_count();
            bodies.push(Body { id, joints, clips, masks: Vec::new(), plan });
        }
        let ragdolls = Ragdolls::new([0.0, -9.81, 0.0]).expect("gravity is finite");
        Ok(Self {
            crowd,
            ragdolls,
            setup: setup.clone(),
            device: 0,
            bodies,
            members: Vec::new(),
            stale: Vec::new(),
            plays: Vec::new(),
            live: Vec::new(),
            spaces: Vec::new(),
            machines: Vec::new(),
            stages: Vec::new(),
            watches: Vec::new(),
            staged: [None; 2],
        })
    }

    /// Draws a member and its body's index; sometimes a despawned one.
    pub(crate) fn member(&self, draw: &mut Draw, name: &str) -> Option<(MemberId, usize)> {
        if !self.stale.is_empty() && draw.chance("stale", 0.02) {
            let index = draw.index(name, self.stale.len());
            return Some(self.stale[index]);
        }
        let count = self.members.len();
        (count > 0).then(|| self.members[draw.index(name, count)])
    }

    /// Draws a joint of a body; sometimes one out of range.
    pub(crate) fn joint(&self, draw: &mut Draw, name: &str, body: usize) -> JointIndex {
        let count = self.bodies[body].joints;
        let past = usize::from(draw.chance("past", 0.01));
        let index = draw.index(name, count) + past * count;
        JointIndex(u32::try_from(index).expect("few joints"))
    }

    /// Moves a despawned member to the stale handles.
    pub(crate) fn retire(&mut self, member: (MemberId, usize)) {
        self.members.retain(|other| *other != member);
        self.stale.push(member);
        if self.stale.len() > MAX_STALE {
            self.stale.remove(0);
        }
    }

    /// Adds a handle to a list, and drops the oldest if there are too many.
    pub(crate) fn keep<T>(list: &mut Vec<T>, handle: T) {
        list.push(handle);
        if list.len() > MAX_MEMBERS {
            list.remove(0);
        }
    }

    /// Returns the bits of every member's palette.
    pub(crate) fn palettes(&mut self) -> Result<Vec<Vec<u32>>, Error> {
        let members = self.members.clone();
        let bits = |palette: Vec<populace::Affine>| {
            palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits).collect()
        };
        members
            .iter()
            .map(|(member, _)| {
                self.crowd.member_mut(*member).and_then(|mut m| m.palette()).map(bits)
            })
            .collect()
    }
}
